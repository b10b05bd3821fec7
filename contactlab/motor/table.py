"""Tables of measurements from CSV and netCDF files: columns with units, and texts such as title and source.

CSV has a header with units in brackets, a line for each row, and comments `# name: number unit` or
`# name: text`; it is separated by commas, semicolons or tabulators, with the last two of which numbers may
have a decimal comma. NetCDF has a variable for each column.
"""

import csv
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from hashlib import sha256
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.parameter import from_cf
from contactlab.quantity import UnitError, factor
from contactlab.suggestion import excerpt, suggestion

if TYPE_CHECKING:
    import xarray

TEXTS: Final = ("title", "source", "licence", "jacobian", "note", "forces", "noise")
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


_contents: dict[str, bytes] = {}
_of_datasets: set[str] = set()


def keep(content: bytes, *, recorded: bool = False) -> str:
    """Keep the content of a file that a configuration names, and return its digest, 16 hexadecimal digits.

    A dataset can be written with it. One that is recorded, from a dataset, stands for its file where that is
    gone or changed.
    """
    digest = sha256(content).hexdigest()[:16]
    _contents[digest] = content
    if recorded:
        _of_datasets.add(digest)
    return digest


def kept(digest: str | None) -> bytes | None:
    """Return the content of a digest; None where none is kept."""
    return None if digest is None else _contents.get(digest)


def recorded_content(digest: str | None) -> bytes | None:
    """Return the content of a digest from a dataset, or from a setup of another process; None without one."""
    return kept(digest) if digest in _of_datasets else None


@final
class MeasurementError(ValueError):
    """A file of measurements that cannot be used; the message names the column and the row."""


def refuse(bad: NDArray[np.bool_], sentence: Callable[[int], str]) -> None:
    """Raise a MeasurementError with the sentence about the first bad row, if there is any."""
    if bad.any():
        raise MeasurementError(sentence(int(np.argmax(bad))))


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

    data: "xarray.Dataset"
    dimension: str
    places: Sequence[str]

    def __post_init__(self) -> None:
        for name in self.names:
            if excerpt(name) != name:
                raise MeasurementError(f"'{excerpt(name)}' is not the name of a column.")
        if not self.places:
            raise MeasurementError("it has no row; there must be one at least.")

    @property
    def names(self) -> list[str]:
        """Names of the columns."""
        return [str(name) for name in self.data.variables]

    @property
    def texts(self) -> dict[str, str]:
        """The attributes that are among `TEXTS`."""
        named = {_text_name(str(name)): str(text) for name, text in self.data.attrs.items()}
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
        needed = f"it must be in {expected} or a unit of its kind."
        if not unit and units != "1":
            raise MeasurementError(f"{name} has no unit; {needed}")
        try:
            scale = 1.0 if unit in ("", units, expected) else float(factor(unit, expected))
        except UnitError as error:
            raise MeasurementError(f"{name} is in '{excerpt(unit)}'; {needed}") from error
        variable = self.data.variables[name]
        if variable.dims not in ((), (self.dimension,)):
            raise MeasurementError(
                f"{name} has the dimensions {variable.dims}; it must be one number for each {self.dimension}."
            )
        rows = np.arange(len(self.places)) if rows is None else rows
        cells = np.broadcast_to(variable.values, (len(self.places),))[rows]
        values = _as_numbers(cells)
        refuse(
            ~(np.abs(values) < LARGEST),
            lambda at: (
                f"{name} is '{excerpt(cells[at])}' in {self.places[int(rows[at])]}; it must be a number."
            ),
        )
        return values * scale

    def flagged(self, names: Iterable[str]) -> NDArray[np.bool_]:
        """Return which rows any of the columns marks, shape (row,)."""
        marked = np.zeros(len(self.places), dtype=bool)
        for name in names:
            cells = np.broadcast_to(self.data.variables[name].values, marked.shape)
            if cells.dtype.kind not in "biuf":
                texts = [_TRUTHS.get(str(cell).strip().lower(), cell) for cell in cells]
                cells = np.array(texts, dtype=object)
            values = _as_numbers(cells)
            if cells.dtype.kind == "O" and not np.isfinite(values).all():
                first = int(np.argmin(np.isfinite(values)))
                raise MeasurementError(
                    f"{name} is '{excerpt(cells[first])}' in {self.places[first]}; a flag must be 0 or "
                    "empty for an impact that is used, and another number for one that is left out."
                )
            # xarray represents an empty cell by NaN.
            marked |= np.nan_to_num(values) != 0.0
        return marked

    def check_names(self, known: Iterable[str]) -> None:
        """Raise a MeasurementError for a column of another name, which may be a misspelt one."""
        names = [*known]
        if unknown := [name for name in self.names if name not in names]:
            hint = suggestion(unknown[0], [*names, *TEXTS], f"It must be one of {', '.join(names)}.")
            raise MeasurementError(f"'{unknown[0]}' is not the name of a column. {hint}")


