"""Claims on the declaration of a study: nothing that an author writes is ignored."""

import multiprocessing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import pytest
from support.slow_study import run_by_workers

import contactlab as cl
from contactlab.studies.runner import TASKS, Store
from contactlab.studies.steady import Steady
from contactlab.studies.study import Task


def test_a_class_attribute_that_no_study_has_is_refused() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Stroke(Steady):
        name: ClassVar[str] = "stroke"
        forms: ClassVar[dict[str, Any]] = {}

    with pytest.raises(TypeError, match="forms"):
        Stroke()


def test_an_attribute_of_its_own_begins_with_an_underscore() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Stroke(Steady):
        name: ClassVar[str] = "stroke"
        _forms: ClassVar[dict[str, Any]] = {}

        def own(self) -> int:
            return 1

    assert Stroke().own() == 1


def test_a_task_that_resumes_leaves_no_folder_before_it_has_something_to_keep(tmp_path: Path) -> None:
    store = Store(tmp_path / TASKS, Steady(), {"": cl.build()})
    task = store.resuming(Task("one", print, (), resumes=True))
    assert task.arguments[-1].parent == tmp_path / TASKS
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
def test_a_process_of_multiprocessing_ends_with_its_study() -> None:
    """It waits for its workers at its end, and they would wait five minutes for work."""
    process = multiprocessing.get_context("spawn").Process(target=run_by_workers)
    process.start()
    process.join(100.0)
    status = process.exitcode
    process.kill()
    assert status == 0
