"""A faulty sweep is refused by its keys, all of them, before anything is written."""

from pathlib import Path

import pytest
from support.command_line import Command, left_behind
from support.sweeps import METRICS_ALONE, QUICK

NUMBERS = [
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
]
"""Arguments of sweeps of numbers alone, and what the refusal names."""

JOBS = [
    (["drive.phase=1,2", "sweep.keep=numbers", "sweep.chunk=-1"], ["sweep.keep", "sweep.chunk"]),
    (["drive.phase=1,2", "hydra/launcher=joblib", "sweep.keep=runs", "sweep.chunk=2"], ["sweep.chunk"]),
    (["contact.clearance=1e-6,2e-6", *QUICK, "hydra.sweep.subdir=one"], ["hydra.sweep.subdir"]),
    (["hydra/sweeper=basic", "sweep.keep=metrics", "drive.phase=0,1", *QUICK], ["sweep.keep=metrics"]),
]

TABLES = [
    ("clearance\n1e-6\n\n-1\n", "contact.clearance"),
    ("clearance,law\n1e-6,newton\n1e-6,\n", "row 2"),
    ("clearence\n1e-6\n", "contact.clearance"),
    ("law\nnewtonn\n", "law"),
    ("drive.phase,contact.friction_coefficient\n0.1,0.3,0.5\n", "line 2"),
    ("drive.phase,law\n0.1,newton\n0.1,newton,0.5\n", "line 3"),
    ("clearance,clearance\n1e-6,2e-6\n", "table.csv"),
    ("clearance,contact.clearance\n1e-6,2e-6\n", "contact.clearance"),
    ("drive.phase\n${contact.friction_coefficient}\n", "drive.phase"),
    ("hello\0\udcff", "table.csv"),
]

REFERENCE = "${oc.env:SECRET}"
"""A variable of the environment, which is neither read nor shown."""

SECRETS = [
    ["-m", "sweep.samples=table.csv"],
    [f"drive.phase={REFERENCE}"],
    ["-m", "drive.phase=0,1", f"contact.clearance={REFERENCE}"],
    [f"law={REFERENCE}"],
    ["-m", f"law=newton,{REFERENCE}"],
    ["-m", f"sweep.samples={REFERENCE}"],
    ["-m", "drive.phase=0,1", f"sweep.metrics={REFERENCE}"],
    ["--config-dir=.", "law=mine"],
]

SECRET_FILES = {
    "table.csv": f"drive.phase\n{REFERENCE}\n",
    "law/mine.yaml": f"name: newton\nrestitution: {REFERENCE}\n",
}

FAULTS = [
    *(([*METRICS_ALONE, *lines], keys, {}) for lines, keys in NUMBERS),
    *((["-m", *lines], keys, {}) for lines, keys in JOBS),
    *((["-m", "sweep.samples=table.csv"], [key], {"table.csv": table}) for table, key in TABLES),
    ([*METRICS_ALONE, "sweep.samples=note.txt"], ["note.txt"], {"note.txt": "hello\0\udcff"}),
    *((lines, [], SECRET_FILES) for lines in SECRETS),
]


@pytest.mark.parametrize(("arguments", "keys", "files"), FAULTS, ids=repr)
def test_a_faulty_sweep_is_refused_by_its_keys_before_anything_runs(
    arguments: list[str],
    keys: list[str],
    files: dict[str, str],
    command: Command,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("SECRET", "hush-1234")
    for name, text in files.items():
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_bytes(text.encode(errors="surrogateescape"))
    before = sorted(left_behind())
    status, out, err = command(*arguments)
    assert (status, out) == (2, "")
    for key in keys:
        assert key in err
    assert "Traceback" not in err
    assert "hush" not in err
    assert sorted(left_behind()) == before
