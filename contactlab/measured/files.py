"""Files of measured impacts: CSV and netCDF as docs/measured_data.md has them, and one published MATLAB file.

What a file is its content tells, not its name.
"""

from pathlib import Path
from typing import Final

import numpy as np
import xarray

from contactlab.measured import columns
from contactlab.measured.assembly import assemble
from contactlab.measured.columns import CONTACT, known_names
from contactlab.measured.csv_files import read_text, write_csv
from contactlab.measured.ellipses import read_ellipses
from contactlab.measured.faults import MeasurementError as MeasurementError
from contactlab.measured.impacts import MeasuredImpacts as MeasuredImpacts
from contactlab.measured.netcdf_files import dataset_of, read_netcdf
from contactlab.measured.series import MEASURABLE, MeasuredSeries, read_series, text_names
from contactlab.parameter import from_cf
from contactlab.results.files import whole_file, whole_netcdf

_UNITS: Final = known_names(dict.fromkeys(CONTACT, False), contact=True)

_MATLAB: Final = b"MATLAB"
_NETCDF: Final = (b"\x89HDF\r\n\x1a\n", b"CDF\x01", b"CDF\x02", b"CDF\x05")


def read_impacts(path: Path) -> MeasuredImpacts:
    """Read measured impacts from a CSV or netCDF file, or from the published MATLAB file of ellipses.

    Raises:
        OSError: it cannot be read.
        MeasurementError: a ValueError with a sentence that names the file, the column and the row.
    """
    path = Path(path)
    try:
        with path.open("rb") as stream:
            start = stream.read(16)
        if start.startswith(_MATLAB):
            return read_ellipses(path)
        table = read_netcdf(path) if start.startswith(_NETCDF) else read_text(path)
        return assemble(table, path.stem)
    except MeasurementError as error:
        raise MeasurementError(f"'{path}': {error}") from error


def read_measurements(path: Path) -> MeasuredImpacts | MeasuredSeries:
    """Read measured impacts or series, by the names of the file's columns.

    Raises:
        OSError: it cannot be read.
        ValueError: it contains neither.
    """
    try:
        with xarray.open_dataset(path, engine="netcdf4", decode_times=False) as data:
            names = {str(name) for name in data.variables}
    # The file may be text.
    except (OSError, ValueError, RuntimeError) as error:
        if isinstance(error, FileNotFoundError | PermissionError | IsADirectoryError):
            raise
        names = text_names(path)
        if any(name.startswith(("before_", "after_")) for name in names):
            return read_impacts(path)
    return read_series(path) if names & {"time", *MEASURABLE} else read_impacts(path)


def write_impacts(impacts: MeasuredImpacts, path: Path) -> None:
    """Write measured impacts, whole or not at all: netCDF where the name ends in .nc, CSV where in .csv.

    They are written as velocities of the contact; read again, they are the same to the last bit.

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
        units = {name: from_cf(unit) for name, unit in _UNITS.items()}
        with whole_file(path) as partial:
            write_csv(_columns(impacts), units, _words(impacts), partial)


def to_xarray(impacts: MeasuredImpacts) -> xarray.Dataset:
    """Return impacts as a netCDF file contains them."""
    return dataset_of(_columns(impacts), _UNITS, _words(impacts))


def _words(impacts: MeasuredImpacts) -> dict[str, str]:
    words = {"title": impacts.title, "source": impacts.source, "licence": impacts.licence}
    return {name: text for name, text in (words | {"note": "\n".join(impacts.notes)}).items() if text}


def _columns(impacts: MeasuredImpacts) -> dict[str, np.ndarray]:
    """Give what is written, by name."""
    found: dict[str, np.ndarray] = {columns.IMPACT.form: impacts.number}
    for at, name in enumerate(CONTACT):
        found[columns.BEFORE.form.format(name)] = impacts.velocity_before[:, at]
        found[columns.AFTER.form.format(name)] = impacts.velocity_after[:, at]
    pairs = ((0, 0), (0, 1), (1, 1))
    for column, (i, j) in zip(columns.DELASSUS, pairs, strict=True):
        found[column.form] = impacts.delassus[:, i, j]
    found[columns.KINETIC_ENERGY.form] = impacts.kinetic_energy
    found[columns.OUTSIDE.form] = impacts.outside
    if impacts.covariance is not None:
        for i, j in pairs:
            name = columns.COVARIANCE_AFTER.form.format(CONTACT[i], CONTACT[j])
            found[name] = impacts.covariance[:, i, j]
    if impacts.measurement is not None:
        found[columns.MEASUREMENT.form] = impacts.measurement
    found[columns.LEFT_OUT.form] = np.array(impacts.left_out)
    return found
