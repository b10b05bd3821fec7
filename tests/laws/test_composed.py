"""Composed laws: what they share, what they refuse, and limits in which two of them are one."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq

from contactlab.engine import simulate
from contactlab.laws import ContactLaw, HertzPenalty, Thornton
from contactlab.laws.base import NormalForce
from contactlab.laws.composed import Composed
from contactlab.laws.damping import Flores, HuntCrossley, LankaraniNikravesh, LinearDamping, loss_number
from contactlab.laws.friction import Coulomb, ElastoPlastic, LuGre, Mindlin, Regularised
from contactlab.laws.normal import NORMAL_FORCES, HertzElliptic, HertzPoint, Line, Linear, approach_factor
from contactlab.testing.plants import block, paper_motor, run, way_of
from contactlab.trajectory import Trajectory


def motor_run(law: ContactLaw) -> Trajectory:
    return simulate(paper_motor(), law, duration=2e-3, record_interval=1e-5, tolerance=1e-9)


def final_velocity(law: ContactLaw) -> float:
    return float(motor_run(law).series["rotor_velocity"][-1])


def fitted_order(sizes: list[float], errors: list[float]) -> float:
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def test_hertz_penalty_is_a_composition_to_the_last_bit() -> None:
    law = HertzPenalty(2e9, 0.4)
    composition = Composed(HertzPoint(2e9), friction=Coulomb(0.4))
    named, composed = motor_run(law), motor_run(composition)
    for name, values in named.series.items():
        np.testing.assert_array_equal(values, composed.series[name])


def test_hunt_crossley_becomes_hertz_with_the_first_power_of_its_loss() -> None:
    elastic = final_velocity(Composed())
    losses = [1e-2, 1e-3, 1e-4]
    errors = [abs(final_velocity(Composed(damping=HuntCrossley(1 - x))) - elastic) for x in losses]
    assert fitted_order(losses, errors) == pytest.approx(1.0, abs=0.05)
    assert final_velocity(Composed(damping=HuntCrossley(1.0))) == elastic


def test_mindlin_becomes_exact_stick_at_least_with_the_root_of_its_compliance() -> None:
    # Where slip ends the spring is left with more than stick needs, and swings about it with a
    # velocity of (bound - F) sqrt(D_tt / k_t).
    exact = final_velocity(Composed())
    ratios = [30.0, 100.0, 300.0, 1e3, 3e3, 1e4]
    errors = [abs(final_velocity(Composed(friction=Mindlin(0.3, r))) - exact) for r in ratios]
    assert errors[-1] < 1e-3 * abs(exact)
    assert -1.2 < fitted_order(ratios, errors) < -0.5


def test_regularised_friction_becomes_set_valued_with_its_creep_velocity() -> None:
    exact = final_velocity(Composed())
    creeps = [1e-3, 3e-4, 1e-4, 3e-5, 1e-5]
    errors = [abs(final_velocity(Composed(friction=Regularised(0.3, v))) - exact) for v in creeps]
    assert errors[-1] < 1e-3 * abs(exact)
    assert fitted_order(creeps, errors) == pytest.approx(1.0, abs=0.25)


def test_lankarani_nikravesh_and_flores_are_one_law_once_they_achieve_what_is_asked() -> None:
    first = motor_run(Composed(damping=LankaraniNikravesh(0.7)))
    second = motor_run(Composed(damping=Flores(0.7)))
    np.testing.assert_array_equal(first.series["gap"], second.series["gap"])


@given(st.floats(0.03, 1.0))
def test_loss_number_solves_its_equation(e: float) -> None:
    d = loss_number(e)
    assert 0.0 <= e * d < 1.0
    # 1 - e D is rounded: as much as that changes the logarithm.
    blur = 1e-15 / (1.0 - e * d)
    assert_allclose(np.log1p(d) - np.log1p(-e * d), (1.0 + e) * d, rtol=1e-9, atol=1e-11 + blur)


@pytest.mark.parametrize("edge", [0.025, 1.0 - 1e-6])
def test_loss_number_is_smooth_where_its_rule_changes(edge: float) -> None:
    below, above = loss_number(edge * (1.0 - 1e-12)), loss_number(edge * (1.0 + 1e-12))
    assert_allclose(below, above, rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: LankaraniNikravesh(0.5), "restitution"),
        (lambda: HuntCrossley(0.3), "restitution"),
        (lambda: Flores(0.0), "restitution"),
        (lambda: Mindlin(0.3, -1.0), "stiffness_ratio"),
        (lambda: LuGre(0.3, 0.5), "static_ratio"),
        (lambda: ElastoPlastic(breakaway_ratio=1.0), "breakaway_ratio"),
        (lambda: HertzElliptic(5e9, 1e-3), "radius_along"),
        (lambda: Composed(Thornton(), HuntCrossley()), "damping"),
    ],
)
def test_a_part_refuses_what_it_cannot_do(make: object, key: str) -> None:
    with pytest.raises(ValueError, match=key):
        make()  # type: ignore[operator]


ELASTIC = [normal for normal in (part() for part in NORMAL_FORCES.values()) if normal.elastic is not None]


@pytest.mark.parametrize("normal", ELASTIC, ids=lambda normal: normal.name)
@given(exponent=st.floats(-10.0, -4.5))
def test_elastic_force_stiffness_and_slope_are_derivatives_of_the_energy(
    normal: NormalForce, exponent: float
) -> None:
    depth = 10.0**exponent
    h = 1e-4 * depth
    ahead, here, behind = (normal.evaluate("elastic", depth=depth + k * h) for k in (1, 0, -1))
    for low, high in ((1, 0), (0, 2)):
        slope = (ahead[low] - behind[low]) / (2.0 * h)
        assert_allclose(slope, here[high], rtol=1e-6)
    # Where a straight piece begins the slope jumps.
    if here[3] == ahead[3] == behind[3] or normal.name not in ("lining",):
        assert_allclose((ahead[2] - behind[2]) / (2.0 * h), here[3], rtol=1e-6, atol=1e-3)


def hertz_approach(large: float, small: float, modulus: float, force: float) -> float:
    """Approach by quadrature of Hertz's potential: a search for the ellipse, and no elliptic integral."""

    def integrals(aspect: float) -> tuple[float, float, float]:
        """Potentials of the ellipse 1 : aspect, weights of x^2, y^2 and of the constant."""

        def part(power_a: float, power_b: float) -> float:
            def integrand(angle: float) -> float:
                w = np.tan(angle) ** 2
                root = (1.0 + w) ** (0.5 + power_a) * (aspect**2 + w) ** (0.5 + power_b)
                return float(2.0 * (1.0 + w) / root)

            return float(quad(integrand, 0.0, 0.5 * np.pi, epsabs=0.0, epsrel=1e-12)[0])

        return part(1.0, 0.0), part(0.0, 1.0), part(0.0, 0.0)

    low, high = 1e-4, 1.0
    for _ in range(100):
        aspect = np.sqrt(low * high)
        along, across, _ = integrals(aspect)
        low, high = (aspect, high) if across / along > large / small else (low, aspect)
    along, _, whole = integrals(aspect)
    # p0 = 3F/(2 pi a b); curvature 1/(2 R') = (3F/(4 pi E*)) along / a^3, depth = (3F/(4 pi E*)) whole / a.
    unit = 3.0 * force / (4.0 * np.pi * modulus)
    a = (2.0 * large * unit * along) ** (1.0 / 3.0)
    return float(unit * whole / a)


