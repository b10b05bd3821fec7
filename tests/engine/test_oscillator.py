"""The repeated integrals of the impulse response, against closed forms in long decimals.

The reference is summed in decimal arithmetic with so many digits that nothing is lost to cancellation:
the power series while (c + sqrt k) s is moderate, and the real roots where it is not.
"""

from decimal import Decimal, localcontext
from math import factorial, sqrt

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from contactlab.compiler.kernels import kernel
from contactlab.compiler.lanes import WIDTH, entry
from contactlab.engine.oscillator import impulse_integrals, integrals_of_several

Array = np.ndarray

TOP = 6
"""Order of the highest integral: one more than a step of the engine needs."""

SERIES_REACH = 300.0


def integrals(k: float, c: float, s: float, top: int = TOP) -> Array:
    """I_-1 .. I_top of the package."""
    out = np.zeros(top + 2)
    impulse_integrals(k, c, s, top, out)
    return out


def by_series(k: Decimal, c: Decimal, s: Decimal, top: int, count: int) -> list[Decimal]:
    """I_m = sum_n a_n s^(n + m + 1) / (n + m + 1)!, a_0 = 1, a_1 = -c, a_n = -c a_n-1 - k a_n-2."""
    sums = [Decimal(0)] * (top + 2)
    before, now, power = Decimal(0), Decimal(1), Decimal(1)
    for n in range(count):
        # power = s^n / n!; the integral of order m takes it m + 1 times further.
        term = power
        for i in range(top + 2):
            sums[i] += now * term
            term = term * s / (n + i + 1)
        before, now = now, -c * now - k * before
        power = power * s / (n + 1)
    return sums


def by_roots(k: Decimal, c: Decimal, s: Decimal, top: int) -> list[Decimal]:
    """From the roots of an overdamped oscillator, and up by c I_m + k I_m+1 = s^m/m! - I_m-1."""
    root = (c * c / 4 - k).sqrt()
    slow, fast = -k / (c / 2 + root), -c / 2 - root
    decays = ((slow * s).exp(), (fast * s).exp())
    result = [(slow * decays[0] - fast * decays[1]) / (slow - fast), (decays[0] - decays[1]) / (slow - fast)]
    for m in range(1, top + 1):
        if k == 0:
            result.append((s**m / factorial(m) - result[-1]) / c)
        else:
            moment = s ** (m - 1) / factorial(m - 1)
            result.append((moment - c * result[-1] - result[-2]) / k)
    return result


def exact(k: float, c: float, s: float, top: int = TOP) -> Array:
    """I_-1 .. I_top to double precision."""
    reach = (c + sqrt(k)) * s
    arguments = (Decimal(k), Decimal(c), Decimal(s), top)
    with localcontext() as context:
        # The largest term of the series has size e^reach, and after 4 reach terms none is left.
        context.prec = 120 + int(reach)
        if reach <= SERIES_REACH:
            return np.array([float(x) for x in by_series(*arguments, 80 + int(4.0 * reach))])
        context.prec = 400
        return np.array([float(x) for x in by_roots(*arguments)])


def scales(k: float, s: float, top: int = TOP) -> Array:
    """Size that round-off is measured by: the free mass, s^(m+1)/(m+1)!, or the static answer."""
    static = np.inf if k == 0.0 else 1.0 / k
    free = [s**i / factorial(i) for i in range(top + 2)]
    drift = [np.inf, np.inf] + [static * x for x in free]
    return np.minimum(free, drift[: top + 2])


REGIMES = [
    pytest.param(0.0, 0.0, 3e-3, id="free mass"),
    pytest.param(0.0, 40.0, 0.5, id="damped free mass"),
    pytest.param(0.0, 1e7, 1e-3, id="free mass, very damped"),
    pytest.param(4e8, 0.0, 1e-6, id="undamped, short"),
    pytest.param(4e8, 0.0, 1e-2, id="undamped, thirty turns"),
    pytest.param(4.07e8, 8143.0, 5e-5, id="underdamped"),
    pytest.param(4e8, 4e4, 1e-4, id="critical"),
    pytest.param(4e8, 4e4 * (1.0 + 1e-9), 1e-4, id="just overdamped"),
    pytest.param(4e8, 4e4 * (1.0 - 1e-9), 1e-4, id="just underdamped"),
    pytest.param(1.25e10, 2.5e5, 4e-6, id="overdamped, the motor's fourth mode"),
    pytest.param(1e14, 2e9, 5e-6, id="very stiff, c s = 1e4"),
    pytest.param(1e10, 1e9, 1e-5, id="very stiff with a slow root"),
    pytest.param(1e-8, 1e-8, 1.0, id="nearly nothing"),
]


