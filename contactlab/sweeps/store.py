"""The folder of a sweep: its plan, and of one that keeps metrics the chunks that are finished.

    DIR/sweep.json        what runs, and by which code
    DIR/chunks/*.npz      a file for every finished chunk: its arrays, and a digest of them at the end
    DIR/sweep.nc          all of it; the chunks are removed when it is on the disk
    DIR/sweep.nc.sha256   its digest, as `sha256sum -c` takes it
    DIR/unfinished.nc     what is finished of a sweep that is not, where it was asked for

Every file appears whole or not at all, and a chunk's numbers do not depend on when or where it runs: a sweep
that is killed goes on where it was and ends with the same bits. Nor can processes that work on one sweep take
anything from each other: whoever writes a file writes the same bytes, nothing but the whole sweep is ever
named sweep.nc, and a chunk is removed only when it is in there.
"""

import errno
import shutil
from collections.abc import Iterator, Sequence
from contextlib import suppress
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Final, final

import numpy as np
import xarray
import yaml

from contactlab.results.files import digest_of_file, whole_file, whole_netcdf
from contactlab.sweeps.batch import Answers, Batch, Report
from contactlab.sweeps.dataset import DATASET, REASONS, Slab, dataset_of, write
from contactlab.sweeps.plan import Plan
from contactlab.sweeps.state import Status
from contactlab.sweeps.values import SweepError

MANIFEST: Final = "sweep.json"
CHUNKS: Final = "chunks"
DIGEST: Final = f"{DATASET}.sha256"
UNFINISHED: Final = "unfinished.nc"

_GONE: Final = (errno.ENOENT, errno.ESTALE)
"""How a file that another machine has removed is told of."""


class ChunkGoneError(Exception):
    """A chunk that was there is there no more: another process has merged it, or somebody removed it."""


