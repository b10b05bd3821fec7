"""Tables of measurements from CSV and netCDF files: columns with units, and texts such as title and source.

CSV has a header with units in brackets, a line for each row, and comments `# name: number unit` or
`# name: text`; it is separated by commas, semicolons or tabulators, with the last two of which numbers may
have a decimal comma. NetCDF has a variable for each column.
"""

import csv
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import numpy as np
import pandas
import xarray
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.config.quantity import UnitError, factor
from contactlab.parameter import from_cf
from contactlab.suggestion import suggestion

TEXTS: Final = ("title", "source", "licence", "jacobian", "note")
"""Texts of a file: comments in CSV, global attributes in netCDF."""

LARGEST: Final = 1e60
"""Upper bound of numbers, so that their squares are finite."""

_ROW: Final = "[row]"
"""Dimension of a table in CSV, which no column can be named."""

_NETCDF: Final = (b"\x89HDF\r\n\x1a\n", b"CDF\x01", b"CDF\x02", b"CDF\x05")
_TRUTHS: Final = {"": "0", "false": "0", "no": "0", "true": "1", "yes": "1"}
_COMMENT: Final = re.compile(r"(?P<name>[^\W\d]\w*)\s*(\[(?P<unit>[^]]*)\])?\s*:\s+(?P<value>.*)")
_HEAD: Final = re.compile(r"(?P<name>[^[\]()]+?)\s*(\[(?P<unit>[^]]*)\])?")
_QUANTITY: Final = re.compile(r"(?P<number>[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?)\s*(?P<unit>\D.*|)")
_DECIMAL_COMMA: Final = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")


@final
class MeasurementError(ValueError):
    """A file of measurements that cannot be used; the message names the column and the row."""


@final
@dataclass(frozen=True, eq=False)
class Table:
    """Columns of a file.

    Args:
        data: variables, numbers or texts, with the attribute `units`; those without a dimension apply to all
        rows.
        dimension: of the rows.
        places: of the rows in the file, for messages: "line 7".
    """

    data: xarray.Dataset
    dimension: str
    places: Sequence[str]

    @property
    def names(self) -> list[str]:
        """Names of the columns."""
        return [str(name) for name in self.data.variables]

    @property
    def texts(self) -> dict[str, str]:
        """The attributes that are among `TEXTS`."""
        named = {str(k).lower().replace("license", "licence"): str(v) for k, v in self.data.attrs.items()}
        return {name: text for name, text in named.items() if name in TEXTS}

    def unit(self, name: str) -> str:
        """Return the unit of a column as written; empty without one."""
        return str(self.data[name].attrs.get("units", "")).strip()

    def numbers(self, name: str, units: str, rows: NDArray[np.int64] | None = None) -> Array:
        """Return a column in SI, shape (row,).

        Args:
            name: of the column.
            units: SI, in the notation of the CF conventions.
            rows: indices of the rows; None is all.

        Raises:
            MeasurementError: a cell is not a number, or the unit does not apply.
        """
        unit, expected = self.unit(name), from_cf(units)
        if not unit and units != "1":
            raise MeasurementError(f"{name} has no unit; it must be in {expected} or a unit of its kind.")
        try:
            scale = 1.0 if unit in ("", units, expected) else float(factor(unit, expected))
        except UnitError as error:
            raise MeasurementError(
                f"{name} is in '{unit}'; it must be in {expected} or a unit of its kind."
            ) from error
        variable = self.data.variables[name]
        if variable.dims not in ((), (self.dimension,)):
            raise MeasurementError(
                f"{name} has the dimensions {variable.dims}; it must be one number for each {self.dimension}."
            )
        rows = np.arange(len(self.places)) if rows is None else rows
        cells = np.broadcast_to(variable.values, (len(self.places),))[rows]
        values = _as_numbers(cells)
        if (bad := ~(np.abs(values) < LARGEST)).any():
            first = int(np.argmax(bad))
            raise MeasurementError(
                f"{name} is '{cells[first]}' in {self.places[int(rows[first])]}; it must be a number."
            )
        return values * scale

    def flagged(self, names: Iterable[str]) -> NDArray[np.bool_]:
        """Return which rows any of the columns marks, shape (row,)."""
        marked = np.zeros(len(self.places), dtype=bool)
        for name in names:
            cells = np.broadcast_to(self.data.variables[name].values, marked.shape)
            if cells.dtype.kind not in "biuf":
                cells = np.array(
                    [_TRUTHS.get(str(cell).strip().lower(), cell) for cell in cells], dtype=object
                )
                if (bad := ~np.isfinite(_as_numbers(cells))).any():
                    first = int(np.argmax(bad))
                    raise MeasurementError(
                        f"{name} is '{cells[first]}' in {self.places[first]}; a flag must be 0 or empty for "
                        "an "
                        "impact that is used, and another number for one that is left out."
                    )
            # xarray represents an empty cell by NaN.
            marked |= np.nan_to_num(_as_numbers(cells)) != 0.0
        return marked

    def check_names(self, known: Iterable[str]) -> None:
        """Raise a MeasurementError for a column of another name, which may be a misspelt one."""
        names = [*known]
        if unknown := [name for name in self.names if name not in names]:
            hint = suggestion(unknown[0], [*names, *TEXTS], "See docs/measured_data.md for all names.")
            raise MeasurementError(f"'{unknown[0]}' is not the name of a column. {hint}")


