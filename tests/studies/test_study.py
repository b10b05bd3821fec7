"""Claims on the declaration of a study: nothing that an author writes is ignored."""

import multiprocessing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import pytest
import xarray
from support.slow_study import run_by_workers

import contactlab as cl
from contactlab.studies.runner import TASKS, Parts, RemovedError, Store
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


def test_data_that_stay_in_memory_are_those_of_the_file_whatever_a_reader_did_to_them(tmp_path: Path) -> None:
    parts = Parts(["small", "large"])
    for key, count in {"small": 2, "large": Parts.HELD // 8 + 1}.items():
        file = tmp_path / f"{key}.nc"
        xarray.DataTree(xarray.Dataset({"x": ("n", [1.0] * count)})).to_netcdf(file)
        parts.put(key, file)
        parts[key]["x"].values[:] = 0.0
        parts[key]["x"].values[:] = 0.0
        file.unlink()
    assert parts["small"]["x"].values.tolist() == [1.0, 1.0]
    # What is too large to stay is read anew.
    with pytest.raises(RemovedError):
        parts["large"]
