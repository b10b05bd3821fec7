"""Tables of measurements as text: a header with units in brackets, a row an impact, `# name: words` above.

Separated by commas, semicolons or tabulators; beside the last two a number may have a decimal comma. UTF-8.
"""

import csv
import re
from collections.abc import Iterator, Mapping
from io import StringIO
from pathlib import Path
from typing import Final

import numpy as np

from contactlab.measured.columns import WORDS
from contactlab.measured.faults import MeasurementError
from contactlab.measured.table import Table

_SAID: Final = re.compile(r"(?P<name>[^\W\d]\w*)\s*(\[(?P<unit>[^]]*)\])?\s*:\s+(?P<value>.*)")
_HEAD: Final = re.compile(r"(?P<name>[^[\]]*?)\s*(\[(?P<unit>[^]]*)\])?")
_QUANTITY: Final = re.compile(r"(?P<number>[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?)\s*(?P<unit>\D.*|)")
_LINE_END: Final = re.compile(r"\r\n|\n|\r")
_DECIMAL_COMMA: Final = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")


def read_csv(text: str) -> Table:
    """Read a table from its text.

    Raises:
        MeasurementError: it has no header, two columns of one name, or rows of another length.
    """
    lines = [(number, line) for number, line in enumerate(_LINE_END.split(text), 1) if line.strip(" \t,;")]
    said = [(number, line) for number, line in lines if _is_comment(line)]
    rows = [(number, line) for number, line in lines if not _is_comment(line)]
    if not rows:
        raise MeasurementError("it has no line with the names of its columns; see docs/measured_data.md.")
    separator = max(",;\t", key=rows[0][1].count)
    cells = list(_split(rows, separator))
    heads = [_HEAD.fullmatch(head) for head in cells[0][1]]
    for head, cell in zip(heads, cells[0][1], strict=True):
        if head is None or "(" in head["name"]:
            raise MeasurementError(f"'{cell}' is no name of a column; write it as 'before_x [m/s]'.")
    names = [head["name"] for head in heads if head]
    units = {head["name"]: head["unit"] for head in heads if head}
    words, shared, shared_units = _said(said, separator)
    _refuse_doubles([*names, *shared])
    body = cells[1:]
    for number, row in body:
        if len(row) != len(names):
            raise MeasurementError(
                f"line {number} has {len(row)} cells and the header {len(names)}; both must have as many. "
                "With decimal commas, separate the columns by semicolons."
            )
    columns = {name: np.array([row[at] for _, row in body], dtype=object) for at, name in enumerate(names)}
    if "" in columns:
        raise MeasurementError("a column has no name; name it or leave it out.")
    places = tuple(f"line {number}" for number, _ in body)
    return Table(columns | shared, units | shared_units, places, words)


def read_text(path: Path) -> Table:
    """Read a table from a text file.

    Raises:
        OSError: the file cannot be read.
        MeasurementError: it is not UTF-8, or see `read_csv`.
    """
    content = path.read_bytes()
    if b"\0" in content:
        raise MeasurementError(
            "it is none of the files that are known; it must be CSV in UTF-8, netCDF, or the published "
            "MATLAB file. Save a spreadsheet as CSV."
        )
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise MeasurementError(
            f"line {line} has a character that is not UTF-8; the file must be UTF-8. Save it as that."
        ) from error
    return read_csv(text)


def write_csv(
    columns: Mapping[str, np.ndarray], units: Mapping[str, str], words: Mapping[str, str], path: Path
) -> None:
    """Write columns, shape (row,), or () above the table, with units as configurations write them.

    A number is written with all its digits.
    """
    rows = {name: values for name, values in columns.items() if values.ndim}
    with path.open("w", encoding="utf-8", newline="") as stream:
        for name, text in words.items():
            stream.writelines(f"# {name}: {line}\n" for line in text.split("\n"))
        for name, value in columns.items():
            if not value.ndim:
                unit = "" if units[name] == "1" else f" {units[name]}"
                stream.write(f"# {name}: {value.item()!r}{unit}\n")
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([name if units[name] == "1" else f"{name} [{units[name]}]" for name in rows])
        writer.writerows(zip(*(map(repr, values.tolist()) for values in rows.values()), strict=True))


def _is_comment(line: str) -> bool:
    """Tell a comment, which a spreadsheet may have put in quotes."""
    return line.lstrip().startswith(("#", '"#'))


def _split(rows: list[tuple[int, str]], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Give the cells of each line, without the empty ones that a spreadsheet leaves at its end."""
    width = 0
    for number, line in rows:
        row = [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
        width = width or _width(row)
        while len(row) > width and not row[-1]:
            row.pop()
        yield number, [_plain(cell, separator) for cell in row]


def _plain(cell: str, separator: str) -> str:
    """Give a cell with a decimal point where it has a decimal comma, which commas between columns exclude."""
    return cell.replace(",", ".") if separator != "," and _DECIMAL_COMMA.fullmatch(cell) else cell


def _width(header: list[str]) -> int:
    return max(at for at, cell in enumerate(header, 1) if cell)


def _said(
    lines: list[tuple[int, str]], separator: str
) -> tuple[dict[str, str], dict[str, np.ndarray], dict[str, str | None]]:
    """Give words, the numbers that are the same for all impacts, and their units, from the comment lines."""
    words: dict[str, str] = {}
    shared: dict[str, np.ndarray] = {}
    units: dict[str, str | None] = {}
    for number, line in lines:
        text = line.strip()
        if text.startswith('"'):
            text = "".join(next(csv.reader(StringIO(text), delimiter=separator)))
        # A spreadsheet ends every line with as many separators as there are columns.
        text = re.sub(rf"{separator}{{2,}}$", "", text)
        found = _SAID.fullmatch(text.lstrip("# \t"))
        if found is None:
            continue
        name, value = found["name"].lower().replace("license", "licence"), found["value"].strip()
        if name in WORDS:
            words[name] = f"{words[name]}\n{value}" if name in words else value
        elif quantity := _QUANTITY.fullmatch(value):
            if found["name"] in shared:
                raise MeasurementError(
                    f"'{found['name']}' is given a second time in line {number}; once will do."
                )
            if found["unit"] is not None and quantity["unit"]:
                raise MeasurementError(f"'{found['name']}' has two units in line {number}; one will do.")
            shared[found["name"]] = np.array(_plain(quantity["number"], separator), dtype=object)
            units[found["name"]] = found["unit"] if found["unit"] is not None else quantity["unit"] or None
    return words, shared, units


def _refuse_doubles(names: list[str]) -> None:
    for name in names:
        if names.count(name) > 1 and name:
            raise MeasurementError(f"'{name}' is there {names.count(name)} times; once will do.")
