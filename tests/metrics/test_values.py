"""Every metric of a run, on a dataset whose answers are found with pencil and paper."""

import json
from collections.abc import Mapping
from math import isnan, nan
from typing import Any

import numpy as np
import pytest
from support.plausibility_trees import (
    CONFIGURATION,
    FIRST,
    INTERVALS,
    LONG,
    MEAN_FORCE,
    NORMAL_AMPLITUDE,
    SECOND,
    TANGENTIAL_AMPLITUDE,
    TIME,
    contacts,
    series,
    tree,
)

from contactlab.laws import hertz_stiffness
from contactlab.metrics import FAIL, METRICS, SENSITIVITIES, STEP_METRICS, Metric, assess

EXPECTED = {
    "energy_residual": 0.0,
    "rotor_momentum": 0.0,
    "impulse_balance": 0.0,
    "penetration_over_radius": 1.0 / 256.0,
    "penetration_over_amplitude": 1.0 / 32.0 / NORMAL_AMPLITUDE,
    "tension": 0.0,
    "force_at_distance": 0.0,
    "cone_excess": 0.0,
    "friction_gain": 0.0,
    "normal_gain": 0.0,
    "contact_gain": 0.0,
    "stick_slip": nan,
    "slip_reversal": 0.0,
    "friction_work": 0.0,
    "peak_force": 32.0,
    "mean_impulse": 1.875,
    "total_impulse": 3.75,
    "total_friction_impulse": -0.75,
    "contact_time": 0.25,
    "contact_duration": 0.125,
    "stick_share": 0.25,
    "restitution": 0.5,
    "hertz_duration_ratio": nan,
    "rotor_velocity": 0.1875,
    "final_rotor_velocity": 0.1875,
    "torque": 0.0,
    "efficiency": 0.0,
    "friction_share": 0.2,
    "normal_loss_share": 0.1,
}


def failed(values: dict[str, float]) -> list[str]:
    return [key for key, metric in METRICS.items() if metric.verdict(values[key]) == FAIL]


def all_of(value: float) -> np.ndarray:
    return np.full_like(TIME, value)


def with_records(name: str, records: object, value: float) -> dict[str, np.ndarray]:
    changed = series()[name].copy()
    changed[records] = value
    return {name: changed}


def configured(section: str, **keys: float) -> dict[str, Any]:
    return CONFIGURATION | {section: CONFIGURATION[section] | keys}


def fallen(loss: str) -> dict[str, np.ndarray]:
    """It falls by a half of what it is after the first contact and stays, the books closed."""
    lost = series()[loss]
    less = lost - 0.5 * lost[FIRST + LONG] * (TIME[FIRST + LONG + 2] <= TIME)
    return {loss: less, "kinetic_energy": series()["kinetic_energy"] + lost - less}


def giving_friction() -> dict[str, np.ndarray]:
    """It takes 1 J in the first contact and gives 0.25 J in the second, the books closed."""
    lost = series()["friction_loss"]
    less = np.minimum(lost, 1.0) - 0.25 * np.maximum(lost - 1.0, 0.0)
    return {"friction_loss": less, "kinetic_energy": series()["kinetic_energy"] + lost - less}


def reversed_slip(after: float) -> dict[str, np.ndarray]:
    """The second contact goes with the slip that it finds, and keeps its sign."""
    return {"slip_velocity": np.where(TIME[FIRST] < TIME, after, 1.0)}


def sticking(first: float, inside: float) -> dict[str, np.ndarray]:
    stuck = slice(SECOND + 4, SECOND + 10)
    slip = with_records("slip_velocity", stuck, 0.0)["slip_velocity"]
    slip[SECOND + 4], slip[SECOND + 6] = first, inside
    return with_records("contact_mode", stuck, 2.0) | {"slip_velocity": slip}


def single_peak() -> np.ndarray:
    return with_records("gap", slice(None), 0.0)["gap"] + (np.arange(TIME.size) == FIRST + 1)


def test_every_metric_is_measured_and_an_honest_dataset_fails_none() -> None:
    result = assess(tree())
    assert list(result) == list(METRICS)
    for key, expected in EXPECTED.items():
        assert result[key] == pytest.approx(expected, rel=1e-12, abs=1e-14, nan_ok=True), key
    assert failed(result) == []


@pytest.mark.parametrize("catalogue", [METRICS, STEP_METRICS, SENSITIVITIES])
def test_every_threshold_has_a_reason_and_every_metric_symbol_unit_and_meaning(
    catalogue: Mapping[str, Metric],
) -> None:
    for key, metric in catalogue.items():
        assert metric.key == key
        assert metric.symbol
        assert metric.units
        assert metric.meaning
        assert bool(metric.reason) == bool(metric.threshold), key
        assert not metric.threshold or metric.source, key


