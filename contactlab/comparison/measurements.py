"""Files of measurements that laws are held against, and what comes of it: rows of the scorecard."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from contactlab.arrays import Array
from contactlab.comparison.runs import ComparisonError
from contactlab.measured.files import read_measurements
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.series import MeasuredSeries
from contactlab.metrics import CANNOT_TELL, Metric, NotApplicableError
from contactlab.results.files import digest_of_file

LEAST: Final = 10
"""Impacts from which an interval by resampling means anything."""

ENDS: Final = ("difference", "lower", "upper")


@final
@dataclass(frozen=True, eq=False)
class Measurement:
    """A file of measurements.

    Args:
        path: as given.
        data: what is in it.
        digest: SHA-256 of the file.
    """

    path: str
    data: MeasuredImpacts | MeasuredSeries
    digest: str

    @property
    def title(self) -> str:
        """The file's own, or its name; what would end the name of a row is a comma."""
        told = (
            self.data.title if isinstance(self.data, MeasuredImpacts) else self.data.attributes.get("title")
        )
        return re.sub(r"[:;]|\. ", ",", str(told or Path(self.path).stem))

    @property
    def source(self) -> str:
        """Who has measured, empty where the file does not say."""
        if isinstance(self.data, MeasuredImpacts):
            return self.data.source
        return str(self.data.attributes.get("source", ""))

    @property
    def contents(self) -> str:
        """What there is of it, in words."""
        if isinstance(self.data, MeasuredImpacts):
            flagged = f", {self.data.left_out} flagged and left out" if self.data.left_out else ""
            return f"{len(self.data)} impacts{flagged}"
        return f"{', '.join(self.data.values)} at {self.data.time.size} times"


@final
@dataclass(frozen=True, eq=False)
class Judged:
    """The laws against one file.

    Args:
        measurement: the file.
        rows: of the scorecard.
        values, errors: of each law, NaN where it cannot be told, shape (row, law).
        nearer: by how much the first law's mean error is less than the second's, with its interval, shape
            (law, law, 3); NaN for series.
        notes: what could not be told and why, a sentence each.
    """

    measurement: Measurement
    rows: tuple[Metric, ...]
    values: Array
    errors: Array
    nearer: Array
    notes: tuple[str, ...]


def read_all(paths: Sequence[str | Path]) -> list[Measurement]:
    """Read files of measured impacts or series.

    Raises:
        ComparisonError: with what is wrong with any of them.
    """
    found, faults = [], []
    for path in map(Path, paths):
        try:
            data = read_measurements(path)
            found.append(Measurement(str(path), data, digest_of_file(path)))
        except ValueError as error:
            faults += str(error).splitlines()
        except OSError as error:
            faults.append(f"'{path}' cannot be read: {error.strerror or error}. Give a file of measurements.")
        else:
            if isinstance(data, MeasuredImpacts) and len(data) < LEAST:
                faults.append(f"'{path}' has {len(data)} impacts; laws are compared on {LEAST} at the least.")
    if repeated := {one.digest for one in found if [o.digest for o in found].count(one.digest) > 1}:
        names = ", ".join(f"'{one.path}'" for one in found if one.digest in repeated)
        faults.append(f"{names} are the same measurements; give each file once.")
    if faults:
        raise ComparisonError(faults)
    return found


def row(key: str, symbol: str, meaning: str, units: str, source: str, absent: str = CANNOT_TELL) -> Metric:
    """Give a row of the scorecard whose values come from measurements, and not from a run alone."""
    return Metric(key, _not_of_a_run, symbol, meaning, units, source=source, absent=absent)


def _not_of_a_run(_: object) -> float:
    raise NotApplicableError
