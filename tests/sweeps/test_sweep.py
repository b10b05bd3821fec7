"""Many runs in one go are the runs that each would be alone, by one process or several."""

import os
import signal
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas
import pytest
import xarray
from omegaconf import OmegaConf
from support.command_line import Command
from support.motors import default_motor, every_law, hertz
from support.sweeps import METRICS_ALONE

import contactlab as cl
from contactlab import WorkerError, sweep
from contactlab.config import build
from contactlab.engine import simulate
from contactlab.laws import ContactLaw, LagrangeStick
from contactlab.metrics import METRICS, assess
from contactlab.motor.motor import Motor
from contactlab.results.netcdf import to_datatree
from contactlab.studies.run_state import Status
from contactlab.studies.sweep.study import Sweep

DURATION = 1e-3
CLEARANCES = (0.0, 0.5e-6, 1e-6)
PHASES = (-1.0, 0.0, 2.0, 3.0)


def motor_at(clearance: float, phase: float) -> Motor:
    return default_motor(clearance=clearance, phase=phase)


def setup_at(clearance: float, phase: float, law: ContactLaw, interval: float | None = None) -> cl.Setup:
    return cl.Setup.of(motor_at(clearance, phase), law, DURATION, interval)


def swept(law: ContactLaw, interval: float | None = None, **options: Any) -> xarray.Dataset:
    over = {"clearance": CLEARANCES, "phase": PHASES}
    return sweep(over, partial(setup_at, law=law, interval=interval), **options)


@pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)
def test_a_run_among_many_is_the_run_alone_to_the_last_bit(law: ContactLaw) -> None:
    result = swept(law, workers=1)
    assert result["final_rotor_velocity"].dims == ("clearance", "phase")
    for clearance in CLEARANCES:
        for phase in PHASES:
            run = simulate(motor_at(clearance, phase), law, duration=DURATION, record_interval=1e-5)
            cell = result.sel(clearance=clearance, phase=phase)
            assert cell["final_rotor_velocity"] == run.series["rotor_velocity"][-1]
            assert cell["total_impulse"] == run.contacts["normal_impulse"].sum()
            assert cell["contact_count"] == run.contacts["start_time"].size


@pytest.mark.long
def test_the_number_of_workers_changes_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    alone = swept(hertz(), workers=1)
    monkeypatch.setattr(Sweep, "delay", 0.0)
    monkeypatch.setattr("contactlab.studies.sweep.plan.CHUNK", 2)
    assert swept(hertz(), workers=3).identical(alone)


def test_all_metrics_are_those_of_the_datasets() -> None:
    law = hertz()
    result = swept(law, 1e-6, metrics=tuple(METRICS), workers=1)
    for clearance, phase in ((0.0, 2.0), (1e-6, -1.0)):
        motor = motor_at(clearance, phase)
        run = simulate(motor, law, duration=DURATION, record_interval=1e-6)
        expected = assess(to_datatree(run))
        cell = result.sel(clearance=clearance, phase=phase)
        for key, value in expected.items():
            assert np.array_equal(cell[key], value, equal_nan=True), key
            assert result[key].attrs["units"] == METRICS[key].units


def test_series_are_those_of_the_runs_and_stop_where_a_run_did() -> None:
    result = sweep(
        {"clearance": CLEARANCES, "phase": PHASES},
        lambda clearance, phase: setup_at(clearance, phase, hertz(0.1 * (1.0 + clearance * 1e6)), 3e-5),
        series=["rotor_velocity", "gap"],
        workers=2,
    )
    run = simulate(motor_at(1e-6, 0.0), hertz(0.2), duration=DURATION, record_interval=3e-5)
    cell = result.sel(clearance=1e-6, phase=0.0)
    assert np.array_equal(result["time"], run.time)
    for name in ("rotor_velocity", "gap"):
        assert np.array_equal(cell[f"{name}_series"], run.series[name])
    assert result["gap_series"].attrs["units"] == "m"


def test_a_run_that_fails_leaves_a_code_and_a_sentence_and_the_others_alone() -> None:
    def setup(voltage: float) -> cl.Setup:
        if voltage < 0.0:
            raise ValueError("no negative voltage here")
        motor = default_motor(voltage_1=voltage, voltage_2=voltage)
        return cl.Setup.of(motor, hertz(stiffness=1e3), DURATION, 1e-5)

    result = sweep({"voltage": [-1.0, 100.0, 1e5]}, setup, series=["gap"], workers=2)
    codes = [Status(code) for code in result["status"].values]
    assert codes == [Status.FAILED, Status.COMPLETE, Status.DIVERGED]
    assert "no negative voltage here" in result["reason"].values[0]
    assert [bool(reason) for reason in result["reason"].values] == [True, False, True]
    assert np.isnan(result["peak_force"].values).tolist() == [True, False, True]
    assert np.isnan(result["gap_series"].values).all(axis=1).tolist() == [True, False, True]


def test_an_axis_brings_its_unit() -> None:
    clearance = xarray.DataArray([*CLEARANCES], attrs={"units": "m"})
    over = {"clearance": clearance, "phase": PHASES}
    result = sweep(over, partial(setup_at, law=LagrangeStick(0.3)), workers=1)
    assert result["clearance"].attrs == {"key": "clearance", "units": "m"}
    assert result["phase"].attrs == {"key": "phase"}


@pytest.mark.long
def test_a_worker_that_is_killed_ends_the_sweep(monkeypatch: pytest.MonkeyPatch) -> None:
    test = os.getpid()

    def setup(phase: float) -> cl.Setup:
        if phase == 2.0 and os.getpid() != test:
            os.kill(os.getpid(), signal.SIGKILL)
        return cl.Setup.of(default_motor(phase=phase), hertz(), 1e-4)

    monkeypatch.setattr(Sweep, "delay", 0.0)
    monkeypatch.setattr("contactlab.studies.sweep.plan.CHUNK", 1)
    with pytest.raises(WorkerError):
        sweep({"phase": PHASES}, setup, workers=2)


