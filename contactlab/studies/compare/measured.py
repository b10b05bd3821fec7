"""Laws against measurements in a comparison: impacts under the law alone, series of the motor from rest.

Rows of impacts have 95 % bootstrap intervals over the impacts with the same resamples for all laws, so that
the difference of two laws is one of pairs.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import nan
from pathlib import Path
from typing import Any, Final, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, Setup, build
from contactlab.config.faults import failure_of
from contactlab.config.nesting import flat, nested
from contactlab.impacts import velocities_after
from contactlab.inference.bootstrap import LEVEL, mean_intervals, paired_differences
from contactlab.inference.series_problem import series_problem
from contactlab.laws.declaration import SHARED
from contactlab.measured import floors
from contactlab.measured.files import read_measurements
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.points import MeasuredPoints
from contactlab.measured.series import MEASURABLE, MeasuredSeries
from contactlab.metrics import CANNOT_TELL, NOT_APPLICABLE, Metric, NotApplicableError
from contactlab.motor.table import MeasurementError
from contactlab.results.files import digest_of_file
from contactlab.studies.compare.runs import FREE, ComparisonError, shown
from contactlab.studies.study import Part

LEAST: Final = 10
"""Smallest number of impacts for an interval by resampling."""

SEED: Final = 1
"""Seed of the resamples."""

ENDS: Final = ("difference", "lower", "upper")
FRICTION: Final = f"contact.{SHARED}"


@final
@dataclass(frozen=True, eq=False)
class Measurement:
    """A file of measurements.

    Args:
        path: as an option.
        data: its contents.
        digest: SHA-256 of the file.
    """

    path: str
    data: MeasuredImpacts | MeasuredSeries
    digest: str

    @property
    def title(self) -> str:
        """Title of the file, or its name, without signs that end the name of a metric."""
        return re.sub(r"[:;]|\. ", ",", self._stated("title") or Path(self.path).stem)

    @property
    def source(self) -> str:
        """Author of the measurements; empty where the file lacks it."""
        return self._stated("source")

    def _stated(self, name: str) -> str:
        if isinstance(self.data, MeasuredImpacts):
            return str(getattr(self.data, name))
        return str(self.data.attributes.get(name) or "")

    @property
    def contents(self) -> str:
        """Number of impacts, or names of series."""
        if isinstance(self.data, MeasuredImpacts):
            flagged = f", {self.data.left_out} flagged and left out" if self.data.left_out else ""
            return f"{len(self.data)} impacts{flagged}"
        return f"{', '.join(self.data.values)} at {self.data.time.size} times"


@final
@dataclass(frozen=True, eq=False)
class Measured:
    """Errors of the laws against one file.

    Args:
        measurement: the file.
        rows: of the scorecard.
        values, errors: of each law, NaN where unknown, shape (row, law).
        nearer: by how much the first law's mean error is less than the second's, with its interval, shape
            (law, law, 3); NaN for series.
        notes: what could not be computed.
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
        ComparisonError: one cannot be read, has too few impacts or occurs twice.
    """
    measurements: list[Measurement] = []
    faults = []
    for path in map(Path, paths):
        try:
            data = read_measurements(path)
            if isinstance(data, MeasuredPoints):
                raise MeasurementError(f"'{path}': it has operating points, which `contactlab fit` reads.")
            measurements.append(Measurement(str(path), data, digest_of_file(path)))
        except ValueError as error:
            faults += [f"measured: {line}" for line in str(error).splitlines()]
        except OSError as error:
            faults.append(f"measured is '{path}' and cannot be read ({error.strerror or error}).")
        else:
            if isinstance(data, MeasuredImpacts) and len(data) < LEAST:
                faults.append(f"measured: '{path}' has {len(data)} impacts; there must be at least {LEAST}.")
    digests = [each.digest for each in measurements]
    if repeated := [each.path for each in measurements if digests.count(each.digest) > 1]:
        faults.append(f"measured: {', '.join(repeated)} are the same measurements; each must occur once.")
    if faults:
        raise ComparisonError(faults)
    return measurements


def check_motor(measurement: Measurement, setup: Setup) -> None:
    """Refuse series of another motor.

    Raises:
        ComparisonError: a key of the file differs; the friction coefficient is a law's parameter.
    """
    series = measurement.data
    if isinstance(series, MeasuredImpacts):
        return
    here = flat(setup.configuration)
    stated = flat({name: keys for name, keys in series.configuration.items() if name not in FREE})
    try:
        there = flat(build(nested({**here, **stated})).configuration)
    except ConfigurationError as error:
        raise ComparisonError([f"'{measurement.path}': {fault}" for fault in error.faults]) from error
    if faults := [
        f"{key} is {shown(there[key])} in '{measurement.path}' and {shown(here[key])} in the runs; it must "
        "be the same."
        for key in stated
        if key in here and key != FRICTION and shown(here[key]) != shown(there[key])
    ]:
        raise ComparisonError(faults)


def do_prediction(setup: Setup, data: MeasuredImpacts | MeasuredSeries) -> Part:
    """Predict the measured impacts under a law, or the measured series of its motor."""
    values: dict[str, Any] = {}
    failure = ""
    try:
        if isinstance(data, MeasuredImpacts):
            values["after"] = (
                ("impact", "direction"),
                velocities_after(setup.law, data.delassus, data.velocity_before),
            )
        else:
            model = series_problem(data, setup.configuration, (), discrepancy=False)
            predicted = model.predict(np.empty(0))
            values = {name: ("time", x) for name, x in (predicted or {}).items()}
            failure = "" if predicted else "its run ends before the last measured time"
    except ConfigurationError:
        raise
    # A law of another package may fail in any way.
    except Exception as error:
        failure = failure_of(error)
    return Part(xarray.DataTree(xarray.Dataset(values, attrs={"failure": failure})))


def measured_rows(
    measurement: Measurement, labels: Sequence[str], predictions: Mapping[str, xarray.DataTree], mark: str
) -> Measured:
    """Return the rows of one file.

    Args:
        measurement: the file.
        labels: of the laws.
        predictions: parts of `do_prediction` by law; a law may be missing.
        mark: end of the names of the rows, which distinguishes files.
    """
    parts: list[Mapping[str, Array] | None] = []
    notes = []
    for label in labels:
        tree = predictions.get(label)
        failure = "its run has no configuration that builds" if tree is None else tree.attrs["failure"]
        if failure or tree is None:
            notes.append(f"{label} has no prediction of {measurement.title}: {failure}.")
            parts.append(None)
        else:
            parts.append({str(name): x.values for name, x in tree.to_dataset().items()})
    if isinstance(measurement.data, MeasuredImpacts):
        return _of_impacts(measurement, measurement.data, labels, parts, mark, notes)
    return _of_series(measurement, measurement.data, parts, mark, notes)


def _of_impacts(
    measurement: Measurement,
    impacts: MeasuredImpacts,
    labels: Sequence[str],
    parts: Sequence[Mapping[str, Array] | None],
    mark: str,
    notes: list[str],
) -> Measured:
    """Return error, error over the lower bound, and share of nearest impacts."""
    nothing = np.full_like(impacts.velocity_before, nan)
    predicted = [nothing if part is None else part["after"] for part in parts]
    for label, part, after in zip(labels, parts, predicted, strict=True):
        if part is not None and (lost := int((~np.isfinite(after)).any(axis=1).sum())):
            notes.append(
                f"{label} has no prediction for {lost} of {len(impacts)} impacts of {measurement.title}."
            )
    errors = np.array([impacts.errors(after) for after in predicted]).T
    best = impacts.errors(floors.velocities_after(impacts, floors.best_admissible_impulses(impacts)))
    known = np.flatnonzero(np.isfinite(errors).all(axis=0))
    values, spread = np.full((2, 3, len(labels)), nan)
    nearer = np.full((len(labels), len(labels), len(ENDS)), nan)
    # The best of the others is none where there is one law.
    others = [np.delete(errors[:, known], i, axis=1).min(axis=1, initial=np.inf) for i in range(known.size)]
    nearest = np.array([errors[:, law] < other for law, other in zip(known, others, strict=True)], float)
    columns = np.column_stack([errors[:, known], *nearest, best]) if known.size else best[:, None]
    intervals = mean_intervals(columns, SEED)
    means, half = intervals.mean, intervals.half
    # Where impulses reproduce every measured velocity, the rest is round-off.
    bounded = means[-1] > floors.ROUND_OFF
    if not bounded:
        notes.append(
            f"impact_error_over_floor does not apply to {measurement.title}: admissible impulses reproduce "
            f"its velocities to {means[-1]:.1g} of the approach, which is round-off."
        )
    tail, count = 0.5 * (1.0 - LEVEL), known.size
    values[0, known], spread[0, known] = means[:count], half[:count]
    if bounded:
        ratios = intervals.resampled[:count] / intervals.resampled[-1]
        values[1, known] = means[:count] / means[-1]
        spread[1, known] = 0.5 * np.ptp(np.quantile(ratios, [tail, 1.0 - tail], axis=1), axis=0)
    if count > 1:
        values[2, known], spread[2, known] = means[count:-1], half[count:-1]
    apart, ends = paired_differences(errors[:, known], SEED)
    pairs = np.concatenate([apart[:, :, None], ends], axis=2).swapaxes(0, 1)
    pairs[np.diag_indices(known.size)] = nan
    nearer[np.ix_(known, known)] = pairs
    about = measurement.title
    texts = {
        "impact_error": (
            "mean of ||v+ - v+_law||_M / ||v-||_M",
            f"error of predicted impacts, less is better ({about}): of the velocities after, in the norm of "
            "the kinetic energy before",
        ),
        "impact_error_over_floor": (
            "mean error / mean error of the best admissible impulse",
            f"error over the least admissible one, less is better ({about}): that of impulses which do not "
            "pull, close or gain energy; 1 is the best",
        ),
        "nearest_impacts": (
            "share of impacts with error < least error of the other laws",
            f"share of impacts that no other law predicts as well, more is better ({about})",
        ),
    }
    rows = [row(measurement, f"{key}{mark}", *text) for key, text in texts.items()]
    if not bounded:
        rows[1] = replace(rows[1], absent=NOT_APPLICABLE)
    return Measured(measurement, tuple(rows), values, spread, nearer, tuple(notes))


def _of_series(
    measurement: Measurement,
    series: MeasuredSeries,
    parts: Sequence[Mapping[str, Array] | None],
    mark: str,
    notes: Sequence[str],
) -> Measured:
    """Return the rms misfit of each series, over its stated error if there is one."""
    laws = len(parts)
    values = np.full((len(series.values), laws), nan)
    rows = []
    for i, (name, measured) in enumerate(series.values.items()):
        for law, part in enumerate(parts):
            if part is not None:
                misfit = (part[name] - measured) / series.errors.get(name, 1.0)
                values[i, law] = np.sqrt(np.mean(misfit**2))
        variable, stated = MEASURABLE[name], name in series.errors
        rows.append(
            row(
                measurement,
                f"{name}_misfit{mark}",
                f"rms of {variable.symbol} - {variable.symbol}_law" + (" over its error" if stated else ""),
                f"misfit of the measured {variable.long_name}{' over its stated error' if stated else ''}, "
                f"less is better ({measurement.title}): rms over the measured time",
                "1" if stated else variable.units,
            )
        )
    nothing = np.full((laws, laws, len(ENDS)), nan)
    return Measured(measurement, tuple(rows), values, np.full_like(values, nan), nothing, tuple(notes))


def row(measurement: Measurement, key: str, symbol: str, meaning: str, units: str = "1") -> Metric:
    """Return a row of the scorecard whose values come from measurements and not from a run."""
    source = "; ".join(filter(None, (measurement.title, measurement.source)))
    return Metric(key, _not_of_a_run, symbol, meaning, units, source=source, absent=CANNOT_TELL)


def _not_of_a_run(_: object) -> float:
    raise NotApplicableError


def with_measurements(data: xarray.Dataset, measured: Sequence[Measured]) -> xarray.Dataset:
    """Add the files of measurements, and the differences of the laws' errors there, to a scorecard."""
    if not measured:
        return data
    files = [each.measurement for each in measured]
    text = {"long_name": "mean error of the other law less that of the law, with its 95 % interval"}
    return data.assign(
        nearer=(("measured", "law", "other_law", "end"), np.array([each.nearer for each in measured]), text)
    ).assign_coords(
        other_law=data["law"].values,
        end=[*ENDS],
        measured=[each.title for each in files],
        measured_source=("measured", [each.source for each in files]),
        measured_contents=("measured", [each.contents for each in files]),
        measured_file=("measured", [each.path for each in files]),
        measured_digest=("measured", [each.digest for each in files]),
    )


