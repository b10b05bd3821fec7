"""The elastic, perfectly plastic sphere against Thornton (1997) and the pressure that it comes from."""

from math import pi, sqrt

import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from support.closed_forms import restitution
from support.normal_balance import forces

from contactlab.laws import Composed, Thornton
from contactlab.testing.plants import block, first, run
from contactlab.trajectory import Trajectory

MASS = 2e-3
SPHERE = Thornton()
ELASTIC, YIELDING = (0.0, SPHERE.yield_depth), (1.0, SPHERE.yield_depth)

YIELD_SPEED = pi**2 / 4.0 * sqrt(8.0 * pi / 15.0)
"""V_y over (p_y^5 R^3 / E*^4 m)^(1/2); 3.194 in print."""


def yield_speed() -> float:
    s = SPHERE
    return YIELD_SPEED * sqrt(s.yield_pressure**5 * s.radius**3 / (s.effective_modulus**4 * MASS))


def impact(ratio: float) -> Trajectory:
    speed = ratio * yield_speed()
    ball = block(MASS, height=1e-6, gap_rate=-speed)
    return run(ball, Composed(SPHERE), 1e-6 / speed + 3e-4)


def test_nothing_is_lost_below_the_yield_speed() -> None:
    slow = impact(0.999)
    assert restitution(slow) == pytest.approx(1.0, abs=1e-9)
    assert abs(first(slow, "energy_loss")) < 1e-30
    assert first(slow, "internal_yields") == 0.0
    assert first(impact(1.001), "energy_loss") > 0.0


@pytest.mark.parametrize("over", [1.0, 1.5, 8.0])
def test_the_force_is_the_sum_of_hertzs_pressure_cut_off_at_its_limit(over: float) -> None:
    depth = over * SPHERE.yield_depth
    radius = sqrt(SPHERE.radius * depth)

    def ring(r: float) -> float:
        hertz = 2.0 * SPHERE.effective_modulus / (pi * SPHERE.radius) * sqrt(radius**2 - r * r)
        return 2.0 * pi * r * min(hertz, SPHERE.yield_pressure)

    flat = radius * sqrt(1.0 - 1.0 / over)
    whole = quad(ring, 0.0, flat)[0] + quad(ring, flat, radius)[0]
    assert_allclose(forces(SPHERE, depth, 0.1, YIELDING)[0], whole, rtol=1e-8)


@pytest.mark.parametrize("over", [1.0, 1.5, 8.0])
def test_it_comes_back_as_a_sphere_with_the_same_contact_circle(over: float) -> None:
    """dN/dd = 2 E* a just behind the turn, and N = 0 at the dent that the limits say."""
    depth = over * SPHERE.yield_depth
    force = forces(SPHERE, depth, 0.1, YIELDING)[0]
    back, _, stiffness, _, _ = forces(SPHERE, depth, -0.1, (0.0, depth))
    assert_allclose(back, force, rtol=1e-12)
    assert_allclose(stiffness, 2.0 * SPHERE.effective_modulus * sqrt(SPHERE.radius * depth), rtol=1e-12)
    flatter = 4.0 / 3.0 * SPHERE.effective_modulus * (SPHERE.radius * depth) ** 1.5 / force
    dent = -SPHERE.evaluate("limits", largest_depth=depth)[1]
    assert_allclose(depth - dent, SPHERE.radius * depth / flatter, rtol=1e-12)
    assert forces(SPHERE, dent, -0.1, (0.0, depth))[0] == 0.0


def test_a_dent_is_elastic_until_its_depth_is_reached_again() -> None:
    """A body so heavy that nothing disturbs it swings between 1/2 and 3/2 of a depth: it yields once."""
    mass, depth, rate = 1e6, 2e-6, 2.0 * pi * 1e3
    start = 0.3 * SPHERE.yield_depth
    stiffness = mass * rate**2
    swing = block(mass, height=-start, weight=stiffness * depth, normal_stiffness=stiffness)
    peak = 2.0 * depth - start
    made = run(swing, Composed(SPHERE), 2.4e-3, record_interval=1e-4)
    n, x = 0.5 * (3.0 * peak / SPHERE.yield_depth - 1.0), peak / SPHERE.yield_depth
    unit = 0.4 * SPHERE.parameters()[0] * SPHERE.yield_depth**2.5
    # Work to the peak less what comes back, in units of the energy of yield.
    expected = unit * (1.0 + 2.5 * (x - 1.0) + 1.875 * (x - 1.0) ** 2 - n * n / sqrt(x))
    assert made.contacts["start_time"].size == 3
    assert_allclose(made.series["contact_loss"][10], expected, rtol=1e-6)
    assert_allclose(made.series["internal_largest_depth"][10], peak, rtol=1e-6)
    assert_allclose(made.series["contact_loss"][-1], expected, rtol=1e-6)
