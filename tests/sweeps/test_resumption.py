"""An interrupted sweep continues to the same bytes, whatever else works in its folder."""

import pickle
import random
from collections.abc import Callable
from pathlib import Path

import pytest
from support.sweeps import CELLS, begun, small_sweep

from contactlab import SweepError
from contactlab.results.files import STATE
from contactlab.studies.run_state import Job, State, Status, read_state, write_state
from contactlab.studies.runner import TASKS
from contactlab.studies.sweep import study as module
from contactlab.studies.sweep.collection import collect
from contactlab.studies.sweep.dataset import DATASET
from contactlab.studies.sweep.plan import Plan
from contactlab.studies.sweep.study import DIGEST, MANIFEST, UNFINISHED, begin, continued, read_plan


def files_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """The files of a sweep that nothing interrupted."""
    folder = tmp_path_factory.mktemp("whole")
    dataset = continued(begun(folder, 0), folder)
    assert dataset.sizes["phase"] == CELLS
    assert dataset.attrs["runs_complete"] == CELLS
    assert {*files_of(folder)} == {DATASET, MANIFEST, DIGEST}
    return files_of(folder)


@pytest.mark.parametrize("finished", [1, 2, 3])
@pytest.mark.parametrize("shared", [False, True])
def test_an_interrupted_sweep_continues_to_the_same_bytes(
    tmp_path: Path, whole: dict[str, bytes], finished: int, shared: bool
) -> None:
    """Also where another process finishes it meanwhile."""
    sweep, others = begun(tmp_path, finished - shared), [small_sweep()] * shared
    counts: list[int] = []

    def progress(done: int, _: int) -> None:
        counts.append(done)
        if others and done == finished:
            continued(others.pop(), tmp_path)

    continued(sweep, tmp_path, progress)
    assert not others
    assert shared or counts == [*range(finished, 4)]
    assert files_of(tmp_path) == whole


def test_a_sweep_that_is_finished_while_a_part_of_it_is_collected_stays_whole(
    tmp_path: Path, whole: dict[str, bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep = begun(tmp_path, 2)
    monkeypatch.setattr(module, "write", once(lambda: continued(sweep, tmp_path), module.write))
    collect(tmp_path)
    assert not (collect(tmp_path)["status"] == Status.ABSENT).any()
    assert files_of(tmp_path) == whole


def once(first: Callable[[], object], real: Callable[..., object]) -> Callable[..., object]:
    """Return the real function, before whose first call something else happens."""
    waiting = [first]

    def call(*arguments: object) -> object:
        if waiting:
            waiting.pop()()
        return real(*arguments)

    return call


def test_of_two_sweeps_that_begin_at_once_in_one_folder_one_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = small_sweep().plan, small_sweep(first=1.0).plan
    text = Plan.text
    other = [lambda: begin(tmp_path, first)]

    def late(self: Plan) -> str:
        if self is second and other:
            other.pop()()
        return text(self)

    monkeypatch.setattr(Plan, "text", late)
    with pytest.raises(SweepError):
        begin(tmp_path, second)
    assert read_plan(tmp_path) == first


def test_plans_and_states_are_read_as_they_were_written(tmp_path: Path) -> None:
    job = Job("key", ("law=newton",), {"law": "newton", "law/normal": None}, {"a": {"b": [1, 2.5, None]}})
    state, plan = State("complete", job, digest="0a", metrics={"peak_force": 0.1}), small_sweep().plan
    write_state(tmp_path, state)
    assert read_state(tmp_path) == state
    assert Plan.of_text(plan.text()) == plan


@pytest.mark.parametrize(
    "text",
    [
        *("", "[]", "{}", "complete", "[" * 100_000, '{"state": "complete"}', '{"state": 1, "job": {}}'),
        '{"state": "complete", "job": {"key": null}}',
        '{"state": "complete", "job": {"overrides": "law=newton"}}',
        '{"state": "complete", "job": {}, "metrics": {"peak_force": "high"}}',
        '{"axes": [{"key": "law", "values": [[]]}], "samples": false, "outputs": {}}',
        '{"axes": [], "samples": false, "outputs": {}, "keep": "nothing"}',
    ],
)
def test_a_spoilt_plan_or_state_is_none(tmp_path: Path, text: str) -> None:
    for name in (MANIFEST, STATE):
        (tmp_path / name).write_text(text)
    assert read_plan(tmp_path) is None
    assert read_state(tmp_path) is None


def test_damaged_tasks_are_done_again(tmp_path: Path, whole: dict[str, bytes]) -> None:
    sweep, chance = begun(tmp_path, 3), random.Random(1)
    flipped, cut, _ = sorted((tmp_path / TASKS).iterdir())
    damaged = bytearray(flipped.read_bytes())
    damaged[chance.randrange(len(damaged))] ^= 1
    flipped.write_bytes(damaged)
    cut.write_bytes(cut.read_bytes()[:-1])
    counts: list[int] = []
    continued(sweep, tmp_path, lambda done, _: counts.append(done))
    assert counts == [1, 2, 3]
    assert files_of(tmp_path) == whole


def test_a_damaged_sweep_is_refused_and_left_alone(tmp_path: Path, whole: dict[str, bytes]) -> None:
    sweep = begun(tmp_path, 3)
    continued(sweep, tmp_path)
    damaged = bytearray(whole[DATASET])
    damaged[len(damaged) // 2] ^= 1
    (tmp_path / DATASET).write_bytes(damaged)
    with pytest.raises(SweepError, match=DATASET):
        continued(sweep, tmp_path)
    assert (tmp_path / DATASET).read_bytes() == damaged
    (tmp_path / DATASET).unlink()
    continued(sweep, tmp_path)
    assert files_of(tmp_path) == whole


def test_what_is_finished_can_be_collected(tmp_path: Path, whole: dict[str, bytes]) -> None:
    sweep = begun(tmp_path, 2)
    result = collect(tmp_path)
    assert Path(result.encoding["source"]) == tmp_path / UNFINISHED
    assert result["status"].values.tolist() == 6 * [Status.COMPLETE] + 3 * [Status.ABSENT]
    assert result.attrs["complete"] == 0
    continued(sweep, tmp_path)
    assert files_of(tmp_path) == whole


def test_a_task_takes_the_values_of_its_own_cells_along() -> None:
    sweep = small_sweep()
    task = pickle.loads(pickle.dumps([*sweep.tasks({})][1]))
    rows = next(each for each in task.arguments if isinstance(each, Plan))
    assert rows.axes[0].values == sweep.plan.axes[0].values[3:6]
    pairs = zip(range(3), range(3, 6), strict=True)
    assert all(rows.configuration(here) == sweep.plan.configuration(there) for here, there in pairs)
