"""Composed laws: what they share, what they refuse, and limits in which two of them are one."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad

from contactlab.engine import simulate
from contactlab.laws import ContactLaw, HertzPenalty, Thornton
from contactlab.laws.composed import Composed
from contactlab.laws.damping import Flores, HuntCrossley, LankaraniNikravesh, LinearDamping, loss_number
from contactlab.laws.friction import Coulomb, ElastoPlastic, LuGre, Mindlin, Regularised
from contactlab.laws.normal import HertzElliptic, HertzPoint
from contactlab.testing.plants import block, paper_motor, run
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


@given(st.floats(0.03, 1.0))
def test_loss_number_solves_its_equation(e: float) -> None:
    d = loss_number(e)
    assert 0.0 <= e * d < 1.0
    # 1 - e D is rounded: as much as that changes the logarithm.
    blur = 1e-15 / (1.0 - e * d)
    assert_allclose(np.log1p(d) - np.log1p(-e * d), (1.0 + e) * d, rtol=1e-9, atol=1e-11 + blur)


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


def test_parameters_are_declared_by_dotted_names_and_can_be_changed() -> None:
    law = Composed(damping=LinearDamping(0.5))
    assert set(law.describe()) == {name for name, _, text in law.effective() if text}
    assert law.changed("normal.stiffness", 3e9).normal == HertzPoint(3e9)
    assert law.changed("damping.restitution", 0.9).damping.describe()["restitution"] == 0.9
    with pytest.raises(ValueError, match="stiffness is -1"):
        law.changed("normal.stiffness", -1.0)
