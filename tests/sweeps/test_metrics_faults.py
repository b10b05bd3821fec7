"""A faulty command line of a sweep that keeps metrics is refused by its keys before anything runs."""

from pathlib import Path

import pytest
from support.command_line import Command, left_behind
from support.sweeps import METRICS_ALONE

FAULTS = [
    (["drive.phase=1"], ["KEY="]),
    (["contact.clearence=1,2"], ["contact.clearance"]),
    (["contact.clearance=foo(1)"], ["contact.clearance"]),
    (["drive.phase=1,2", "contact.clearance="], ["contact.clearance"]),
    (["drive.phase=[1],[2]"], ["drive.phase"]),
    (["law=hertz,newton"], ["hertz"]),
    (["law=composed", "law.normal.name=linear", "drive.phase=1,2"], ["law.normal.name"]),
    ([f"drive.{key}=linspace(0,1,400)" for key in ("phase", "voltage_1", "voltage_2")], ["6.4e+07"]),
    (["drive.phase=1,2", "solver.duratio=1"], ["solver.duration"]),
    (["drive.phase=1,2", "rotor.load_torque=${oc.decode:'1e-3'}"], ["${NAME:...}"]),
    (["drive.phase=1,2", "sweep.metrics=peak_farce"], ["sweep.metrics", "peak_force"]),
    (["drive.phase=1,2", "sweep.series=gab"], ["sweep.series", "gab"]),
    (["solver.duration=1e-3,2e-3", "sweep.series=gap"], ["solver.duration"]),
    (["drive.phase=1,2", "hydra/launcher=joblib"], ["hydra/launcher", "sweep.keep"]),
    (["drive.phase=1,2", "hydra/launcher=joblib", "sweep.keep=runs", "sweep.chunk=2"], ["sweep.chunk"]),
    (["drive.phase=1,2", "sweep.samples=nowhere.csv"], ["sweep.samples"]),
    (["sweep.samples=nowhere.csv"], ["nowhere.csv"]),
    (["sweep.samples=nowhere.nc"], ["nowhere.nc"]),
    (["drive.phase=1,2", "hydra/launcher=jubilee"], ["hydra/launcher"]),
    (["drive.phase=1,2", "hydra.launcher.n_jobs=2"], ["n_jobs"]),
    (["hydra.run.dir=a,b"], ["Hydra"]),
    (
        [
            "contact.clearance=linspace(0,2e-6)",
            "drive.phase=linspace(0,1,0)",
            "drive.voltage_1=linspace(0,1,1.5)",
            "drive.voltage_2=linspace(0 kg,1 V,3)",
            "rotor.radius=linspace(a,1 m,3)",
            "rotor.inertia=geomspace(0,1e-6,4)",
            "rotor.damping=range(1,1)",
            "rotor.load_torque=linspace(0,inf,3)",
            "drive.frequency=range(0,1,1e-9)",
        ],
        [
            *("contact.clearance", "drive.phase", "drive.voltage_1", "drive.voltage_2", "rotor.radius"),
            *("rotor.inertia", "rotor.damping", "rotor.load_torque", "drive.frequency"),
        ],
    ),
    (["contact.clearance=-1e-6,1e-6", "resonator.shapes=linspace(2,3,3)"], ["clearance", "shapes is 2.5"]),
    (["contact.clearance=interval(0,1)", "drive.phase=1,2"], ["clearance"]),
    (["drive.phase=1,2", "drive.phase=3"], ["drive.phase"]),
    (["drive.phase=1,1", "contact.clearance=1e-6,1 um"], ["drive.phase", "contact.clearance"]),
    (["drive.phase=1,2", "sweep.keep=numbers", "sweep.chunk=-1"], ["sweep.keep", "sweep.chunk"]),
]


@pytest.mark.parametrize(("arguments", "keys"), FAULTS, ids=[" ".join(f)[:80] for f, _ in FAULTS])
def test_a_faulty_sweep_is_refused_by_its_keys_before_anything_runs(
    arguments: list[str], keys: list[str], command: Command
) -> None:
    kept = any(each.startswith("sweep.keep=") for each in arguments)
    status, out, err = command(*(["-m"] if kept else METRICS_ALONE), *arguments)
    assert (status, out) == (2, "")
    for key in keys:
        assert key in err
    assert "Traceback" not in err
    assert left_behind() == []


@pytest.mark.parametrize("name", ["note.txt", "note.csv"])
def test_a_file_that_is_no_table_of_samples_is_refused(name: str, command: Command) -> None:
    Path(name).write_bytes(b"hello\0\xff")
    status, _, err = command(*METRICS_ALONE, f"sweep.samples={name}")
    assert status == 2
    assert name in err
