"""Steady states of laws whose internal variables live for the run: they are part of the state."""

import numpy as np
import pytest
from support.closed_form_memory import Cooling, FreshDent
from support.command_line import cases
from support.settled_motors import by_run, drawn

import contactlab as cl
from contactlab.engine import Flow, Simulator
from contactlab.motor.bodies import block
from contactlab.motor.drive import period_of
from contactlab.steady_state import NotSettledError, UnboundedError
from contactlab.steady_state.arrival import _drifts, _grows
from contactlab.steady_state.basins import same
from contactlab.steady_state.branches import NoBranchError
from contactlab.testing.plants import run

PRONY = ("law=composed", "law/normal=prony")
FAST = (*PRONY, "law.normal.first_time=1e-4")
SLOW = (*PRONY, "law.normal.first_time=1e-3", "law.normal.first_stiffness=2e7")


@pytest.mark.parametrize(("law", "settled"), [(FAST, 0.4), (SLOW, 0.5)])
def test_a_memory_of_the_run_settles_where_a_long_run_does(law: tuple[str, ...], settled: float) -> None:
    setup = cl.build([*law, "solver.tolerance=1e-9"])
    result = cl.steady(setup)
    assert result.orbit is not None
    # All that the run has left of its way.
    assert settled > 20.0 * result.orbit.settling_time
    period = period_of(setup.motor.drive)
    made = setup.run(duration=round(settled / period) * period, record_interval=period)
    assert result.velocity[0] == pytest.approx(np.diff(made.series["rotor_angle"])[-1] / period, rel=1e-8)


@pytest.mark.parametrize("time", [2e-4, 5e-2])
def test_the_multiplier_of_a_memory_is_that_of_its_decay(time: float) -> None:
    """What decays by itself, dz/dt = -z/T, and acts on nothing has the multiplier exp(-period/T)."""
    setup = cl.build()
    result = cl.steady(setup.motor, Cooling(time=time), belt=-2.0)
    assert result.orbit is not None
    own = np.exp(-result.orbit.map.period / time)
    assert np.abs(result.orbit.multipliers - own).min() < 1e-9
    assert result.end[3] == pytest.approx(0.0, abs=1e-8)


def test_an_orbit_with_memory_is_one_whatever_its_section_and_start() -> None:
    setup = cl.build(FAST)
    first, other = cl.steady(setup), cl.steady(setup, start=(cl.steady(setup).end[1], 1.0))
    assert same(first, other)
    assert not same(first, cl.steady(cl.build([*PRONY, "law.normal.first_time=1.2e-4"])))


@pytest.mark.parametrize("wear", cases((1e-4, 1e-2), ()))
def test_a_variable_that_only_grows_has_no_steady_state_and_is_named(wear: float) -> None:
    setup = cl.build(["law=archard", f"law.wear_coefficient={wear}"])
    with pytest.raises(UnboundedError, match="wear"):
        cl.steady(setup)
    axes = {"rotor_velocity": np.array([0.0, 1.0]), "drive_phase": np.array([0.0])}
    with pytest.raises(UnboundedError):
        cl.basins(setup, axes)
    with pytest.raises(NotSettledError):
        cl.branch(setup, "contact.clearance", 1e-6, 1.1e-6)


def test_basins_and_branches_are_those_of_the_whole_state() -> None:
    setup = cl.build(FAST)
    settled = cl.steady(setup).velocity[0]
    axes = {"rotor_velocity": np.array([-2.0, 2.0]), "drive_phase": np.array([0.0, 0.4])}
    result = cl.basins(setup, axes)
    assert result.shares == (1.0,)
    assert result.attractors[0].velocity[0] == pytest.approx(settled, rel=1e-8)
    branch = cl.branch(setup, "law.normal.first_time", 1e-4, 2e-4)
    assert branch.points[0].velocity == pytest.approx(settled, rel=1e-8)
    end = cl.steady(cl.build([*PRONY, "law.normal.first_time=2e-4"])).velocity[0]
    assert branch.points[-1].velocity == pytest.approx(end, rel=1e-8)
    with pytest.raises(NoBranchError, match="internal variables"):
        cl.branch(setup, "law.normal.second_stiffness", 0.0, 1e6)


def test_round_off_is_no_drift_and_a_curve_that_goes_one_way_is_one() -> None:
    steps = np.linspace(0.0, 1.0, 2000)
    assert not _drifts(-2.66 - 3e-12 * steps)
    assert not _grows(-2.66 - 3e-12 * steps)
    assert _drifts(-2.66 - 1e-6 * steps)
    assert _grows(1.0 - np.exp(-3.0 * steps))
    assert not _grows(np.sin(20.0 * steps))


def test_a_dent_that_is_not_cleared_is_part_of_the_state() -> None:
    """A ball falls back before it has left its dent: positions and velocities alone do not go on there."""
    motor = block(2e-3, height=1e-6, gap_rate=-0.1, weight=1.3)
    made = run(motor, FreshDent(), 6e-4).contacts
    between = 0.5 * (made["start_time"][0] + made["duration"][0] + made["start_time"][1])
    assert motor.start is not None
    start = motor.start.displacement[None], motor.start.velocity[None], np.zeros(1)
    over, before = (Flow(Simulator(motor, FreshDent(), duration))(*start) for duration in (between, 5e-6))
    assert over.messages[0]
    assert np.isnan(over.displacement).all()
    assert before.messages == ("",)


@pytest.mark.parametrize("number", cases(range(12), (4, 7)))
def test_random_motors_settle_where_a_run_of_a_second_does_or_are_refused(number: int) -> None:
    setup = drawn(number)
    run, left, grows = by_run(setup)
    try:
        result = cl.converged(setup)
    except UnboundedError:
        assert grows
        return
    first, error = result.steps[0].velocity
    # The run has the first step or tolerance, whose error is the distance to the finest.
    step = abs(first - result.velocity[0]) + result.velocity[1]
    ripple = 1e-9 * float(np.abs(result.best.curves().series["rotor_velocity"]).max())
    assert abs(first - run) <= left + error + step + ripple
