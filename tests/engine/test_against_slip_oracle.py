"""The slip-only rigid law tends to where the paper's own time stepping tends.

No event-driven solution exists in stick, so that both sides are stepped here: the engine with an exact
flow between forces, the oracle with backward Euler, both of first order and with errors of their own. Each
is run at six steps and a line through the runs gives its limit; where the bodies would stick the law
chatters from step to step, and the scatter about the line says how well the limit is known.

Measured: the limits differ by at most 1.7 times the scatter, or by less than 1.2e-4 of how far a quantity
went, which is what the steps' second order leaves where the first is 1e-3 and more.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from oracle import SlipOnlyRun, solve_rigid_slip, solve_rigid_stick
from support.command_line import cases
from support.motors import PLACEMENT_1, default_motor, oracle_motor, random_motor, run

from contactlab.laws import LagrangeSlip
from contactlab.trajectory import Trajectory

Array = NDArray[np.float64]

STEPS = np.array([2e-7, 1.55e-7, 1.2e-7, 0.93e-7, 0.72e-7, 0.55e-7])
"""Contact steps [s], not multiples of one another."""

SECOND_ORDER = 1.5e-4
"""What the second order of the step may leave in a limit, as a share of a quantity's size."""

CASE_A = "case A"

MOTORS: dict[str, dict[str, float]] = {
    CASE_A: {},
    "placement 1 at its first frequency": {
        **PLACEMENT_1,
        "frequency": 2019.9,
        "clearance": 0.5e-6,
        "phase": 0.4,
    },
    "no clearance, loaded and damped, turning backwards": {
        "clearance": 0.0,
        "load_torque": 2e-3,
        "rotor_damping": 1e-4,
        "initial_velocity": -0.9,
    },
    "high voltages and friction": {"voltage_1": 400.0, "voltage_2": 300.0, "friction_coefficient": 0.8},
    "ratio three to two, six shapes, slippery": {
        "frequency": 3000.0,
        "frequency_ratio": 1.5,
        "phase": 1.0,
        "friction_coefficient": 0.1,
        "shapes": 6,
    },
    "a random motor": random_motor(1),
}

motors = pytest.mark.parametrize("name", cases(MOTORS, (CASE_A,)))


def duration_of(name: str) -> float:
    return 5e-3 if name == CASE_A else 2e-3


@cache
def oracle_runs(name: str) -> list[SlipOnlyRun]:
    motor = oracle_motor(**MOTORS[name])
    return [solve_rigid_slip(motor, duration_of(name), float(h)) for h in STEPS]


@cache
def engine_runs(name: str) -> list[Trajectory]:
    motor = default_motor(**MOTORS[name])
    law = LagrangeSlip(MOTORS[name].get("friction_coefficient", 0.3))
    return [run(motor, law, duration_of(name), contact_step=float(h)) for h in STEPS]


def oracle_ends(r: SlipOnlyRun) -> list[float]:
    """Rotor velocity, angle, displacement, slope, normal and friction impulse."""
    impulses = [r.normal_impulse.sum(), r.friction_impulse.sum()]
    return [r.rotor_velocity, r.rotor_angle, r.u, r.theta, *impulses]


SERIES = ("rotor_velocity", "rotor_angle", "tip_normal_displacement", "tip_slope")


def engine_ends(r: Trajectory) -> list[float]:
    """The same from the engine."""
    impulses = [r.contacts[name].sum() for name in ("normal_impulse", "friction_impulse")]
    return [*(float(r.series[name][-1]) for name in SERIES), *impulses]


def sizes_of(r: Trajectory) -> Array:
    """How large each of them became; a friction impulse is measured by the normal one."""
    impulse = r.contacts["normal_impulse"].sum()
    return np.array([*(np.abs(r.series[name]).max() for name in SERIES), impulse, impulse])


def limit(values: Sequence[ArrayLike]) -> tuple[Array, Array]:
    """Where the line through the runs meets step zero, and the scatter about it."""
    table = np.array(values)
    lines = np.polyfit(STEPS, table, 1)
    residuals = table - (np.outer(STEPS, lines[0]) + lines[1])
    return lines[1], np.sqrt((residuals**2).sum(axis=0) / (len(STEPS) - 2))


