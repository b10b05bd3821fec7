"""The runner of all studies: does the tasks, in this process, by joblib or by Dask, and resumes.

Each finished task is a netCDF file in the folder `tasks` of the result's folder, named by the digest of all
that its numbers depend on (configuration, options, version and sources) and by the digest of its content. A
study that is killed therefore goes on where it stopped and leaves the same bytes; files of another
configuration or version are never taken for its own. They are removed when the study's dataset is written.
"""

import errno
import json
import socket
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import replace
from hashlib import sha256
from multiprocessing import parent_process
from pathlib import Path
from pickle import PicklingError, dumps
from time import process_time
from typing import Any, ClassVar, Protocol, final
from urllib.parse import urlsplit

import xarray

from contactlab.checks import check_kind
from contactlab.foreign import covered_sources, digest_of_sources, other_sources
from contactlab.interrupts import raise_if_stopped
from contactlab.processes import WorkerError
from contactlab.results.files import digest_of_file
from contactlab.results.netcdf import write_tree
from contactlab.results.provenance import code_digest
from contactlab.studies.run_state import key_of
from contactlab.studies.task import TASKS as TASKS, Part, Progress, Setups, Task


class Work(Protocol):
    """What the runner needs of a study: its tasks, and what they depend on."""

    @property
    def name(self) -> str:
        """Name of the study."""

    @property
    def delay(self) -> float:
        """Processor time after which other processes are started [s]."""

    @property
    def workers(self) -> int:
        """Processes at work."""

    @property
    def scheduler(self) -> str | None:
        """Address of a Dask scheduler."""

    @property
    def options(self) -> Mapping[str, Any]:
        """The options on which the result depends, by name."""

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return the independent pieces of the study."""

    def further_tasks(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> Iterable[Task]:
        """Return tasks that follow from finished ones."""


class RemovedError(OSError):
    """Another process ended the same study in the same folder, and removed its finished tasks."""


@final
class Parts(Mapping[str, xarray.DataTree]):
    """Data of the finished tasks by key, in the order of the tasks; those in a folder are read one by one.

    The first `HELD` bytes that are read stay in memory: a study may ask for all of them at each of its looks.
    """

    HELD: ClassVar[int] = 2**26

    def __init__(self, keys: Iterable[str]) -> None:
        self._places: dict[str, Part | Path | None] = dict.fromkeys(keys)
        self._read: dict[str, xarray.DataTree] = {}
        self._held = 0

    def put(self, key: str, place: Part | Path) -> None:
        """Add a part, or the file that contains it."""
        self._places[key] = place

    def __getitem__(self, key: str) -> xarray.DataTree:
        if key in self._read:
            return self._read[key].copy(deep=True)
        match self._places[key]:
            case Part() as part:
                return part.data
            case Path() as file:
                try:
                    with xarray.open_datatree(file, engine="netcdf4") as tree:
                        data = tree.load()
                except FileNotFoundError as error:
                    raise RemovedError(*error.args) from error
                if self._held + data.nbytes <= self.HELD:
                    self._read[key], self._held = data.copy(deep=True), self._held + data.nbytes
                return data
        raise KeyError(key)

    def add(self, others: "Parts") -> None:
        """Add the places of other tasks."""
        self._places |= others._places

    @property
    def count(self) -> int:
        """Number of tasks, finished or not."""
        return len(self._places)

    @property
    def unmade(self) -> bool:
        """Whether the data of every task are made only when they are read."""
        return all(isinstance(place, Part) and callable(place.source) for place in self._places.values())

    @property
    def missing(self) -> list[str]:
        """Keys of the tasks that are not finished."""
        return [key for key, place in self._places.items() if place is None]

    def __contains__(self, key: object) -> bool:
        return isinstance(key, str) and self._places.get(key) is not None

    def __iter__(self) -> Iterator[str]:
        return (key for key, place in self._places.items() if place is not None)

    def __len__(self) -> int:
        return sum(place is not None for place in self._places.values())


def done_parts(
    study: Work,
    setups: Setups,
    folder: Path | None = None,
    progress: Progress | None = None,
    first: Callable[[Parts], object] = lambda _: None,
) -> tuple[Parts, Any]:
    """Do what is left of a study's tasks; return their data, and the details of a single task.

    The arguments and exceptions are those of `contactlab.studies.study.run`; `first` receives what is done
    before further tasks.
    """
    store = None
    # A motor made in Python has no configuration that determines it.
    if folder is not None and not any(setup.made_in_python for setup in setups.values()):
        store = Store(folder / TASKS, study, setups)
    parts, details = Parts(()), None
    tasks = list(study.tasks(setups))
    while tasks:
        if len({task.key for task in tasks}) < len(tasks):
            raise ValueError(f"Two tasks of the study {study.name} have one key.")
        parts.add(store.kept(tasks) if store else Parts(task.key for task in tasks))
        pending = [store.resuming(task) if store else task for task in tasks if task.key not in parts]
        if progress:
            progress(len(parts), parts.count)
        for key, part in _finished(study, pending):
            check_kind(f"The study {study.name}: what its task {key!r} returns", part, Part)
            parts.put(key, store.write(key, part.data) if store else part)
            details = part.details if parts.count == 1 else None
            raise_if_stopped()
            if progress:
                progress(len(parts), parts.count)
        if tasks := list(study.further_tasks(setups, parts)):
            first(parts)
    return parts, details


@final
class Store:
    """Keeps the parts of one study in a folder."""

    def __init__(self, folder: Path, study: Work, setups: Setups) -> None:
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
        checkpoint = self.folder / f"{self._name(task.key)}.checkpoint"
        return replace(task, arguments=(*task.arguments, checkpoint))

    def kept(self, tasks: Sequence[Task]) -> Parts:
        """Return the finished parts of tasks."""
        parts = Parts(task.key for task in tasks)
        # One look into the folder: a sweep has thousands of tasks.
        files = {file.stem.partition("-")[0]: file for file in self.folder.glob("*-*.nc")}
        for task in tasks:
            # Before it is opened: the netCDF library may take damaged numbers for numbers.
            with suppress(OSError):
                file = files.get(self._name(task.key))
                if file and digest_of_file(file) == file.stem.partition("-")[2]:
                    parts.put(task.key, file)
        return parts

    def write(self, key: str, data: xarray.DataTree) -> Path:
        """Write the data of a part and return the file."""
        self.folder.mkdir(parents=True, exist_ok=True)
        fresh = self.folder / f"{self._name(key)}.nc"
        try:
            digest = write_tree(data, fresh)
        except OSError as error:
            if error.errno == errno.ENOENT or not self.folder.exists():
                raise RemovedError(*error.args) from error
            raise
        file = fresh.with_name(f"{fresh.stem}-{digest}.nc")
        # Another process that does the same task may have moved its own.
        with suppress(FileNotFoundError):
            fresh.replace(file)
        return file


def _finished(study: Work, tasks: Sequence[Task]) -> Iterator[tuple[str, Part]]:
    """Do tasks and yield key and part of each as it ends."""
    if study.scheduler is not None:
        yield from _by_dask(study.scheduler, tasks)
        return
    rest, begun = deque(tasks), process_time()
    while rest and (study.workers < 2 or len(rest) < 2 or process_time() < begun + study.delay):
        task = rest.popleft()
        yield task.key, task()
    if rest:
        # Imported here: one process needs none.
        from joblib import Parallel, delayed
        from joblib.externals.loky import get_reusable_executor

        every = Parallel(n_jobs=min(study.workers, len(rest)), return_as="generator_unordered")
        code = code_digest(), covered_sources()
        try:
            yield from every(delayed(_done_by_worker)(task, *code) for task in rest)
        except PicklingError:
            # What cannot be sent says why itself.
            dumps([*rest])
            raise
        except WorkerError as error:
            # The next study of this process must not meet workers with old code.
            get_reusable_executor().shutdown()
            # Without the worker's traceback.
            raise WorkerError(str(error)) from None
        except BrokenProcessPool as error:
            raise WorkerError(
                "A worker process died, maybe for want of memory; finished tasks are kept. Start again, with "
                "fewer workers if it dies again."
            ) from error
        finally:
            # A process that multiprocessing made ends after its workers, which wait five minutes for work.
            if parent_process() is not None:
                get_reusable_executor().shutdown()


def _done_by_worker(task: Task, package: str, sources: Mapping[str, str]) -> tuple[str, Part]:
    """Do a task in a worker; a WorkerError where its code is not that of the process which keeps the part.

    That is the digest of this `package`, and those of the `sources` of others by module.
    """
    part = task()
    others = [] if code_digest() == package else ["contactlab"]
    # Laws that are built from a configuration are loaded by the task.
    if others := others + other_sources(sources):
        raise WorkerError(
            f"The sources of {', '.join(others)} in a worker are not those of this process. They were edited "
            "meanwhile, or it is a Dask worker from before; start that anew."
        )
    return task.key, replace(part, source=part.data)


def _by_dask(address: str, tasks: Sequence[Task]) -> Iterator[tuple[str, Part]]:
    """Have the workers of a Dask scheduler do tasks; those of a worker that dies go to the others."""
    try:
        from distributed import Client, KilledWorker, as_completed

        _check_listener(address)
    except (ImportError, OSError, ValueError) as error:
        raise ValueError(
            f"scheduler is {address!r} and cannot be used ({error}); it must be the address of a running "
            "Dask scheduler. pip install 'contactlab[cluster]' brings Dask."
        ) from error
    try:
        with Client(address, set_as_default=False) as client:
            code = code_digest(), covered_sources()
            if not client.scheduler_info()["workers"]:
                text = f"The Dask scheduler {address} has no worker; the tasks wait for one."
                print(f"contactlab: {text} Start it: dask worker {address}", file=sys.stderr, flush=True)
            futures = [client.submit(_done_by_worker, task, *code, pure=False) for task in tasks]
            for future in as_completed(futures, loop=client.loop):
                yield future.result()
                future.release()
    except (CancelledError, KilledWorker, OSError) as error:
        raise WorkerError(
            f"The Dask scheduler {address}, or every worker with a task, was lost; finished tasks are kept. "
            "Start again, with workers of more memory if they die again."
        ) from error


def _check_listener(address: str) -> None:
    """Connect to an address once; an OSError or ValueError if nobody listens or it is none."""
    parts = urlsplit(address if "://" in address else f"tcp://{address}")
    # Other protocols, as those within a process, have no port.
    if parts.scheme in ("tcp", "tls"):
        if parts.port is None:
            raise ValueError("it has no port")
        socket.create_connection((parts.hostname, parts.port), timeout=10.0).close()