def test_a_signal_that_ends_the_job_is_no_result_of_a_cell() -> None:
    def time_is_up(*_: object) -> None:
        raise TimeoutError("time is up")

    def setup(phase: float) -> cl.Setup:
        if phase == 2.0:
            os.kill(os.getpid(), signal.SIGUSR2)
        return cl.Setup.of(default_motor(phase=phase), hertz(), 1e-4)

    before = signal.signal(signal.SIGUSR2, time_is_up)
    try:
        with pytest.raises(TimeoutError):
            sweep({"phase": PHASES}, setup, workers=1)
    finally:
        signal.signal(signal.SIGUSR2, before)


def test_what_a_function_returns_beside_a_setup_is_a_failed_run() -> None:
    result = sweep({"clearance": [1e-6], "phase": [0.0]}, motor_at, workers=1)
    assert result["status"].item() == Status.FAILED
    assert "Setup" in str(result["reason"].item())


def test_a_sweep_of_keys_is_the_one_of_the_command_line(command: Command) -> None:
    """Names, values, units and bits are the same, so that both align."""
    values = {"law": ["newton", "hertz_penalty"], "clearance": "linspace(0, 2 um, 3)"}
    base = ["drive.phase=1", "solver.duration=1 ms"]
    result = sweep(values, base, workers=1)
    lines = ["law=newton,hertz_penalty", "contact.clearance=linspace(0, 2 um, 3)", "drive.phase=1"]
    command(*METRICS_ALONE, *lines, "solver.duration=1 ms", "hydra.sweep.dir=here")
    with xarray.open_dataset("here/sweep.nc") as commanded:
        xarray.testing.assert_equal(commanded, result)
        assert commanded["clearance"].attrs == result["clearance"].attrs
        assert commanded["clearance"].attrs["key"] == "contact.clearance"
        assert "clearance" in commanded["clearance"].attrs["long_name"] or commanded["clearance"].units == "m"
    xarray.testing.assert_equal(sweep(values, base, output="mine", workers=2), result)
    # A setup is what it was made from: the steps of its law are not those of others.
    for setup in (build(base), replace(build(base[:1]), duration=1e-3)):
        xarray.testing.assert_equal(sweep(values, setup, workers=1), result)


SAMPLES = [
    {"clearance": "1 um", "law": "newton", "drive.phase": 0.1},
    {"clearance": 2e-6, "law": "hertz_penalty", "drive.phase": 0.2},
]


@pytest.mark.long
def test_the_rows_of_a_table_are_runs_wherever_it_is_given(command: Command) -> None:
    result = sweep(SAMPLES, ["solver.duration=1 ms"], workers=1)
    assert result["clearance"].dims == ("run",)
    pandas.DataFrame(SAMPLES).to_csv("table.csv", index=False)
    short = ("sweep.samples=table.csv", "solver.duration=1 ms", "record.picture=false")
    assert command("-m", *short, "sweep.keep=metrics", "hydra.sweep.dir=metrics")[0] == 0
    assert command("-m", *short, "hydra.sweep.dir=runs")[0] == 0
    for folder in ("metrics", "runs"):
        with xarray.open_dataset(f"{folder}/sweep.nc") as read:
            ordered = read.sortby("phase")
            for name in ("clearance", "law", "phase", "final_rotor_velocity", "peak_force"):
                is_number = result[name].dtype.kind == "f"
                assert np.array_equal(ordered[name], result[name], equal_nan=is_number), (folder, name)
    # What a sweep leaves is a table for another.
    again = ("sweep.samples=metrics/sweep.nc", "solver.duration=1 ms", "sweep.keep=metrics")
    status, _, err = command("-m", *again, "hydra.sweep.dir=again")
    assert status == 0, err


def test_the_folder_of_a_run_may_be_named_by_a_variable_of_the_environment(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SCRATCH", "elsewhere")
    short = ("solver.duration=1e-5", "record.picture=false", "drive.phase=${contact.friction_coefficient}")
    status, _, _ = command(*short, "hydra.run.dir=${oc.env:SCRATCH}/run")
    assert status == 0
    run = cl.load("elsewhere/run/run.nc")
    assert run.setup is not None
    assert run.setup.configuration["drive"]["phase"] == 0.3
    # Configurations of others are resolved as Hydra does.
    assert OmegaConf.create({"place": "${oc.env:SCRATCH}"}).place == "elsewhere"
    assert OmegaConf.create({"place": "${oc.env:NOWHERE,here}"}).place == "here"


def test_a_study_is_swept_over_keys_and_over_the_numbers_of_a_motor() -> None:
    setup = build(["law=newton"])
    phases, study = [-1.0, 0.0], cl.Steady(refine=False)
    keys = sweep({"drive.phase": phases}, ["law=newton"], study=study, workers=1)
    alone = cl.steady(build(["law=newton", "drive.phase=0.0"]))
    for quantity in study.quantities:
        cell = [keys[f"{quantity.name}{of}"].sel(phase=0.0).item() for of in ("", "_error")]
        np.testing.assert_array_equal(cell, alone.numbers[quantity.name])
    assert keys["rotor_velocity"].attrs["units"] == "rad s-1"
    numbers = {"rotor.inertia": [2e-5, 4e-5]}
    made = sweep(numbers, cl.Setup.of(setup.motor, setup.law, 1e-3), study=study, workers=1)
    built = sweep(numbers, setup, study=study, workers=1)
    assert np.allclose(made["rotor_velocity"], built["rotor_velocity"], rtol=1e-6)
