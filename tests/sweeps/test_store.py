"""Processes that work on one sweep at a time take nothing from each other, and what is damaged is told."""

import random
from collections.abc import Callable
from pathlib import Path

import pytest
from support.sweeps import CELLS, Made, begun, plan

from contactlab.sweeps import SweepError, store
from contactlab.sweeps.dataset import DATASET
from contactlab.sweeps.plan import Plan
from contactlab.sweeps.state import Status
from contactlab.sweeps.store import CHUNKS, MANIFEST, Store


def finish(path: Path) -> None:
    """What another process does that makes the sweep as well."""
    other = Store.opened(path)
    for chunk in other.missing():
        other.run(chunk, Made())
    other.merge()


def assert_whole(folder: Store) -> None:
    found = folder.dataset()
    assert found["peak_force"].values.tolist() == list(range(CELLS))
    assert found.attrs["runs_absent"] == 0
    assert {path.name for path in folder.path.iterdir()} == {DATASET, MANIFEST, f"{DATASET}.sha256"}


def once(first: Callable[[], object], real: Callable[..., object]) -> Callable[..., object]:
    """The real function, before whose first call something else happens."""
    waiting = [first]

    def call(*arguments: object) -> object:
        if waiting:
            waiting.pop()()
        return real(*arguments)

    return call


def test_a_sweep_that_is_completed_while_a_part_of_it_is_collected_stays_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = begun(tmp_path, finished=2)
    monkeypatch.setattr(store, "write", once(lambda: finish(tmp_path), store.write))
    folder.merge()
    found = Store.opened(tmp_path).merge()
    assert not (found["status"] == Status.ABSENT).any()
    assert_whole(folder)


def test_chunks_that_another_process_has_merged_are_not_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = begun(tmp_path, finished=3)
    missing = Store.missing
    other = [lambda: finish(tmp_path)]

    def look(self: Store) -> list[int]:
        found = missing(self)
        if self is folder and other:
            other.pop()()
        return found

    monkeypatch.setattr(Store, "missing", look)
    assert not (folder.merge()["status"] == Status.ABSENT).any()
    assert_whole(folder)


def test_a_chunk_whose_sweep_is_completed_meanwhile_is_not_missed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = begun(tmp_path, finished=1)
    # The folder of the chunks goes away after this process has made sure that it is there.
    monkeypatch.setattr(store, "write_chunk", once(lambda: finish(tmp_path), store.write_chunk))
    folder.run(1, Made())
    assert_whole(folder)
    before = (tmp_path / DATASET).read_bytes()
    folder.run(2, Made(lambda: pytest.fail("It is there already.")))
    assert folder.missing() == []
    folder.merge()
    assert (tmp_path / DATASET).read_bytes() == before


def test_of_two_sweeps_that_begin_at_once_in_one_folder_one_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = Store(tmp_path, plan()), Store(tmp_path, plan(first=1.0))
    text = Plan.text
    other = [first.begin]

    def late(self: Plan) -> str:
        if self is second.plan and other:
            other.pop()()
        return text(self)

    monkeypatch.setattr(Plan, "text", late)
    with pytest.raises(SweepError, match="holds another sweep"):
        second.begin()
    assert Store.opened(tmp_path).plan == first.plan


def test_every_damage_of_a_chunk_is_told(tmp_path: Path) -> None:
    folder = begun(tmp_path, finished=3, series=("gap",))
    file = tmp_path / CHUNKS / "000001.npz"
    sound = file.read_bytes()
    chance = random.Random(1)
    for _ in range(200):
        damaged = bytearray(sound)
        place = chance.randrange(len(damaged))
        damaged[place] ^= 1 << chance.randrange(8)
        file.write_bytes(damaged)
        with pytest.raises(SweepError, match="is damaged"):
            folder.merge()
    for length in (0, 10, len(sound) - 1):
        file.write_bytes(sound[:length])
        with pytest.raises(SweepError, match="is damaged"):
            folder.merge()
    assert not (tmp_path / DATASET).exists()
    file.write_bytes(sound)
    folder.merge()
    assert_whole(folder)


def test_a_damaged_sweep_is_told_and_left_alone(tmp_path: Path) -> None:
    finish_in = begun(tmp_path, finished=3, series=("gap",))
    finish_in.merge()
    file = tmp_path / DATASET
    damaged = bytearray(file.read_bytes())
    damaged[len(damaged) // 2] ^= 1
    file.write_bytes(damaged)
    with pytest.raises(SweepError, match=r"is not as the sweep left it.*Move it away"):
        Store.opened(tmp_path).merge()
    assert file.read_bytes() == damaged
    file.unlink()
    folder = begun(tmp_path, finished=3, series=("gap",))
    folder.merge()
    assert_whole(folder)
