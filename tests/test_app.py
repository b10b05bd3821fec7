"""The command: what it refuses, what it leaves behind and how it ends."""

import dataclasses
import logging
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import xarray
import yaml
from conf_files import CONF, options
from synthetic import synthetic_trajectory

from contactlab import app, engine
from contactlab.command import runner
from contactlab.trajectory import Ending, Trajectory

Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> Iterator[Command]:
    """Runs the command in an empty directory; gives its exit status, output and errors."""
    monkeypatch.chdir(tmp_path)
    handlers = logging.root.handlers[:]

    def run(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["contactlab", *arguments])
        try:
            status = app.main()
        except SystemExit as stop:
            status = int(stop.code or 0)
        out, err = capfd.readouterr()
        return status, out, err

    yield run
    logging.root.handlers[:] = handlers


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

        monkeypatch.setattr(engine, "simulate", simulate)

    return replace


def left_behind() -> list[Path]:
    return list(Path().rglob("*"))


def configuration_of(path: Path) -> dict[str, dict[str, object]]:
    with xarray.open_dataset(path) as root:
        configuration: dict[str, dict[str, object]] = yaml.safe_load(root.attrs["configuration"])
    return configuration


# What it refuses


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["law=hertz"], "law is 'hertz'; it must be one of hertz_penalty, lagrange_slip"),
        (["law=null"], "law is null; it must be one of hertz_penalty"),
        (["experiment=case_b"], "experiment is 'case_b'; it must be one of case_a. Did you mean"),
        (["solver=5"], "solver is 5; it must be one of default"),
        (["contactstep=1"], "contactstep is not a known key. Did you mean solver.contact_step?"),
        (["+drive.gain=2"], "drive.gain is not a known key"),
        (["+drive.phase=2"], "+drive.phase=2 adds a key that exists"),
        (["~drive.phase"], "drive.phase is missing"),
        (["law/foo=bar"], "law/foo is not a known key"),
        (
            ["law=lagrange_slip", "law.stiffness=1"],
            "law.stiffness does not belong to lagrange_slip",
        ),
        (["hydra.run.folder=x"], "hydra.run.folder=x cannot be composed"),
        (["contact.clearance=1", "um"], "um cannot be read; an argument must have the form"),
        (["rotor.radius=(1"], "rotor.radius=(1 cannot be read"),
        (["=1"], "=1 has no key"),
        (["drive.phase=${nothing}"], "Interpolation key 'nothing' not found"),
        (["solver.duration=1,2"], "gives several values; a single run takes one. Add -m"),
        (["solver.duration=5 kg"], "whose unit 'kg' cannot be converted to s"),
        (["solver.contact_step=-1e-7"], "solver.contact_step is -1e-07 s; it must be greater"),
        (["placement.end=40 mm"], "half of resonator.length"),
        (["hydra.run.dir=${nothing}"], "hydra.run.dir cannot be resolved"),
        (["--config-name", "other"], "Cannot find primary config 'other'"),
        (["--config-dir", "nowhere"], "which is not a directory"),
        (["--run", "--multirun"], "Only one of --run, --multirun"),
        (["--resolve"], "can only be used in conjunction with --cfg"),
        (["--frobnicate"], "unrecognized arguments: --frobnicate"),
        (["--help", "law=hertz"], "law is 'hertz'; it must be one of"),
        (["--cfg", "job", "foo=1"], "foo is not a known key"),
        (["-m", "drive.voltage_1=interval(0,1)"], "does not support sweep type"),
        (["-m", "law=hertz_penalty,hertz"], "law is 'hertz'; it must be one of"),
        (["-m", "contact.clearance=1e-6,-1e-6"], "contact.clearance is -1e-06 m"),
        (["-m", "law=lagrange_slip,lagrange_stick", "hydra.sweep.subdir=x"], "to 2 jobs, which"),
    ],
)
def test_bad_input_is_refused_in_a_sentence_and_nothing_is_written(
    command: Command, arguments: list[str], words: str
) -> None:
    status, _, err = command(*arguments)
    assert status == 2
    assert words in err
    assert "Traceback" not in err
    assert left_behind() == []


