"""The text at the end of a run says what the run holds, in units that are handy to read."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest
from support.motors import default_motor, hertz
from support.synthetic import CONFIGURATION, synthetic_trajectory

from contactlab.engine import simulate
from contactlab.laws import HertzPenalty
from contactlab.results.netcdf import to_datatree
from contactlab.results.summary import prefixed, prefixed_unit, summarise
from contactlab.trajectory import Ending


def lines_of(text: str) -> dict[str, str]:
    """Value by label."""
    split = (line.split("  ", maxsplit=1) for line in text.splitlines())
    return {label: value.strip() for label, value in split}


def test_every_number_is_that_of_the_trajectory() -> None:
    lines = lines_of(summarise(to_datatree(synthetic_trajectory(), CONFIGURATION), wall_time=1.25e-3))
    assert lines == {
        "law": "hertz_penalty (stiffness 1e+10, friction_coefficient 0.3, contact step 2 us)",
        "contacts": "16, 960 us in contact, 240 us of it sticking",
        "rotor velocity": "-0.441758 rad/s after 5 ms",
        "steady state": "cannot tell: the run has 15 whole periods of the drive, and it takes 40 to tell. "
        "Let it run on, solver.until=steady solver.duration=0.05, or find its steady state at once: "
        "contactlab steady.",
        "peak normal force": "9 N",
        "normal impulse": "0.00550039 N s in all",
        "ledger residual": "-9.6e-14 J, 7.1e-12 of the drive work",
        "speed": "5 ms of motor in 1.25 ms, 4 times real time",
    }


def test_values_are_aligned_and_plain() -> None:
    text = summarise(to_datatree(synthetic_trajectory(), CONFIGURATION), wall_time=1.25e-3)
    lines = text.splitlines()
    column = lines[0].index("hertz_penalty")
    assert all(line[column - 1] == " " != line[column] for line in lines)
    assert text.isascii()


def test_a_run_without_contact_says_so() -> None:
    trajectory = synthetic_trajectory(contact=False)
    lines = lines_of(summarise(to_datatree(trajectory, CONFIGURATION), wall_time=1e-3))
    assert lines["contacts"].startswith("none: of the clearance, 1 um, the tip bridged at most ")
    assert lines["peak normal force"] == "0 N"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"clearance": 3e-5}, "{way}; settled and free it reaches {reach} and never touches. Lower contact."),
        ({}, "{way} so far, and {reach} once it has settled. Raise solver.duration."),
        ({"voltage_1": 0.0, "voltage_2": 0.0}, "0 m, and nothing moves it. Raise the drive's voltages."),
    ],
    ids=["never", "not yet", "silent"],
)
def test_a_tip_that_touches_nothing_is_told_whether_it_ever_will(
    changes: dict[str, float], words: str
) -> None:
    motor = default_motor(**changes)
    duration = 0.2 if "clearance" in changes else 6e-5
    trajectory = simulate(motor, hertz(), duration=duration, record_interval=5e-6)
    tree = to_datatree(trajectory)
    # What a run that has settled bridges, with nothing to touch.
    far = replace(motor, geometry=replace(motor.geometry, clearance=3e-5))
    late = simulate(far, hertz(), duration=0.2, record_interval=5e-6).series["gap"][-2000:]
    assert tree.attrs["free_reach"] == pytest.approx(3e-5 - late.min(), rel=2e-3, abs=1e-15)
    way = prefixed(max(motor.geometry.clearance - float(trajectory.series["gap"].min()), 0.0), "m")
    told = words.format(way=way, reach=prefixed(tree.attrs["free_reach"], "m")).replace("µ", "u")
    assert told in lines_of(summarise(tree))["contacts"]


def test_a_run_cut_short_ends_with_its_reason() -> None:
    trajectory = synthetic_trajectory(ending=Ending.DIVERGED, message="The gap is no number.")
    lines = summarise(to_datatree(trajectory, CONFIGURATION), wall_time=1e-3).splitlines()
    assert lines[-1].split(maxsplit=1) == ["incomplete", "The gap is no number."]


def test_a_run_with_an_open_ledger_is_not_called_incomplete() -> None:
    trajectory = synthetic_trajectory(ending=Ending.UNBALANCED, message="The ledger is open.")
    lines = summarise(to_datatree(trajectory, CONFIGURATION), wall_time=1e-3).splitlines()
    assert lines[-1].split(maxsplit=1) == ["unbalanced", "The ledger is open."]
    assert not any(line.startswith("incomplete") for line in lines)


def test_a_complete_run_has_no_reason() -> None:
    assert "incomplete" not in summarise(to_datatree(synthetic_trajectory(), CONFIGURATION), wall_time=1e-3)


@pytest.mark.parametrize("torque", [1e-3, -1e-3])
def test_a_load_brakes_one_direction_and_drives_the_other(torque: float) -> None:
    """J dOmega/dt = -tau, and the work of the rotor on the load is tau times the angle."""
    motor = default_motor(clearance=1e-3, load_torque=torque, initial_velocity=-0.5)
    law = HertzPenalty(stiffness=1e10, friction_coefficient=0.3)
    run = simulate(motor, law, duration=5e-3, record_interval=1e-3)
    change = run.series["rotor_velocity"][-1] - run.series["rotor_velocity"][0]
    assert change == pytest.approx(-torque * 5e-3 / motor.rotor.inertia)
    work = torque * run.series["rotor_angle"][-1]
    assert run.series["load_work"][-1] == pytest.approx(work)
    what = "drives the motor and works on it" if torque > 0.0 else "brakes the motor and takes"
    assert lines_of(summarise(to_datatree(run), wall_time=1e-3))["load"] == f"{what}: {abs(work):.4g} J"


def test_a_preload_is_no_load_of_the_rotor() -> None:
    """Constant modal forces do the work f'q; the rotor carries no torque."""
    motor = default_motor(clearance=1e-3)
    force = 5.0 * motor.modes.tip_displacement
    pressed = dataclasses.replace(motor, preload=force)
    run = simulate(pressed, HertzPenalty(1e10, 0.3), duration=2e-3, record_interval=1e-4)
    work = float(force @ run.final.displacement)
    assert work > 0.0
    lines = lines_of(summarise(to_datatree(run), wall_time=1e-3))
    assert "load" not in lines
    assert lines["preload"].split()[2] == f"{work:.4g}"


