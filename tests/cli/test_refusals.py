"""What the command refuses: in sentences, those on values all at once, and nothing is written."""

import subprocess
import sys
from pathlib import Path

import pytest
from support.command_line import Command, cases, left_behind


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        (["law=null"], "law"),
        (["experiment=case_b"], "experiment"),
        (["solver=5"], "solver"),
        (["contactstep=1"], "contactstep"),
        (["+drive.gain=2"], "drive.gain"),
        (["~drive.phase"], "drive.phase"),
        (["law/foo=bar"], "law.foo"),
        (["law=lagrange_slip", "law.stiffness=1"], "law.stiffness"),
        (["law=hertz_penalty", "law/normal=linear"], "law.normal"),
        (["law=composed", "law/normal=rubber"], "law/normal"),
        (["law=composed", "law.normal.name=rubber"], "law.normal.name"),
        (["law=composed", "law.friction.bristle_stiffness=1"], "law.friction.bristle_stiffness"),
        (["law=composed", "law.normal={name:linear}"], "law.normal"),
        (["-m", "law=composed", "law.friction.name=coulomb,lugre"], "law.friction.name"),
        (["law.name=nosuch", "solver.tolerance=1e-8"], "law.name"),
        (["+hydra.foo=1"], "hydra.foo"),
        (["hydra.sweper.params={}"], "hydra.sweper.params"),
        (["hydra.searchpath=[file:///nowhere]"], "path"),
        (["hydra.output_subdir=/"], "hydra.output_subdir"),
        (["hydra.output_subdir=../above"], "hydra.output_subdir"),
        (["hydra.run.dir="], "hydra.run.dir"),
        (["hydra.hydra_logging.formatters=1"], "hydra.hydra_logging.formatters"),
        (["contact.clearance=" + "9" * 5000], "5000"),
        (["contact.clearance='1e9999999999 m'"], "contact.clearance"),
        (["contact.clearance=" + "{a:" * 500 + "1" + "}" * 500], "nested"),
        (["contact.clearance=1\udcb5m"], "contact.clearance"),
        (["hydra.run.dir=a\0b"], "hydra.run.dir"),
        (["colect", "here"], "colect"),
        (["Verify"], "Verify"),
        (["--multirn"], "--multirn"),
        (["laws", "hertz"], "hertz"),
        (["laws", "friction"], "friction"),
        (["laws", "dampngs/"], "damping"),
        (["laws", "friction/coulom"], "friction/coulom"),
        (["validate"], "validate"),
        (["laws", "--lawz"], "--lawz"),
        (["verify", "now"], "now"),
        (["collect", "here", "--outptu=x"], "--outptu"),
        (["compare", "here", "--no-refin"], "--no-refin"),
        (["animate", "nowhere/run.nc"], "nowhere/run.nc"),
        (["animate", "run.nc", "--fsp", "3"], "--fsp"),
        (["map", "sweep.drive.phase=1,2"], "map"),
        (["contact.clearance=linspace(0,2 um,5)"], "contact.clearance"),
        (["-m", "law=glob(nosuch*)"], "law"),
        (["-m", *(f"drive.{key}=range(0,100)" for key in ("phase", "voltage_1", "voltage_2"))], "1e+06"),
        (["law=composed", "~law.normal"], "law.normal"),
        (["-m", "law=composed", "law/normal=linear,rubber"], "law/normal"),
        (["hydra.run.folder=x"], "hydra.run.folder"),
        (["contact.clearance=1", "um"], "um"),
        (["rotor.radius=(1"], "rotor.radius"),
        (["=1"], "=1"),
        (["drive.phase=${nothing}"], "nothing"),
        (["solver.duration=1,2"], "solver.duration"),
        (["hydra.run.dir=${nothing}"], "hydra.run.dir"),
        (["--config-name", "other"], "other"),
        (["hydra.job.num=many"], "hydra.job.num"),
        (["hydra.job.chdir=many"], "hydra.job.chdir"),
        (["--config-dir", "nowhere"], "nowhere"),
        (["--run", "--multirun"], "--multirun"),
        (["--resolve"], "--resolve"),
        (["--frobnicate"], "--frobnicate"),
        (["--help", "law=hertz"], "law"),
        (["--cfg", "job", "foo=1"], "foo"),
        (["-m", "drive.voltage_1=interval(0,1)"], "drive.voltage_1"),
        (["-m", "law=hertz_penalty,hertz"], "law"),
        (["-m", "contact.clearance=1e-6,-1e-6"], "contact.clearance"),
        (["-m", "law=lagrange_slip,lagrange_stick", "hydra.sweep.subdir=x"], "hydra.sweep.subdir"),
    ],
)
def test_bad_input_is_refused_by_its_key_and_nothing_is_written(
    command: Command, arguments: list[str], key: str
) -> None:
    status, _, err = command(*arguments)
    assert status == 2
    assert key in err
    assert "Traceback" not in err
    assert left_behind() == []