def test_faults_of_every_kind_come_at_once(command: Command) -> None:
    status, out, err = command(
        "law=hertz",
        "um",
        "contact.clearance=-1 um",
        "record.interval=1 s",
        "rotor.inertia=heavy",
        "frequency=3 kHz",
        "hydra.run.folder=x",
    )
    assert status == 2
    assert out == ""
    assert sorted(line.split()[0] for line in err.splitlines()) == [
        "contact.clearance",
        "frequency",
        "hydra.run.folder=x",
        "law",
        "record.interval",
        "rotor.inertia",
        "um",
    ]


def test_faults_of_all_jobs_of_a_sweep_come_before_any_runs(command: Command) -> None:
    status, out, err = command("-m", "law=lagrange_slip,hertz", "rotor.radius=0.025,-1,0")
    assert status == 2
    assert out == ""
    assert [line.partition(";")[0] for line in err.splitlines()] == [
        "rotor.radius is -1 m",
        "rotor.radius is 0 m",
        "law is 'hertz'",
    ]


@pytest.mark.parametrize("directory", ["/proc/nowhere", "file/below", "file", "back\\\\slash"])
def test_directory_that_cannot_be_written_is_refused(command: Command, directory: str) -> None:
    Path("file").touch()
    for arguments in ([f"hydra.run.dir='{directory}'"], ["-m", f"hydra.sweep.dir='{directory}'"]):
        status, _, err = command(*arguments)
        assert status == 2
        assert "cannot be written to" in err
        assert "Traceback" not in err
        assert left_behind() == [Path("file")]


