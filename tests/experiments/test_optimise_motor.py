"""The search for better motors: what it varies, and that nothing that ends it is seen in the result."""

import shutil
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from functools import cache
from pathlib import Path
from time import sleep

import harness
import motor_search
import numpy as np
import optimise_motor
import optuna
import pytest
import study_file
import xarray
from support.command_line import cases

from contactlab.config import ConfigurationError, Setup

TRIALS = 34
"""A generation and a few: from here on the search goes on from what it has found."""


@cache
def setup_of(*overrides: str) -> Setup:
    return harness.setup_of("optimise_motor", overrides)


def fingerprint(trials: list) -> list[tuple]:
    return [(t.state, t.params, t.values, t.user_attrs, t.intermediate_values) for t in trials]


@cache
def uninterrupted(objective: str, seed: int = 0) -> list[tuple]:
    search = motor_search.Search(trials=TRIALS, seed=seed, objective=objective)
    return fingerprint(motor_search.searched(setup_of(), search))


# What is searched.


def test_every_variable_in_its_range_is_a_motor_of_the_schema() -> None:
    bounds = motor_search.ranges_of(setup_of())
    for ends in np.ndindex(*(2,) * len(bounds)):
        values = {name: bounds[name][end] for name, end in zip(bounds, ends, strict=True)}
        made = motor_search.designed(setup_of(), values)
        natural = made.motor.modes.natural_frequency[0]
        assert made.motor.drive.frequency[0] / natural == pytest.approx(values["relative_frequency"])


def test_a_key_that_is_given_is_held() -> None:
    words = ["placement.start=1e-3", "contact.clearance=5e-7", "trials=3", "law=lagrange_stick"]
    search, rest = motor_search.search_of(words)
    assert rest == [words[0], words[1], words[3]]
    assert search.held == {"placement", "contact.clearance"}
    setup = setup_of(*rest)
    assert set(motor_search.ranges_of(setup, search.held)) == {"phase", "relative_frequency"}
    made = motor_search.designed(setup, {"phase": -1.0, "relative_frequency": 1.1})
    assert made.configuration["placement"]["start"] == 1e-3
    assert made.configuration["contact"]["clearance"] == 5e-7
    assert made.law.name == "lagrange_stick"


def test_the_front_is_beaten_by_nobody_and_beats_the_rest() -> None:
    goals = np.array(
        [[9, 9, 0], [2, 2, 2], [1, 3, 2], [1, 2, 2], [2, 2, 3], [2, 2, 2], [0, 0, np.nan]], float
    )
    among = optimise_motor.among_the_best
    assert among(goals, "all").tolist() == [False, True, True, False, False, False, False]
    assert np.flatnonzero(among(goals, "velocity")).tolist() == [1]


# What ends a search leaves no trace in its result.


@pytest.mark.parametrize("objective", cases(["all", "velocity"], ["all"]))
@pytest.mark.long
def test_the_same_seed_is_the_same_search_and_another_is_not(objective: str) -> None:
    first = uninterrupted(objective)
    uninterrupted.cache_clear()
    assert uninterrupted(objective) == first
    assert uninterrupted(objective, 1) != first


