"""The folder of a map: its plan, the chunks that are finished, and at the end one dataset of them all.

    DIR/plan.json       what runs, and by which code
    DIR/chunks/*.npz    a file for every finished chunk
    DIR/map.nc          all of it; the chunks are removed when it is on the disk
    DIR/map.nc.sha256   its digest, as `sha256sum -c` takes it
    DIR/unfinished.nc   what is finished of a map that is not, where it was asked for

Every file appears whole or not at all, and a chunk's numbers do not depend on when or where it runs. So a
map that is killed at any moment goes on where it was and ends with the same bits. Nor can processes that
work on one map at a time, on one machine or on several, take anything from each other: whoever writes a
plan, a chunk or a map writes the same bytes, nothing but the whole map is ever named map.nc, and a chunk
is removed only when it is in there.
"""

import errno
import shutil
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, final

import netCDF4
import numpy as np
import xarray
import yaml
from numpy.typing import NDArray

from contactlab.results.files import digest_of_file, whole_file
from contactlab.results.provenance import code_digest, versions
from contactlab.sweeps.cells import REASONS, counts_of, dataset_of, write
from contactlab.sweeps.chunk_file import read_chunk, write_chunk
from contactlab.sweeps.faults import ChunkGoneError, MapError
from contactlab.sweeps.many import Answers, Report
from contactlab.sweeps.plan import Plan, Setups
from contactlab.sweeps.series import GROUP, series_group
from contactlab.sweeps.status import Status
from contactlab.sweeps.workers import Pool

PLAN: Final = "plan.json"
CHUNKS: Final = "chunks"
MAP: Final = "map.nc"
DIGEST: Final = f"{MAP}.sha256"
UNFINISHED: Final = "unfinished.nc"


