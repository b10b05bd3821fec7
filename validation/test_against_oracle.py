"""Motors end where the independent event-driven solver ends; rigid contact tends to it with first order."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from oracle.composed import Judge, Parts
from oracle.friction_parts import SetValued
from oracle.normal_parts import Power
from support.command_line import cases
from support.motors import PLACEMENT_1, default_motor, final, oracle_motor, random_motor, random_stiffness

from contactlab.engine import simulate
from contactlab.laws import Composed
from contactlab.laws.friction import Coulomb
from contactlab.laws.normal import HertzPoint

DURATION = 3e-3
LOADED = "no clearance, loaded and damped, turning backwards"
STRONG = "high voltages and friction"
OBLIQUE = "rotor beside the tip's axis"

MOTORS: dict[str, dict[str, float]] = {
    "placement 1": {**PLACEMENT_1, "frequency": 2019.9, "clearance": 0.5e-6, "phase": 0.4},
    LOADED: {"clearance": 0.0, "load_torque": 2e-3, "rotor_damping": 1e-4, "initial_velocity": -0.9},
    STRONG: {"voltage_1": 400.0, "voltage_2": 300.0, "friction_coefficient": 0.8},
    "ratio three to two, six shapes": {
        "frequency": 3000.0, "frequency_ratio": 1.5, "phase": 1.0, "friction_coefficient": 0.1, "shapes": 6,
    },
    "one tone, patches in between, fast rotor": {
        "patch_start": 5e-3, "patch_end": 14e-3, "frequency": 2600.0, "frequency_ratio": 1.0,
        "initial_velocity": 3.0, "rotor_damping": 5e-4,
    },
    "small light rotor, short tip, light damping": {
        "rotor_radius": 10e-3, "tip_length": 12e-3, "rotor_inertia": 4e-6, "mass_damping": 60.0,
        "stiffness_damping": 4e-6, "phase": -2.0,
    },
    OBLIQUE: {"angle": 0.5, "friction_coefficient": 0.4, "phase": 0.2},
}  # fmt: skip
STIFFNESSES = dict(zip(MOTORS, (1e10, 1e10, 3e9, 1e9, 2e10, 1e9, 5e9), strict=True))

STATIC = {216: 1.2, 291: 2.5}
"""Static over kinetic friction of random motors that once left their stick too early or slipped too late."""


def friction_of(changes: dict[str, float]) -> float:
    return changes.get("friction_coefficient", 0.3)


def assert_hertz_agrees(
    changes: dict[str, float], stiffness: float, ratio: float = 1.0, tolerance: float | None = None
) -> None:
    mu, motor = friction_of(changes), oracle_motor(**changes)
    judge = Judge(motor, Parts(Power(stiffness, 1.5), SetValued(mu, ratio)), 1e-11).run(DURATION)
    law = Composed(HertzPoint(stiffness), friction=Coulomb(mu, static_ratio=ratio))
    made = simulate(
        default_motor(**changes), law, duration=DURATION, record_interval=1e-5, tolerance=tolerance
    )
    assert made.complete, made.message
    # Both are good to about 1e-9; contacts amplify it, grazing ones most.
    contacts, largest = made.contacts, max([1e-12, *judge.normal_impulses])
    counts = contacts["normal_impulse"] > 1e-6 * largest, np.array(judge.normal_impulses) > 1e-6 * largest
    for name, values, scale in (
        ("start_time", judge.starts, 1e-3),
        ("duration", judge.durations, 1e-3),
        ("normal_impulse", judge.normal_impulses, largest),
        ("friction_impulse", judge.friction_impulses, largest),
    ):
        expected = np.array(values)[counts[1]]
        assert_allclose(contacts[name][counts[0]], expected, rtol=0.0, atol=2e-6 * scale, err_msg=name)
    for name, end in (("rotor_velocity", judge.rotor_velocity), ("tip_normal_displacement", judge.u)):
        travel = np.abs(made.series[name]).max()
        assert final(made, name) == pytest.approx(end, abs=1e-6 * travel), name


@pytest.mark.parametrize("name", cases(MOTORS, (LOADED, STRONG, OBLIQUE)))
def test_hertz_ends_where_the_oracle_ends(name: str) -> None:
    assert_hertz_agrees(MOTORS[name], STIFFNESSES[name])


@pytest.mark.parametrize("seed", cases(STATIC, (216,)))
def test_stick_begins_and_ends_at_the_static_cone_of_the_instant(seed: int) -> None:
    assert_hertz_agrees(random_motor(seed), random_stiffness(seed), STATIC[seed], 1e-10)
