"""The folder of a sweep that keeps metrics: its plan, the chunks that are finished, at the end one dataset.

    DIR/sweep.json        what runs, and by which code
    DIR/chunks/*.npz      a file for every finished chunk: its arrays, and a digest of them at the end
    DIR/sweep.nc          all of it; the chunks are removed when it is on the disk
    DIR/sweep.nc.sha256   its digest, as `sha256sum -c` takes it
    DIR/unfinished.nc     what is finished of a sweep that is not, where it was asked for

Every file appears whole or not at all, and a chunk's numbers do not depend on when or where it runs. So a
sweep that is killed at any moment goes on where it was and ends with the same bits. Nor can processes that
work on one sweep at a time, on one machine or on several, take anything from each other: whoever writes a
plan, a chunk or a dataset writes the same bytes, nothing but the whole sweep is ever named sweep.nc, and a
chunk is removed only when it is in there.
"""

import errno
import shutil
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final, final

import netCDF4
import numpy as np
import xarray
import yaml

from contactlab.results.files import digest_of_file, whole_file
from contactlab.sweeps.answers import Answers, ChunkGoneError, read_chunk, write_chunk
from contactlab.sweeps.batch import Batch, Report
from contactlab.sweeps.dataset import (
    DATASET,
    GROUP,
    REASONS,
    RUN,
    dataset_of,
    names_of,
    series_group,
    write,
)
from contactlab.sweeps.manifest import MANIFEST
from contactlab.sweeps.plan import Plan, Setups
from contactlab.sweeps.state import Status
from contactlab.sweeps.values import SweepError

CHUNKS: Final = "chunks"
DIGEST: Final = f"{DATASET}.sha256"
UNFINISHED: Final = "unfinished.nc"


