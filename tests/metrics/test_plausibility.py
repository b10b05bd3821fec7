"""Every metric of a run, on a dataset whose answers are found with pencil and paper."""

import json
from math import isnan, nan

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
    touching,
    tree,
)

from contactlab.laws import hertz_stiffness
from contactlab.metrics import FAIL, METRICS, NOT_APPLICABLE, assess

ANSWERS = {
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


def replaced(name: str, values: object) -> dict[str, np.ndarray]:
    return {name: np.broadcast_to(np.asarray(values, dtype=float), TIME.shape).copy()}


def with_records(name: str, records: object, value: float) -> dict[str, np.ndarray]:
    changed = series()[name].copy()
    changed[records] = value
    return {name: changed}


def test_every_metric_is_measured_and_an_honest_dataset_fails_none() -> None:
    found = assess(tree())
    assert list(found) == list(METRICS)
    for key, answer in ANSWERS.items():
        assert found[key] == pytest.approx(answer, rel=1e-12, abs=1e-14, nan_ok=True), key
    assert failed(found) == []


def test_every_threshold_has_a_reason_and_every_metric_symbol_unit_and_meaning() -> None:
    for key, metric in METRICS.items():
        assert metric.key == key
        assert metric.symbol
        assert metric.units
        assert metric.meaning
        assert bool(metric.reason) == bool(metric.threshold), key
        assert not metric.threshold or metric.source, key


def test_energy_that_the_terms_do_not_explain_is_a_share_of_the_drive_work() -> None:
    more = series()["kinetic_energy"] + 0.5 * (TIME > 0.5)
    found = assess(tree({"kinetic_energy": more}))
    assert found["energy_residual"] == pytest.approx(0.05, rel=1e-12)
    assert failed(found) == ["energy_residual"]


def test_a_rotor_that_turns_without_impulses_has_momentum_from_nowhere() -> None:
    # R sum|p_t| is 0.375, the rotor has 0.375 too: a load that it does not carry is missing.
    rotor = CONFIGURATION["rotor"] | {"load_torque": 0.125}
    found = assess(tree(configuration=CONFIGURATION | {"rotor": rotor}))
    assert found["rotor_momentum"] == pytest.approx(1.0 / 3.0)
    assert failed(found) == ["rotor_momentum"]


def test_damping_of_the_rotor_is_part_of_its_balance() -> None:
    angle = series()["rotor_angle"]
    rotor = CONFIGURATION["rotor"] | {"damping": 0.75}
    found = assess(tree(configuration=CONFIGURATION | {"rotor": rotor}))
    assert found["rotor_momentum"] == pytest.approx(2.0 * angle[-1])


def test_impulses_are_the_integrals_of_the_forces() -> None:
    found = assess(tree(table={"normal_impulse": np.array([1.25, 2.75])}))
    assert found["impulse_balance"] == pytest.approx(0.25 / 4.0)
    assert failed(found) == ["impulse_balance"]


def test_penetration_is_measured_by_the_radius_of_a_tip_with_the_laws_stiffness() -> None:
    unknown = CONFIGURATION | {"law": {"name": "hertz_penalty", "tip_radius": None}}
    parameters = json.dumps({"stiffness": hertz_stiffness(5e-3, 0.5)})
    depth = {"max_penetration": np.array([1e-6, 2e-6])}
    found = assess(tree(table=depth, configuration=unknown, law_parameters=parameters))
    assert found["penetration_over_radius"] == pytest.approx(2e-6 / 5e-3, rel=1e-9)
    without = assess(tree(configuration=unknown, law="lagrange_stick"))
    assert METRICS["penetration_over_radius"].verdict(without["penetration_over_radius"]) == (
        NOT_APPLICABLE
    )


def test_a_pull_is_measured_by_the_mean_force_in_contact() -> None:
    found = assess(
        tree(with_records("normal_force", FIRST + LONG, -3.0), without=("contact_mode",))
    )
    assert found["tension"] == pytest.approx(3.0 / MEAN_FORCE)
    assert "tension" in failed(found)


def test_a_force_at_a_distance_is_weighed_by_the_gap_that_is_certain() -> None:
    # The gap is wide and constant, the force stays.
    found = assess(tree(replaced("gap", 0.125)))
    assert found["force_at_distance"] == pytest.approx(20.0 * 0.125 / MEAN_FORCE / NORMAL_AMPLITUDE)
    assert failed(found) == ["force_at_distance"]


def test_a_contact_between_two_open_records_is_no_force_at_a_distance() -> None:
    # The gap falls and rises as fast as it may close within an interval.
    gap = np.abs(TIME - TIME[FIRST] - 0.5 / INTERVALS)
    only = np.zeros_like(TIME)
    only[FIRST + 1] = 1.0
    found = assess(tree({"gap": gap, "normal_force": only}))
    assert found["force_at_distance"] == 0.0


def test_friction_beyond_the_cone_is_measured_by_the_mean_force() -> None:
    found = assess(tree({"friction_force": -0.5 * series()["normal_force"]}))
    # A millionth of the bound is left for round-off.
    assert found["cone_excess"] == pytest.approx(0.25 * 20.0 / MEAN_FORCE, rel=1e-5)
    assert failed(found) == ["impulse_balance", "cone_excess"]


def test_a_static_ratio_widens_the_cone() -> None:
    parameters = json.dumps({"friction.static_ratio": 2.0})
    friction = {"friction_force": -0.5 * series()["normal_force"]}
    assert assess(tree(friction, law_parameters=parameters))["cone_excess"] == 0.0


@pytest.mark.parametrize(
    ("loss", "key", "scale"),
    [("friction_loss", "friction_gain", 2.0), ("contact_loss", "normal_gain", 1.0)],
)
def test_falls_of_a_loss_are_a_share_of_all_changes(loss: str, key: str, scale: float) -> None:
    lost = series()[loss]
    # It falls by a half of what it is after the first contact and stays.
    fallen = lost - 0.5 * lost[FIRST + LONG] * (TIME[FIRST + LONG + 2] <= TIME)
    balanced = series()["kinetic_energy"] + lost - fallen
    found = assess(tree({loss: fallen, "kinetic_energy": balanced}))
    fall = 0.25 * scale
    assert found[key] == pytest.approx(fall / (3.0 + fall))
    assert failed(found) == [key]


def test_a_fall_within_the_step_of_an_impact_is_left_to_the_slip_it_leaves() -> None:
    lost = series()["friction_loss"].copy()
    lost[FIRST + 1 :] -= 0.125
    assert assess(tree({"friction_loss": lost}))["friction_gain"] == 0.0


def test_energy_from_contacts_is_a_share_of_the_energy_that_all_exchange() -> None:
    found = assess(tree(table={"energy_loss": np.array([3.0, -1.0])}))
    assert found["contact_gain"] == 0.25
    assert failed(found) == ["contact_gain"]


def test_slip_while_sticking_is_measured_where_the_neighbours_stick_too() -> None:
    inside = slice(SECOND + 4, SECOND + 10)
    stuck = with_records("contact_mode", inside, 2.0)
    slip = series()["slip_velocity"].copy()
    slip[inside] = 0.0
    assert assess(tree(stuck | {"slip_velocity": slip}))["stick_slip"] == 0.0
    # The first record lies on the switch, whatever its slip.
    slip[SECOND + 4] = 0.5
    assert assess(tree(stuck | {"slip_velocity": slip}))["stick_slip"] == 0.0
    slip[SECOND + 6] = -1.0 / 32.0
    found = assess(tree(stuck | {"slip_velocity": slip}))
    assert found["stick_slip"] == pytest.approx(1.0 / 32.0 / TANGENTIAL_AMPLITUDE)
    assert failed(found) == ["stick_slip"]


def test_friction_that_turns_the_slip_around_is_counted_by_touch_downs() -> None:
    slip = replaced("slip_velocity", 1.0)["slip_velocity"]
    slip[FIRST + 1 :] = -0.5
    # The second contact goes with the slip that it finds, and keeps its sign.
    found = assess(tree({"slip_velocity": slip}))
    assert found["slip_reversal"] == 0.5
    assert failed(found) == ["slip_reversal"]
    # A slip that passes zero as fast as it changed before is its own doing.
    passing = {"slip_velocity": TIME[FIRST] + 0.5 / INTERVALS - TIME}
    assert assess(tree(passing))["slip_reversal"] == 0.0
    # Round-off has no sign.
    slip[FIRST + 1 :] = -1e-12
    assert assess(tree({"slip_velocity": slip}))["slip_reversal"] == 0.0


def test_without_friction_there_is_no_slip_to_reverse() -> None:
    frictionless = replaced("friction_force", 0.0)
    found = assess(tree(frictionless, table={"friction_impulse": np.zeros(2)}))
    assert isnan(found["slip_reversal"])
    assert isnan(found["rotor_momentum"])


def test_a_load_is_driven_by_torque_at_an_efficiency() -> None:
    # A constant friction of -2 N at half a metre, and a fifth of what the drive gives.
    found = assess(tree(replaced("friction_force", -2.0) | {"load_work": 2.0 * TIME}))
    assert found["torque"] == pytest.approx(1.0)
    assert found["efficiency"] == pytest.approx(0.2)


def test_a_load_that_drives_has_no_efficiency() -> None:
    assert isnan(assess(tree({"load_work": -2.0 * TIME}))["efficiency"])


def test_the_mean_velocity_is_of_whole_periods_in_the_last_quarter() -> None:
    # A run of three periods: the last one, though it is longer than a quarter.
    slow = CONFIGURATION | {"drive": {"frequency": 3.0}}
    angle = np.where(TIME[85] >= TIME, 0.0, TIME - TIME[85])
    found = assess(tree({"rotor_angle": angle}, configuration=slow))
    assert found["rotor_velocity"] == pytest.approx(1.0)
    # Of a run that is shorter than a period there is none.
    shorter = CONFIGURATION | {"drive": {"frequency": 0.5}}
    assert isnan(assess(tree(configuration=shorter))["rotor_velocity"])
    # Without a known drive it is the last quarter.
    without = {key: value for key, value in CONFIGURATION.items() if key != "drive"}
    assert assess(tree(configuration=without))["rotor_velocity"] == pytest.approx(0.1875)


def test_the_bandwidth_of_a_sine_is_its_frequency_and_of_one_peak_that_of_the_records() -> None:
    sine = np.cos(2.0 * np.pi * 16.0 * TIME)
    assert assess(tree({"normal_force": sine}))["force_bandwidth"] == pytest.approx(16.0)
    peak = np.zeros_like(TIME)
    peak[FIRST + 1] = 1.0
    # 1 + 2 k of 128 equal shares lie up to line k.
    assert assess(tree({"normal_force": peak}))["force_bandwidth"] == pytest.approx(63.0)


def test_contacts_that_never_were_leave_what_needs_them_not_applicable() -> None:
    none = {name: np.empty(0) for name in contacts()}
    zero = np.zeros_like(TIME)
    still = ("normal_force", "friction_force", "friction_loss", "contact_loss", "rotor_velocity")
    quiet = dict.fromkeys((*still, "rotor_angle", "contact_mode"), zero)
    quiet["kinetic_energy"] = 6.0 * TIME
    quiet["gap"] = np.full_like(TIME, 1.0 / 16.0)
    found = assess(tree(quiet, table=none))
    applicable = {key for key, value in found.items() if not isnan(value)}
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
    assert failed(found) == []


def test_two_intervals_of_touching_are_what_the_helper_says() -> None:
    assert touching().sum() == 2 * LONG