def read_table(source: Path | bytes) -> Table:
    """Read a table from a file, or from the content of one, whose format is detected from the content.

    Raises:
        OSError: the file cannot be read.
        MeasurementError: it contains no table.
    """
    # Imported here, as below: a run without files needs none.
    import netCDF4
    import xarray

    from contactlab.checks import check_declared

    content = source if isinstance(source, bytes) else source.read_bytes()
    if not content.startswith(_NETCDF):
        return _from_text(content)
    try:
        check_declared(content)
        # Closed once it is loaded.
        store: Any = xarray.backends.NetCDF4DataStore  # untyped
        store = store(netCDF4.Dataset("content", memory=content))
        data = xarray.load_dataset(store, decode_times=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise MeasurementError(f"it cannot be read as netCDF: {f'{error}'.rstrip('.')}.") from error
    first = next((variable.dims[0] for variable in data.variables.values() if variable.dims), "impact")
    dimension = "time" if "time" in data.dims else str(first)
    count = data.sizes.get(dimension, 1)
    return Table(data, dimension, [f"row {number} of {count}" for number in range(1, count + 1)])


def _from_text(content: bytes) -> Table:
    """Read a table from CSV."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise MeasurementError("it must be CSV in UTF-8 or netCDF; save a spreadsheet as CSV.") from error
    lines = [
        (at, line.strip(" ")) for at, line in enumerate(re.split("\r\n?|\n", text), 1) if line.strip(" \t,;")
    ]
    # A spreadsheet may put comments in quotes.
    comments = [line for _, line in lines if line.startswith(("#", '"#'))]
    rows = [(f"line {at}", line) for at, line in lines if not line.startswith(("#", '"#'))]
    if not rows:
        raise MeasurementError("it has no line with the names of its columns; see docs/measured_data.md.")
    return _table_of(rows, comments)


def _table_of(rows: Sequence[tuple[str, str]], comments: Sequence[str]) -> Table:
    """Return the table of the lines of a header and of rows, each with its place, and of comments."""
    separator = max(",;\t", key=rows[0][1].count)
    header, *cells = (_cells(line, separator) for _, line in rows)
    places = [place for place, _ in rows[1:]]
    # A spreadsheet fills up its lines.
    width = len(header) - len(list(takewhile(lambda cell: not cell, reversed(header))))
    for place, row in zip(places, cells, strict=True):
        if len(row) < width or any(row[width:]):
            raise MeasurementError(
                f"{place} has {len(row)} cells and the header {width}; both must have as many. With decimal "
                "commas, separate the columns by semicolons."
            )
    named = [_headed(cell, [row[at] for row in cells]) for at, cell in enumerate(header[:width])]
    texts: dict[str, str] = {}
    for name, unit, value in filter(None, (_comment(line, separator) for line in comments)):
        if (text_name := _text_name(name)) in TEXTS:
            texts[text_name] = f"{texts[text_name]}\n{value}" if text_name in texts else value
        elif number := _QUANTITY.fullmatch(value):
            if unit is not None and number["unit"]:
                raise MeasurementError(f"'{excerpt(name)}' has two units; it must have one.")
            named.append((name, unit or number["unit"], _with_point(number["number"], separator)))
    import xarray

    columns: dict[str, xarray.Variable] = {}
    for name, unit, values in named:
        if name in columns:
            raise MeasurementError(f"'{excerpt(name)}' occurs twice; it must occur once.")
        array = np.array(values, dtype=object)
        columns[name] = xarray.Variable((_ROW,) * array.ndim, array, {"units": unit or ""})
    return Table(xarray.Dataset(columns, attrs=texts), _ROW, places)


def _cells(line: str, separator: str) -> list[str]:
    """Return the cells of a line, with decimal points."""
    reader = csv.reader([line], delimiter=separator, skipinitialspace=True)
    return [_with_point(cell.strip(), separator) for cell in next(reader)]


def _with_point(cell: str, separator: str) -> str:
    return cell.replace(",", ".") if separator != "," and _DECIMAL_COMMA.fullmatch(cell) else cell


def _headed(cell: str, values: list[str]) -> tuple[str, str | None, str | list[str]]:
    """Return name and unit in the head of a column, and its values."""
    if (head := _HEAD.fullmatch(cell)) is None:
        raise MeasurementError(
            f"'{excerpt(cell)}' is not the name of a column; it must be as 'before_x [m/s]'."
        )
    return head["name"], head["unit"], values


def _comment(line: str, separator: str) -> tuple[str, str | None, str] | None:
    """Return name, unit and value in a comment; None for other comments, which are ignored."""
    text = "".join(_cells(line, separator)) if line.startswith('"') else line
    comment = _COMMENT.fullmatch(re.sub(rf"{separator}{{2,}}$", "", text).lstrip("# \t"))
    return None if comment is None else (comment["name"], comment["unit"], comment["value"].strip())


def write_csv(data: "xarray.Dataset", path: Path) -> None:
    """Write variables with one dimension as columns and numbers and texts as comments, with all digits."""
    import pandas

    units = {name: from_cf(variable.attrs["units"]) for name, variable in data.variables.items()}
    columns = {name: x.values for name, x in data.variables.items() if x.ndim}
    with path.open("w", encoding="utf-8", newline="") as stream:
        for name, text in data.attrs.items():
            stream.writelines(f"# {name}: {line}\n" for line in text.split("\n"))
        for name, variable in data.variables.items():
            if not variable.ndim:
                unit = "" if units[name] == "1" else f" {units[name]}"
                stream.write(f"# {name}: {variable.values.item()!r}{unit}\n")
        head = [str(name) if units[name] == "1" else f"{name} [{units[name]}]" for name in columns]
        pandas.DataFrame(columns).to_csv(stream, index=False, header=head, lineterminator="\n")


def _text_name(name: str) -> str:
    return name.lower().replace("license", "licence")


def _as_numbers(cells: NDArray[Any]) -> Array:
    """Return cells as numbers, NaN for those that are none."""
    if cells.dtype.kind in "biuf":
        return cells.astype(np.float64)

    def number(cell: str) -> float:
        try:
            # Python reads 1_000, which no table means.
            return np.nan if "_" in cell else float(cell)
        except ValueError:
            return np.nan

    return np.array([number(str(cell)) for cell in cells], dtype=np.float64)