@pytest.mark.parametrize(
    ("arguments", "sentences"),
    [
        (["law=hertz"], ["law is 'hertz'; it must be one of "]),
        (
            [
                "contact.clearance=1",
                "drive.phase=1e17",
                "drive.voltage_1=1e300",
                "drive.frequency=1e-320",
                "drive.frequency_ratio=1e300",
                "solver.duration=5 kg",
                "solver.contact_step=-1e-7",
                "placement.end=40 mm",
            ],
            [
                "at most 0.001 m, the resonator.beam_thickness",
                "at most 1e+06 rad",
                "at most 100000 V",
                "it must be at least 1e-09 Hz",
                "drive.frequency_ratio is 1e+300; it must be at least 1e-09 and at most 1e+09",
                "whose unit 'kg' cannot be converted to s",
                "solver.contact_step is -1e-07 s; it must be greater",
                "half of resonator.length",
            ],
        ),
        (
            ["law=composed", "law.normal.stiffness=2 N", "law.friction.static_ratio=0.5"],
            ["cannot be converted to N/m^1.5", "law.friction.static_ratio is 0.5; it must be at least 1"],
        ),
        (
            ["law=composed", "law.normal.name=linear", "law.friction=lugre"],
            ["of one law/normal to another", "must be a choice, law/friction=NAME"],
        ),
        (
            [
                "law.name=lagrange_stick",
                "resonator.basis=finite_element",
                "piezoceramic.constants=tensor",
                "hydra.sweeper=optuna",
                "hydra.launcher=joblib",
            ],
            [
                "of one law to another",
                "Choose one by resonator=NAME",
                "Choose one by piezoceramic=NAME",
                "must be a choice, hydra/sweeper=NAME. Choose one of basic",
                "must be a choice, hydra/launcher=NAME",
            ],
        ),
        (
            [
                "-m",
                "drive.phase=range(0,1,1e-9)",
                "drive.voltage_1=range(0,inf,1)",
                "drive.voltage_2=range(0,1,0)",
                "contact.clearance=range(1,1)",
            ],
            [
                "has 1e+09 values; it must have at most 100000",
                "drive.voltage_1=range(0,inf,1) does not end",
                "drive.voltage_2=range(0,1,0) does not end",
                "a range ends before its STOP",
            ],
        ),
    ],
)
def test_bad_values_are_refused_together(
    command: Command, arguments: list[str], sentences: list[str]
) -> None:
    status, _, err = command(*arguments)
    assert status == 2
    for sentence in sentences:
        assert sentence in err
    assert "Traceback" not in err
    assert left_behind() == []


def test_faults_of_all_values_come_at_once(command: Command) -> None:
    status, out, err = command(
        "contact.clearance=-1 um",
        "record.interval=1 s",
        "rotor.inertia=heavy",
        "+frequency=3 kHz",
        "law.name=hertz_penalty",
        "hydra.launcher=joblib",
    )
    assert status == 2
    assert out == ""
    assert [line.split()[0] for line in err.splitlines()] == [
        "hydra.launcher=joblib",
        "law.name=hertz_penalty",
        "contact.clearance",
        "rotor.inertia",
        "frequency",
        "record.interval",
    ]


def test_faults_of_all_jobs_of_a_sweep_come_before_any_runs(command: Command) -> None:
    status, out, err = command("-m", "law=lagrange_slip,newton", "rotor.radius=0.025,-1,0")
    assert status == 2
    assert out == ""
    assert [line.partition(";")[0] for line in err.splitlines()] == [
        "rotor.radius is -1 m",
        "rotor.radius is 0 m",
    ]


@pytest.mark.parametrize(
    "directory",
    cases(["/proc/nowhere", "file/below", "file", "back\\\\slash"], ["file/below", "back\\\\slash"]),
)
def test_directory_that_cannot_be_written_is_refused(command: Command, directory: str) -> None:
    Path("file").touch()
    for arguments in (
        [f"hydra.run.dir='{directory}'"],
        ["-m", "drive.phase=0,1", f"hydra.sweep.dir='{directory}'"],
    ):
        status, _, err = command(*arguments)
        assert status == 2
        assert "cannot be written to" in err
        assert "Traceback" not in err
        assert left_behind() == [Path("file")]


def test_real_command_refuses_with_status_2_and_no_traceback(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "contactlab", "solver.contact_step=-1e-7", "rotor.radius=-1"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 2
    assert list(tmp_path.iterdir()) == []
