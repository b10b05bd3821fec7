"""The page of a data sheet: one file that holds its figure itself and fetches nothing."""

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Final

import xarray

from contactlab.datasheet.table import BALANCE, Cell, Row, columns, motion_row, motor_rows, rows, sentences

PAGE: Final = Path(__file__).with_name("sheet.html")  # the page without its words

NOT_SHOWN: Final = {*BALANCE, "drive_power"} - {"output_power", "active_power"}
"""Quantities that the balance shows."""


def page(data: xarray.Dataset, picture: Path) -> str:
    """Write the page of a sheet, with its figure, a PNG file."""
    names = [str(name) for name in data if data[name].dims == ("law", "point") and f"{name}_error" in data]
    shown = [name for name in names if name not in NOT_SHOWN]
    labels = [str(label) for label in data["law"].values]
    points, balances, ran = [], [], []
    for label in labels:
        law, title = data.sel(law=label), f"<h3>{escape(label)}</h3>"
        places = columns(law)
        heads = [str(law["role"].values[place]) for place in places]
        points.append(title + _table(heads, [motion_row(law, places), *rows(law, shown, places)]))
        parts = rows(law, [*BALANCE], places)
        named = [row._replace(name=word) for row, word in zip(parts, BALANCE.values(), strict=True)]
        balances.append(title + _table(heads, named))
        written = escape(law["configuration"].item())
        ran.append(f"{title}<details><summary>Configuration</summary><pre>{written}</pre></details>")
    code = {k.removesuffix("_version"): v for k, v in data.attrs.items() if k.endswith("_version")}
    code["revision"] = data.attrs["git_revision"]
    said = {
        "title": escape(f"Data sheet: {', '.join(labels)}"),
        "motor": _table(labels, motor_rows(data)),
        "picture": b64encode(picture.read_bytes()).decode(),
        "points": "\n".join(points),
        "balances": "\n".join(balances),
        "sentences": "<ul>" + "".join(f"<li>{escape(words)}</li>" for words in sentences(data)) + "</ul>",
        "definitions": "".join(_definition(data[name]) for name in data if "symbol" in data[name].attrs),
        "configurations": "\n".join(ran),
        "versions": escape("; ".join(f"{name} {version}" for name, version in code.items())),
    }
    return Template(PAGE.read_text(encoding="utf-8")).substitute(said)


def _definition(said: xarray.DataArray) -> str:
    symbol, meaning = escape(said.attrs["symbol"]), escape(said.attrs["long_name"])
    return f"<li><code>{said.name}</code> {symbol}: {meaning}.</li>"


def _table(heads: Sequence[str], body: Sequence[Row]) -> str:
    lines = ["<tr><th></th>" + "".join(f"<th>{escape(head)}</th>" for head in heads) + "</tr>"]
    for row in body:
        cells = "".join(f"<td>{_cell(cell)}</td>" for cell in row.cells)
        lines.append(f"<tr><td title='{escape(row.meaning)}'>{escape(row.label)}</td>{cells}</tr>")
    return f"<div class='box'><table>{''.join(lines)}</table></div>"


def _cell(cell: Cell) -> str:
    return escape(cell.number) + (f" <small>± {escape(cell.error)}</small>" if cell.error else "")