@pytest.mark.parametrize(("k", "c", "s"), REGIMES)
def test_integrals_are_the_closed_form_in_every_regime(k: float, c: float, s: float) -> None:
    error = np.abs(integrals(k, c, s) - exact(k, c, s))
    # Each doubling carries the round-off of the one before: a few bits a turn or decay time.
    allowed = 5e-15 * (10.0 + (c + sqrt(k)) * s) * scales(k, s)
    assert np.all(error <= allowed), error / allowed


stiffness = st.one_of(st.just(0.0), st.floats(0.0, 11.0).map(lambda x: 10.0**x))
damping = st.one_of(st.just(0.0), st.floats(0.0, 6.0).map(lambda x: 10.0**x))
time = st.floats(-8.0, -3.5).map(lambda x: 10.0**x)


@settings(deadline=None)
@given(stiffness, damping, time)
def test_random_oscillators_are_the_closed_form(k: float, c: float, s: float) -> None:
    if (c + sqrt(k)) * s > SERIES_REACH:
        s = SERIES_REACH / (c + sqrt(k))
    error = np.abs(integrals(k, c, s) - exact(k, c, s))
    assert np.all(error <= 5e-15 * (10.0 + (c + sqrt(k)) * s) * scales(k, s))


@kernel
def _of_several(k, c, s, top, out):  # type: ignore[no-untyped-def]
    integrals_of_several(entry(k, 0), entry(c, 0), s, top, out)


@kernel
def _at_several(k, c, s, top, out):  # type: ignore[no-untyped-def]
    integrals_of_several(k, c, entry(s, 0), top, out)


@settings(deadline=None)
@given(st.lists(st.tuples(stiffness, damping), min_size=WIDTH, max_size=WIDTH), time)
def test_oscillators_in_lanes_are_the_closed_form_each(pairs: list[tuple[float, float]], s: float) -> None:
    k, c = np.array(pairs).T.copy()
    fastest = (c + np.sqrt(k)).max()
    s = min(s, SERIES_REACH / fastest) if fastest > 0.0 else s
    out = np.zeros((TOP + 2, WIDTH))
    _of_several(k[None], c[None], s, TOP, out)
    for i in range(WIDTH):
        # All are doubled as often as the fastest needs it.
        allowed = 5e-15 * (10.0 + fastest * s) * scales(k[i], s)
        assert np.all(np.abs(out[:, i] - exact(k[i], c[i], s)) <= allowed)


@settings(deadline=None)
@given(stiffness, damping, time, st.lists(st.floats(1e-3, 1.0), min_size=WIDTH, max_size=WIDTH))
def test_times_in_lanes_are_the_closed_form_each(
    k: float, c: float, longest: float, shares: list[float]
) -> None:
    if (c + sqrt(k)) * longest > SERIES_REACH:
        longest = SERIES_REACH / (c + sqrt(k))
    times = longest * np.array(shares)
    out = np.zeros((TOP + 2, WIDTH))
    _at_several(k, c, times[None], TOP, out)
    for i, s in enumerate(times):
        # All are doubled as often as the longest needs it.
        allowed = 5e-15 * (10.0 + (c + sqrt(k)) * longest) * scales(k, s)
        assert np.all(np.abs(out[:, i] - exact(k, c, s)) <= allowed)


@settings(deadline=None)
@given(damping=st.floats(1e-12, 1e-3), s=st.floats(1e-6, 1e-3))
def test_a_slow_rotor_in_lanes_loses_its_velocity_to_the_last_bit(damping: float, s: float) -> None:
    """However often the fastest beside it is doubled; what it loses in a period may be below round-off."""
    k, c = np.zeros(WIDTH), np.full(WIDTH, damping)
    k[0] = 1e11
    out = np.zeros((TOP + 2, WIDTH))
    _of_several(k[None], c[None], s, TOP, out)
    assert np.all(np.abs(out[0, 1:] - np.exp(-damping * s)) <= 2.3e-16)
