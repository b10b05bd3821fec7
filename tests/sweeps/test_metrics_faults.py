"""A faulty command line of a sweep that keeps metrics is refused in a sentence before anything runs."""

from pathlib import Path

import pytest
from support.command_line import Command, left_behind
from support.sweeps import METRICS_ALONE

FAULTS = [
    (["drive.phase=1"], "Nothing is swept"),
    (["contact.clearence=1,2"], "contact.clearance"),
    (["contact.clearance=foo(1)"], "cannot be read"),
    (["drive.phase=1,2", "contact.clearance="], "contact.clearance is ''"),
    (["drive.phase=[1],[2]"], "each must be a number"),
    (["law=hertz,newton"], "hertz"),
    (["law=composed", "law.normal.name=linear", "drive.phase=1,2"], "of one law/normal to another"),
    (
        [f"drive.{key}=linspace(0,1,400)" for key in ("phase", "voltage_1", "voltage_2")],
        "400 x 400 x 400 = 6.4e+07 runs are asked for; a sweep must have at most 10000000",
    ),
    (["drive.phase=1,2", "--workerz=2"], "--workerz=2"),
    (["drive.phase=1,2", "solver.duratio=1"], "solver.duration"),
    (["drive.phase=1,2", "rotor.load_torque=${contact.clearance}"], "references in ${...}"),
    (["drive.phase=1,2", "sweep.metrics=peak_farce"], "peak_force"),
    (["drive.phase=1,2", "sweep.series=gab"], "gab"),
    (["solver.duration=1e-3,2e-3", "sweep.series=gap"], "at the same times in every run"),
    (["drive.phase=1,2", "sweep.keep=runs", "sweep.workers=2"], "it must come with sweep.keep=metrics"),
    (["drive.phase=1,2", "sweep.samples=nowhere.csv"], "swept at once"),
    (["sweep.samples=nowhere.csv"], "sweep.samples is 'nowhere.csv' and cannot be read (No such file"),
    (["sweep.samples=nowhere.nc"], "sweep.samples is 'nowhere.nc' and cannot be read (No such file"),
    (["drive.phase=1,2", "--config-dir=nowhere"], "nowhere"),
    (["drive.phase=1,2", "hydra/launcher=jubilee"], "hydra/launcher is 'jubilee'"),
    (["drive.phase=1,2", "hydra.launcher.n_jobs=2"], "n_jobs"),
    (["hydra.run.dir=a,b"], "Sweeping over Hydra's configuration is not supported"),
]

TOGETHER = [
    (
        [
            "contact.clearance=linspace(0,2e-6)",
            "drive.phase=linspace(0,1,0)",
            "drive.voltage_1=linspace(0,1,1.5)",
            "drive.voltage_2=linspace(0 kg,1 V,3)",
            "rotor.radius=linspace(a,1 m,3)",
            "rotor.inertia=geomspace(0,1e-6,4)",
            "rotor.damping=range(1,1)",
        ],
        [
            "does not have three arguments",
            "has the count '0'",
            "has the count '1.5'",
            "whose unit 'kg' cannot be converted to V",
            "'a', which is not a number",
            "Use linspace",
            "has no values",
        ],
    ),
    (
        [
            "drive.phase=range(0,1,1e-9)",
            "drive.voltage_1=range(0,inf,1)",
            "drive.voltage_2=range(0,nan,1)",
            "contact.clearance=linspace(0,1,1000000000)",
            "drive.frequency=linspace(0,1," + "9" * 5000 + ")",
            "rotor.load_torque=linspace(0,inf,3)",
            "rotor.initial_velocity=linspace(-1e308,1e308,3)",
        ],
        [
            "has 1e+09 values; it must have at most 10000000",
            "drive.voltage_1=range(0,inf,1) does not end",
            "drive.voltage_2=range(0,nan,1) does not end",
            "has the count '1000000000'; it must be a whole number of at least 1 and at most 10000000",
            "99'; it must be a whole number of at least 1 and at most 10000000",
            "rotor.load_torque goes from 0 to inf; both ends must be finite",
            "rotor.initial_velocity goes from -1e+308 to 1e+308; both ends must be finite",
        ],
    ),
    (
        ["contact.clearance=-1e-6,1e-6", "resonator.shapes=linspace(2,3,3)"],
        ["contact.clearance is -1e-06 m; it must be at least 0 m", "resonator.shapes is 2.5"],
    ),
    (
        ["contact.clearance=interval(0,1)", "drive.phase=1,2", "drive.phase=3"],
        ["cannot be swept", "given more than once"],
    ),
    (
        ["drive.phase=1,1", "contact.clearance=1e-6,1 um"],
        ["drive.phase has a value twice", "contact.clearance has a value twice"],
    ),
    (
        ["drive.phase=1,2", "sweep.keep=numbers", "sweep.workers=0", "sweep.chunk=-1"],
        [
            "sweep.keep is 'numbers'",
            "sweep.workers is 0; it must be at least 1",
            "sweep.chunk is -1; it must be at least 1",
        ],
    ),
]


@pytest.mark.parametrize(("arguments", "sentences"), TOGETHER)
def test_faults_of_a_sweep_are_told_together(
    arguments: list[str], sentences: list[str], command: Command
) -> None:
    status, out, err = command(*METRICS_ALONE, *arguments)
    assert status == 2
    for sentence in sentences:
        assert sentence in err
    assert "Traceback" not in err
    assert out == ""
    assert left_behind() == []


@pytest.mark.parametrize(("arguments", "words"), FAULTS, ids=[" ".join(f)[:80] for f, _ in FAULTS])
def test_a_faulty_sweep_is_refused_in_a_sentence_before_anything_runs(
    arguments: list[str], words: str, command: Command
) -> None:
    status, out, err = command(*METRICS_ALONE, *arguments)
    assert status == 2
    assert words in err
    assert "Traceback" not in err
    assert out == ""
    assert left_behind() == []


def test_a_file_that_is_no_table_of_samples_is_refused_in_our_words(command: Command) -> None:
    for name in ("note.txt", "note.csv"):
        Path(name).write_bytes(b"hello\0\xff")
        status, _, err = command(*METRICS_ALONE, f"sweep.samples={name}")
        assert status == 2
        assert f"sweep.samples is '{name}' and is no table that can be read; it must be a table" in err
        assert "engine" not in err
