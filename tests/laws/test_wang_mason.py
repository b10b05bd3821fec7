"""Poisson's impact is that of Wang and Mason (1992): the closed forms of all of their modes of contact.

In their words B1 = d_tt, B2 = d_nn, B3 = -d_nt; C0 < 0 and S0 are gap rate and slip at first, s is the sign
of S0.
"""

from math import copysign, cos, sin

import pytest
from support.impacts import Delassus, after, drawn_impacts, impact_of

from contactlab.laws import Poisson
from contactlab.laws.base import SLIP, STICK

MODES = {
    "sliding": SLIP,
    "sticking in compression": STICK,
    "sticking in restitution": STICK,
    "reversed in compression": SLIP,
    "reversed in restitution": SLIP,
}
"""Their modes of a slip, and whether the contact sticks at the end."""


def mode_of(normal: float, slip: float, d: Delassus, mu: float, e: float) -> str:
    """Return the mode by the normal impulses at which the slip ends and compression ends, cross-multiplied.

    P_d = (B2 + s mu B3) s S0 against P_q = (mu B1 + s B3) (-C0), and mu against that of stick, |B3|/B1.
    """
    b1, b2, b3, s = d[2], d[0], -d[1], copysign(1.0, slip)
    p_d, p_q = (b2 + s * mu * b3) * s * slip, (mu * b1 + s * b3) * -normal
    if p_d > (1.0 + e) * p_q:
        return "sliding"
    sticks = "sticking" if mu > abs(b3) / b1 else "reversed"
    return f"{sticks} in {'restitution' if p_d > p_q else 'compression'}"


def impulses(mode: str, normal: float, slip: float, d: Delassus, mu: float, e: float) -> tuple[float, float]:
    """Return the normal impulse and the friction impulse of a mode [N s], each from its own equations.

    Slip ends at P_s = -s S0/(s d_nt - mu d_tt). Up to there p_t = -s mu p_n; behind it the slip is zero,
    or friction has turned. Compression ends where C0 + d_nn p_n + d_nt p_t = 0.
    """
    (d_nn, d_nt, d_tt), s = d, copysign(1.0, slip)
    slid = -s * slip / (s * d_nt - mu * d_tt)
    if mode in ("sliding", "sticking in restitution", "reversed in restitution"):
        p_n = -(1.0 + e) * normal / (d_nn - s * mu * d_nt)
    elif mode == "sticking in compression":
        # Where both directions are at rest.
        p_n = (1.0 + e) * (d_nt * slip - d_tt * normal) / (d_nn * d_tt - d_nt * d_nt)
    else:
        p_n = -(1.0 + e) * (normal - 2.0 * s * mu * d_nt * slid) / (d_nn + s * mu * d_nt)
    if mode == "sliding":
        return p_n, -s * mu * p_n
    if mode.startswith("sticking"):
        return p_n, -(slip + d_nt * p_n) / d_tt
    return p_n, s * mu * (p_n - 2.0 * slid)


def test_poisson_has_the_impulses_of_every_mode_of_wang_and_mason() -> None:
    seen = dict.fromkeys(MODES, 0)
    for normal, slip, d, mu in drawn_impacts(6000):
        # Their forms leave out slip that jams, where the normal impulse alone decides nothing.
        if mu * abs(d[1]) >= 0.95 * d[0]:
            continue
        e = 0.7
        mode = mode_of(normal, slip, d, mu, e)
        seen[mode] += 1
        result = impact_of(Poisson(mu, e), normal, slip, d)
        assert result[2] == MODES[mode], mode
        expected = impulses(mode, normal, slip, d, mu, e)
        assert result[:2] == pytest.approx(expected, rel=1e-8, abs=1e-10 * result[0]), mode
        left = after(normal, slip, d, result)[1]
        if mode.startswith("reversed"):
            assert left * slip < 0.0
    print(seen)
    assert min(seen.values()) > 20


def rod(angle: float) -> Delassus:
    """A uniform rod of mass and length one that touches with its end, at an angle from the floor."""
    # From the contact to the centre: sideways and up; 1/12 is its moment of inertia.
    x, y = 0.5 * cos(angle), 0.5 * sin(angle)
    return 1.0 + 12.0 * x * x, -12.0 * x * y, 1.0 + 12.0 * y * y


@pytest.mark.parametrize(("angle", "mode"), [(0.3, SLIP), (1.3, STICK)])
def test_a_rod_that_falls_without_slip_sticks_or_slides_by_the_coefficient_of_its_angle(
    angle: float, mode: int
) -> None:
    """mu_s = |B3|/B1 = 3 sin cos/(1 + 3 sin^2): with less friction its end slides away from the first on."""
    d, e, speed = rod(angle), 0.5, 1.0
    critical = 3.0 * sin(angle) * cos(angle) / (1.0 + 3.0 * sin(angle) ** 2)
    mu = critical * (1.1 if mode == STICK else 0.9)
    p_n, p_t, result = impact_of(Poisson(mu, e), -speed, 0.0, d)
    assert result == mode
    ratio = min(mu, critical)
    assert p_n == pytest.approx((1.0 + e) * speed / (d[0] + ratio * d[1]), rel=1e-12)
    assert p_t == pytest.approx(ratio * p_n, rel=1e-12)
    left = after(-speed, 0.0, d, (p_n, p_t, result))[1]
    assert left == pytest.approx(0.0, abs=1e-12) if mode == STICK else left < -1e-3