@motors
def test_engine_and_paper_stepping_tend_to_the_same_limit(name: str) -> None:
    sizes = sizes_of(engine_runs(name)[-1])
    found, scatter = limit([engine_ends(r) for r in engine_runs(name)])
    expected, other_scatter = limit([oracle_ends(r) for r in oracle_runs(name)])
    uncertainty = np.hypot(scatter, other_scatter)
    # The chatter must not be what lets them agree.
    assert np.all(uncertainty <= 2e-3 * sizes)
    assert np.all(np.abs(found - expected) <= 3.0 * uncertainty + SECOND_ORDER * sizes)


@motors
def test_engine_makes_the_contacts_of_the_paper_stepping(name: str) -> None:
    pairs = list(zip(engine_runs(name), oracle_runs(name), strict=True))
    for trajectory, reference in pairs:
        assert len(trajectory.contacts["start_time"]) == len(reference.start_time)
    for column in ("normal_impulse", "friction_impulse"):
        found, scatter = limit([trajectory.contacts[column] for trajectory, _ in pairs])
        expected, other_scatter = limit([getattr(reference, column) for _, reference in pairs])
        uncertainty = np.hypot(scatter, other_scatter)
        allowed = 3.0 * uncertainty + SECOND_ORDER * pairs[-1][1].normal_impulse.max()
        assert np.all(np.abs(found - expected) <= allowed), column


def test_case_a_tends_to_the_known_rotor_velocity_and_impact() -> None:
    # The paper's stepping as others programmed it: -0.4836 rad/s at 1e-8 s, peaks of 15459 N there.
    expected, scatter = limit([oracle_ends(r) for r in oracle_runs(CASE_A)])
    assert expected[0] == pytest.approx(-0.4836, abs=3.0 * scatter[0] + 1e-4)
    impacts = [[r.peak_normal_force.max() * h] for r, h in zip(oracle_runs(CASE_A), STEPS, strict=True)]
    assert limit(impacts)[0] == pytest.approx([15459.0 * 1e-8], rel=2e-4)


def test_peak_force_grows_exactly_as_the_step_shrinks() -> None:
    peaks = [r.peak_normal_force.max() for r in oracle_runs(CASE_A)]
    found = [r.contacts["peak_normal_force"].max() for r in engine_runs(CASE_A)]
    for values in (peaks, found):
        assert np.polyfit(np.log(STEPS), np.log(values), 1)[0] == pytest.approx(-1.0, abs=5e-3)


def test_friction_impulse_reverses_the_slip_in_nearly_every_impact_of_case_a() -> None:
    for reference in oracle_runs(CASE_A):
        # All but the first, which the rotor meets at rest.
        assert reference.reversals.tolist() == [False] + 15 * [True]
    slippery = oracle_motor(**MOTORS["ratio three to two, six shapes, slippery"])
    assert not solve_rigid_slip(slippery, 2e-3, float(STEPS[0])).reversals.any()


def test_without_friction_the_paper_stepping_tends_to_the_event_driven_solution() -> None:
    motor = oracle_motor(friction_coefficient=0.0)
    exact = solve_rigid_stick(motor, 1e-3)
    assert len(exact.start_time) > 2
    runs = [solve_rigid_slip(motor, 1e-3, float(h)) for h in STEPS]
    found, scatter = limit([[r.u, r.theta, r.normal_impulse.sum()] for r in runs])
    expected = np.array([exact.u, exact.theta, exact.normal_impulse.sum()])
    allowed = 3.0 * scatter + SECOND_ORDER * np.abs(expected)
    assert np.all(np.abs(found - expected) <= allowed)


def test_paper_stepping_refuses_what_it_cannot_step() -> None:
    with pytest.raises(ValueError, match="step"):
        solve_rigid_slip(oracle_motor(), 1e-3, 0.0)
    with pytest.raises(ValueError, match="clearance"):
        solve_rigid_slip(oracle_motor(clearance=-1e-6), 1e-3, 1e-7)
