"""The folder of a map: its plan, the chunks that are finished, and at the end one dataset of them all.

    DIR/plan.json       what runs, and by which code
    DIR/chunks/*.npz    a file for every finished chunk
    DIR/map.nc          all of it; the chunks are removed when it is whole

Every file appears whole or not at all, and a chunk's numbers do not depend on when or where it runs. So a
map that is killed at any moment goes on where it was and ends with the same bits.
"""

import shutil
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, final

import netCDF4
import numpy as np
import xarray
import yaml
from numpy.typing import NDArray

from contactlab.output.files import whole_file
from contactlab.output.provenance import code_digest, versions
from contactlab.sweep.cells import REASONS, counts_of, dataset_of, write
from contactlab.sweep.many import Answers, Report
from contactlab.sweep.plan import Plan, Setups
from contactlab.sweep.series import series_group
from contactlab.sweep.status import Status
from contactlab.sweep.workers import Pool

PLAN: Final = "plan.json"
CHUNKS: Final = "chunks"
MAP: Final = "map.nc"


class MapError(ValueError):
    """A folder that cannot hold a map; the message is a sentence."""


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
        file = self.path / PLAN
        if file.exists():
            if file.read_text(encoding="utf-8") != self.plan.text():
                raise MapError(
                    f"'{self.path}' holds another map, or one made by other code; a map goes on only with "
                    "what it began with. Choose another folder by --output DIR, or remove this one."
                )
            return
        self.path.mkdir(parents=True, exist_ok=True)
        with whole_file(file) as partial:
            partial.write_text(self.plan.text(), encoding="utf-8")

    @property
    def complete(self) -> bool:
        """Whether the dataset of the whole map is there, in whatever way its runs ended."""
        return (self.path / MAP).exists() and self.dataset().attrs.get("runs_absent") == 0

    def missing(self) -> list[int]:
        """The chunks that are not finished."""
        return [chunk for chunk in range(self.plan.chunks) if not self._file(chunk).exists()]

    def pool(self, workers: int) -> Pool:
        """Processes that run the chunks."""
        return Pool(Setups(self.plan), self.plan.wanted, workers)

    def run(self, chunk: int, pool: Pool, report: Report | None = None) -> None:
        """Run a chunk and keep its answers.

        Raises:
            WorkerError: a worker process died.
            OSError: the answers cannot be written.
        """
        found = pool.answers(self.plan.cells_of(chunk), report)
        self._file(chunk).parent.mkdir(exist_ok=True)
        with whole_file(self._file(chunk)) as partial, partial.open("wb") as stream:
            arrays: dict[str, Any] = {
                "metrics": found.metrics,
                "status": found.status,
                "reason": np.array(found.reason, dtype=np.str_),
                "time": found.time,
            }
            arrays |= {f"series_{name}": rows for name, rows in found.series.items()}
            np.savez(stream, **arrays)

    def merge(self) -> xarray.Dataset:
        """Write the dataset of all chunks that are finished; the chunks go when none is missing.

        Returns:
            The metrics over the axes; series are in the file only.

        Raises:
            OSError: the file cannot be written.
        """
        if self.complete:
            self._tidy()
            return self.dataset()
        plan = self.plan
        metrics = np.full((plan.cells, len(plan.wanted.metrics)), np.nan)
        status = np.full(plan.cells, Status.ABSENT, dtype=np.int8)
        reason = np.full(plan.cells, REASONS[Status.ABSENT], dtype=object)
        for chunk, answers in self._finished():
            cells = plan.cells_of(chunk)
            place = slice(cells.start, cells.stop)
            metrics[place], status[place], reason[place] = (
                answers.metrics,
                answers.status,
                answers.reason,
            )
        whole = not (status == Status.ABSENT).any()
        columns = zip(plan.wanted.metrics, metrics.T, strict=True)
        dataset = dataset_of(
            plan.axes,
            {key: column.reshape(plan.shape) for key, column in columns},
            status.reshape(plan.shape),
            reason.reshape(plan.shape),
            self._attributes(status),
        )
        write(dataset, self.path / MAP, self._add_series if plan.wanted.series else None)
        if whole:
            self._tidy()
        return dataset

    def dataset(self) -> xarray.Dataset:
        """The dataset that was written, in memory."""
        with xarray.open_dataset(self.path / MAP, engine="netcdf4", decode_times=False) as found:
            return found.load()

    def _tidy(self) -> None:
        shutil.rmtree(self.path / CHUNKS, ignore_errors=True)

    def _file(self, chunk: int) -> Path:
        return self.path / CHUNKS / f"{chunk:06d}.npz"

    def _finished(self) -> Iterator[tuple[int, Answers]]:
        """The finished chunks, one in memory at a time.

        Raises:
            MapError: a file is damaged.
        """
        missing = set(self.missing())
        for chunk in range(self.plan.chunks):
            if chunk not in missing:
                yield chunk, self._read(chunk)

    def _read(self, chunk: int) -> Answers:
        file = self._file(chunk)
        try:
            with file.open("rb") as stream, np.load(stream, allow_pickle=False) as read:
                return Answers(
                    metrics=read["metrics"],
                    status=read["status"],
                    reason=read["reason"].tolist(),
                    series={name: read[f"series_{name}"] for name in self.plan.wanted.series},
                    time=read["time"],
                )
        except (OSError, ValueError, KeyError, zipfile.BadZipFile) as error:
            raise MapError(
                f"'{file}' is damaged ({error}); it must be as it was written. Remove it and give the "
                "same command again: its runs are made anew."
            ) from error

    def _add_series(self, path: Path) -> None:
        """Add the series of all chunks to a file that has the dimensions of the map."""
        plan = self.plan
        with netCDF4.Dataset(path, "a") as file:
            group = None
            for chunk, found in self._finished():
                if group is None and found.time.size:
                    names = [axis.name for axis in plan.axes]
                    group = series_group(file, names, plan.wanted.series, found.time)
                if group is None or not found.time.size:
                    continue
                for row, cell in enumerate(plan.cells_of(chunk)):
                    place = tuple(map(int, np.unravel_index(cell, plan.shape)))
                    for name, rows in found.series.items():
                        group[name][place] = rows[row]

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
