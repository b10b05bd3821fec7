"""Files of measured impacts and series, docs/measured_data.md: CSV, netCDF, one published MATLAB file."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import numpy as np
import xarray

from contactlab.measured import columns
from contactlab.measured.assembly import impacts_of
from contactlab.measured.columns import CONTACT, known_names
from contactlab.measured.ellipses import read_ellipses
from contactlab.measured.impacts import MeasuredImpacts as MeasuredImpacts
from contactlab.measured.series import MEASURABLE, MeasuredSeries, series_of_table
from contactlab.measured.table import MeasurementError as MeasurementError, Table, read_table, write_csv
from contactlab.results.files import damage, digest_of_file, whole_file, whole_netcdf

_UNITS: Final = known_names(dict.fromkeys(CONTACT, False), contact=True)
_COMPRESSED: Final = {"zlib": True, "complevel": 1, "shuffle": True, "_FillValue": None}


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Begin the message of a MeasurementError with the name of the file."""
    try:
        yield
    except MeasurementError as error:
        raise MeasurementError(f"'{path}': {error}") from error


def read_measurements(path: Path) -> MeasuredImpacts | MeasuredSeries:
    """Read measured impacts or series, by content; impacts have velocities before and after, series a time.

    Raises:
        OSError: the file cannot be read.
        MeasurementError: it contains neither, or faulty ones.
    """
    path = Path(path)
    with _naming(path):
        with path.open("rb") as stream:
            if stream.read(6) == b"MATLAB":
                return read_ellipses(path)
        if fault := damage(path):
            raise MeasurementError(fault)
        table = read_table(path)
        impacts = any(name.startswith(("before_", "after_")) for name in table.names)
        if impacts or not {"time", *MEASURABLE} & {*table.names}:
            return impacts_of(table if "impact" in table.names else _numbered(table), path.stem)
        return series_of_table(table, digest_of_file(path))


def read_impacts(path: Path) -> MeasuredImpacts:
    """Read measured impacts from a CSV or netCDF file, or from the published MATLAB file of ellipses.

    Raises:
        OSError: the file cannot be read.
        MeasurementError: it contains no impacts, or faulty ones; file, column and row are in the message.
    """
    result = read_measurements(path)
    if isinstance(result, MeasuredSeries):
        raise MeasurementError(
            f"'{path}': it has series over time ({', '.join(result.values)}); `contactlab fit` and "
            "`contactlab "
            "compare` read these, and impacts must have before_NAME and after_NAME."
        )
    return result


def read_series(path: Path) -> MeasuredSeries:
    """Read measured series of a motor from a CSV or netCDF file, or from a run.

    Raises:
        OSError: the file cannot be read.
        MeasurementError: it contains no series, or faulty ones; file and column are in the message.
    """
    result = read_measurements(path)
    if isinstance(result, MeasuredImpacts):
        raise MeasurementError(f"'{path}': it has impacts, and no series over time.")
    return result


def _numbered(table: Table) -> Table:
    """Return a table of impacts whose numbers are those of the dimension, whatever its name."""
    if table.dimension not in table.data.variables:
        return table
    return Table(
        table.data.rename_vars({table.dimension: columns.IMPACT.form}), table.dimension, table.places
    )


def write_impacts(impacts: MeasuredImpacts, path: Path) -> None:
    """Write measured impacts as contact velocities, whole or not at all; read again they have the same bits.

    Args:
        impacts: what is written.
        path: ends in .nc for netCDF, in .csv for CSV.

    Raises:
        OSError: the folder is missing, not writable or full.
        ValueError: the name ends otherwise.
    """
    path = Path(path)
    if path.suffix not in (".csv", ".nc"):
        raise ValueError(f"'{path}' ends in '{path.suffix}'; it must end in .csv or .nc.")
    if path.suffix == ".nc":
        with whole_netcdf(path) as partial:
            to_xarray(impacts).to_netcdf(partial, engine="netcdf4")
    else:
        with whole_file(path) as partial:
            write_csv(_columns(impacts), _UNITS, _texts(impacts), partial)


def write_series(measured: MeasuredSeries, path: Path) -> None:
    """Write measured series as netCDF, whole or not at all.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    with whole_netcdf(path) as partial:
        measured.to_xarray().to_netcdf(partial, engine="netcdf4")


def to_xarray(impacts: MeasuredImpacts) -> xarray.Dataset:
    """Return impacts as a netCDF file contains them."""
    variables = {
        name: xarray.Variable((columns.IMPACT.form,) * values.ndim, values, {"units": _UNITS[name]})
        for name, values in _columns(impacts).items()
    }
    for variable in variables.values():
        variable.encoding = _COMPRESSED if variable.ndim else {"_FillValue": None}
    return xarray.Dataset(variables, attrs=_texts(impacts))


def _texts(impacts: MeasuredImpacts) -> dict[str, str]:
    texts = {"title": impacts.title, "source": impacts.source, "licence": impacts.licence}
    return {name: text for name, text in (texts | {"note": "\n".join(impacts.notes)}).items() if text}


def _columns(impacts: MeasuredImpacts) -> dict[str, np.ndarray]:
    """Return the columns of impacts by name."""
    result: dict[str, np.ndarray] = {columns.IMPACT.form: impacts.number}
    for at, name in enumerate(CONTACT):
        result[columns.BEFORE.form.format(name)] = impacts.velocity_before[:, at]
        result[columns.AFTER.form.format(name)] = impacts.velocity_after[:, at]
    pairs = ((0, 0), (0, 1), (1, 1))
    for column, (i, j) in zip(columns.DELASSUS, pairs, strict=True):
        result[column.form] = impacts.delassus[:, i, j]
    result[columns.KINETIC_ENERGY.form] = impacts.kinetic_energy
    result[columns.OUTSIDE.form] = impacts.outside
    if impacts.covariance is not None:
        for i, j in pairs:
            name = columns.COVARIANCE_AFTER.form.format(CONTACT[i], CONTACT[j])
            result[name] = impacts.covariance[:, i, j]
    if impacts.measurement is not None:
        result[columns.MEASUREMENT.form] = impacts.measurement
    result[columns.LEFT_OUT.form] = np.array(impacts.left_out)
    return result