@final
class Store:
    """Keeps a sweep on the disk.

    Args:
        path: its folder.
        plan: what it runs.
    """

    def __init__(self, path: Path, plan: Plan) -> None:
        self.path = path
        self.plan = plan

    @classmethod
    def opened(cls, path: Path) -> "Store":
        """Open a folder that a sweep was begun in.

        Raises:
            SweepError: there is no plan in it that can be read.
        """
        try:
            return cls(path, Plan.of_text((path / MANIFEST).read_text(encoding="utf-8")))
        # Somebody else's file of that name may be anything.
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise SweepError(
                f"'{path}' holds no {MANIFEST} that can be read; it must be the folder of a sweep with "
                "sweep.keep=metrics. `contactlab -m KEY=VALUES sweep.keep=metrics` begins one."
            ) from error

    def begin(self) -> None:
        """Write the plan, or find that it is there already.

        Raises:
            SweepError: the folder holds another sweep, or one by other code.
            OSError: the folder cannot be written to.
        """
        self.path.mkdir(parents=True, exist_ok=True)
        file = self.path / MANIFEST
        # Of several that begin at once one writes, and the others find what it wrote.
        if not file.exists():
            with suppress(FileExistsError), whole_file(file, fresh=True) as partial:
                partial.write_text(self.plan.text(), encoding="utf-8")
        if file.read_bytes() != self.plan.text().encode():
            raise SweepError(
                f"'{self.path}' holds another sweep, or one made by other code; a sweep goes on only with "
                "what it began with. Choose another folder by hydra.sweep.dir=DIR, or remove this one."
            )

    @property
    def complete(self) -> bool:
        """Whether the dataset of the whole sweep is there, in whatever way its runs ended."""
        return (self.path / DATASET).exists()

    def missing(self) -> list[int]:
        """List the chunks that are not finished; none where the whole sweep is there."""
        missing = [chunk for chunk in range(self.plan.chunks) if not self._file(chunk).exists()]
        # In this order: who completes the sweep removes the chunks afterwards.
        return [] if self.complete else missing

    def missing_runs(self) -> int:
        """Count the runs of the chunks that are not finished."""
        return sum(len(self.plan.cells_of(chunk)) for chunk in self.missing())

    def batch(self, workers: int | None, report: Report | None = None) -> Batch:
        """Give the processes that run the chunks."""
        return Batch(Setups(self.plan), self.plan.outputs, workers, report)

    def run(self, chunk: int, batch: Batch) -> None:
        """Run a chunk and keep its answers, unless another process has done so meanwhile.

        Raises:
            WorkerError: a worker process died.
            OSError: the answers cannot be written.
        """
        file = self._file(chunk)
        if file.exists() or self.complete:
            return
        answers = batch.answers(self.plan.cells_of(chunk))
        try:
            file.parent.mkdir(exist_ok=True)
            write_chunk(file, answers)
        except OSError:
            # Another process that has completed the sweep takes the folder of the chunks away.
            if not self.complete:
                raise

    def run_missing(self, workers: int | None, report: Report | None = None) -> None:
        """Run all chunks that are not finished.

        Raises:
            WorkerError: a worker process died.
            OSError: the answers cannot be written.
        """
        with self.batch(workers, report) as batch:
            for chunk in self.missing():
                self.run(chunk, batch)

    def merge(self) -> xarray.Dataset:
        """Write the dataset of all chunks that are finished; the chunks go when none is missing.

        Returns:
            The metrics over the axes; series are in the file only.

        Raises:
            SweepError: a chunk or the dataset is damaged.
            OSError: the file cannot be written.
        """
        while not self.complete:
            missing = set(self.missing())
            chunks = [chunk for chunk in range(self.plan.chunks) if chunk not in missing]
            # Another process has completed the sweep, and looking again finds that.
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
        return self.path / (DATASET if self.complete else UNFINISHED)

    def dataset(self) -> xarray.Dataset:
        """Read the dataset of the whole sweep.

        Raises:
            SweepError: it is damaged.
        """
        file, told = self.path / DATASET, self.path / DIGEST
        if told.exists() and told.read_text(encoding="utf-8") != _digest_line(file):
            raise SweepError(
                f"'{file}' is not as the sweep left it, by its digest in {DIGEST}; it is damaged or was "
                f"changed. Move it away and give the command again: its runs are made anew. If the change "
                f"is yours, remove {DIGEST}."
            )
        with xarray.open_dataset(file, engine="netcdf4", decode_times=False) as found:
            return found.load()

    def _merged(self, chunks: Sequence[int]) -> xarray.Dataset:
        """Write the dataset of some chunks, that of all as the sweep's.

        Raises:
            ChunkGoneError: a chunk is there no more; nothing was written.
        """
        plan = self.plan
        metrics = np.full((plan.cells, len(plan.outputs.metrics)), np.nan)
        status = np.full(plan.cells, Status.ABSENT, dtype=np.int8)
        reason = np.full(plan.cells, REASONS[Status.ABSENT], dtype=object)
        for chunk, answers in self._answers(chunks):
            cells = plan.cells_of(chunk)
            place = slice(cells.start, cells.stop)
            metrics[place], status[place] = answers.metrics, answers.status
            reason[place] = answers.reason
        shown = plan.bases[0] if len(plan.bases) == 1 else list(plan.bases)
        dataset = dataset_of(
            plan.axes,
            dict(zip(plan.outputs.metrics, metrics.T.reshape(-1, *plan.shape), strict=True)),
            status.reshape(plan.shape),
            reason.reshape(plan.shape),
            {"configuration": yaml.safe_dump(shown, sort_keys=False, allow_unicode=True)},
            grid=not plan.samples,
        )
        whole = len(chunks) == plan.chunks

        def finish(partial: Path) -> None:
            if plan.outputs.series:
                self._add_series(partial, chunks)
            if whole:
                self._verify(partial, dataset)
                # Before the sweep has its name: killed in between, the chunks make the same again.
                with whole_file(self.path / DIGEST) as told:
                    told.write_text(_digest_line(partial), encoding="utf-8")

        write(dataset, self.path / (DATASET if whole else UNFINISHED), finish)
        return dataset

    def _file(self, chunk: int) -> Path:
        return self.path / CHUNKS / f"{chunk:06d}.npz"

    def _answers(self, chunks: Sequence[int]) -> Iterator[tuple[int, Answers]]:
        """Read finished chunks, one in memory at a time."""
        for chunk in chunks:
            yield chunk, read_chunk(self._file(chunk))

    def _runs(self, chunks: Sequence[int]) -> Iterator[tuple[Answers, tuple[int, ...], int]]:
        """Give every run with records: the answers of its chunk, its cell, its row in there."""
        for chunk, found in self._answers(chunks):
            for row, cell in enumerate(self.plan.cells_of(chunk) if found.time.size else ()):
                yield found, tuple(map(int, np.unravel_index(cell, self.plan.shape))), row

    def _add_series(self, path: Path, chunks: Sequence[int]) -> None:
        """Add the series of chunks to a file that has the dimensions of the sweep."""
        dims = [RUN] if self.plan.samples else names_of(self.plan.axes)
        with netCDF4.Dataset(path, "a") as file:
            group = None
            for found, place, row in self._runs(chunks):
                group = group or series_group(file, dims, self.plan.outputs.series, found.time)
                for name, rows in found.series.items():
                    group[name][place] = rows[row]

    def _verify(self, path: Path, dataset: xarray.Dataset) -> None:
        """Read back what was written, before the chunks that it was made of may go.

        Raises:
            OSError: it is something else.
        """
        with xarray.open_dataset(path, engine="netcdf4", decode_times=False) as written:
            same = written.load().equals(dataset)
        if self.plan.outputs.series:
            with netCDF4.Dataset(path) as file:
                file.set_auto_mask(False)
                same &= all(
                    np.array_equal(file[GROUP][name][place], rows[row], equal_nan=True)
                    for found, place, row in self._runs(range(self.plan.chunks))
                    for name, rows in found.series.items()
                )
        if not same:
            raise OSError(errno.EIO, "what was written is not what is read back")


def _digest_line(file: Path) -> str:
    return f"{digest_of_file(file)}  {DATASET}\n"