@pytest.mark.parametrize("ratio", [1.0, 1.2, 3.0, 20.0, 400.0])
def test_elliptic_contact_is_hertz_by_quadrature(ratio: float) -> None:
    normal = HertzElliptic(2e-3 * ratio, 2e-3)
    depth = 1e-6
    force = normal.evaluate("elastic", depth=depth)[0]
    result = hertz_approach(2e-3 * ratio, 2e-3, normal.effective_modulus, force)
    assert_allclose(result, depth, rtol=1e-8)


@pytest.mark.parametrize("ratio", [1e6, 1e9, 1e12])
def test_a_slender_elliptic_contact_is_the_limit_of_hertz(ratio: float) -> None:
    """With b/a -> 0: E -> 1 and K -> log(4 a/b), up to (b/a)^2; Johnson, eqs. 4.26 to 4.28."""

    def missing(log_aspect: float) -> float:
        first = np.log(4.0) + log_aspect
        return float(np.log((np.exp(2.0 * log_aspect) - first) / (first - 1.0)) - np.log(ratio))

    log_aspect = brentq(missing, 1.0, 40.0, xtol=1e-15)
    first = np.log(4.0) + log_aspect
    cube = (
        4.0 / np.pi * np.exp(-1.5 * log_aspect) * np.sqrt((np.exp(2.0 * log_aspect) - first) * (first - 1.0))
    )
    factor = 2.0 / np.pi * np.exp(-0.5 * log_aspect) * cube ** (-1.0 / 3.0) * first
    # What the limit leaves out is of this order.
    left = first * np.exp(-2.0 * log_aspect)
    assert_allclose(approach_factor(ratio), factor, rtol=2.0 * left + 1e-12)


