"""A run that ends once its motor has settled is the run that was never cut, up to there."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import contactlab as cl
from contactlab.config import ConfigurationError
from contactlab.metrics import Run
from contactlab.motor.drive import period_of
from contactlab.results.summary import summary_of
from contactlab.settling.criterion import LONGEST, PRECISION
from contactlab.settling.until import simulate_until_steady
from contactlab.settling.verdict import settling_of
from contactlab.trajectory import Trajectory

FAST = ("rotor.inertia=1e-5", "record.interval=1e-5", "solver.duration=0.4")
"""A rotor that settles in some hundred periods."""


def setup(*others: str, until: str = "steady") -> cl.Setup:
    return cl.build([*FAST, f"solver.until={until}", *others])


def assert_begins(whole: Trajectory, part: Trajectory) -> None:
    count = part.time.size
    assert np.array_equal(part.time, whole.time[:count])
    assert np.array_equal(part.contact_mode, whole.contact_mode[:count])
    for name, values in part.series.items():
        assert np.array_equal(values, whole.series[name][:count]), name
    ended = int(np.isfinite(part.contacts["separation_velocity"]).sum())
    assert part.contacts["start_time"].size - ended <= 1
    for name, values in part.contacts.items():
        assert np.array_equal(values[:ended], whole.contacts[name][:ended], equal_nan=True), name


@pytest.mark.parametrize("law", ["hertz_penalty", "lagrange_stick", "newton"])
def test_a_run_until_steady_is_the_beginning_of_the_uncut_run_to_the_last_bit(law: str) -> None:
    part = setup(f"law={law}").run()
    assert part.complete
    assert 0.01 < part.time[-1] < 0.3
    assert_begins(setup(f"law={law}", until="duration").run(duration=part.time[-1] + 0.01), part)
    result = Run.of_trajectory(part, {}).settling
    assert result.verdict == "settled"
    assert result.share <= PRECISION
    # One look earlier it had not.
    before = setup(f"law={law}", until="duration").run(duration=part.time[-1] / 1.3)
    assert Run.of_trajectory(before, {}).settling.share > PRECISION


@pytest.mark.parametrize("law", ["hertz_penalty", "lagrange_stick", "newton"])
@pytest.mark.parametrize("precision", [1e-2, 1e-3, 1e-4])
def test_the_motor_is_as_near_to_its_orbit_as_was_asked_for(law: str, precision: float) -> None:
    there = setup(f"law={law}", f"solver.precision={precision}")
    result = Run.of_trajectory(there.run(), there.configuration).settling
    assert result.now == pytest.approx(cl.steady(there).velocity[0], rel=precision)


def test_without_a_duration_a_run_has_a_longest_of_its_own() -> None:
    assert cl.build().duration == 0.02
    assert cl.build(["solver.until=steady"]).duration == LONGEST
    assert setup().duration == 0.4
    motor = cl.build(["rotor.inertia=1e-5"])
    run = cl.simulate(motor.motor, motor.law, record_interval=1e-5, until="steady")
    assert 0.02 < run["time"][-1] < LONGEST
    assert run.tree.attrs["settled"] == 1
    assert "ended" in summary_of(run.tree)
    assert "ended" not in summary_of(cl.simulate(cl.build(["solver.duration=1e-3"])).tree)
    with pytest.raises(ValueError, match="duration"):
        cl.simulate(motor.motor, motor.law)


@pytest.mark.parametrize("precision", [0.0, 0.02, -1.0, float("nan")])
def test_a_precision_that_no_run_can_have_is_refused(precision: float) -> None:
    with pytest.raises(ValueError, match="precision"):
        cl.simulate(setup(), until="steady", precision=precision)
    with pytest.raises(ValueError, match="until"):
        cl.simulate(setup(), precision=1e-3)


def test_a_memory_that_still_flows_is_waited_for() -> None:
    """The rotor seems to have settled long before the lining has; it follows the lining, slowly."""
    lining = ("law=composed", "law/normal=prony", "law.normal.first_stiffness=2e7")
    still = setup(*lining, "law.normal.first_time=0.1", "solver.duration=0.03")
    run = still.run()
    assert run.time[-1] == pytest.approx(0.03)
    result = Run.of_trajectory(run, still.configuration).settling
    assert result.verdict != "settled"
    assert np.isnan(result.velocity)
    # Judged by the rotor alone it would be a steady state that the orbit is not.
    alone = settling_of({**run.series, "time": run.time}, run.contacts, period_of(still.motor.drive))
    assert alone.verdict == "settled"
    assert abs(alone.velocity - cl.steady(still).velocity[0]) > 3.0 * alone.error
    fast = setup(*lining, "law.normal.first_time=2e-3", "solver.duration=1")
    run = fast.run()
    assert run.time[-1] < 0.5
    now = Run.of_trajectory(run, fast.configuration).settling.now
    assert now == pytest.approx(cl.steady(fast).velocity[0], rel=PRECISION)


def test_wear_is_never_settled_and_a_file_says_the_same(tmp_path: Path) -> None:
    worn = cl.simulate(setup("law=archard", "solver.duration=0.3"))
    assert worn["time"][-1] == pytest.approx(0.3)
    assert worn.tree.attrs["settled"] != 1
    assert "wear" in worn.tree.attrs["settling"]
    worn.save(tmp_path / "run.nc")
    assert Run.of(cl.load(tmp_path / "run.nc").tree).settling.sentence == worn.tree.attrs["settling"]


def test_it_goes_on_from_a_state_that_falls_between_records_as_the_uncut_run_does() -> None:
    whole = setup(until="duration")
    state = whole.run(duration=0.00123456).state
    part = setup().run(start=state)
    assert part.time[0] == 0.00123456
    assert_begins(whole.run(start=state, duration=part.duration + 0.01), part)


def test_what_has_not_settled_in_its_duration_is_the_plain_run() -> None:
    arguments = ("rotor.inertia=4.8e-5", "solver.duration=0.02")
    part, plain = (setup(*arguments, until=until).run() for until in ("steady", "duration"))
    assert part.time.size == plain.time.size
    assert_begins(plain, part)
    assert part.statistics == plain.statistics
    assert np.array_equal(part.final.displacement, plain.final.displacement)


def test_a_duration_that_no_look_divides_is_reached_to_the_last_bit() -> None:
    slow = setup("rotor.inertia=1e-3")
    for duration in (0.0131, 0.01641, 0.0327, 0.05):
        assert simulate_until_steady(slow.motor, slow.law, duration=duration, record_interval=1e-5).time[
            -1
        ] == pytest.approx(duration, rel=1e-15)


def test_progress_tells_of_one_run() -> None:
    reported: list[float] = []
    end = setup().run(progress=reported.append).time[-1]
    assert reported.count(0.0) == 1
    assert reported == sorted(reported)
    assert reported[-1] == end


def test_python_and_the_configuration_say_it_alike(tmp_path: Path) -> None:
    requested, reported = cl.simulate(setup(until="duration"), until="steady"), cl.simulate(setup())
    assert requested.tree.attrs["configuration"] == reported.tree.attrs["configuration"]
    assert np.array_equal(requested["time"], reported["time"])
    assert (
        cl.simulate(
            requested.setup.motor, requested.setup.law, duration=0.4, record_interval=1e-5, until="steady"
        )["time"][-1]
        == reported["time"][-1]
    )
    reported.save(tmp_path / "run.nc")
    loaded = cl.load(tmp_path / "run.nc")
    assert loaded.setup is not None
    assert loaded.setup.until == "steady"
    with pytest.raises(ValueError, match="until"):
        cl.simulate(setup(), until="end")


def test_a_run_that_could_never_be_judged_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"record\.interval"):
        setup("record.interval=1e-4")
    with pytest.raises(ConfigurationError, match="frequenc"):
        setup("drive.frequency_ratio=1.4142135623")
    plain = replace(setup(until="duration"), until="steady", record_interval=1e-3)
    with pytest.raises(ValueError, match=r"record\.interval"):
        plain.run()