def read_table(path: Path) -> Table:
    """Read a table from a file, whose format is detected from the content.

    Raises:
        OSError: the file cannot be read.
        MeasurementError: it contains no table.
    """
    with path.open("rb") as stream:
        start = stream.read(8)
    if not start.startswith(_NETCDF):
        return _from_text(path)
    try:
        with xarray.open_dataset(path, engine="netcdf4", decode_times=False) as opened:
            data = opened.load()
    except (OSError, ValueError, RuntimeError) as error:
        raise MeasurementError(f"it cannot be read as netCDF: {error}.") from error
    first = next((variable.dims[0] for variable in data.variables.values() if variable.dims), "impact")
    dimension = "time" if "time" in data.dims else str(first)
    count = data.sizes.get(dimension, 1)
    return Table(data, dimension, [f"row {number} of {count}" for number in range(1, count + 1)])


@final
class _Text:
    """Lines of a table in CSV.

    Attributes:
        separator: of the cells.
        width: number of the columns.
        columns: variables by name.
        texts: comments that are among `TEXTS`.
    """

    def __init__(self, header: str) -> None:
        self.separator, self.width = max(",;\t", key=header.count), 0
        self.columns: dict[str, xarray.Variable] = {}
        self.texts: dict[str, str] = {}
        self.width = len(self.cells(header))

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line, with decimal points."""
        reader = csv.reader([line], delimiter=self.separator, skipinitialspace=True)
        cells = [self._with_point(cell.strip()) for cell in next(reader)]
        # A spreadsheet fills up its lines.
        while len(cells) > self.width and not cells[-1]:
            cells.pop()
        return cells

    def _with_point(self, cell: str) -> str:
        comma = self.separator != "," and _DECIMAL_COMMA.fullmatch(cell)
        return cell.replace(",", ".") if comma else cell

    def add(self, name: str, unit: str | None, values: str | list[str]) -> None:
        """Add a column, or one number for all rows."""
        if name in self.columns:
            raise MeasurementError(f"'{name}' occurs twice; it must occur once.")
        cells = np.array(values, dtype=object)
        self.columns[name] = xarray.Variable((_ROW,) * cells.ndim, cells, {"units": unit or ""})

    def add_comment(self, line: str) -> None:
        """Add a text, or one number for all rows; other comments are ignored."""
        if line.startswith('"'):
            line = "".join(self.cells(line))
        comment = _COMMENT.fullmatch(re.sub(rf"{self.separator}{{2,}}$", "", line).lstrip("# \t"))
        if comment is None:
            return
        name, value = comment["name"].lower().replace("license", "licence"), comment["value"].strip()
        if name in TEXTS:
            self.texts[name] = f"{self.texts[name]}\n{value}" if name in self.texts else value
        elif quantity := _QUANTITY.fullmatch(value):
            if comment["unit"] is not None and quantity["unit"]:
                raise MeasurementError(f"'{comment['name']}' has two units; it must have one.")
            self.add(
                comment["name"], comment["unit"] or quantity["unit"], self._with_point(quantity["number"])
            )


def _from_text(path: Path) -> Table:
    """Read a table from CSV."""
    try:
        content = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise MeasurementError("it must be CSV in UTF-8 or netCDF; save a spreadsheet as CSV.") from error
    lines = [(at, line.strip(" ")) for at, line in enumerate(content.split("\n"), 1) if line.strip(" \t,;")]
    # A spreadsheet may put comments in quotes.
    rows = [item for item in lines if not item[1].startswith(("#", '"#'))]
    if not rows:
        raise MeasurementError("it has no line with the names of its columns; see docs/measured_data.md.")
    text = _Text(rows[0][1])
    header, *cells = (text.cells(line) for _, line in rows)
    places = [f"line {number}" for number, _ in rows[1:]]
    for place, row in zip(places, cells, strict=True):
        if len(row) != text.width:
            raise MeasurementError(
                f"{place} has {len(row)} cells and the header {text.width}; both must have as many. With "
                "decimal "
                "commas, separate the columns by semicolons."
            )
    for at, cell in enumerate(header):
        if (head := _HEAD.fullmatch(cell)) is None:
            raise MeasurementError(f"'{cell}' is not the name of a column; it must be as 'before_x [m/s]'.")
        text.add(head["name"], head["unit"], [row[at] for row in cells])
    for _, line in lines:
        if line.startswith(("#", '"#')):
            text.add_comment(line)
    return Table(xarray.Dataset(text.columns, attrs=text.texts), _ROW, places)


def write_csv(
    columns: Mapping[str, np.ndarray], units: Mapping[str, str], texts: Mapping[str, str], path: Path
) -> None:
    """Write columns, shape (row,), or () as comments, with all digits of each number."""
    rows = {name: values for name, values in columns.items() if values.ndim}
    head = [name if units[name] == "1" else f"{name} [{from_cf(units[name])}]" for name in rows]
    with path.open("w", encoding="utf-8", newline="") as stream:
        for name, text in texts.items():
            stream.writelines(f"# {name}: {line}\n" for line in text.split("\n"))
        for name, value in columns.items():
            if not value.ndim:
                unit = "" if units[name] == "1" else f" {from_cf(units[name])}"
                stream.write(f"# {name}: {value.item()!r}{unit}\n")
        pandas.DataFrame(rows).to_csv(stream, index=False, header=head, lineterminator="\n")


def _as_numbers(cells: NDArray[Any]) -> Array:
    """Return cells as numbers, NaN for those that are none."""
    if cells.dtype.kind in "biuf":
        return cells.astype(np.float64)
    return np.array([_number(str(cell)) for cell in cells], dtype=np.float64)


def _number(cell: str) -> float:
    try:
        # Python reads 1_000, which no table means.
        return np.nan if "_" in cell else float(cell)
    except ValueError:
        return np.nan