def test_a_circular_elliptic_contact_is_the_point_contact() -> None:
    normal = HertzElliptic(4e-3, 4e-3, 1e11)
    assert normal.parameters()[0] == 4.0 / 3.0 * 1e11 * np.sqrt(4e-3)
    assert approach_factor(1.0 + 1e-6) == pytest.approx(1.0, abs=1e-9)


def test_line_contact_of_steel_is_palmgrens_rule() -> None:
    # d = 3.84e-5 Q^0.9 / L^0.8 in newtons and millimetres.
    length, force = 10.0, 500.0
    depth = 3.84e-5 * force**0.9 / length**0.8 * 1e-3
    normal = Line(length * 1e-3)
    result = normal.evaluate("elastic", depth=depth)[0]
    assert_allclose(result, force, rtol=0.03)


@settings(max_examples=25, deadline=None)
@given(
    ratio=st.floats(0.05, 5.0),
    mu=st.floats(0.05, 1.0),
    rates=st.tuples(st.floats(30.0, 3e3), st.floats(30.0, 3e3)),
    swings=st.tuples(st.floats(0.1, 0.95), st.floats(-6.5, -5.0)),
)
def test_no_cycle_of_load_and_slip_makes_energy_in_mindlins_spring(
    ratio: float, mu: float, rates: tuple[float, float], swings: tuple[float, float]
) -> None:
    """A body so heavy that the contact cannot disturb it presses and slides to and fro."""
    mass, depth = 1e6, 2e-6
    pressing, sliding = (2.0 * np.pi * rate for rate in rates)
    way = 10.0 ** swings[1]
    motor = block(
        mass,
        height=-depth,
        gap_rate=swings[0] * depth * pressing,
        weight=mass * pressing**2 * depth,
        normal_stiffness=mass * pressing**2,
        velocity=way * sliding,
        stiffness=mass * sliding**2,
    )
    law = Composed(HertzPoint(1e10), friction=Mindlin(mu, ratio))
    trajectory = run(motor, law, 4.0 / min(rates), 1e-5, 0.01 / max(rates), tolerance=1e-14)
    assert trajectory.contacts["start_time"].size == 1
    loss = np.diff(trajectory.series["friction_loss"])
    # A force that stayed in unloading would make a tenth of what is lost; this is the step's error.
    assert loss.min() >= -1e-7 * loss.sum()


def test_elasto_plastic_friction_does_not_drift_where_lugre_does() -> None:
    """Dupont et al. (2002): a load that swings inside the cone moves LuGre's block for ever."""
    weight, mu = 10.0, 0.3
    ways = []
    for friction in (LuGre(mu, bristle_stiffness=1e5), ElastoPlastic(mu, bristle_stiffness=1e5), Coulomb(mu)):
        motor = block(
            1e-3,
            height=-weight / 1e7,
            weight=weight,
            push=0.3 * mu * weight,
            push_amplitude=0.2 * mu * weight,
            push_frequency=50.0,
        )
        law = Composed(Linear(1e7), friction=friction)
        way = way_of(run(motor, law, 0.4, 1e-4, 0.02).series["tip_slope"])
        ways.append(abs(way[-1] - way[10]) / (0.3 * mu / 1e5))
    assert ways[0] > 0.1
    assert ways[1] < 1e-6
    assert ways[2] < 1e-9


def test_parameters_are_declared_by_dotted_names_and_can_be_changed() -> None:
    law = Composed(damping=LinearDamping(0.5))
    assert set(law.describe()) == {name for name, _, text in law.effective() if text}
    assert law.changed("normal.stiffness", 3e9).normal == HertzPoint(3e9)
    assert law.changed("damping.restitution", 0.9).damping.describe()["restitution"] == 0.9
    with pytest.raises(ValueError, match="stiffness is -1"):
        law.changed("normal.stiffness", -1.0)
