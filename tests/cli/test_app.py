"""The command: what it refuses, what it leaves behind and how it ends."""

import dataclasses
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray
import yaml
from support.command_line import Command, cases, left_behind
from support.synthetic import synthetic_trajectory

from contactlab.cli import start
from contactlab.trajectory import Ending, Trajectory

NO_PICTURE = "record.picture=false"


@pytest.fixture
def ending(monkeypatch: pytest.MonkeyPatch) -> Callable[[Ending | BaseException], None]:
    """Replaces the simulation by one that is over at once and ends as asked."""

    def replace(how: Ending | BaseException) -> None:
        def simulate(*_: object, **__: object) -> Trajectory:
            if isinstance(how, BaseException):
                raise how
            trajectory = synthetic_trajectory(duration=1e-3)
            message = "" if how is Ending.COMPLETE else "It ended too early."
            return dataclasses.replace(trajectory, ending=how, message=message)

        monkeypatch.setattr("contactlab.config.setup.simulate", simulate)

    return replace


def configuration_of(path: Path) -> dict[str, dict[str, Any]]:
    with xarray.open_dataset(path) as root:
        configuration: dict[str, dict[str, Any]] = yaml.safe_load(root.attrs["configuration"])
    return configuration


def test_configuration_is_shown_and_nothing_run(command: Command) -> None:
    status, out, _ = command("--cfg", "job", "experiment=case_a", "law=lagrange_stick")
    assert status == 0
    shown = yaml.safe_load(out)
    assert shown["law"] == {"name": "lagrange_stick"}
    assert shown["drive"]["frequency"] == 3210.0
    assert left_behind() == []


@pytest.mark.parametrize(
    ("line", "completion"),
    [
        ("contactlab law=lagrange_", "law=lagrange_ageing law=lagrange_slip law=lagrange_stick"),
        ("contactlab solver.d", "solver.duration="),
        ("contactlab law/normal=hertz_p", "law/normal=hertz_point"),
        ("contactlab law=composed law.normal.s", "law.normal.stiffness="),
        ("contactlab -m experiment=c", "experiment=case_a"),
        ("contactlab stead", "steady"),
        ("contactlab help stead", "steady"),
        ("contactlab steady law=h", "law=hertz_penalty"),
        ("contactlab characterise law=newton,h", "law=newton,hertz_penalty"),
        ("contactlab drive path.csv law.st", "law.stiffness="),
        ("contactlab drive path.csv law=newton law.r", "law.restitution="),
        ("contactlab compare ref", "refine="),
        ("contactlab compare refine=", "refine=true refine=false"),
        ("contactlab compare law=newton,poisson refine=false output=here law.r", "law.restitution="),
        ("contactlab laws iw", "iwan"),
        ("contactlab animate a", ""),
        ("contactlab nonsense po", ""),
        ("contactlab steady 'contact.clearance=1 um' law=h", "law=hertz_penalty"),
        ("contactlab resonator=modal resonator.file=", "resonator.file=./modes.csv"),
    ],
)
def test_tab_completes_options_and_keys(
    command: Command, monkeypatch: pytest.MonkeyPatch, line: str, completion: str
) -> None:
    Path("modes.csv").touch()
    monkeypatch.setenv("COMP_LINE", line)
    status, out, err = command("-sc", "query=bash")
    assert status == 0
    assert (out.strip(), err) == (completion, "")


# What it leaves behind


def test_a_file_of_ones_own_is_an_option(
    command: Command, ending: Callable[[Ending], None], tmp_path: Path
) -> None:
    ending(Ending.COMPLETE)
    folder = tmp_path / "mine/law"
    folder.mkdir(parents=True)
    text = "name: hertz_penalty\nstiffness: 3.0e+10\ntip_radius: null\n"
    (folder / "stiff.yaml").write_text(text)
    (folder / "rubber.yaml").write_text(
        "defaults:\n  - composed\n  - override normal: linear\n  - _self_\nnormal:\n  stiffness: 1e4\n"
    )
    for name, stiffness in (("stiff", {"stiffness": 3e10}), ("rubber", {"normal": 1e4})):
        status, _, err = command("--config-dir", "mine", f"law={name}", NO_PICTURE, "hydra.run.dir=here")
        assert status == 0, err
        law = configuration_of(Path("here/run.nc"))["law"]
        for key, value in stiffness.items():
            assert law[key] == value or law[key] == {"name": "linear", "stiffness": value}


def test_run_leaves_dataset_picture_and_summary(command: Command) -> None:
    status, out, err = command("solver.duration=0.2 ms", "hydra.run.dir=here")
    assert status == 0, err
    assert "rotor" in out
    configuration = configuration_of(Path("here/run.nc"))
    assert configuration["solver"]["duration"] == 0.2e-3
    assert configuration["drive"]["frequency"] == pytest.approx(3210.121, rel=1e-6)
    with xarray.open_dataset("here/run.nc") as root:
        assert root.attrs["complete"] == 1
    assert Path("here/run.png").read_bytes().startswith(b"\x89PNG")
    assert not list(Path("here").glob("*.log"))


def test_task_can_be_sent_to_another_process() -> None:
    assert pickle.loads(pickle.dumps(start.task)) is start.task


# How it ends


@pytest.mark.parametrize(
    "how", cases([Ending.DIVERGED, Ending.CHATTERED, Ending.UNBALANCED, Ending.STALLED], [Ending.UNBALANCED])
)
def test_run_that_is_not_complete_is_written_as_such_with_status_1(
    command: Command, ending: Callable[[Ending], None], how: Ending
) -> None:
    ending(how)
    status, _, _ = command(NO_PICTURE, "hydra.run.dir=here")
    assert status == 1
    with xarray.open_dataset("here/run.nc") as root:
        assert root.attrs["complete"] == 0


def test_interrupted_run_leaves_nothing_that_looks_whole(
    command: Command, ending: Callable[[Ending | BaseException], None]
) -> None:
    ending(Ending.COMPLETE)
    assert command(NO_PICTURE, "hydra.run.dir=here")[0] == 0

    ending(KeyboardInterrupt())
    assert command("hydra.run.dir=here")[0] == 130
    assert not list(Path("here").glob("*run*"))

    ending(Ending.INTERRUPTED)
    status, _, _ = command(NO_PICTURE, "hydra.run.dir=here")
    assert status == 130
    with xarray.open_dataset("here/run.nc") as root:
        assert root.attrs["complete"] == 0


@pytest.mark.skipif(
    sys.platform == "win32", reason="Windows has no SIGINT to send; run the tests on Linux or macOS."
)
def test_ctrl_c_ends_the_real_command_with_status_130(tmp_path: Path) -> None:
    long_run = ["solver.duration=1e4", "record.interval=1e-2", "hydra.run.dir=here"]
    process = subprocess.Popen(
        [sys.executable, "-m", "contactlab", *long_run], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    patience = time.monotonic() + 60.0
    while not (tmp_path / "here/.hydra/overrides.yaml").exists() and process.poll() is None:
        assert time.monotonic() < patience
        time.sleep(0.05)
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60.0)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    if (tmp_path / "here/run.nc").exists():
        with xarray.open_dataset(tmp_path / "here/run.nc") as root:
            assert root.attrs["complete"] == 0