def test_real_command_refuses_with_status_2_and_no_traceback(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "contactlab", "solver.contact_step=-1e-7", "law=hertz"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 2
    assert list(tmp_path.iterdir()) == []


# What it shows


def test_help_tells_of_every_group_and_option(command: Command) -> None:
    status, out, _ = command("--help")
    assert status == 0
    for group in (path.name for path in CONF.iterdir() if path.is_dir()):
        assert f"{group}: {', '.join(options(group))}" in out
    assert 'eval "$(contactlab -sc install=bash)"' in out
    assert left_behind() == []


def test_configuration_is_shown_and_nothing_run(command: Command) -> None:
    status, out, _ = command("--cfg", "job", "experiment=case_a", "law=lagrange_stick")
    assert status == 0
    shown = yaml.safe_load(out)
    assert shown["law"] == {"name": "lagrange_stick"}
    assert shown["drive"]["frequency"] == 3210.0
    assert left_behind() == []


def test_version_is_shown(command: Command) -> None:
    status, out, _ = command("--version")
    assert status == 0
    assert out.startswith("contactlab ")
    assert "hydra-core 1.3" in out


@pytest.mark.parametrize(
    ("line", "completion"),
    [
        ("contactlab law=lagrange_", "law=lagrange_slip law=lagrange_stick"),
        ("contactlab solver.d", "solver.duration="),
        ("contactlab -m experiment=", "experiment=case_a"),
    ],
)
def test_tab_completes_options_and_keys(
    command: Command, monkeypatch: pytest.MonkeyPatch, line: str, completion: str
) -> None:
    monkeypatch.setenv("COMP_LINE", line)
    status, out, _ = command("-sc", "query=bash")
    assert status == 0
    assert out.strip() == completion


# What it leaves behind


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


def test_sweep_runs_every_combination_in_a_directory_of_its_own(command: Command) -> None:
    status, out, err = command(
        "solver.duration=0.2 ms", "-m", "law=lagrange_stick,hertz_penalty", "hydra.sweep.dir=here"
    )
    assert status == 0, err
    assert "#0 : " in out
    directories = sorted(path.parent.name for path in Path("here").glob("*/run.nc"))
    assert directories == [
        "0_law=lagrange_stick,solver.duration=0.2_ms",
        "1_law=hertz_penalty,solver.duration=0.2_ms",
    ]
    laws = [configuration_of(Path("here") / name / "run.nc")["law"]["name"] for name in directories]
    assert laws == ["lagrange_stick", "hertz_penalty"]


def test_experiment_is_a_change_of_the_default_that_arguments_override(
    command: Command, ending: Callable[[Ending], None]
) -> None:
    ending(Ending.COMPLETE)
    status, _, err = command("experiment=case_a", "drive.phase=0", "hydra.run.dir=here")
    assert status == 0, err
    configuration = configuration_of(Path("here/run.nc"))
    assert configuration["drive"]["frequency"] == 3210.0
    assert configuration["drive"]["phase"] == 0.0
    assert configuration["solver"]["duration"] == 5e-3


def test_configuration_may_ask_for_a_sweep_itself(
    command: Command, ending: Callable[[Ending], None]
) -> None:
    ending(Ending.COMPLETE)
    status, _, err = command("hydra.mode=MULTIRUN", "contact.clearance=1 um,2 um")
    assert status == 0, err
    assert len(list(Path("multirun").rglob("run.nc"))) == 2


def test_task_can_be_sent_to_another_process() -> None:
    assert pickle.loads(pickle.dumps(app.run)) is app.run


@pytest.mark.parametrize(
    ("overrides", "name"),
    [
        ("law=lagrange_slip", "3_law=lagrange_slip"),
        ("contact.clearance=1\\ um", "3_contact.clearance=1_um"),
        ("a='2 µm',b=x/y", "3_a=-2_-m-,b=x-y"),
        ("", "3"),
        ("x" * 300, "3_" + "x" * 118),
    ],
)
def test_directory_of_a_job_has_a_name_for_any_file_system(overrides: str, name: str) -> None:
    assert app.job_directory(3, overrides) == name


# How it ends


@pytest.mark.parametrize("how", [Ending.DIVERGED, Ending.CHATTERED])
def test_run_that_ends_early_is_written_as_incomplete_with_status_1(
    command: Command, ending: Callable[[Ending], None], how: Ending
) -> None:
    ending(how)
    status, _, err = command("hydra.run.dir=here")
    assert status == 1
    assert "It ended too early." in err
    with xarray.open_dataset("here/run.nc") as root:
        assert root.attrs["complete"] == 0


def test_sweep_goes_on_after_a_run_that_ended_early_and_has_status_1(
    command: Command, ending: Callable[[Ending], None]
) -> None:
    ending(Ending.DIVERGED)
    status, _, _ = command("-m", "contact.clearance=1 um,2 um")
    assert status == 1
    assert len(list(Path("multirun").rglob("run.nc"))) == 2


def test_interrupted_run_leaves_nothing_that_looks_whole(
    command: Command, ending: Callable[[Ending | BaseException], None]
) -> None:
    ending(Ending.COMPLETE)
    assert command("hydra.run.dir=here")[0] == 0

    ending(KeyboardInterrupt())
    status, _, err = command("hydra.run.dir=here")
    assert status == 130
    assert err == "Interrupted before the run was written.\n"
    assert not list(Path("here").glob("*run*"))

    ending(Ending.INTERRUPTED)
    status, _, err = command("hydra.run.dir=here")
    assert status == 130
    assert err == "It ended too early.\n"
    with xarray.open_dataset("here/run.nc") as root:
        assert root.attrs["complete"] == 0


def test_interrupt_stops_a_sweep(
    command: Command, ending: Callable[[Ending | BaseException], None]
) -> None:
    ending(Ending.INTERRUPTED)
    status, _, _ = command("-m", "contact.clearance=1 um,2 um")
    assert status == 130
    assert len(list(Path("multirun").rglob("run.nc"))) == 1


def test_disk_that_fails_is_told_in_a_sentence(
    command: Command, ending: Callable[[Ending], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(*_: object) -> None:
        raise OSError(28, "No space left on device", "run.nc")

    ending(Ending.COMPLETE)
    monkeypatch.setattr("contactlab.output.dataset.write", write)
    status, _, err = command("hydra.run.dir=here")
    assert status == 1
    assert "The run could not be written: " in err
    assert "No space left on device" in err


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT to send.")
def test_ctrl_c_ends_the_real_command_with_status_130(tmp_path: Path) -> None:
    long_run = ["solver.duration=1e4", "record.interval=1e-2", "hydra.run.dir=here"]
    process = subprocess.Popen(
        [sys.executable, "-m", "contactlab", *long_run],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
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


def test_progress_shows_on_a_terminal_only_and_not_before_its_time(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with runner._progress_bar(0.02) as progress:
        progress(0.01)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    for delay, shown in ((60.0, False), (1e-9, True)):
        monkeypatch.setattr(runner, "PROGRESS_AFTER", delay)
        with runner._progress_bar(0.02) as progress:
            time.sleep(0.2)
            progress(0.01)
        assert ("50 %" in capsys.readouterr().err) is shown
