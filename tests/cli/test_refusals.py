"""What the command refuses: status 2 with the key, all faults of values at once, and nothing is written."""

import subprocess
import sys
from pathlib import Path

import pytest
from support.command_line import Command, left_behind

FAULTS = [
    (["law=null"], ["law"]),
    (["law=hertz"], ["law is 'hertz'", "law=hertz_penalty", "law/normal=hertz_point"]),
    (["stick"], ["law=lagrange_stick"]),
    (["coulomb"], ["law=composed law/friction=coulomb"]),
    (["mu=0.4"], ["contact.friction_coefficient"]),
    (["steady", "mu=0.4"], ["contact.friction_coefficient"]),
    (["law/friction=dahl"], ["law=composed law/friction=dahl"]),
    (["resonator=modal"], ["resonator.file="]),
    (["compare", "newton", "poisson"], ["law=newton,poisson"]),
    (["drive", "lugre"], ["law=composed law/friction=lugre"]),
    (["laws", "newton", "hertz"], ["'hertz'", "law=hertz_penalty"]),
    (["law=[newton,poisson]"], ["law"]),
    (["experiment=case_b"], ["experiment"]),
    (["contactstep=1"], ["contactstep"]),
    (["+drive.gain=2"], ["drive.gain"]),
    (["~drive.phase"], ["drive.phase"]),
    (["law=lagrange_slip", "law.stiffness=1"], ["law.stiffness"]),
    (["law=composed", "law/normal=rubber"], ["law/normal"]),
    (["law=composed", "law.normal.name=linear"], ["law.normal.name"]),
    (["-m", "law=composed", "law.friction.name=coulomb,lugre"], ["law.friction.name"]),
    (["law=composed", "~law.normal"], ["law.normal"]),
    (["hydra.sweper.params={}"], ["hydra.sweper.params"]),
    (["hydra.output_subdir=../above"], ["hydra.output_subdir"]),
    (["hydra.run.dir="], ["hydra.run.dir"]),
    (["hydra.run.dir=${nothing}"], ["hydra.run.dir"]),
    (["contact.clearance=1\udcb5m"], ["contact.clearance"]),
    (["contact.clearance=" + "9" * 5000], ["5000"]),
    (["contact.clearance=" + "{a:" * 500 + "1" + "}" * 500], ["nested"]),
    (["contact.clearance=1", "um"], ["um"]),
    (["=1"], ["=1"]),
    ([""], [""]),
    (["drive.phase=${oc.env:HOME}"], ["drive.phase"]),
    (["solver.duration=1,2"], ["solver.duration"]),
    (["contact.clearance=linspace(0,2 um,5)"], ["contact.clearance"]),
    (["sweep.samples=x.csv"], ["sweep.samples"]),
    (["steady", "record.interval=1e-6"], ["record.interval"]),
    (["steady", "brake=-1"], ["brake"]),
    (["steady", "law=newton", "law=poisson"], ["law", "newton", "poisson"]),
    (["law=newton", "law=poisson"], ["law", "newton", "poisson"]),
    (["steady", "brake=1e-3", "brake=2e-3"], ["brake", "1e-3", "2e-3"]),
    (["steady", "law=newton,poisson"], ["law is newton,poisson"]),
    (["branch", "contact.clearance=1 um.."], ["contact.clearance", "1 um..", "at least 0 m"]),
    (["contact.clearance=1 um."], ["contact.clearance", "1 um."]),
    (["collect", ".", "serie=gap"], ["serie", "mean series"]),
    (["animate", "run.nc", "format=avi"], ["format", "duration", "output"]),
    (["output=here"], ["output", "hydra.run.dir"]),
    (["steady", "bracke=1e-3"], ["bracke", "mean brake"]),
    (["compare", "draws=4"], ["draws", "samples"]),
    (["steady", "clearance=1e-6"], ["mean contact.clearance"]),
    (["steady", "load=3 kg"], ["load"]),
    (["steady", "output=a\0b"], ["output"]),
    (["steady", "scheduler=tcp://127.0.0.1:1"], ["scheduler"]),
    (["characterise", "contact.clearance=,"], ["contact.clearance"]),
    (["compare", "law=newton,poisson", "posterior=none.nc"], ["posterior", "none.nc"]),
    (["drive", "none.csv", "law=newton"], ["data", "none.csv"]),
    (["rotor.radius=1e-320"], ["rotor.radius"]),
    (["rotor.damping=1e308"], ["rotor.damping"]),
    (["--config-name", "other"], ["other"]),
    (["--config-dir", "nowhere"], ["nowhere"]),
    (["--frobnicate"], ["--frobnicate"]),
    (["--law", "newton"], ["law=newton"]),
    (["steady", "--brake", "2 mN m"], ["'brake=2 mN m'"]),
    (["steady", "--no-refine"], ["refine=false"]),
    (["collect", "here", "--output", "all.nc"], ["output=all.nc"]),
    (["colect", "here"], ["collect"]),
    (["laws", "friction/coulom"], ["friction/coulom"]),
    (["laws", "--lawz"], ["--lawz"]),
    (["collect", "here", "--outptu=x"], ["--outptu"]),
    (["-m", "law=glob(nosuch*)"], ["law"]),
    (["-m", *(f"drive.{key}=range(0,100)" for key in ("phase", "voltage_1", "voltage_2"))], ["1e+06"]),
    (["-m", "law=composed", "law/normal=linear,rubber"], ["law/normal"]),
    (["-m", "drive.voltage_1=interval(0,1)"], ["drive.voltage_1"]),
    (["-m", "contact.clearance=1e-6,-1e-6"], ["contact.clearance"]),
    (["-m", "law=newton,poisson", "contact.clearance=abc", "sweep.keep=metrics"], ["contact.clearance"]),
    (["-m", "law=lagrange_slip,lagrange_stick", "hydra.sweep.subdir=x"], ["hydra.sweep.subdir"]),
    (
        [
            "contact.clearance=-1 um",
            "record.interval=1 s",
            "rotor.inertia=heavy",
            "+frequency=3 kHz",
            "solver.duration=5 kg",
        ],
        ["contact.clearance", "rotor.inertia", "drive.frequency", "solver.duration"],
    ),
    (["-m", "law=lagrange_slip,newton", "rotor.radius=0.025,-1,0"], ["radius is -1 m", "radius is 0 m"]),
]


@pytest.mark.parametrize(("arguments", "keys"), FAULTS)
def test_bad_input_is_refused_by_its_keys_and_nothing_is_written(
    command: Command, arguments: list[str], keys: list[str]
) -> None:
    status, out, err = command(*arguments)
    assert (status, out) == (2, "")
    for key in keys:
        assert key in err
    assert "Traceback" not in err
    assert left_behind() == []


@pytest.mark.parametrize("directory", ["file/below", "back\\\\slash"])
def test_a_directory_that_cannot_be_written_is_refused(command: Command, directory: str) -> None:
    Path("file").touch()
    for arguments in (
        [f"hydra.run.dir='{directory}'"],
        ["-m", "drive.phase=0,1", f"hydra.sweep.dir='{directory}'"],
        ["-m", "drive.phase=0,1", "sweep.keep=metrics", f"hydra.sweep.dir='{directory}'"],
    ):
        status, _, err = command(*arguments)
        assert status == 2
        assert arguments[-1].partition("=")[0] in err
        assert left_behind() == [Path("file")]


def test_the_real_command_refuses_with_status_2_and_no_traceback(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "contactlab", "solver.contact_step=-1e-7", "rotor.radius=-1"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert len(done.stderr.splitlines()) == 2
    assert list(tmp_path.iterdir()) == []