def nearest_laws(data: xarray.Dataset) -> Iterator[str]:
    """Yield for each file of impacts which law predicts them best, and by how much."""
    if "nearer" not in data:
        return
    labels = list(map(str, data["law"].values))
    for title, nearer in zip(map(str, data["measured"].values), data["nearer"].values, strict=True):
        means = nearer[:, :, 0]
        # The first has no negative difference; NaN is unknown.
        least = np.where(np.isnan(means).all(axis=1), -np.inf, np.nan_to_num(means, nan=np.inf).min(axis=1))
        first = int(np.argmax(least))
        parts: dict[str, list[str]] = {"equal": [], "open": [], "better": []}
        for other in np.argsort(means[first]):
            apart, low, high = (float(x) for x in nearer[first, other])
            if apart == low == high == 0.0:
                parts["equal"].append(labels[other])
            elif low > 0.0:
                parts["better"].append(f"{labels[other]} ({apart:.2g} +- {0.5 * (high - low):.1g})")
            elif np.isfinite(apart):
                parts["open"].append(f"{labels[other]} ({apart:.2g}, {low:.2g} to {high:.2g})")
        verbs = {"equal": "equal to", "open": "not distinguishable from", "better": "better than"}
        lists = [f"{verbs[kind]} {', '.join(names)}" for kind, names in parts.items() if names]
        if lists:
            yield f"{labels[first]} predicts the impacts of {title} best: {'; '.join(lists)}."
