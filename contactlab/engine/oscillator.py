"""The exact response of one linear oscillator, for any damping and for none.

With the impulse response w of  w'' + c w' + k w = 0,  w(0) = 0,  w'(0) = 1,  and its repeated
integrals

    I_-1 = w',   I_0 = w,   I_m(s) = int_0^s I_(m-1),

everything the engine needs of an oscillator is linear in them: the free flow

    q(s) = (I_-1 + c I_0) q0 + I_0 v0,      v(s) = -k I_0 q0 + I_-1 v0,

and the answer to a force s^m / m! from rest, q = I_(m+1), v = I_m. They are summed from their power
series over a short time and doubled from there, which holds for under-, critically and overdamped
oscillators and for a free mass (k = 0) alike: there is no case to choose and nothing cancels. Every doubling
doubles the round-off: of several at once a slow one takes w' from w, whose part in it is small.
"""

from math import cos, exp, expm1, sin, sqrt
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, kernel, part_kernel
from contactlab.compiler.lanes import entry, fill, largest_of_all, root, set_entry, where_less

REACH = 0.25
"""Largest (c + sqrt k) d of the power series; longer times are doubled."""

TERMS = 11
"""Terms of the series: the first that is left out is below 3e-14 of the sum."""

RECIPROCALS = 1.0 / np.maximum(np.arange(64.0), 1.0)
"""1/n: a division costs more than a term of the series."""


@kernel
def impulse_integrals(k: float, c: float, s: float, top: int, out: Array) -> None:
    """Fill out[i] = I_(i-1)(s) [s^i] for i = 0 .. top + 1, with top at least 1.

    k [1/s^2] and c [1/s] are stiffness and damping over mass, not negative; s is the time [s].
    """
    _fill_integrals(k, c, (c + sqrt(k)) * s, s, top, out)


@inner_kernel
def integrals_of_several(k: Any, c: Any, s: Any, top: int, out: Array) -> None:
    """Fill out[i] with what `impulse_integrals` does, of an oscillator or of a time in each lane."""
    turns = (c + root(k)) * s
    _fill_integrals(k, c, largest_of_all(turns), s, top, out)
    # I_-1 = 1 - c I_0 - k I_1: a slow rotor keeps its velocity to the last bit.
    slow = -c * entry(out, 1) - k * entry(out, 2) + 1.0
    set_entry(out, 0, where_less(turns, fill(REACH), slow, entry(out, 0)))


@part_kernel
def _fill_integrals(k: Any, c: Any, reach: float, s: Any, top: int, out: Array) -> None:
    """Fill out[i] = I_(i-1)(s) of one oscillator, or of several, whose motions turn by a reach at most."""
    # c + sqrt k bounds the rate of any motion, under- or overdamped: over a time that is short against its
    # reciprocal the series is short.
    d, doublings = s, 0
    while reach > REACH:
        reach *= 0.5
        d = 0.5 * d
        doublings += 1
    # The two highest integrals by power series.
    factorial, power = 1.0, d
    for i in range(2, top + 1):
        factorial *= i
        power = power * d
    # The derivatives of w at zero obey the oscillator's equation, w^(n+2) = -c w^(n+1) - k w^(n). A term
    # s^n/n! of w is s^(n+m)/(n+m)! after m integrations.
    cd, kdd = c * d, k * d * d
    before = 0.0 * cd
    begins = before + 1.0
    now, highest, second = begins, before, before
    lower = 1.0 / factorial
    upper = lower / (top + 1)
    for n in range(1, TERMS):
        second = second + now * lower
        highest = highest + now * upper
        lower = upper
        upper = upper * RECIPROCALS[n + top + 1]
        before, now = now, -cd * now - kdd * before
    # The others down I_(m-1) = d^m / m! - c I_m - k I_(m+1), stable while (c + sqrt k) d is small. The
    # powers are multiplied up, not divided down: a rigid body must keep its place to the last bit.
    set_entry(out, 0, begins)
    for m in range(1, top):
        set_entry(out, m, entry(out, m - 1) * d / m)
    set_entry(out, top + 1, highest * power * d)
    set_entry(out, top, second * power)
    for m in range(top, 0, -1):
        set_entry(out, m - 1, entry(out, m - 1) - c * entry(out, m) - k * entry(out, m + 1))
    # From I(d) to I(2 d): the flow of what the first half answers, and what the second does.
    for _ in range(doublings):
        rate, w = entry(out, 0), entry(out, 1)
        # Eq. 2.6: I_m(2 d) is the free flow from displacement I_m and rate I_(m-1) at d, and the answer to
        # the force from there on. Downwards in m, so that every line reads values at d.
        keep = rate + c * w
        for m in range(top, 0, -1):
            # The force (d + s)^(m-1) / (m-1)! of the second half, expanded about its start.
            shifted, moment = entry(out, m + 1), d
            for i in range(m - 2, -1, -1):
                shifted = shifted + moment * entry(out, i + 2)
                moment = moment * (d / (m - i))
            set_entry(out, m + 1, keep * entry(out, m + 1) + w * entry(out, m) + shifted)
        set_entry(out, 1, keep * w + w * rate)
        set_entry(out, 0, -k * w * w + rate * rate)
        d = 2.0 * d


@kernel
def response_from_rest(k: float, c: float, omega: float, s: float) -> tuple[float, float, float, float]:
    """Return Re R, Im R [s^2] and their rates [s]: an underdamped oscillator under exp(i omega s), from rest.

    Near resonance the steady state is what the tone builds up over a long time, up to a billion times what
    moves now: split off, it would leave its own round-off in every gap. The answer from rest is as small as
    what a step adds:

        R(s) = int_0^s w(u) exp(i omega (s - u)) du = exp(i omega s) (E(z_-) - E(z_+)) / (2 i nu),
        E(z) = (1 - exp(-z s)) / z,  z_-+ = sigma + i (omega -+ nu),

    with the impulse response w(u) = exp(-sigma u) sin(nu u) / nu. The first term is the beat that grows,
    and it does so without cancellation however slow the beat is. It asks for c^2 < 4 k.
    """
    sigma = 0.5 * c
    nu = sqrt(k - sigma * sigma)
    # Eq. 2.7 without exp(i omega s), by which it is turned in the end.
    beat_re, beat_im = _faded(sigma, omega - nu, s)
    fast_re, fast_im = _faded(sigma, omega + nu, s)
    q_re, q_im = (beat_im - fast_im) / (2.0 * nu), (fast_re - beat_re) / (2.0 * nu)
    # The rate has w' in place of w: the cosine is the mean of both terms, and the decay takes sigma R.
    v_re = 0.5 * (beat_re + fast_re) - sigma * q_re
    v_im = 0.5 * (beat_im + fast_im) - sigma * q_im
    cosine, sine = cos(omega * s), sin(omega * s)
    return (
        q_re * cosine - q_im * sine,
        q_re * sine + q_im * cosine,
        v_re * cosine - v_im * sine,
        v_re * sine + v_im * cosine,
    )


@inner_kernel
def _faded(a: float, b: float, s: float) -> tuple[float, float]:
    """Return Re and Im of (1 - exp(-z s)) / z for z = a + i b, not zero."""
    # 1 - exp(-a s) cos(b s) without cancellation, by expm1 of the decay and the half-angle of the turn.
    left = exp(-a * s)
    half = sin(0.5 * b * s)
    real = 2.0 * left * half * half - expm1(-a * s)
    imaginary = left * sin(b * s)
    size = a * a + b * b
    return (real * a + imaginary * b) / size, (imaginary * a - real * b) / size
