"""Measured series of a motor, from a netCDF file that is laid out as a run's, or is a run's, or from CSV.

    time                       s since the drive was switched on, the motor at rest until then; increasing
    rotor_velocity, gap, ...   any of `MEASURABLE`, over time, each with its `units`
    NAME_error                 standard deviation of NAME's error, over time or one number; may be left out
    configuration              attribute: what is known of the motor, YAML as of a run; may be left out

Forces are means over the interval that ends at their time, as of a run.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import numpy as np
import xarray
import yaml

from contactlab import variables
from contactlab.arrays import Array
from contactlab.config.quantity import UnitError, to_si
from contactlab.measured.csv_files import read_csv
from contactlab.measured.faults import MeasurementError
from contactlab.measured.table import Table
from contactlab.parameter import from_cf
from contactlab.results.files import damage, digest_of_file, whole_netcdf
from contactlab.suggestion import suggestion
from contactlab.variables import Variable

LEAST: Final = 8
"""Times of a series that something can be found from."""

CURRENTS: Final = tuple(
    Variable(f"current_{i}", ("time",), "A", f"I_{i}", f"current into the electrodes of drive.voltage_{i}")
    for i in (1, 2)
)

_OF_A_RUN: Final = (
    "tip_normal_displacement",
    "tip_tangential_displacement",
    "tip_slope",
    "gap",
    "slip_velocity",
    "rotor_velocity",
    "rotor_angle",
    "normal_force",
    "friction_force",
)

MEASURABLE: Final = {
    one.name: one for one in (*variables.SERIES, *CURRENTS) if one.name in _OF_A_RUN or one in CURRENTS
}
"""What may be measured of a motor, by name."""

ERROR: Final = "_error"
"""What the name of a standard deviation ends in."""


class SeriesError(ValueError):
    """What is wrong with a file of measured series; a sentence for each fault."""

    def __init__(self, path: Path, faults: Sequence[str]) -> None:
        super().__init__("\n".join(f"'{path}': {fault}" for fault in faults))


@final
@dataclass(frozen=True, eq=False)
class MeasuredSeries:
    """Quantities of a motor that were measured at the same times.

    Args:
        time: since the drive was switched on [s], increasing, shape (time,).
        values: by the names of `MEASURABLE`, in SI, shape (time,) each.
        errors: standard deviations of some of them, positive, shape (time,) each.
        configuration: what the file tells of the motor, may be empty.
        attributes: all others of the file.
        digest: of the file.
    """

    time: Array
    values: Mapping[str, Array]
    errors: Mapping[str, Array]
    configuration: Mapping[str, Any]
    attributes: Mapping[str, Any]
    digest: str = ""

    def only(self, names: Sequence[str]) -> "MeasuredSeries":
        """Give some of the series.

        Raises:
            ValueError: one that there is not; a sentence.
        """
        for name in names:
            if name not in self.values:
                hint = suggestion(name, self.values, f"There is {', '.join(self.values)}.")
                raise ValueError(f"There is no series '{name}' in the data. {hint}")
        values = {name: self.values[name] for name in names}
        errors = {name: error for name, error in self.errors.items() if name in values}
        return MeasuredSeries(self.time, values, errors, self.configuration, self.attributes, self.digest)

    def to_xarray(self) -> xarray.Dataset:
        """Give the series as a file holds them."""
        data = xarray.Dataset(coords={"time": ("time", self.time, {"units": "s"})})
        for name, values in self.values.items():
            said = MEASURABLE[name]
            data[name] = ("time", values, {"units": said.units, "long_name": said.long_name})
            if name in self.errors:
                words = {"units": said.units, "long_name": f"standard deviation of the error of {name}"}
                data[f"{name}{ERROR}"] = ("time", self.errors[name], words)
        data.attrs = dict(self.attributes)
        if self.configuration:
            data.attrs["configuration"] = yaml.safe_dump(dict(self.configuration), sort_keys=False)
        return data


def chosen_names(text: str | None) -> list[str]:
    """Give names of what may be measured from a text with commas; the rotor's velocity from none.

    Raises:
        ValueError: a name that there is not; a sentence.
    """
    names = [name.strip() for name in text.split(",")] if text else ["rotor_velocity"]
    for name in names:
        if name not in MEASURABLE:
            hint = suggestion(name, MEASURABLE, f"There is {', '.join(MEASURABLE)}.")
            raise ValueError(f"'{name}' is nothing that may be measured of a motor. {hint}")
    return names


def write_series(measured: MeasuredSeries, path: Path) -> None:
    """Write a file of measured series, netCDF, whole or not at all.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    with whole_netcdf(path) as partial:
        measured.to_xarray().to_netcdf(partial, engine="netcdf4")


