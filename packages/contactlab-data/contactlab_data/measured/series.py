"""Measured series of a motor, from netCDF with the layout of a run, from a run, or from CSV, and points.

    time                       s since the drive was switched on, the motor at rest until then; increasing
    rotor_velocity, gap, ...   any of `MEASURABLE`, over time, each with its unit
    NAME_error                 standard deviation of NAME's error, over time or one number; optional
    configuration              attribute: known keys of the motor, YAML as of a run; optional

Forces are means over the interval that ends at their time, as of a run. A contact by itself on a prescribed
path, where there is a column `slip` or `velocity`:

    time                            s, increasing
    slip or velocity                displacement along the surface [m], or its rate [m/s], which is integrated
    gap or normal                   prescribed gap [m] or normal force [N]
    normal_force, friction_force    N, measured at these times; optional, but for a fit
    normal_force_error, ...         as of a motor
    forces                          attribute: `values` at their times, or `means` over the interval before

Cells of what is measured may be empty: a row without all of them has no prediction to be compared with.

A force curve, where there is a column `z`; its rows are in the order in which they were measured:

    z                       position of the cantilever's base [m], greater away from the surface
    normal_force            N, positive where it pushes the tip away
    normal_force_error      as of a motor

Operating points of a settled motor:

    rotor_velocity          rad/s, of the settled motor
    rotor_velocity_error    standard deviation of its error; optional
    rotor.load_torque ...   full keys of the motor's configuration, each with its unit

A load that brakes has the sign of the rotation.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from typing import Any, Final, final

import numpy as np
import xarray
import yaml
from numpy.typing import NDArray

from contactlab import variables
from contactlab.arrays import Array
from contactlab.driving import integrated
from contactlab.motor.table import MeasurementError, Table
from contactlab.results.yaml_text import read_yaml, write_yaml
from contactlab.suggestion import excerpt, suggestion

FORCES: Final = ("normal_force", "friction_force")
"""What can be measured of a contact on a prescribed path."""

FEWEST: Final = 8
"""Smallest number of times."""

_OF_A_RUN: Final = (
    *("tip_normal_displacement", "tip_tangential_displacement", "tip_slope", "gap", "slip_velocity"),
    *("rotor_velocity", "rotor_angle", "normal_force", "friction_force"),
)

MEASURABLE: Final = {
    **{item.name: item for item in variables.SERIES if item.name in _OF_A_RUN},
    **{item.name: item for electrode in (1, 2) for item in variables.of_electrode(electrode)},
}
"""Quantities of a motor that can be measured, by name."""

PATH: Final = {"slip": "m", "velocity": "m s-1", "gap": "m", "normal": "N", "z": "m"}
"""Units of what can be prescribed to a contact; a column of the first two or the last tells that it is."""

POSITION: Final = "z"
"""What is prescribed in a force curve, and nothing else."""

MEANS, AT_TIMES = "means", "values"
"""What forces of a record are: over the interval that ends at their time, or at it."""

LONG: Final = 3.0
"""Interval over the median one from which on it is a gap of the record."""

ERROR: Final = "_error"
"""End of the name of a standard deviation."""


@final
@dataclass(frozen=True, eq=False)
class MeasuredSeries:
    """Quantities of a motor, or of a contact on a prescribed path, that were measured at the same times.

    Args:
        time: since the drive was switched on [s], increasing, shape (time,).
        values: by the names of `MEASURABLE`, in SI, shape (time,) each.
        errors: standard deviations of some of them, positive, shape (time,) each.
        configuration: of the motor as far as the file states it, may be empty.
        attributes: all others of the file.
        digest: of the file.
        path: slip, and gap or normal, or z, shape (time,) each, prescribed to a contact; empty for a motor.
            Rows of a path without all forces have NaN for these. The times of a force curve are the numbers
            of its rows, from 0.
        notes: sentences of the reader.
    """

    time: Array
    values: Mapping[str, Array]
    errors: Mapping[str, Array]
    configuration: Mapping[str, Any]
    attributes: Mapping[str, Any]
    digest: str = ""
    path: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def means(self) -> bool:
        """Whether forces are means over the interval that ends at their time."""
        return bool(self.attributes.get("forces", AT_TIMES if self.path else MEANS) == MEANS)

    def rows(self, chosen: NDArray[np.bool_]) -> "MeasuredSeries":
        """Return some of the times."""
        parts = (
            {name: x[chosen] for name, x in each.items()} for each in (self.values, self.errors, self.path)
        )
        values, errors, path = parts
        return replace(self, time=self.time[chosen], values=values, errors=errors, path=path)

    @property
    def content_digest(self) -> str:
        """SHA-256 of numbers and configuration, 64 hexadecimal digits."""
        parts: list[Any] = [self.time.tobytes(), sorted(self.configuration.items()), self.means]
        every = (self.values, self.errors, self.path)
        parts += [(name, x.tobytes()) for each in every for name, x in each.items()]
        return sha256(repr(parts).encode()).hexdigest()

    def only(self, names: Sequence[str]) -> "MeasuredSeries":
        """Return some of the series.

        Raises:
            ValueError: a series is missing.
        """
        for name in names:
            if name not in self.values:
                hint = suggestion(name, self.values, f"There is {', '.join(self.values)}.")
                raise ValueError(f"There is no series '{name}' in the data. {hint}")
        errors = {name: error for name, error in self.errors.items() if name in names}
        return replace(self, values={name: self.values[name] for name in names}, errors=errors)

    def to_xarray(self) -> xarray.Dataset:
        """Return the series as a file contains them."""
        data = xarray.Dataset(coords={"time": ("time", self.time, {"units": "s"})})
        for name, values in self.path.items():
            data[name] = ("time", values, {"units": PATH[name]})
        for name, values in self.values.items():
            units, long_name = MEASURABLE[name].units, MEASURABLE[name].long_name
            data[name] = ("time", values, {"units": units, "long_name": long_name})
            if name in self.errors:
                long_name = f"standard deviation of the error of {name}"
                data[f"{name}{ERROR}"] = ("time", self.errors[name], {"units": units, "long_name": long_name})
        data.attrs = dict(self.attributes)
        if self.configuration:
            data.attrs["configuration"] = write_yaml(dict(self.configuration))
        return data


def series_of_table(table: Table, digest: str) -> MeasuredSeries:
    """Return the series of a table, and the attributes of its file with the file's digest.

    Raises:
        MeasurementError: the table has no time or no series, or a series is faulty.
    """
    units, present, stated, path = names_in(table)
    compared = [name for name in (*present, *stated) if not name.startswith("velocity")]
    seen = ~np.any(
        [np.zeros(len(table.places), bool), *(empty_cells(table, name) for name in compared)], axis=0
    )
    if (count := int(seen.sum())) < min(FEWEST, seen.size):
        raise MeasurementError(f"{', '.join(compared)} have numbers in {count} rows; at least {FEWEST} must.")
    # Of a path every row counts, measured or not.
    kept = np.flatnonzero(seen | bool(path))

    def column(name: str) -> Array:
        """Return the kept rows of a column in SI, NaN where it is measured and not seen."""
        result = np.full(len(table.places), np.nan)
        rows = np.flatnonzero(seen) if name in compared else kept
        result[rows] = table.numbers(name, units[name], rows)
        return result[kept]

    curve = path == [POSITION]
    columns = {name: column(name) for name in (*present, *stated, *path)}
    time = np.arange(kept.size, dtype=np.float64) if curve else column("time")
    if time.size < FEWEST or (time[0] < 0.0 and not path) or not (np.diff(time) > 0.0).all():
        raise MeasurementError(
            f"time must have at least {FEWEST} values that increase, from 0 when the drive is switched on; "
            f"it has {time.size}, from {time.min(initial=np.inf):.9g} s."
            if not curve
            else f"z must have at least {FEWEST} values; it has {time.size}."
        )
    for name in stated:
        if not (least := np.nanmin(columns[name])) > 0.0:
            raise MeasurementError(f"{name} is {least:g}; it must be greater than 0.")
    attributes = {str(key): value for key, value in table.data.attrs.items() if key != "configuration"}
    if (kind := attributes.get("forces", MEANS)) not in (MEANS, AT_TIMES):
        raise MeasurementError(f"forces is '{excerpt(kind)}'; it must be {MEANS} or {AT_TIMES}.")
    notes = [*(backwards(columns[POSITION], columns["normal_force"]) if curve else gaps(time))]
    if count < seen.size:
        notes.append(f"{seen.size - count} of {seen.size} rows lack a measured number and are not compared.")
    if "velocity" in path:
        columns["slip"], text = integrated(time, columns["velocity"], columns.get(f"velocity{ERROR}"))
        notes.append(text)
    return MeasuredSeries(
        time,
        {name: columns[name] for name in present},
        {name.removesuffix(ERROR): columns[name] for name in stated if name in compared},
        configuration_in(table),
        attributes,
        digest,
        {name: columns[name] for name in PATH if path and name in columns and name != "velocity"},
        tuple(notes),
    )


def names_in(table: Table) -> tuple[dict[str, str], list[str], list[str], list[str]]:
    """Return units by name, and the names of what is measured, of stated errors and of the path."""
    curve = POSITION in table.names
    path = [POSITION] if curve else [name for name in PATH if name in table.names]
    path = path if {"slip", "velocity", POSITION} & {*path} else []
    names = FORCES[:1] if curve else FORCES if path else (*MEASURABLE,)
    measurable = {name: MEASURABLE[name].units for name in names}
    units = ({} if curve else {"time": "s"}) | measurable | {name: PATH[name] for name in path}
    units |= {f"{name}{ERROR}": units[name] for name in [*measurable, *({"velocity"} & {*path})]}
    present = [name for name in measurable if name in table.names]
    if curve and not present:
        raise MeasurementError(f"it has {excerpt(', '.join(table.names))}; beside z it must have {names[0]}.")
    if not curve and ("time" not in table.names or not (present or path) or len(path) not in (0, 2)):
        beside = ", and slip or velocity beside either gap or normal" if path else ""
        raise MeasurementError(
            f"it has {excerpt(', '.join(table.names))}; it must have time and at least one of "
            f"{', '.join(measurable)}{beside}."
        )
    # A run has other variables; an error of nothing is a misspelt one.
    runs = table.dimension == "time"
    table.check_names([*units, *(n for n in table.names if runs and not n.endswith(ERROR))])
    stated = [name for name in table.names if name in units and name.endswith(ERROR)]
    for name in stated:
        if name.removesuffix(ERROR) not in (*present, *path):
            raise MeasurementError(f"{name} is the error of a series that is missing; leave it out.")
    return units, present, stated, path


def configuration_in(table: Table) -> dict[str, Any]:
    """Return the configuration of a motor in the attributes of a table."""
    try:
        configuration = read_yaml(str(table.data.attrs.get("configuration", "{}")))
    # YAML raises ValueErrors for impossible dates.
    except (yaml.YAMLError, ValueError) as error:
        raise MeasurementError(f"its configuration is not YAML: {excerpt(error)}.") from error
    if not isinstance(configuration, dict):
        raise MeasurementError("its configuration must be a mapping of groups of keys, as that of a run.")
    return configuration


def empty_cells(table: Table, name: str) -> NDArray[np.bool_]:
    """Return which cells of a column are empty, or NaN in netCDF, shape (row,)."""
    cells = np.broadcast_to(table.data.variables[name].values, (len(table.places),))
    return np.isnan(cells) if cells.dtype.kind == "f" else np.array([not str(x).strip() for x in cells])


def gaps(time: Array) -> Iterator[str]:
    """Yield a sentence on the intervals that are far longer than the others, if there are any."""
    intervals = np.diff(time)
    usual = float(np.median(intervals))
    if (count := int(np.sum(intervals > LONG * usual))) > 0:
        longest = int(np.argmax(intervals))
        yield (
            f"The record has {count} gaps of more than {LONG:g} intervals of {usual:.3g} s, the longest of "
            f"{intervals[longest]:.3g} s after {time[longest]:.6g} s."
        )


def backwards(position: Array, force: Array) -> Iterator[str]:
    """Yield a sentence on a force curve that pushes most where the base is far away, if it does."""
    place = position[np.nanargmax(force)]
    if place > 0.5 * (position.min() + position.max()):
        yield (
            f"normal_force is greatest at z = {place:.6g} m, in the far half of the curve; z must be greater "
            "away from the surface, and normal_force positive where it pushes the tip away."
        )


VELOCITY: Final = "rotor_velocity"
FEWEST_POINTS: Final = 2


@final
@dataclass(frozen=True, eq=False)
class MeasuredPoints:
    """Operating points of a settled motor.

    Args:
        table: of the file, whose other columns are keys of the configuration.
        values: `rotor_velocity` [rad/s], shape (point,).
        errors: its standard deviation, positive, shape (point,), where the file states it.
        attributes: texts of the file.
        digest: of the file.
    """

    table: Table
    values: Mapping[str, Array]
    errors: Mapping[str, Array]
    attributes: Mapping[str, Any]
    digest: str = ""
    configuration: Mapping[str, Any] = field(default_factory=dict)

    @property
    def keys(self) -> list[str]:
        """Full keys by which the points differ."""
        return [name for name in self.table.names if name not in (VELOCITY, VELOCITY + ERROR)]

    @property
    def content_digest(self) -> str:
        """SHA-256 of the numbers, 64 hexadecimal digits."""
        every = [(str(name), x.values.tolist()) for name, x in self.table.data.variables.items()]
        return sha256(repr([every, *(x.tolist() for x in self.errors.values())]).encode()).hexdigest()


def points_of_table(table: Table, digest: str) -> MeasuredPoints:
    """Return the operating points of a table.

    Raises:
        MeasurementError: there are too few, no key, or an error that is not positive.
    """
    velocity, errors = table.numbers(VELOCITY, "rad s-1"), {}
    if velocity.size < FEWEST_POINTS:
        raise MeasurementError(
            f"it has {velocity.size} operating points; there must be at least {FEWEST_POINTS}."
        )
    if (name := VELOCITY + ERROR) in table.names:
        errors[VELOCITY] = table.numbers(name, "rad s-1")
        if not errors[VELOCITY].min() > 0.0:
            raise MeasurementError(f"{name} is {errors[VELOCITY].min():g}; it must be greater than 0.")
    result = MeasuredPoints(table, {VELOCITY: velocity}, errors, table.texts, digest)
    for key in result.keys:
        if "." not in key or key.startswith("law."):
            raise MeasurementError(
                f"'{key}' is no key of a motor; columns must be {VELOCITY}, {VELOCITY}{ERROR} and full keys, "
                "such as rotor.load_torque."
            )
    if not result.keys:
        raise MeasurementError(
            "it has no key by which the points differ, such as rotor.load_torque; it must."
        )
    return result