@final
class Store:
    """Keeps the sweep of a plan on the disk, in the folder `path`."""

    def __init__(self, path: Path, plan: Plan) -> None:
        self.path = path
        self.plan = plan

    @classmethod
    def opened(cls, path: Path) -> "Store":
        """Open a folder that a sweep was begun in; a SweepError tells that it is none."""
        if plan := read_plan(path):
            return cls(path, plan)
        raise SweepError(
            f"'{path}' holds no {MANIFEST} that can be read; it must be the folder of a sweep with "
            "sweep.keep=metrics. `contactlab -m KEY=VALUES sweep.keep=metrics` begins one."
        )

    def begin(self) -> None:
        """Write the plan, or find that it is there already; a sweep of folders may be extended.

        Raises:
            SweepError: the folder holds another sweep, or one by other code.
            OSError: the folder cannot be written to.
        """
        self.path.mkdir(parents=True, exist_ok=True)
        file, there = self.path / MANIFEST, read_plan(self.path)
        extends = self.plan.keep == "runs" and (there is None or there.keep == "runs")
        # Of several that begin at once one writes, and the others find what it wrote.
        if extends or not file.exists():
            with suppress(FileExistsError), whole_file(file, fresh=not extends) as partial:
                partial.write_text(self.plan.text(), encoding="utf-8")
        if not extends and file.read_bytes() != self.plan.text().encode():
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
        missing = [chunk for chunk in self.plan.chunks if not self._file(chunk).exists()]
        # In this order: who completes the sweep removes the chunks afterwards.
        return [] if self.complete else missing

    def missing_runs(self) -> int:
        """Count the runs of the chunks that are not finished."""
        return sum(len(self.plan.cells_of(chunk)) for chunk in self.missing())

    def run(self, chunk: int, batch: Batch) -> None:
        """Run a chunk and keep its answers, unless another process has done so meanwhile."""
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
        """Run all chunks that are not finished; a WorkerError or OSError tells why that cannot be done."""
        with self.plan.batch(workers, report) as batch:
            for chunk in self.missing():
                self.run(chunk, batch)

    def merge(self) -> xarray.Dataset:
        """Write and give the dataset of all chunks that are finished; they go when none is missing.

        Series are in the file only, which is the attribute `source` of its `encoding`.

        Raises:
            SweepError: a chunk or the dataset is damaged.
            OSError: the file cannot be written.
        """
        while not self.complete:
            missing = set(self.missing())
            chunks = [chunk for chunk in self.plan.chunks if chunk not in missing]
            # Another process has completed the sweep, and looking again finds that.
            with suppress(ChunkGoneError):
                dataset = self._merged(chunks)
                if missing:
                    return dataset
        dataset = self.dataset()
        shutil.rmtree(self.path / CHUNKS, ignore_errors=True)
        (self.path / UNFINISHED).unlink(missing_ok=True)
        return dataset

    def dataset(self) -> xarray.Dataset:
        """Read the dataset of the whole sweep; a SweepError tells that it is damaged."""
        file, told = self.path / DATASET, self.path / DIGEST
        if told.exists() and told.read_text(encoding="utf-8") != _digest_line(file):
            raise SweepError(
                f"'{file}' is not as the sweep left it, by its digest in {DIGEST}; it is damaged or was "
                f"changed. Move it away and give the command again: its runs are made anew. If the change "
                f"is yours, remove {DIGEST}."
            )
        with xarray.open_dataset(file, engine="netcdf4", decode_times=False) as found:
            dataset = found.load()
        dataset.encoding["source"] = str(file)
        return dataset

    def _merged(self, chunks: Sequence[int]) -> xarray.Dataset:
        """Write the dataset of some chunks, that of all as the sweep's."""
        plan, whole = self.plan, len(chunks) == len(self.plan.chunks)
        columns: Answers = {
            **{key: np.full(plan.cells, np.nan) for key in plan.outputs.metrics},
            "status": np.full(plan.cells, Status.ABSENT, dtype=np.int8),
            "reason": np.full(plan.cells, REASONS[Status.ABSENT], dtype=object),
        }
        for chunk in chunks:
            cells, answers = plan.cells_of(chunk), read_chunk(self._file(chunk))
            for name, column in columns.items():
                column[cells.start : cells.stop] = answers[name]
        shown = plan.bases[0] if len(plan.bases) == 1 else list(plan.bases)
        configuration = yaml.safe_dump(shown, sort_keys=False, allow_unicode=True)
        said, kept = {"configuration": configuration}, plan.outputs.kept
        dataset = dataset_of(
            plan.axes, columns, said, samples=plan.samples, series=kept, numbers=plan.outputs.numbers
        )
        path = self.path / (DATASET if whole else UNFINISHED)
        with whole_netcdf(path) as partial:
            write(dataset, partial, kept, lambda: self._slabs(chunks))
            if whole:
                # Before the sweep has its name: killed in between, the chunks make the same again.
                with whole_file(self.path / DIGEST) as told:
                    told.write_text(_digest_line(partial), encoding="utf-8")
        dataset.encoding["source"] = str(path)
        return dataset

    def _file(self, chunk: int) -> Path:
        return self.path / CHUNKS / f"{chunk:06d}.npz"

    def _slabs(self, chunks: Sequence[int]) -> Iterator[Slab]:
        """Give the series of every run with records, one chunk in memory at a time."""
        for chunk in chunks:
            answers = read_chunk(self._file(chunk))
            for row, cell in enumerate(self.plan.cells_of(chunk) if answers["time"].size else ()):
                place = tuple(map(int, np.unravel_index(cell, self.plan.shape)))
                series = {n: answers[f"{n}_series"][row] for n in self.plan.outputs.series}
                yield place, answers["time"], series


def read_plan(folder: Path) -> Plan | None:
    """Read the plan of a sweep; None where there is none that can be read, as somebody else's file."""
    try:
        return Plan.of_text((folder / MANIFEST).read_bytes())
    except (OSError, ValueError):
        return None


def write_chunk(file: Path, answers: Answers) -> None:
    """Write a chunk, whole or not at all: an .npz with a digest behind it, the same for the same answers."""
    stream = BytesIO()
    np.savez(stream, **answers)  # type: ignore[arg-type]
    stream.write(sha256(stream.getbuffer()).digest())
    with whole_file(file) as partial:
        partial.write_bytes(stream.getbuffer())


def read_chunk(file: Path) -> Answers:
    """Read the answers of a chunk; a SweepError tells that it is damaged."""
    try:
        kept, size = file.read_bytes(), sha256().digest_size
        if sha256(memoryview(kept)[:-size]).digest() != kept[-size:]:
            raise ValueError("its digest is another")
        with np.load(BytesIO(kept), allow_pickle=False) as read:
            return dict(read)
    except (OSError, ValueError) as error:
        if isinstance(error, OSError) and error.errno in _GONE:
            raise ChunkGoneError from error
        raise SweepError(
            f"'{file}' is damaged ({error}); it must be as it was written. Remove it and give the "
            "same command again: its runs are made anew."
        ) from error


def _digest_line(file: Path) -> str:
    return f"{digest_of_file(file)}  {DATASET}\n"