@pytest.mark.parametrize("objective", cases(["all", "velocity"], ["all"]))
@pytest.mark.long
def test_interrupted_anywhere_and_resumed_it_is_the_uninterrupted_search(
    objective: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    search = motor_search.Search(trials=TRIALS, objective=objective, file=tmp_path / "new" / "study.db")
    measured = motor_search.performance

    def cut_at(trial: int) -> Callable[..., object]:
        calls = iter(range(trial))

        def cut(*arguments: object) -> object:
            if next(calls, None) is None:
                raise KeyboardInterrupt
            return measured(*arguments)

        return cut

    # The first trial, another, the same again, and those about the end of a generation.
    for trial in (0, 9, 0, 19, 0, 1, 1):
        monkeypatch.setattr(motor_search, "performance", cut_at(trial))
        with pytest.raises(KeyboardInterrupt):
            motor_search.searched(setup_of(), search)
    monkeypatch.setattr(motor_search, "performance", measured)
    assert fingerprint(motor_search.searched(setup_of(), search)) == uninterrupted(objective)
    # It is finished: asked again, nothing is measured.
    monkeypatch.setattr(motor_search, "performance", cut_at(0))
    assert fingerprint(motor_search.searched(setup_of(), search)) == uninterrupted(objective)


def finished(folder: Path, elsewhere: Path) -> int:
    """Trials in a study that another process keeps locked, seen in a copy; 0 if that is not whole."""
    for name in ("study.db-wal", "study.db"):
        if not (folder / name).exists():
            return 0
        shutil.copy(folder / name, elsewhere)
    try:
        with closing(sqlite3.connect(elsewhere / "study.db")) as look:
            query = "SELECT count(*) FROM trials WHERE state IN ('COMPLETE', 'PRUNED')"
            return int(look.execute(query).fetchone()[0])
    except sqlite3.DatabaseError:
        return 0


@pytest.mark.long
def test_killed_and_started_again_it_leaves_the_same_bytes(tmp_path: Path) -> None:
    def command(folder: str) -> list[str]:
        script = optimise_motor.__file__
        return [sys.executable, script, "trials=8", f"output={tmp_path / folder}"]

    with subprocess.Popen(command("killed"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as search:
        try:
            # As soon as something is finished, while the rest is on its way.
            while finished(tmp_path / "killed", tmp_path) < 2:
                assert search.poll() is None
                sleep(0.02)
        finally:
            search.kill()
    assert search.returncode == -signal.SIGKILL
    for folder in ("killed", "whole"):
        assert optimise_motor.run(command(folder)[2:]) in (0, 1)
    for name in ("table.csv", "figure.png"):
        killed, whole = (tmp_path / folder / name for folder in ("killed", "whole"))
        assert killed.read_bytes() == whole.read_bytes()
    with (
        xarray.open_dataset(tmp_path / "killed" / "data.nc") as one,
        xarray.open_dataset(tmp_path / "whole" / "data.nc") as other,
    ):
        assert one.sizes["motor"] == 9
        assert one.equals(other)


# What cannot be searched is refused, and costs nothing.


def test_a_study_of_other_settings_is_refused_and_says_what_differs(tmp_path: Path) -> None:
    search = motor_search.Search(trials=1, file=tmp_path / "study.db")
    before = fingerprint(motor_search.searched(setup_of(), search))
    for setup, other, words in (
        (setup_of("law=lagrange_stick"), search, "law.name = hertz_penalty, not lagrange_stick"),
        (setup_of("contact.friction_coefficient=0.2"), search, "friction_coefficient = 0.3, not 0.2"),
        (setup_of(), replace(search, seed=1), "seed = 0, not 1"),
        (setup_of(), replace(search, objective="velocity"), "objective = all, not velocity"),
        (setup_of(), replace(search, held=frozenset({"contact.clearance"})), "range.clearance"),
    ):
        with pytest.raises(ConfigurationError, match=f"study.db was made with .*{words}"):
            motor_search.searched(setup, other)
    assert fingerprint(motor_search.searched(setup_of(), search)) == before


def test_a_study_in_use_and_a_file_that_is_none_are_refused_and_left_alone(tmp_path: Path) -> None:
    search = motor_search.Search(trials=1, file=tmp_path / "study.db")
    no_pruner = optuna.pruners.NopPruner()
    with (
        study_file.study_in(search.file, {}, ["maximize"], no_pruner),
        pytest.raises(ConfigurationError, match=r"study\.db is in use"),
    ):
        motor_search.searched(setup_of(), search)
    text, database = tmp_path / "text", tmp_path / "other.db"
    text.write_text("no study " * 1000)
    with closing(sqlite3.connect(database)) as other:
        other.execute("CREATE TABLE mine (number)")
        other.commit()
    for file, words in (
        (text, "file is not a database"),
        (database, "database of something else"),
        (tmp_path, "unable to open"),
        (text / "study.db", "File exists"),
    ):
        before = file.read_bytes() if file.is_file() else None
        with pytest.raises(ConfigurationError, match=f"cannot hold a study: .*{words}"):
            motor_search.searched(setup_of(), replace(search, file=file))
        assert (file.read_bytes() if file.is_file() else None) == before


@pytest.mark.parametrize(
    ("word", "fault"),
    [
        ("trials=0", "trials is 0; it must be a whole number, at least 1"),
        ("seed=x", "seed is x; it must be a whole number, at least 0"),
        ("objective=torque", "objective is torque; it must be one of all, velocity"),
        ("rotor.load_torque=1e-3", "rotor.load_torque is 0.001 N m; it must be 0"),
        ("drive.frequency_ratio=1.5", "drive.frequency_ratio is 1.5; it must be a whole number"),
        ("contact.clearance=1e-4", "The configured motor is none to compare with"),
        ("contact.clearance=-1", "contact.clearance"),
    ],
)
def test_a_fault_is_a_sentence_and_leaves_nothing(
    word: str, fault: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "out"
    assert optimise_motor.run(["trials=1", f"output={folder}", word]) == 2
    assert fault in capsys.readouterr().err
    assert not folder.exists()


def test_a_search_of_nothing_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["placement=placement_1", "drive.phase=0", "drive.frequency=3000", "contact.clearance=0"]
    assert optimise_motor.run([f"output={tmp_path / 'out'}", *given]) == 2
    assert "at least one must be left to be searched" in capsys.readouterr().err


def test_ctrl_c_says_that_the_same_command_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def cut(*arguments: object) -> object:
        raise KeyboardInterrupt

    monkeypatch.setattr(motor_search, "performance", cut)
    assert optimise_motor.run([f"output={tmp_path}", "trials=1"]) == 130
    assert "the same command goes on" in capsys.readouterr().err
