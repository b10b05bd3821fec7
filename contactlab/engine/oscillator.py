"""The exact response of one linear oscillator, for any damping and for none.

With the impulse response w of  w'' + c w' + k w = 0,  w(0) = 0,  w'(0) = 1,  and its repeated
integrals

    I_-1 = w',   I_0 = w,   I_m(s) = int_0^s I_(m-1),

everything the engine needs of an oscillator is linear in them: the free flow

    q(s) = (I_-1 + c I_0) q0 + I_0 v0,      v(s) = -k I_0 q0 + I_-1 v0,

and the answer to a force s^m / m! from rest, q = I_(m+1), v = I_m. They are summed from their power
series over a short time and doubled from there, which holds for under-, critically and overdamped
oscillators and for a free mass (k = 0) alike: there is no case to choose and nothing cancels.
"""

from math import sqrt

import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import kernel, part_kernel

REACH = 0.25
"""Largest (c + sqrt k) d that the power series is asked for; the rest is doubled."""

TERMS = 11
"""Terms of the series, REACH^TERMS / TERMS! being far below round-off."""

RECIPROCALS = 1.0 / np.maximum(np.arange(64.0), 1.0)
"""1/n: a division costs more than a term of the series."""


@kernel
def impulse_integrals(k: float, c: float, s: float, top: int, out: Array) -> None:
    """Fill out[i] = I_(i-1)(s) for i = 0 .. top + 1.

    Args:
        k: stiffness over mass [1/s^2], not negative.
        c: damping over mass [1/s], not negative.
        s: time [s].
        top: highest integral, at least 1.
        out: result, I_m in s^(m+1), shape (at least top + 2,).
    """
    reach = (c + sqrt(k)) * s
    doublings = 0
    d = s
    while reach > REACH:
        reach *= 0.5
        d *= 0.5
        doublings += 1
    _series(k, c, d, top, out)
    for _ in range(doublings):
        _double(k, c, d, top, out)
        d *= 2.0


@part_kernel
def _series(k: float, c: float, d: float, top: int, out: Array) -> None:
    """The two highest integrals by power series, the others down the recurrence.

    I_(m-1) = d^m / m! - c I_m - k I_(m+1), stable downwards while (c + sqrt k) d is small.
    """
    factorial = 1.0
    power = 1.0
    for i in range(1, top + 1):
        factorial *= i
        power *= d
    cd = c * d
    kdd = k * d * d
    before = 0.0
    now = 1.0
    lower = 1.0 / factorial
    upper = lower / (top + 1)
    highest = 0.0
    second = 0.0
    for n in range(1, TERMS):
        second += now * lower
        highest += now * upper
        lower = upper
        upper = upper * RECIPROCALS[n + top + 1]
        before, now = now, -cd * now - kdd * before
    # Multiplied up, not divided down: a rigid body must keep its place to the last bit.
    out[0] = 1.0
    for m in range(1, top):
        out[m] = out[m - 1] * d / m
    out[top + 1] = highest * power * d
    out[top] = second * power
    for m in range(top, 0, -1):
        out[m - 1] = out[m - 1] - c * out[m] - k * out[m + 1]


@part_kernel
def _double(k: float, c: float, d: float, top: int, out: Array) -> None:
    """From I(d) to I(2 d): flow the answer of the first half, add that of the second."""
    w = out[1]
    rate = out[0]
    keep = rate + c * w
    for m in range(top, 0, -1):
        # The force (d + s)^(m-1) / (m-1)! of the second half, expanded about its start.
        shifted = 0.0
        moment = 1.0
        for i in range(m - 1, -1, -1):
            shifted += moment * out[i + 2]
            moment *= d / (m - i)
        out[m + 1] = keep * out[m + 1] + w * out[m] + shifted
    out[1] = keep * w + w * rate
    out[0] = -k * w * w + rate * rate
