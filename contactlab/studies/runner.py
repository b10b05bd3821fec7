"""The runner of all studies: does the tasks, in this process, by joblib or by Dask, and resumes.

Each finished task is a netCDF file in the folder `tasks` of the result's folder, named by the digest of all
that its numbers depend on (configuration, options, version and sources) and by the digest of its content. A
study that is killed therefore goes on where it stopped and leaves the same bytes; files of another
configuration or version are never taken for its own. They are removed when the study's dataset is written.
"""

import json
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Final, final

import xarray
import yaml

from contactlab.foreign import digest_of_sources
from contactlab.results.files import digest_of_file
from contactlab.results.netcdf import write_tree
from contactlab.results.provenance import code_attributes
from contactlab.studies.study import Part, Result, Setups, Study, Task
from contactlab.sweeps.state import key_of

TASKS: Final = "tasks"
"""Folder of the finished tasks, beside the files of the result."""

Progress = Callable[[int, int], object]
"""Receives the number of finished tasks and that of all."""


def run(study: Study, setups: Setups, folder: Path | None = None, progress: Progress | None = None) -> Result:
    """Do what is left of a study's tasks and combine them.

    Args:
        study: the question.
        setups: what it is put to, by label.
        folder: where finished tasks are kept until `finish`; None keeps none.
        progress: receives the number of finished tasks and that of all.

    Raises:
        ValueError: two tasks have one key.
        OSError: the folder cannot be written to.
        KeyboardInterrupt: as it comes; finished tasks are kept.
    """
    tasks = list(study.tasks(setups))
    if len({task.key for task in tasks}) < len(tasks):
        raise ValueError(f"Two tasks of the study {study.name} have one key.")
    # A motor made in Python has no configuration that determines it.
    resumable = folder is not None and all("resonator" in setup.configuration for setup in setups.values())
    store = Store(folder / TASKS, study, setups) if folder is not None and resumable else None
    parts: dict[str, Part] = {}
    if store:
        parts = {task.key: part for task in tasks if (part := store.read(task.key))}
    pending = [store.resuming(task) if store else task for task in tasks if task.key not in parts]
    if progress:
        progress(len(parts), len(tasks))
    for key, part in _finished(study, pending):
        parts[key] = store.write(key, part) if store else part
        if progress:
            progress(len(parts), len(tasks))
    data = study.combine(setups, {task.key: parts[task.key].data for task in tasks})
    data.attrs = {**code_attributes(), **_settings(study, setups), **data.attrs}
    details = parts[tasks[0].key].details if len(tasks) == 1 else None
    return Result(study, setups, data, details)


def _settings(study: Study, setups: Setups) -> dict[str, str]:
    """Return the attributes of a dataset that say what it was made from."""
    configurations = [setup.configuration for setup in setups.values()]
    shown = configurations[0] if len(configurations) == 1 else configurations
    return {
        "study": yaml.safe_dump({"name": study.name, **study.options}, sort_keys=False),
        "configuration": yaml.safe_dump(shown, sort_keys=False, allow_unicode=True),
    }


def finish(result: Result, folder: Path) -> list[str]:
    """Write the files of a result into its folder, remove the finished tasks and return the files' names.

    Raises:
        OSError: the folder cannot be written to.
    """
    # Imported here: it brings matplotlib.
    from contactlab.studies.report import save

    files = save(result, folder)
    shutil.rmtree(folder / TASKS, ignore_errors=True)
    return files


@final
class Store:
    """Keeps the parts of one study in a folder."""

    def __init__(self, folder: Path, study: Study, setups: Setups) -> None:
        self.folder = folder
        parts = [
            study.name,
            json.dumps(study.options, sort_keys=True, default=str),
            digest_of_sources(type(study)),
        ]
        parts += [f"{label}\0{key_of(setup)}" for label, setup in setups.items()]
        self._digest = sha256("\0".join(parts).encode()).hexdigest()

    def _name(self, key: str) -> str:
        return sha256(f"{self._digest}\0{key}".encode()).hexdigest()[:32]

    def resuming(self, task: Task) -> Task:
        """Return a task with the file by which it resumes."""
        if not task.resumes:
            return task
        self.folder.mkdir(parents=True, exist_ok=True)
        checkpoint = self.folder / f"{self._name(task.key)}.checkpoint"
        return replace(task, arguments=(*task.arguments, checkpoint))

    def read(self, key: str) -> Part | None:
        """Return a finished part; None where there is none, or where its file is damaged."""
        for file in self.folder.glob(f"{self._name(key)}-*.nc"):
            # Before it is opened: the netCDF library may take damaged numbers for numbers.
            with suppress(OSError):
                if digest_of_file(file) == file.stem.partition("-")[2]:
                    return Part(_loaded(file))
        return None

    def write(self, key: str, part: Part) -> Part:
        """Write a part and return it as it will be read."""
        self.folder.mkdir(parents=True, exist_ok=True)
        fresh = self.folder / f"{self._name(key)}.nc"
        digest = write_tree(part.data, fresh)
        file = fresh.replace(fresh.with_name(f"{fresh.stem}-{digest}.nc"))
        return Part(_loaded(file), part.details)


def _loaded(file: Path) -> xarray.DataTree:
    with xarray.open_datatree(file, engine="netcdf4") as tree:
        return tree.load()


def _finished(study: Study, tasks: Sequence[Task]) -> Iterator[tuple[str, Part]]:
    """Do tasks and yield key and part of each as it ends."""
    if study.scheduler is not None:
        yield from _by_dask(study.scheduler, tasks)
    elif study.workers > 1 and len(tasks) > 1:
        # Imported here: one process needs none.
        from joblib import Parallel, delayed

        every = Parallel(n_jobs=min(study.workers, len(tasks)), return_as="generator_unordered")
        yield from every(delayed(_done)(task) for task in tasks)
    else:
        yield from map(_done, tasks)


def _done(task: Task) -> tuple[str, Part]:
    return task.key, task()


def _by_dask(address: str, tasks: Sequence[Task]) -> Iterator[tuple[str, Part]]:
    """Have the workers of a Dask scheduler do tasks; those of a worker that dies go to the others."""
    from distributed import Client, as_completed

    with Client(address, set_as_default=False) as client:
        futures = [client.submit(_done, task, pure=False) for task in tasks]
        for future in as_completed(futures, loop=client.loop):
            yield future.result()
            future.release()
