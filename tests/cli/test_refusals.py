"""What the command refuses: in sentences, those on values all at once, and nothing is written."""

import subprocess
import sys
from pathlib import Path

import pytest
from support.command_line import Command, cases, left_behind


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["law=null"], "law=null names no option; it must have the form GROUP=OPTION"),
        (["experiment=case_b"], "experiment is 'case_b'; it must be one of basis_convergence, case_a,"),
        (["solver=5"], "solver=5 names no option"),
        (["contactstep=1"], "contactstep is not a known key. Did you mean solver.contact_step?"),
        (["+drive.gain=2"], "drive.gain is not a known key"),
        (["~drive.phase"], "drive.phase is missing"),
        (["law/foo=bar"], "law.foo is not a known key"),
        (["law=lagrange_slip", "law.stiffness=1"], "law.stiffness does not belong to lagrange_slip"),
        (
            ["law=hertz_penalty", "law/normal=linear"],
            "law.normal does not belong to hertz_penalty; it must be absent",
        ),
        (["law=composed", "law/normal=rubber"], "law/normal is 'rubber'; it must be one of "),
        (["law=composed", "law.normal.name=rubber"], "Choose one by law/normal=NAME"),
        (
            ["law=composed", "law.friction.bristle_stiffness=1"],
            "law.friction.bristle_stiffness does not belong to the default",
        ),
        (["law=composed", "law.normal={name:linear}"], "Choose one by law/normal=NAME"),
        (["-m", "law=composed", "law.friction.name=coulomb,lugre"], "of one law/friction to another"),
        (["law.name=nosuch", "solver.tolerance=1e-8"], "Choose one by law=NAME"),
        (["+hydra.foo=1"], "hydra.foo is not a known key"),
        (["hydra.sweper.params={}"], "Did you mean hydra.sweeper?"),
        (["hydra.searchpath=[file:///nowhere]"], "path=/nowhere is not available"),
        (["hydra.output_subdir=/"], "must be a folder below that of the run"),
        (["hydra.output_subdir=../above"], "must be a folder below that of the run"),
        (["hydra.run.dir="], "is empty, as of a shell variable that is not set"),
        (["hydra.hydra_logging.formatters=1"], "The run could not be started"),
        (["contact.clearance=" + "9" * 5000], "value has 5000 digits"),
        (["contact.clearance='1e9999999999 m'"], "which is too large"),
        (["contact.clearance=" + "{a:" * 500 + "1" + "}" * 500], "nested too deeply"),
        (["contact.clearance=1\udcb5m"], "has bytes that are no text; it must be UTF-8"),
        (["hydra.run.dir=a\0b"], "has bytes that are no text"),
        (["colect", "here"], "There is no verb 'colect'"),
        (["Verify"], "Did you mean verify?"),
        (["--multirn"], "Did you mean --multirun?"),
        (["laws", "hertz"], "Did you mean hertz_penalty or"),
        (["laws", "friction"], "friction is a group of parts. Choose one of friction/coulomb, friction/reg"),
        (["laws", "dampngs/"], "damping is a group of parts. Choose one of damping/none, damping/linear,"),
        (["laws", "friction/coulom"], "Did you mean friction/coulomb?"),
        (["validate"], "the following arguments are required: DATA. contactlab validate --help"),
        (["laws", "--lawz"], "--lawz is not understood"),
        (["verify", "now"], "'now' is not there; it must be a netCDF-4 file"),
        (["collect", "here", "--outptu=x"], "Did you mean --output?"),
        (["collect", ""], "an argument is empty"),
        (["compare", "here", "--no-refin"], "Did you mean --no-refine?"),
        (["compare"], "the following arguments are required: DIR"),
        (["animate", "nowhere/run.nc"], "There is no file 'nowhere/run.nc'"),
        (["animate", "run.nc", "--fsp", "3"], "Did you mean --fps?"),
        (["map", "sweep.drive.phase=1,2"], "no verb 'map' any more; sweeps run without it: contactlab -m"),
        (["contact.clearance=linspace(0,2 um,5)"], "gives several values; a single run takes one"),
        (["-m", "law=glob(nosuch*)"], "has no values"),
        (
            ["-m", *(f"drive.{key}=range(0,100)" for key in ("phase", "voltage_1", "voltage_2"))],
            "100 x 100 x 100 = 1e+06 runs are asked for",
        ),
        (["law=composed", "~law.normal"], "law.normal is missing"),
        (["-m", "law=composed", "law/normal=linear,rubber"], "law/normal is 'rubber'"),
        (["hydra.run.folder=x"], "hydra.run.folder is not a known key. Did you mean hydra.run.dir?"),
        (["contact.clearance=1", "um"], "um cannot be read; an argument must have the form"),
        (["rotor.radius=(1"], "rotor.radius=(1 cannot be read"),
        (["=1"], "=1 has no key"),
        (["drive.phase=${nothing}"], "Interpolation key 'nothing' not found"),
        (["solver.duration=1,2"], "gives several values; a single run takes one. Add -m"),
        (["hydra.run.dir=${nothing}"], "hydra.run.dir cannot be resolved"),
        (["--config-name", "other"], "--config-name is 'other', and there is no such configuration;"),
        (["hydra.job.num=many"], "hydra.job.num is 'many'; it must be a whole number."),
        (["hydra.job.chdir=many"], "hydra.job.chdir is 'many'; it must be true or false."),
        (["--config-dir", "nowhere"], "nowhere' not found. It must be a folder; create it."),
        (["--run", "--multirun"], "Only one of --run, --multirun"),
        (["--resolve"], "can only be used in conjunction with --cfg"),
        (["--frobnicate"], "unrecognized arguments: --frobnicate"),
        (["--help", "law=hertz"], "law is 'hertz'; it must be one of"),
        (["--cfg", "job", "foo=1"], "foo is not a known key"),
        (["-m", "drive.voltage_1=interval(0,1)"], "cannot be swept; a swept parameter must have"),
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


@pytest.mark.parametrize(
    ("arguments", "sentences"),
    [
        (["law=hertz"], ["law is 'hertz'; it must be one of ", "Did you mean hertz_penalty?"]),
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