@final
class MapFolder:
    """A map on the disk.

    Args:
        path: its folder.
        plan: what it runs.
    """

    def __init__(self, path: Path, plan: Plan) -> None:
        self.path = path
        self.plan = plan

    @classmethod
    def opened(cls, path: Path) -> "MapFolder":
        """A folder that a map was begun in.

        Raises:
            MapError: there is no plan in it that can be read.
        """
        try:
            return cls(path, Plan.of_text((path / PLAN).read_text(encoding="utf-8")))
        # Somebody else's file of that name may be anything.
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise MapError(
                f"'{path}' holds no {PLAN} that can be read; it must be the folder of a map. "
                "`contactlab map` begins one."
            ) from error

    def begin(self) -> None:
        """Write the plan, or find that it is there already.

        Raises:
            MapError: the folder holds another map, or one by other code.
            OSError: the folder cannot be written to.
        """
        self.path.mkdir(parents=True, exist_ok=True)
        file = self.path / PLAN
        # Of several that begin at once one writes, and the others find what it wrote.
        if not file.exists():
            with suppress(FileExistsError), whole_file(file, fresh=True) as partial:
                partial.write_text(self.plan.text(), encoding="utf-8")
        if file.read_bytes() != self.plan.text().encode():
            raise MapError(
                f"'{self.path}' holds another map, or one made by other code; a map goes on only with "
                "what it began with. Choose another folder by --output DIR, or remove this one."
            )

    @property
    def complete(self) -> bool:
        """Whether the dataset of the whole map is there, in whatever way its runs ended."""
        # One without a digest was brought here, or is of an earlier version, which named parts so too.
        return (self.path / MAP).exists() and (
            (self.path / DIGEST).exists() or self._read().attrs.get("runs_absent") == 0
        )

    def missing(self) -> list[int]:
        """The chunks that are not finished; none where the whole map is there."""
        missing = [chunk for chunk in range(self.plan.chunks) if not self._file(chunk).exists()]
        # In this order: who completes the map removes the chunks afterwards.
        return [] if self.complete else missing

    def pool(self, workers: int) -> Pool:
        """Processes that run the chunks."""
        return Pool(Setups(self.plan), self.plan.wanted, workers)

    def run(self, chunk: int, pool: Pool, report: Report | None = None) -> None:
        """Run a chunk and keep its answers, unless another process has done so meanwhile.

        Raises:
            WorkerError: a worker process died.
            OSError: the answers cannot be written.
        """
        file = self._file(chunk)
        if file.exists() or self.complete:
            return
        found = pool.answers(self.plan.cells_of(chunk), report)
        try:
            file.parent.mkdir(exist_ok=True)
            write_chunk(file, found)
        except OSError:
            # Another process that has completed the map takes the folder of the chunks away.
            if not self.complete:
                raise

    def merge(self) -> xarray.Dataset:
        """Write the dataset of all chunks that are finished; the chunks go when none is missing.

        Returns:
            The metrics over the axes; series are in the file only.

        Raises:
            MapError: a chunk or the dataset is damaged.
            OSError: the file cannot be written.
        """
        while not self.complete:
            missing = set(self.missing())
            chunks = [chunk for chunk in range(self.plan.chunks) if chunk not in missing]
            # Another process has completed the map, and looking again finds that.
            with suppress(ChunkGoneError):
                dataset = self._merged(chunks)
                if missing:
                    return dataset
        dataset = self.dataset()
        shutil.rmtree(self.path / CHUNKS, ignore_errors=True)
        (self.path / UNFINISHED).unlink(missing_ok=True)
        return dataset

    @property
    def file(self) -> Path:
        """Where the dataset is."""
        return self.path / (MAP if self.complete else UNFINISHED)

    def dataset(self) -> xarray.Dataset:
        """The dataset of the whole map, in memory.

        Raises:
            MapError: it is damaged.
        """
        file, told = self.path / MAP, self.path / DIGEST
        if told.exists() and told.read_text(encoding="utf-8") != _digest_line(file):
            raise MapError(
                f"'{file}' is not as the map left it, by its digest in {DIGEST}; it is damaged or was "
                f"changed. Move it away and give the command again: its runs are made anew. If the change "
                f"is yours, remove {DIGEST}."
            )
        return self._read()

    def _read(self) -> xarray.Dataset:
        with xarray.open_dataset(self.path / MAP, engine="netcdf4", decode_times=False) as found:
            return found.load()

    def _merged(self, chunks: Sequence[int]) -> xarray.Dataset:
        """Write the dataset of some chunks, that of all as the map.

        Raises:
            ChunkGoneError: a chunk is there no more; nothing was written.
        """
        plan = self.plan
        metrics = np.full((plan.cells, len(plan.wanted.metrics)), np.nan)
        status = np.full(plan.cells, Status.ABSENT, dtype=np.int8)
        reason = np.full(plan.cells, REASONS[Status.ABSENT], dtype=object)
        for chunk, answers in self._answers(chunks):
            cells = plan.cells_of(chunk)
            place = slice(cells.start, cells.stop)
            metrics[place], status[place], reason[place] = (
                answers.metrics,
                answers.status,
                answers.reason,
            )
        columns = zip(plan.wanted.metrics, metrics.T, strict=True)
        dataset = dataset_of(
            plan.axes,
            {key: column.reshape(plan.shape) for key, column in columns},
            status.reshape(plan.shape),
            reason.reshape(plan.shape),
            self._attributes(status),
        )
        whole = len(chunks) == plan.chunks

        def finish(partial: Path) -> None:
            if plan.wanted.series:
                self._add_series(partial, chunks)
            if whole:
                self._verify(partial, dataset)
                # Before the map has its name: killed in between, the chunks make the same map again.
                with whole_file(self.path / DIGEST) as told:
                    told.write_text(_digest_line(partial), encoding="utf-8")

        write(dataset, self.path / (MAP if whole else UNFINISHED), finish)
        return dataset

    def _file(self, chunk: int) -> Path:
        return self.path / CHUNKS / f"{chunk:06d}.npz"

    def _answers(self, chunks: Sequence[int]) -> Iterator[tuple[int, Answers]]:
        """Finished chunks, one in memory at a time."""
        for chunk in chunks:
            yield chunk, read_chunk(self._file(chunk))

    def _add_series(self, path: Path, chunks: Sequence[int]) -> None:
        """Add the series of chunks to a file that has the dimensions of the map."""
        with netCDF4.Dataset(path, "a") as file:
            group = None
            for found, place, row in self._runs(chunks):
                if group is None:
                    names = [axis.name for axis in self.plan.axes]
                    group = series_group(file, names, self.plan.wanted.series, found.time)
                for name, rows in found.series.items():
                    group[name][place] = rows[row]

    def _verify(self, path: Path, dataset: xarray.Dataset) -> None:
        """Read back what was written, before the chunks that it was made of may go.

        Raises:
            OSError: it is something else.
        """
        with xarray.open_dataset(path, engine="netcdf4", decode_times=False) as written:
            same = written.load().equals(dataset)
        if self.plan.wanted.series:
            with netCDF4.Dataset(path) as file:
                file.set_auto_mask(False)
                same &= all(
                    np.array_equal(file[GROUP][name][place], rows[row], equal_nan=True)
                    for found, place, row in self._runs(range(self.plan.chunks))
                    for name, rows in found.series.items()
                )
        if not same:
            raise OSError(errno.EIO, "what was written is not what is read back")

    def _runs(self, chunks: Sequence[int]) -> Iterator[tuple[Answers, tuple[int, ...], int]]:
        """Every run with records: the answers of its chunk, its cell, its row in there."""
        for chunk, found in self._answers(chunks):
            for row, cell in enumerate(self.plan.cells_of(chunk) if found.time.size else ()):
                yield found, tuple(map(int, np.unravel_index(cell, self.plan.shape))), row

    def _attributes(self, status: NDArray[np.int8]) -> dict[str, Any]:
        bases = self.plan.bases
        shown = bases[0] if len(bases) == 1 else list(bases)
        return {
            "Conventions": "CF-1.11",
            "title": f"Standing-wave piezoelectric motor over {', '.join(a.name for a in self.plan.axes)}",
            "source": f"contactlab {versions()['contactlab_version']}, numerical simulation",
            "configuration": yaml.safe_dump(shown, sort_keys=False, allow_unicode=True),
            **versions(),
            "code_digest": code_digest(),
            **counts_of(status),
            "complete": int(bool(np.all(status == Status.COMPLETE))),
        }


def _digest_line(file: Path) -> str:
    return f"{digest_of_file(file)}  {MAP}\n"
