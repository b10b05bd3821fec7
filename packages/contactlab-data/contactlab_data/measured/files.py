"""Files of measured impacts, tracks and series, docs/measured_data.md: CSV and netCDF."""

from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray

from contactlab.checks import checked_arguments
from contactlab.motor.table import MeasurementError as MeasurementError, Table, read_table, write_csv
from contactlab.results.files import check_file, damage, digest_of_file, whole_file, whole_netcdf
from contactlab_data.measured import columns
from contactlab_data.measured.columns import CONTACT, impacts_of, known_names
from contactlab_data.measured.impacts import MeasuredImpacts as MeasuredImpacts
from contactlab_data.measured.series import (
    MEASURABLE,
    POSITION,
    VELOCITY,
    MeasuredPoints,
    MeasuredSeries,
    points_of_table,
    series_of_table,
)
from contactlab_data.measured.tracks import impacts_of_tracks

_COMPRESSED: Final = {"zlib": True, "complevel": 1, "shuffle": True, "_FillValue": None}


@checked_arguments()
def read_measurements(path: str | Path) -> MeasuredImpacts | MeasuredSeries | MeasuredPoints:
    """Read measured impacts, tracks, series or operating points, by content.

    Impacts have velocities before and after, tracks a time, x and y, series a time, force curves a z,
    operating points a rotor velocity and no time.

    Raises:
        OSError: the file cannot be read.
        MeasurementError: it contains none of them, or faulty ones; file, column and row are in the message.
    """
    path = Path(path)
    try:
        try:
            check_file(path)
        except ValueError as error:
            raise MeasurementError(str(error)) from error
        if fault := damage(path):
            raise MeasurementError(fault)
        table = read_table(path)
        names = {*table.names}
        if {"time", "x", "y"} <= names:
            return impacts_of_tracks(table, path.stem)
        series = {"time", POSITION, *MEASURABLE} & names
        if series == {VELOCITY}:
            return points_of_table(table, digest_of_file(path))
        if series and not any(name.startswith(("before_", "after_")) for name in names):
            return series_of_table(table, digest_of_file(path))
        if table.dimension in names and "impact" not in names:
            # Numbers of the impacts are those of the dimension, whatever its name.
            data = table.data.rename_vars({table.dimension: "impact"})
            table = Table(data, table.dimension, table.places)
        return impacts_of(table, path.stem)
    except MeasurementError as error:
        raise MeasurementError(f"'{path}': {error}") from error


@checked_arguments()
def read_impacts(path: str | Path) -> MeasuredImpacts:
    """Read impacts, measured or of tracks, from CSV or netCDF.

    Raises:
        OSError: the file cannot be read.
        MeasurementError: it contains no impacts, or faulty ones; file, column and row are in the message.
    """
    result = read_measurements(path)
    if isinstance(result, MeasuredPoints):
        raise MeasurementError(f"'{path}': it has operating points of a motor, which `contactlab fit` reads.")
    if isinstance(result, MeasuredSeries):
        raise MeasurementError(
            f"'{path}': it has series over time ({', '.join(result.values)}); `contactlab fit` "
            "reads these, and impacts must have before_NAME and after_NAME."
        )
    return result


@checked_arguments()
def write_impacts(impacts: MeasuredImpacts, path: str | Path) -> None:
    """Write measured impacts as contact velocities, whole or not at all; read again they have the same bits.

    Args:
        path: ends in .nc for netCDF, in .csv for CSV.

    Raises:
        OSError: the folder is missing, not writable or full.
        ValueError: the name ends otherwise.
    """
    path, data = Path(path), to_xarray(impacts)
    if path.suffix == ".nc":
        with whole_netcdf(path) as partial:
            data.to_netcdf(partial, engine="netcdf4")
    elif path.suffix == ".csv":
        with whole_file(path) as partial:
            write_csv(data, partial)
    else:
        raise ValueError(f"'{path}' ends in '{path.suffix}'; it must end in .csv or .nc.")


def to_xarray(impacts: MeasuredImpacts) -> xarray.Dataset:
    """Return impacts as a file contains them."""
    values: dict[str, Any] = {columns.IMPACT.form: impacts.number}
    for at, name in enumerate(CONTACT):
        values[columns.BEFORE.form.format(name)] = impacts.velocity_before[:, at]
        values[columns.AFTER.form.format(name)] = impacts.velocity_after[:, at]
    pairs = ((0, 0), (0, 1), (1, 1))
    values |= {
        column.form: impacts.delassus[:, i, j] for column, (i, j) in zip(columns.DELASSUS, pairs, strict=True)
    }
    values |= {columns.KINETIC_ENERGY.form: impacts.kinetic_energy, columns.OUTSIDE.form: impacts.outside}
    if impacts.covariance is not None:
        for i, j in pairs:
            name = columns.COVARIANCE_AFTER.form.format(CONTACT[i], CONTACT[j])
            values[name] = impacts.covariance[:, i, j]
    if impacts.measurement is not None:
        values[columns.MEASUREMENT.form] = impacts.measurement
    values[columns.LEFT_OUT.form] = np.array(impacts.left_out)
    units = known_names(dict.fromkeys(CONTACT, False), contact=True)
    variables = {n: xarray.Variable(("impact",) * x.ndim, x, {"units": units[n]}) for n, x in values.items()}
    for variable in variables.values():
        variable.encoding = _COMPRESSED if variable.ndim else {"_FillValue": None}
    texts = {"title": impacts.title, "source": impacts.source, "licence": impacts.licence}
    texts["note"] = "\n".join(impacts.notes)
    return xarray.Dataset(variables, attrs={name: text for name, text in texts.items() if text})
