"""Metrics alone: every cell is the run of its own configuration, and a kill costs one chunk at most."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray
import yaml
from support.command_line import Command
from support.sweeps import METRICS_ALONE

from contactlab.config import build
from contactlab.config.nesting import with_key
from contactlab.metrics import METRICS
from contactlab.studies.run_state import Status
from contactlab.studies.runner import TASKS
from contactlab.studies.sweep.dataset import DATASET
from contactlab.studies.sweep.plan import Outputs

SHORT = "solver.duration=1 ms"
HERE = (*METRICS_ALONE, SHORT, "hydra.sweep.dir=here")


def opened(path: Path, name: str = DATASET) -> xarray.Dataset:
    with xarray.open_dataset(path / name, decode_times=False) as result:
        return result.load()


def test_every_cell_is_the_run_of_its_configuration(command: Command) -> None:
    swept = ("contact.clearance=linspace(0,2 um,3)", "drive.phase=-90 deg,0.5")
    status, _, err = command(*HERE, "law=lagrange_stick", *swept)
    assert status == 0, err
    result = opened(Path("here"))
    assert result["clearance"].attrs["units"] == "m"
    assert result["phase"].values.tolist() == [-np.pi / 2.0, 0.5]
    assert list(result.data_vars) == [*Outputs().metrics, "status", "reason"]
    base = yaml.safe_load(result.attrs["configuration"])
    for clearance in result["clearance"].values:
        for phase in result["phase"].values:
            changed = with_key(base, "contact.clearance", float(clearance))
            setup = build(with_key(changed, "drive.phase", float(phase)))
            assert setup.law.name == "lagrange_stick"
            run = setup.run(duration=1e-3, record_interval=1e-3)
            cell = result.sel({"clearance": clearance, "phase": phase})
            assert cell["final_rotor_velocity"] == run.series["rotor_velocity"][-1]
            assert cell["total_impulse"] == run.contacts["normal_impulse"].sum()


def test_a_reference_follows_what_is_swept(command: Command) -> None:
    swept = ("drive.voltage_1=90,100", "drive.voltage_2=${drive.voltage_1}", "record.picture=false", SHORT)
    expected = [
        build([f"drive.voltage_{number}={voltage}" for number in (1, 2)]).run(duration=1e-3)
        for voltage in (90, 100)
    ]
    for keep in ("metrics", "runs"):
        status, _, err = command("-m", *swept, f"sweep.keep={keep}", f"hydra.sweep.dir={keep}")
        assert status == 0, err
        velocity = opened(Path(keep))["final_rotor_velocity"]
        assert velocity.values.tolist() == [run.series["rotor_velocity"][-1] for run in expected]


def test_the_same_command_finds_its_folder_and_runs_nothing_again(command: Command) -> None:
    arguments = (*METRICS_ALONE, SHORT, "drive.phase=0,1")
    assert command(*arguments)[0] == 0
    (file,) = Path("multirun").rglob(DATASET)
    before = file.stat().st_mtime_ns
    status, out, _ = command(*arguments)
    assert status == 0
    assert str(file) in out
    assert file.stat().st_mtime_ns == before
    assert command(*METRICS_ALONE, SHORT, "drive.phase=0,1", "law=newton")[0] == 0
    assert len(list(Path("multirun").rglob(DATASET))) == 2


@pytest.mark.parametrize(
    ("code", "lines"),
    [
        ("other", (*METRICS_ALONE, "drive.phase=0,1")),
        ("", (*METRICS_ALONE, "drive.phase=0,2")),
        ("", ("-m", "drive.phase=0,1", "record.picture=false")),
    ],
    ids=["by_other_code", "of_other_values", "of_folders"],
)
def test_another_sweep_does_not_go_into_the_folder_of_one(
    command: Command, monkeypatch: pytest.MonkeyPatch, code: str, lines: tuple[str, ...]
) -> None:
    assert command(*HERE, "drive.phase=0,1")[0] == 0
    before = {path: path.read_bytes() for path in Path("here").iterdir()}
    if code:
        monkeypatch.setattr("contactlab.studies.run_state.code_digest", lambda: code)
    assert command(*lines, SHORT, "hydra.sweep.dir=here")[0] == 2
    assert {path: path.read_bytes() for path in Path("here").iterdir()} == before


def test_cells_whose_values_are_faulty_together_are_refused_alone(command: Command) -> None:
    status, out, _ = command(*HERE, "placement.start=1 mm,12 mm", "placement.end=10 mm,20 mm")
    assert status == 0
    assert "3 complete" in out
    assert "start=0.012, end=0.01: refused. placement" in out
    result = opened(Path("here"))
    codes = [[Status(code) for code in row] for row in result["status"].values]
    complete, refused = Status.COMPLETE, Status.REFUSED
    assert codes == [[complete, complete], [refused, complete]]
    assert np.isnan(result["peak_force"].values[1, 0])
    assert result["reason"].values[1, 0].startswith("placement")
    assert result.attrs["runs_refused"] == 1


def test_series_lie_beside_the_metrics(command: Command) -> None:
    interval = "record.interval=10 us"
    kept = ("sweep.series=gap,rotor_velocity", "sweep.metrics=all", "sweep.chunk=2")
    assert command(*HERE, interval, "drive.phase=0,1,2", "law.stiffness=1e9,1e10", *kept)[0] == 0
    assert set(METRICS) <= set(opened(Path("here")).data_vars)
    command(SHORT, interval, "drive.phase=2", "law.stiffness=1e9", "hydra.run.dir=run")
    with (
        xarray.open_datatree(Path("here") / DATASET, decode_times=False) as tree,
        xarray.open_dataset(Path("run") / "run.nc", decode_times=False) as run,
    ):
        cell = tree["series"].to_dataset().sel({"phase": 2.0, "stiffness": 1e9})
        assert np.array_equal(cell["time"], run["time"])
        for name in ("gap", "rotor_velocity"):
            assert np.array_equal(cell[name], run[name])
            assert cell[name].attrs["units"] == run[name].attrs["units"]


@pytest.mark.long
def test_ctrl_c_keeps_what_is_finished(tmp_path: Path) -> None:
    arguments = ["drive.phase=linspace(-3,3,2000)", "sweep.chunk=20", "hydra.sweep.dir=here", SHORT]
    running = subprocess.Popen(
        [sys.executable, "-m", "contactlab", *METRICS_ALONE, *arguments],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        # As a shell starts it: with the interrupt not ignored.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    while not list(tmp_path.glob(f"here/{TASKS}/*-*.nc")):
        assert running.poll() is None
        time.sleep(0.01)
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=60)
    assert running.returncode == 130
    assert "Traceback" not in err
    assert not (tmp_path / "here" / DATASET).exists()
    assert list((tmp_path / "here" / TASKS).iterdir())
