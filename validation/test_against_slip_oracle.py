"""The slip-only rigid law tends to where the paper's own time stepping tends.

Both sides are stepped, as no event-driven solution exists in stick: the engine with an exact flow between
forces, the oracle with backward Euler. A line through six runs gives the limit of each, and the scatter
about the line, where the law chatters from step to step, how well it is known.
"""

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from oracle.slip_only import solve_rigid_slip
from support.command_line import cases
from support.motors import PLACEMENT_1, default_motor, oracle_motor, random_motor, run

from contactlab.laws import LagrangeSlip

Array = NDArray[np.float64]

STEPS = np.array([2e-7, 1.55e-7, 1.2e-7, 0.93e-7, 0.72e-7, 0.55e-7])
"""Contact steps [s], not multiples of one another."""

SECOND_ORDER = 1.5e-4
"""What the second order of the step may leave in a limit, as a share of a quantity's size."""

CASE_A = "case A"

MOTORS: dict[str, dict[str, float]] = {
    CASE_A: {},
    "placement 1": {**PLACEMENT_1, "frequency": 2019.9, "clearance": 0.5e-6, "phase": 0.4},
    "loaded": {"clearance": 0.0, "load_torque": 2e-3, "rotor_damping": 1e-4, "initial_velocity": -0.9},
    "strong": {"voltage_1": 400.0, "voltage_2": 300.0, "friction_coefficient": 0.8},
    "random": random_motor(1),
}


def limit(values: list[ArrayLike]) -> tuple[Array, Array]:
    """Where the line through the runs meets step zero, and the scatter about it."""
    table = np.array(values)
    lines = np.polyfit(STEPS, table, 1)
    residuals = table - (np.outer(STEPS, lines[0]) + lines[1])
    return lines[1], np.sqrt((residuals**2).sum(axis=0) / (len(STEPS) - 2))


@pytest.mark.parametrize("name", cases(MOTORS, (CASE_A,)))
def test_engine_and_paper_stepping_tend_to_the_same_limit(name: str) -> None:
    changes, duration = MOTORS[name], 2e-3
    motor, law = default_motor(**changes), LagrangeSlip(changes.get("friction_coefficient", 0.3))
    runs = [run(motor, law, duration, contact_step=float(h)) for h in STEPS]
    references = [solve_rigid_slip(oracle_motor(**changes), duration, float(h)) for h in STEPS]
    series, impulse = runs[-1].series, runs[-1].contacts["normal_impulse"].sum()
    names = ("rotor_velocity", "tip_normal_displacement")
    sizes = np.array([*(np.abs(series[k]).max() for k in names), impulse, impulse])
    result, scatter = limit(
        [
            [
                *(r.series[k][-1] for k in names),
                *(r.contacts[k].sum() for k in ("normal_impulse", "friction_impulse")),
            ]
            for r in runs
        ]
    )
    expected, other_scatter = limit(
        [[r.rotor_velocity, r.u, sum(r.normal_impulses), sum(r.friction_impulses)] for r in references]
    )
    uncertainty = np.hypot(scatter, other_scatter)
    # The chatter must not be what lets them agree.
    assert np.all(uncertainty <= 2e-3 * sizes)
    assert np.all(np.abs(result - expected) <= 3.0 * uncertainty + SECOND_ORDER * sizes)
    for made, reference in zip(runs, references, strict=True):
        assert made.contacts["start_time"].size == len(reference.starts)
