"""Internal variables, guards, limits and moments of laws whose motion is known in closed form."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator
from support.closed_form_memory import (
    Cooling,
    FreshDent,
    Ledge,
    RigidAgeing,
    RigidRenewal,
    Softening,
    TwoClocks,
    softened_end,
)
from support.command_line import cases
from support.flights import DURATION, random_flight

from contactlab.engine import Flow, Simulator, simulate
from contactlab.laws import ContactLaw
from contactlab.laws.composed import Composed
from contactlab.laws.damping import HuntCrossley
from contactlab.laws.friction import RateAndState
from contactlab.laws.normal import HertzPoint
from contactlab.motor.motor import Motor
from contactlab.testing.plants import attempt, block, paper_motor, run, way_of

MASS, SPEED, HEIGHT = 2e-3, 0.1, 1e-6

LAWS = pytest.mark.parametrize(
    "law", [Softening(), Cooling(), FreshDent(), RigidAgeing()], ids=lambda law: law.name
)


def thrown(**more: float) -> Motor:
    """A ball that touches down after 10 us."""
    return block(MASS, height=HEIGHT, gap_rate=-SPEED, **more)


@pytest.mark.parametrize("time", [1e-6, 3e-5, 1e-4])
def test_a_guard_is_located_and_the_step_ends_there(time: float) -> None:
    law = Softening(time=time)
    made = run(thrown(), law, 4e-4)
    duration, rebound = softened_end(law, MASS, SPEED)
    assert_allclose(made.contacts["internal_switched"], time, rtol=1e-12)
    assert_allclose(made.contacts["internal_clock"], duration, rtol=1e-7)
    assert_allclose(made.contacts["duration"], duration, rtol=1e-7)
    assert_allclose(made.contacts["separation_velocity"], rebound, rtol=1e-7)


def test_of_two_guards_within_a_step_the_earlier_one_falls_first() -> None:
    made = run(thrown(), TwoClocks(), 4e-4)
    assert_array_equal(made.contacts["internal_order"], 21.0)


def test_what_is_stored_less_after_a_jump_is_lost_by_the_contact() -> None:
    law = Softening()
    made = run(thrown(), law, 4e-4, record_interval=1e-6)
    rebound = softened_end(law, MASS, SPEED)[1]
    lost = 0.5 * MASS * (SPEED**2 - rebound**2)
    assert_allclose(made.series["contact_loss"][-1], lost, rtol=1e-6)
    assert_allclose(made.contacts["energy_loss"], lost, rtol=1e-6)
    assert np.abs(made.series["energy_residual"]).max() < 1e-8 * 0.5 * MASS * SPEED**2


@pytest.mark.parametrize("law", [Cooling(), RigidAgeing(time=2e-4), RigidAgeing(time=1e-6)], ids=str)
@pytest.mark.parametrize("weight", [5.0, 500.0])
def test_what_lives_for_the_run_flows_in_flight_and_in_contact(law: ContactLaw, weight: float) -> None:
    """Forces of a rigid contact at rest shorten no step: the relaxation itself does."""
    made = run(thrown(weight=weight), law, 1e-3, record_interval=1e-5)
    assert 0.0 < made.contacts["duration"].sum() < made.time[-1]
    time = 2e-4 if isinstance(law, Cooling) else law.time
    assert_allclose(made.series["internal_warmth"], np.exp(-made.time / time), rtol=1e-10, atol=1e-8)
    assert made.statistics["contact_steps"] + made.statistics["rejected_steps"] < 5000


@pytest.mark.parametrize("slip", [0.5, 2.0, 8.0])
def test_the_age_of_a_contact_without_force_is_that_of_its_slip(slip: float) -> None:
    """It parts faster than its damped spring pushes: dtheta/dt = 1 - v theta/D at a constant v."""
    friction = RateAndState(renewal_distance=1.4e-6, reference_velocity=5e-7, fresh_age=2e-6)
    law = Composed(HertzPoint(4e10), HuntCrossley(0.534, 0.328), friction)
    made = run(block(MASS, height=-4e-6, gap_rate=2.0, velocity=slip), law, 1.9e-6, record_interval=1e-8)
    assert not made.series["normal_force"].any()
    steady = friction.renewal_distance / slip
    age = steady + (friction.fresh_age - steady) * np.exp(-made.time / steady)
    exact = np.log(friction.reference_velocity * age / friction.renewal_distance)
    assert_allclose(made.series["internal_age"], exact, atol=1e-7)


@pytest.mark.parametrize("distance", [1e-5, 1e-6])
def test_a_variable_of_a_rigid_contact_is_that_of_an_integrator_over_its_slip(distance: float) -> None:
    """Stick and slip alternate in a contact whose forces let it take long steps; each slip begins at zero."""
    pushed = block(MASS, weight=5.0, push_amplitude=3.0, push_frequency=1000.0)
    made = run(pushed, RigidRenewal(distance=distance), 2e-3, record_interval=1e-7)
    assert made.contacts["duration"].size == 1
    assert made.statistics["friction_switches"] >= 6
    assert made.statistics["contact_steps"] + made.statistics["rejected_steps"] < 2000
    slip = PchipInterpolator(made.time, np.abs(made.series["slip_velocity"]))
    exact = solve_ivp(
        lambda time, age: 1.0 - slip(time) * age / distance,
        *((0.0, made.time[-1]), [0.0], "LSODA", made.time[::100]),
        rtol=1e-9, atol=1e-16, max_step=1e-6,
    )  # fmt: skip
    assert_allclose(made.series["internal_age"][::100], exact.y[0], rtol=1e-4, atol=1e-10)


@pytest.mark.parametrize("number", cases(range(16), range(6)))
def test_a_contact_begins_where_the_law_says_as_safely_as_at_zero(number: int) -> None:
    _, flight = random_flight(7, number)
    grid, gaps, _ = flight.on_grid(DURATION)
    # It starts open, whatever the clearance.
    begin = min((-1e-7, 2e-9, 1e-10)[number % 3], 0.5 * float(gaps[0]))
    made = attempt(flight.motor, Ledge(begin=begin, end=begin), DURATION)
    result = made.contacts["start_time"]
    closed = grid[gaps <= begin]
    if result.size == 0:
        assert closed.size == 0
        return
    assert result[0] <= (closed[0] if closed.size else DURATION)
    assert abs(float(flight.at(result[0])[0]) - begin) < 1e-16
    assert (gaps[grid < result[0]] > begin).all()


def test_a_contact_ends_where_the_law_says() -> None:
    law = Ledge(begin=0.0, end=1e-7)
    made = run(thrown(), law, 4e-4, record_interval=1e-7)
    # A force that is there at once is brought by nothing but the way from the ledge: 1/2 k g_1^2.
    rebound = np.sqrt(SPEED**2 + law.stiffness * law.end**2 / MASS)
    assert_allclose(made.contacts["separation_velocity"], rebound, rtol=1e-8)
    ends = made.contacts["start_time"] + made.contacts["duration"]
    assert_allclose(np.interp(ends, made.time, made.series["gap"]), law.end, rtol=1e-3)


def test_a_rigid_law_bounces_with_its_restitution_and_slides_to_rest_against_its_bound() -> None:
    """It bounces once with its restitution; resting, it slides off against mu (W + C)."""
    e, weight, cohesion, mu, speed = 0.5, 5.0, 3.0, 0.3, 0.5
    made = run(thrown(), RigidAgeing(restitution=e), 1e-4)
    assert_allclose(made.contacts["separation_velocity"], e * SPEED, rtol=1e-6)
    stop = speed * MASS / (mu * (weight + cohesion))
    sliding = block(MASS, weight=weight, velocity=speed)
    made = run(sliding, RigidAgeing(cohesion=cohesion), 3.0 * stop, record_interval=stop / 20.0)
    stuck = float(made.contacts["stick_duration"][0])
    assert_allclose(3.0 * stop - stuck, stop, rtol=3e-3)
    assert_allclose(way_of(made.series["tip_slope"])[-1], 0.5 * speed * stop, rtol=5e-3)
    # The age is that of the stick, and there was one switch.
    assert_allclose(made.contacts["internal_age"], stuck, rtol=1e-9)
    assert_array_equal(made.contacts["internal_switches"], 1.0)


@LAWS
def test_many_starts_at_once_remember_apart(law: ContactLaw) -> None:
    motor = paper_motor()
    made = simulate(motor, law, duration=6e-4, record_interval=6e-4)
    zero = np.zeros((3, motor.modes.stiffness.size))
    ends = Flow(Simulator(motor, law, 6e-4))(zero, zero, np.zeros(3))
    for i in range(3):
        assert_array_equal(ends.displacement[i], made.final.displacement)


def test_another_memory_begins_in_flight_and_is_refused_in_contact() -> None:
    motor = thrown()
    in_contact = simulate(motor, Softening(), duration=2e-5, record_interval=2e-5).state
    with pytest.raises(ValueError, match="law"):
        simulate(motor, FreshDent(), duration=1e-4, record_interval=1e-6, start=in_contact)
    flying = simulate(motor, Cooling(), duration=5e-6, record_interval=5e-6).state
    made = simulate(motor, Softening(), duration=2e-4, record_interval=1e-6, start=flying)
    assert made.series["internal_clock"][0] == 0.0
    cooled = simulate(motor, Cooling(), duration=1e-6, record_interval=1e-6, start=flying)
    assert_allclose(cooled.series["internal_warmth"][0], np.exp(-5e-6 / 2e-4), rtol=1e-12)