LOAD_BY_HAND = {"configuration": configured("rotor", load_torque=0.125)}
STEEPER = {"friction_force": -0.5 * series()["normal_force"]}
ENERGY = series()["kinetic_energy"] + 0.5 * (TIME > 0.5)
DAMPED = {"configuration": configured("rotor", damping=0.75)}
PULL = with_records("normal_force", FIRST + LONG, -3.0)
IN_STEP = series()["friction_loss"] - 0.125 * (TIME[FIRST] < TIME)
ITS_OWN = {"slip_velocity": TIME[FIRST] + 0.5 / INTERVALS - TIME}
SHORT_GAP = {"gap": np.abs(TIME - TIME[FIRST] - 0.5 / INTERVALS), "normal_force": single_peak()}
"""The gap falls and rises as fast as it may close within an interval."""


@pytest.mark.parametrize(
    ("arguments", "key", "expected", "fails"),
    [
        # Energy that the terms do not explain is a share of the drive work.
        ({"changes": {"kinetic_energy": ENERGY}}, "energy_residual", 0.05, ["energy_residual"]),
        # R sum|p_t| is 0.375, the rotor has 0.375 too: a load that it does not carry is missing.
        (LOAD_BY_HAND, "rotor_momentum", 1.0 / 3.0, ["rotor_momentum"]),
        (DAMPED, "rotor_momentum", 2.0 * series()["rotor_angle"][-1], ["rotor_momentum"]),
        (
            {"table": {"normal_impulse": np.array([1.25, 2.75])}},
            "impulse_balance",
            0.25 / 4.75,
            ["impulse_balance"],
        ),
        # Cohesion alone: friction without a normal force is balanced by its own size.
        (
            {
                "changes": {"normal_force": all_of(0.0)},
                "table": {
                    "normal_impulse": np.array([1e-12, -1e-12]),
                    "friction_impulse": np.array([-0.25, -0.5 + 2e-8]),
                },
            },
            "impulse_balance",
            2e-8 / 0.75,
            None,
        ),
        # A pull is measured by the mean force in contact.
        (
            {"changes": PULL, "without": ("contact_mode",)},
            "tension",
            3.0 / MEAN_FORCE,
            ["impulse_balance", "tension", "cone_excess"],
        ),
        # The gap is wide and constant, the force stays: weighed by the gap that is certain.
        (
            {"changes": {"gap": all_of(0.125)}},
            "force_at_distance",
            20.0 * 0.125 / MEAN_FORCE / NORMAL_AMPLITUDE,
            ["force_at_distance"],
        ),
        ({"changes": SHORT_GAP}, "force_at_distance", 0.0, None),
        # A millionth of the bound is left for round-off.
        (
            {"changes": STEEPER},
            "cone_excess",
            (0.25 - 0.25e-6) * 20.0 / MEAN_FORCE,
            ["impulse_balance", "cone_excess"],
        ),
        (
            {"changes": STEEPER, "law_parameters": json.dumps({"friction.static_ratio": 2.0})},
            "cone_excess",
            0.0,
            ["impulse_balance"],
        ),
        # Falls of a loss are a share of all changes of both.
        # The rows, which have no fall, no longer sum to it.
        ({"changes": fallen("friction_loss")}, "friction_gain", 0.5 / 3.5, ["loss_balance", "friction_gain"]),
        ({"changes": fallen("contact_loss")}, "normal_gain", 0.25 / 3.25, ["loss_balance", "normal_gain"]),
        # A fall within the step of an impact is left to the slip that it leaves.
        ({"changes": {"friction_loss": IN_STEP}}, "friction_gain", 0.0, None),
        # Energy from contacts is a share of the energy that all exchange.
        ({"table": {"energy_loss": np.array([4.5, -1.5])}}, "contact_gain", 0.25, ["contact_gain"]),
        # The rows sum to the losses of friction and contact.
        ({"table": {"energy_loss": np.array([1.5, 2.25])}}, "loss_balance", 0.2, ["loss_balance"]),
        # Slip while sticking counts where the neighbours stick too: the first record is on the switch.
        ({"changes": sticking(0.0, 0.0)}, "stick_slip", 0.0, []),
        ({"changes": sticking(0.5, 0.0)}, "stick_slip", 0.0, []),
        (
            {"changes": sticking(0.5, -1.0 / 32.0)},
            "stick_slip",
            1.0 / 32.0 / TANGENTIAL_AMPLITUDE,
            ["stick_slip"],
        ),
        # Friction gives back a quarter of what it took in the contact before.
        (
            {"changes": giving_friction()},
            "friction_work",
            0.2,
            ["loss_balance", "friction_gain", "friction_work"],
        ),
        # Friction that turns the slip around is counted by touch-downs, and not judged: a spring may.
        ({"changes": reversed_slip(-0.5)}, "slip_reversal", 0.5, []),
        # A slip that passes zero as fast as it changed before is its own doing; round-off has no sign.
        ({"changes": ITS_OWN}, "slip_reversal", 0.0, []),
        ({"changes": reversed_slip(-1e-12)}, "slip_reversal", 0.0, []),
        # A constant friction of -2 N at half a metre, and a fifth of what the drive gives.
        ({"changes": {"friction_force": all_of(-2.0)}}, "torque", 1.0, None),
        ({"changes": {"load_work": 2.0 * TIME}}, "efficiency", 0.2, None),
        # A load that drives has no efficiency.
        ({"changes": {"load_work": -2.0 * TIME}}, "efficiency", nan, None),
        # The bandwidth of a sine is its frequency; 2 k of 127 equal shares of a peak lie up to line k.
        ({"changes": {"normal_force": np.cos(2.0 * np.pi * 16.0 * TIME)}}, "force_bandwidth", 16.0, None),
        ({"changes": {"normal_force": single_peak()}}, "force_bandwidth", 63.0, None),
        # A mean, as that of a preload, has no frequency, and a force that is constant no bandwidth.
        (
            {"changes": {"normal_force": 9.0 + np.cos(2.0 * np.pi * 16.0 * TIME)}},
            "force_bandwidth",
            16.0,
            None,
        ),
        ({"changes": {"normal_force": all_of(5.0)}}, "force_bandwidth", nan, None),
    ],
)
def test_a_change_has_its_answer_and_fails_no_other_line(
    arguments: dict[str, Any], key: str, expected: float, fails: list[str] | None
) -> None:
    result = assess(tree(**arguments))
    assert result[key] == pytest.approx(expected, rel=1e-12, abs=1e-14, nan_ok=True)
    assert fails is None or failed(result) == fails


