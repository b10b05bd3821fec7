"""The search for better motors: variables, front, and a killed search that goes on to the same result."""

import signal
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from time import monotonic, sleep

import experiment
import numpy as np
import optimise_motor
import optuna
import pytest
import xarray
from optimise_motor import OBJECTIVES, OptimiseMotor, among_the_best, designed, fixed_by, ranges_of, study_in

from contactlab.config import Setup

TRIALS = 9
SCRIPT = Path(optimise_motor.__file__)


def setup_of(*overrides: str) -> Setup:
    return experiment.setup_of("optimise_motor", overrides)


def test_every_variable_in_its_range_is_a_motor() -> None:
    setup = setup_of()
    bounds = ranges_of(setup)
    for ends in zip(*bounds.values(), strict=True):
        motor = designed(setup, dict(zip(bounds, ends, strict=True)))
        placement = motor.configuration["placement"]
        assert (
            0.0 <= placement["start"] < placement["end"] <= 0.5 * setup.configuration["resonator"]["length"]
        )
        natural = motor.motor.modes.natural_frequency[0]
        assert motor.motor.drive.frequency[0] / natural == pytest.approx(
            ends[list(bounds).index("relative_frequency")]
        )


def test_a_key_that_is_set_is_fixed() -> None:
    assert fixed_by(["placement=placement_1", "drive.frequency=null", "drive.phase=-1"]) == [
        "drive.phase",
        "placement",
    ]
    assert {*ranges_of(setup_of(), ["placement"])} == {"phase", "relative_frequency", "clearance"}
    with pytest.raises(ValueError, match="fixed"):
        ranges_of(setup_of(), [*optimise_motor.KEYS])


def test_no_motor_of_the_front_is_beaten() -> None:
    goals = np.array([[9.0, 9.0, 0.0], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0], [1.0, 1.0, 3.0], [2.0, 1.0, 3.0]])
    # The configured motor is not on it, and a motor that is drawn twice stands there once.
    assert among_the_best(goals, "all").tolist() == [False, True, True, False, False]
    assert among_the_best(goals, "velocity").tolist() == [False, False, True, False, False]


def test_trials_of_other_settings_are_refused(tmp_path: Path) -> None:
    file = str(tmp_path / "study.db")
    directions = list(OBJECTIVES["velocity"].values())
    with study_in(file, {"seed": 0}, directions) as study:
        study.add_trial(optuna.trial.create_trial(value=1.0))
    with pytest.raises(ValueError, match="seed"), study_in(file, {"seed": 1}, directions):
        pass


def arguments(folder: Path) -> list[str]:
    return [sys.executable, str(SCRIPT), f"output={folder}", f"trials={TRIALS}", "objective=all"]


@pytest.mark.long
def test_killed_and_started_again_it_has_the_same_numbers(tmp_path: Path) -> None:
    subprocess.run(arguments(tmp_path / "whole"), cwd=tmp_path, capture_output=True, check=False)
    cut = tmp_path / "cut"
    for count in (2, 5):
        with subprocess.Popen(arguments(cut), cwd=tmp_path, stderr=subprocess.DEVNULL) as running:
            began = monotonic()
            while (
                finished(cut / "study.db") < count and running.poll() is None and monotonic() - began < 300.0
            ):
                sleep(0.05)
            running.send_signal(signal.SIGKILL)
    subprocess.run(arguments(cut), cwd=tmp_path, capture_output=True, check=False)
    whole, resumed = (
        xarray.load_dataset(folder / f"{OptimiseMotor.name}.nc") for folder in (tmp_path / "whole", cut)
    )
    xarray.testing.assert_equal(whole, resumed)


def finished(file: Path) -> int:
    # Read only: Optuna would make tables that the running process is just making.
    if not file.is_file():
        return 0
    states = [state.name for state in optimise_motor.FINISHED]
    question = f"SELECT COUNT(*) FROM trials WHERE state IN ({', '.join('?' * len(states))})"
    with closing(sqlite3.connect(f"file:{file}?mode=ro", uri=True)) as database:
        try:
            return int(database.execute(question, states).fetchone()[0])
        # Its tables are not yet there, or it is being written.
        except sqlite3.OperationalError:
            return 0