@pytest.mark.parametrize("records", [1, 2])
def test_a_run_of_hardly_any_record_divides_by_nothing(records: int) -> None:
    whole = synthetic_trajectory(contact=False)
    trajectory = dataclasses.replace(
        whole,
        time=whole.time[:records],
        series={name: np.zeros(records) for name in whole.series},
        contact_mode=whole.contact_mode[:records],
    )
    lines = lines_of(summarise(to_datatree(trajectory, CONFIGURATION), wall_time=0.0))
    assert lines["ledger residual"] == "0 J, no drive work"
    assert "real time" not in lines["speed"]


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (2.0, "2 s"),
        (5e-3, "5 ms"),
        (1e-3, "1 ms"),
        (0.9999999e-3, "1 ms"),
        (248.31e-6, "248.3 µs"),
        (3e-9, "3 ns"),
        (-2e-3, "-2 ms"),
        (0.0, "0 s"),
    ],
)
def test_a_time_is_read_in_its_own_unit(size: float, text: str) -> None:
    assert prefixed(size, "s") == text


def test_a_smaller_number_is_kept_in_the_larger_unit_on_request() -> None:
    assert prefixed_unit(0.5e-6, "m", smallest=0.1) == ("µm", 1e-6)
    assert prefixed_unit(0.5e-6, "m") == ("nm", 1e-9)