def test_penetration_is_measured_by_the_radius_of_a_tip_with_the_laws_stiffness() -> None:
    unknown = configured("law", tip_radius=None)
    parameters = json.dumps({"stiffness": hertz_stiffness(5e-3, 0.5)})
    depth = {"max_penetration": np.array([1e-6, 2e-6])}
    result = assess(tree(table=depth, configuration=unknown, law_parameters=parameters))
    assert result["penetration_over_radius"] == pytest.approx(2e-6 / 5e-3, rel=1e-9)
    without = assess(tree(configuration=unknown, law="lagrange_stick"))
    assert isnan(without["penetration_over_radius"])


def test_the_mean_velocity_is_of_whole_periods_in_the_last_quarter() -> None:
    # A run of three periods: the last one, though it is longer than a quarter.
    slow = configured("drive", frequency=3.0)
    angle = np.where(TIME[85] >= TIME, 0.0, TIME - TIME[85])
    result = assess(tree({"rotor_angle": angle}, configuration=slow))
    assert result["rotor_velocity"] == pytest.approx(1.0)
    # Of a run that is shorter than a period there is none.
    shorter = configured("drive", frequency=0.5)
    assert isnan(assess(tree(configuration=shorter))["rotor_velocity"])
    # Without a known drive it is the last quarter.
    without = {key: value for key, value in CONFIGURATION.items() if key != "drive"}
    assert assess(tree(configuration=without))["rotor_velocity"] == pytest.approx(0.1875)


def test_contacts_that_never_were_leave_what_needs_them_not_applicable() -> None:
    none = {name: np.empty(0) for name in contacts()}
    still = ("normal_force", "friction_force", "friction_loss", "contact_loss", "rotor_velocity")
    quiet = dict.fromkeys((*still, "rotor_angle", "contact_mode"), all_of(0.0))
    quiet["kinetic_energy"] = 6.0 * TIME
    quiet["gap"] = all_of(1.0 / 16.0)
    result = assess(tree(quiet, table=none))
    applicable = {key for key, value in result.items() if not isnan(value)}
    assert applicable == {
        "energy_residual",
        "missed_contact",
        "contact_count",
        "rotor_velocity",
        "final_rotor_velocity",
        "torque",
        "efficiency",
        "friction_share",
        "normal_loss_share",
    }
    assert failed(result) == []
