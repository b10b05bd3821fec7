"""Claims on motors that change during a run: it is the runs in sequence, and faults have a name."""

import numpy as np
import pytest

import contactlab as cl

OFF = "1 ms; drive.voltage_1=0; drive.voltage_2=0"


@pytest.mark.parametrize("law", ["hertz_penalty", "newton"])
def test_a_run_with_changes_is_the_runs_in_sequence(law: str) -> None:
    common = [f"law={law}", "drive.frequency=3210"]
    loaded = "1.5 ms; rotor.load_torque=2 mN*m"
    whole = cl.build([*common, "solver.duration=2e-3", f"solver.changes=['{OFF}','{loaded}']"]).run()
    silent = [*common, "drive.voltage_1=0", "drive.voltage_2=0"]
    first = cl.build([*common, "solver.duration=1e-3"]).run()
    second = cl.build([*silent, "solver.duration=0.5e-3"]).run(start=first.state)
    third = cl.build([*silent, "rotor.load_torque=2e-3", "solver.duration=0.5e-3"]).run(start=second.state)
    assert whole.contacts["start_time"].size
    for name, values in third.series.items():
        assert np.array_equal(whole.series[name][-values.size :], values), name
    assert whole.time.tolist() == [*first.time[:-1], *second.time[:-1], *third.time]
    drive = whole.series["drive_work"]
    assert np.all(drive[whole.time >= 1e-3] == drive[-1])


def test_a_change_to_the_same_changes_nothing() -> None:
    plain = cl.build(["solver.duration=2e-3"]).run()
    same = cl.build(["solver.duration=2e-3", "solver.changes=['1.2345 ms; drive.voltage_1=100']"]).run()
    # Records of another origin are reached in other ways, but for round-off the same.
    assert same.series["rotor_velocity"][-1] == pytest.approx(plain.series["rotor_velocity"][-1], rel=1e-13)
    assert same.contacts["start_time"].tolist() == plain.contacts["start_time"].tolist()


def test_the_ledger_closes_over_a_change_of_preload() -> None:
    run = cl.build(
        ["contact.preload=1 N", "solver.duration=6e-3", "solver.changes=['3 ms; contact.preload=8 N']"]
    ).run()
    residual = np.abs(run.series["energy_residual"]).max()
    assert residual < 1e-9 * np.abs(run.series["drive_work"]).max()


def test_the_recorded_configuration_has_the_changes() -> None:
    setup = cl.build([f"solver.changes=['{OFF}']"])
    again = cl.build(setup.configuration)
    assert again.configuration == setup.configuration
    assert [time for time, _ in again.changes] == [1e-3]


@pytest.mark.parametrize(
    "change",
    [
        "soon; drive.phase=0",
        "1 V; drive.phase=0",
        "0; drive.phase=0",
        "20 ms; drive.phase=0",
        "1 ms; drive.phase",
        "1 ms; drive.voltage=0",
        "1 ms; law.stiffness=1e9",
        "1 ms; contact.clearance=0",
        "1 ms; contact.preload=1",
        "1 ms; drive.signal=chirp",
        "1 ms; drive.phase=1 m",
        "1 ms",
        "1 ms; drive.phase=0; drive.phase=1",
    ],
)
def test_an_impossible_change_is_refused(change: str) -> None:
    with pytest.raises(cl.ConfigurationError):
        cl.build([f"solver.changes=['{change}']"])


def test_changes_come_in_their_order_and_to_no_steady_state() -> None:
    with pytest.raises(cl.ConfigurationError, match=r"solver\.changes"):
        cl.build(["solver.changes=['2 ms; drive.phase=0','1 ms; drive.phase=1']"])
    with pytest.raises(cl.ConfigurationError, match=r"solver\.changes"):
        cl.build([f"solver.changes=['{OFF}']", "solver.until=steady"])
    with pytest.raises(ValueError, match=r"solver\.changes"):
        cl.steady(cl.build([f"solver.changes=['{OFF}']"]))
