"""Measured series of a motor, from netCDF with the layout of a run, from a run, or from CSV, and points.

    time                       s since the drive was switched on, the motor at rest until then; increasing
    rotor_velocity, gap, ...   any of `MEASURABLE`, over time, each with its unit
    NAME_error                 standard deviation of NAME's error, over time or one number; optional
    configuration              attribute: known keys of the motor, YAML as of a run; optional

Forces are means over the interval that ends at their time, as of a run. A contact by itself on a prescribed
path, where there is a column `slip`:

    time                            s, increasing
    slip, gap or normal             displacement along the surface [m]; prescribed gap [m] or normal force [N]
    normal_force, friction_force    N, measured at these times; optional, but for a fit
    normal_force_error, ...         as of a motor

Operating points of a settled motor:

    rotor_velocity          rad/s, of the settled motor
    rotor_velocity_error    standard deviation of its error; optional
    rotor.load_torque ...   full keys of the motor's configuration, each with its unit

A load that brakes has the sign of the rotation.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from typing import Any, Final, final

import numpy as np
import xarray
import yaml

from contactlab import variables
from contactlab.arrays import Array
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

PATH: Final = {"slip": "m", "gap": "m", "normal": "N"}
"""Units of what can be prescribed to a contact; a column of the first tells that it is."""

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
        path: of `PATH`, shape (time,) each, what was prescribed to a contact; empty for a motor.
    """

    time: Array
    values: Mapping[str, Array]
    errors: Mapping[str, Array]
    configuration: Mapping[str, Any]
    attributes: Mapping[str, Any]
    digest: str = ""
    path: Mapping[str, Any] = field(default_factory=dict)

    @property
    def content_digest(self) -> str:
        """SHA-256 of numbers and configuration, 64 hexadecimal digits."""
        parts: list[Any] = [self.time.tobytes(), sorted(self.configuration.items())]
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
    path = [name for name in PATH if name in table.names] if "slip" in table.names else []
    measurable = {n: x for n, x in MEASURABLE.items() if not path or n in FORCES}
    units = {"time": "s"} | {n: x.units for n, x in measurable.items()} | {n: PATH[n] for n in path}
    errors = {f"{name}{ERROR}": item.units for name, item in measurable.items()}
    present = [name for name in measurable if name in table.names]
    if "time" not in table.names or not (present or path) or len(path) not in (0, 2):
        beside = ", and beside slip either gap or normal" if path else ""
        raise MeasurementError(
            f"it has {excerpt(', '.join(table.names))}; it must have time and at least one of "
            f"{', '.join(measurable)}{beside}."
        )
    # A run has other variables; an error of nothing is a misspelt one.
    runs = table.dimension == "time"
    table.check_names([*units, *errors, *(n for n in table.names if runs and not n.endswith(ERROR))])
    for name in table.names:
        if name in errors and name.removesuffix(ERROR) not in present:
            raise MeasurementError(f"{name} is the error of a series that is missing; leave it out.")
    time = table.numbers("time", "s")
    if time.size < FEWEST or (time[0] < 0.0 and not path) or not (np.diff(time) > 0.0).all():
        raise MeasurementError(
            f"time must have at least {FEWEST} values that increase, from 0 when the drive is switched on; "
            f"it has {time.size}, from {time.min(initial=np.inf):.9g} s."
        )
    deviations = {}
    for name in present:
        if (key := f"{name}{ERROR}") in table.names:
            deviations[name] = table.numbers(key, errors[key])
            if not deviations[name].min() > 0.0:
                raise MeasurementError(f"{key} is {deviations[name].min():g}; it must be greater than 0.")
    try:
        configuration = read_yaml(str(table.data.attrs.get("configuration", "{}")))
    # YAML raises ValueErrors for impossible dates.
    except (yaml.YAMLError, ValueError) as error:
        raise MeasurementError(f"its configuration is not YAML: {excerpt(error)}.") from error
    if not isinstance(configuration, dict):
        raise MeasurementError("its configuration must be a mapping of groups of keys, as that of a run.")
    return MeasuredSeries(
        time,
        {name: table.numbers(name, units[name]) for name in present},
        deviations,
        configuration,
        {str(key): value for key, value in table.data.attrs.items() if key != "configuration"},
        digest,
        {name: table.numbers(name, units[name]) for name in path},
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