def read_series(path: Path) -> MeasuredSeries:
    """Read a file of measured series, or a run.

    Raises:
        OSError: it cannot be read.
        SeriesError: it holds no such series, or wrong ones; a sentence for each fault.
    """
    if words := damage(path):
        raise SeriesError(path, [words])
    try:
        if csv_names(path):
            data = _of_table(read_csv(path.read_text(encoding="utf-8-sig")))
        else:
            with xarray.open_dataset(path, engine="netcdf4", decode_times=False) as opened:
                data = opened.load()
    except MeasurementError as error:
        raise SeriesError(path, [str(error)]) from error
    except (OSError, ValueError, RuntimeError) as error:
        if isinstance(error, FileNotFoundError | PermissionError):
            raise
        raise SeriesError(path, [f"it cannot be read as netCDF: {error}."]) from error
    faults: list[str] = []
    if "time" not in data.variables:
        words = "it has no time; there must be one, in seconds since the drive was switched on."
        raise SeriesError(path, [words])
    time = _time(data, faults)
    there = [name for name in MEASURABLE if name in data.variables]
    if not there:
        held = ", ".join(map(str, data.variables)) or "nothing"
        faults.append(
            "it has nothing that may be measured of a motor; there must be one of "
            f"{', '.join(MEASURABLE)}. It has {held}."
        )
    columns = {name: _column(data, name, MEASURABLE[name].units, time.size, faults) for name in there}
    errors = {name: _error(data, name, time.size, faults) for name in there}
    configuration = _configuration(data, faults)
    faults += _strange(data)
    if faults:
        raise SeriesError(path, faults)
    attributes = {str(key): value for key, value in data.attrs.items() if key != "configuration"}
    values, deviations = (
        {name: column for name, column in each.items() if column is not None} for each in (columns, errors)
    )
    return MeasuredSeries(time, values, deviations, configuration, attributes, digest_of_file(path))


def csv_names(path: Path) -> list[str]:
    """Return the columns of a table of series in CSV; none where the file is anything else."""
    try:
        names = [*read_csv(path.read_text(encoding="utf-8-sig")).values]
    except (MeasurementError, UnicodeDecodeError):
        return []
    return names if "time" in names else []


def _of_table(table: Table) -> xarray.Dataset:
    """Return the columns of a table that belong to series; others are refused."""
    table.refuse_unknown(["time", *MEASURABLE, *(f"{name}{ERROR}" for name in MEASURABLE)], [])
    data = xarray.Dataset(attrs=dict(table.words))
    for name in table.values:
        units = "s" if name == "time" else MEASURABLE[name.removesuffix(ERROR)].units
        numbers = table.numbers(name, units)
        data[name] = (("time",) if numbers.ndim else (), numbers, {"units": units})
    return data


def _error(data: xarray.Dataset, name: str, size: int, faults: list[str]) -> Array | None:
    """Give the standard deviation of a series' error, None where none is stated."""
    if f"{name}{ERROR}" not in data.variables:
        return None
    found = _column(data, f"{name}{ERROR}", MEASURABLE[name].units, size, faults)
    if found is not None and found.size and not found.min() > 0.0:
        faults.append(
            f"{name}{ERROR} is {found.min():g} at the least; a standard deviation must be greater than 0. "
            "Leave it out for one that is to be found."
        )
    return found


def _configuration(data: xarray.Dataset, faults: list[str]) -> dict[str, Any]:
    """Give what the file tells of the motor."""
    try:
        found = yaml.safe_load(str(data.attrs.get("configuration", "{}")))
    # Besides its own errors YAML raises those of impossible dates.
    except (yaml.YAMLError, ValueError) as error:
        faults.append(f"its configuration is no YAML: {' '.join(str(error).split())}. Leave it out.")
        return {}
    if not isinstance(found, dict):
        faults.append("its configuration must be a mapping of groups of keys, as a run's. Leave it out.")
        return {}
    return found


def _time(data: xarray.Dataset, faults: list[str]) -> Array:
    """Give the times; what is wrong with them is added to the faults."""
    time = _column(data, "time", "s", data["time"].size, faults)
    if time is None:
        return np.empty(data["time"].size)
    if time.size < LEAST:
        faults.append(f"it has {time.size} times; there must be {LEAST} at the least.")
    elif not (np.diff(time) > 0.0).all():
        place = int(np.argmax(np.diff(time) <= 0.0))
        faults.append(
            f"time {time[place + 1]:.9g} s stands behind {time[place]:.9g} s; times must increase. Sort them."
        )
    elif time[0] < 0.0:
        faults.append(
            f"time begins at {time[0]:.9g} s; it must not be negative, 0 being when the drive is switched "
            "on. Leave out what was before."
        )
    return time


def _column(data: xarray.Dataset, name: str, units: str, size: int, faults: list[str]) -> Array | None:
    """Give a variable in SI over time, or add to the faults what is wrong with it."""
    one, expected = data[name], from_cf(units)
    said = str(one.attrs.get("units", "")).strip()
    if not said:
        faults.append(f"{name} has no units; it must be in {expected}, or in what can be converted to it.")
        return None
    try:
        factor = to_si(f"1 {from_cf(said)}", expected) if said != units else 1.0
    except UnitError:
        faults.append(f"{name} is in '{said}'; it must be in {expected}, or in what can be converted to it.")
        return None
    if one.dims not in ((), ("time",)) or one.dtype.kind not in "iuf":
        faults.append(f"{name} has the dimensions {one.dims}; it must be numbers over time alone.")
        return None
    values = np.array(np.broadcast_to(one.values, (size,)), dtype=np.float64) * factor
    if not np.isfinite(values).all():
        place = int(np.argmin(np.isfinite(values)))
        faults.append(
            f"{name} is {values[place]:g} in row {place + 1}; all must be finite. Leave out the rows that "
            "were not measured."
        )
        return None
    return values


def _strange(data: xarray.Dataset) -> Iterator[str]:
    """Say what is the error of nothing: a slip of the pen that would be passed over."""
    for name in map(str, data.data_vars):
        if name.endswith(ERROR) and name.removesuffix(ERROR) not in data.variables:
            yield f"{name} is there and {name.removesuffix(ERROR)} is not; rename it or leave it out."
