"""The report: one page that holds its pictures itself and fetches nothing."""

import json
from base64 import b64encode
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path
from typing import Final

import xarray

from contactlab.comparison.tables import Cell, Row, rows
from contactlab.comparison.words import conclusion, differences, verdicts

STYLE: Final = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 64rem; margin: 0 auto; padding: 1rem; color: #222;
  overflow-wrap: anywhere }
h1 { line-height: 1.2 } img { display: block; max-width: 100%; height: auto; margin: 0 auto }
figure { margin: 2rem 0 } figcaption { color: #555; font-size: 0.9rem }
.box { overflow-x: auto } pre { overflow-x: auto; font-size: 0.75rem }
table { border-collapse: collapse; font-size: 0.8rem; overflow-wrap: normal }
td, th { padding: 0.2rem 0.6rem; text-align: right; white-space: nowrap; border-bottom: 1px solid #ddd }
td:first-child, th:first-child { text-align: left; white-space: normal; min-width: 9rem }
td small { color: #555 } .pass { color: #00623f }
.fail { color: #a33c00; font-weight: bold } .none { color: #767676 }
@media (max-width: 40rem) { td small { display: block } td, th { padding: 0.2rem 0.35rem }
  td:first-child { min-width: 7.5rem } ul { padding-left: 1.2rem } }
"""

CAPTIONS: Final = {
    "contact_force": "Normal force and friction of one contact, means over the record intervals. Peaks of "
    "rigid impacts grow without bound as the step falls; they are named, not drawn.",
    "tip_trajectory": "Path of the tip in the last two drive periods.",
    "rotor_velocity": "Rotor velocity; bands are the numerical error, where none is seen it is thinner than "
    "the line. Below: how far the laws are apart, in black, against the numerical error of each, both as "
    "the median over a drive period.",
    "energy_flow": "Where the work of the drive has gone by the end of the run.",
    "phase_portrait": "Gap rate (mean over the record intervals) and slip over the gap in the last two drive "
    "periods.",
}


def page(data: xarray.Dataset, pictures: Mapping[str, bytes]) -> str:
    """The report.

    Args:
        data: the scorecard.
        pictures: PNG by figure name.
    """
    labels = [str(label) for label in data["law"].values]
    title = "Contact laws compared" if len(labels) > 1 else f"Contact law {labels[0]}"
    parts = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>",
        f"<h1>{escape(title)}</h1>",
        f"<p><b>{escape(conclusion(data))}</b></p>",
        _list(differences(data)),
        "<h2>Scorecard</h2>",
        _table(rows(data), labels),
        "<p><small>\u00b1 is the numerical error by Richardson's estimate from three runs at ever finer "
        "steps or tolerances; n/a: the metric does not apply or could not be found.</small></p>",
        *(_picture(name, png) for name, png in pictures.items()),
        "<h2>Law by law</h2>",
        *(f"<h3>{escape(k)}</h3>{_list(said)}" for k, said in verdicts(data).items()),
        *_notes(data),
        "<h2>What is measured</h2>",
        _definitions(rows(data), data),
        "<h2>What ran</h2>",
        *_configurations(data),
        "<h2>Versions</h2>",
        _versions(data),
        "</body></html>",
    ]
    return "\n".join(parts)


def write_page(data: xarray.Dataset, folder: Path, names: Mapping[str, object]) -> str:
    """The report with the pictures that lie in a folder."""
    return page(data, {name: (folder / f"{name}.png").read_bytes() for name in names})


def _list(sentences: list[str]) -> str:
    return (
        "<ul>" + "".join(f"<li>{escape(s)}</li>" for s in sentences) + "</ul>" if sentences else ""
    )


def _table(table: list[Row], labels: list[str]) -> str:
    head = "".join(f"<th>{escape(word)}</th>" for word in ("metric", "must be", *labels))
    body = "".join(
        f"<tr><td title='{escape(row.meaning)}'>{escape(row.brief)}{escape(row.unit)}</td>"
        f"<td>{escape(_sign(row.threshold))}</td>{''.join(map(_cell, row.cells.values()))}</tr>"
        for row in table
    )
    return f"<div class='box'><table id='scorecard'><tr>{head}</tr>{body}</table></div>"


def _sign(threshold: str) -> str:
    return threshold.replace("<=", "\u2264").replace(">=", "\u2265")


def _cell(cell: Cell) -> str:
    kind = {"pass": "pass", "fail": "fail", "n/a": "none"}.get(cell.verdict, "")
    number, _, error = cell.number.partition(" \u00b1 ")
    small = f" <small>\u00b1 {escape(error)}</small>" if error else ""
    return f"<td class='{kind}'>{escape(number)}{small} {escape(cell.word)}</td>"


def _picture(name: str, png: bytes) -> str:
    said = escape(CAPTIONS[name])
    return (
        f"<figure><img alt='{said}' src='data:image/png;base64,{b64encode(png).decode()}'>"
        f"<figcaption>{said}</figcaption></figure>"
    )


def _notes(data: xarray.Dataset) -> Iterator[str]:
    if notes := str(data.attrs["notes"]):
        yield "<h2>Notes</h2>"
        yield _list(notes.splitlines())


def _definitions(table: list[Row], data: xarray.Dataset) -> str:
    """Key, symbol, meaning and the threshold's reason of every metric."""
    entries = []
    for j, row in enumerate(table):
        symbol = str(data["symbol"].values[j])
        source = str(data["metric_source"].values[j])
        said = [f"{row.meaning}." if not row.meaning.endswith(".") else row.meaning]
        if row.threshold:
            said.append(f"Must be {_sign(row.threshold)}: {row.reason.rstrip('.')}.")
        if source:
            said.append(f"Source: {source.rstrip('.')}.")
        text = " ".join(said)
        entries.append(
            f"<li><code>{escape(row.key)}</code> = {escape(symbol)}{escape(row.unit)}: "
            f"{escape(text)}</li>"
        )
    summary = "<summary>Definitions, thresholds, sources</summary>"
    return f"<details>{summary}<ul>{''.join(entries)}</ul></details>"


def _configurations(data: xarray.Dataset) -> Iterator[str]:
    for i, label in enumerate(data["law"].values):
        told = {name: str(data[name].values[i]) for name in ("run", "refined", "configuration")}
        yield (
            f"<h3>{escape(str(label))}</h3><p>{escape(told['run'])}; values at {escape(told['refined'])}.</p>"
            f"<details><summary>Configuration</summary><pre>{escape(told['configuration'])}</pre></details>"
        )


def _versions(data: xarray.Dataset) -> str:
    names = [name for name in data.attrs if str(name).endswith("_version")]
    said = [f"{str(name).removesuffix('_version')} {data.attrs[name]}" for name in names]
    said.append(f"revision {data.attrs['git_revision']}")
    said += [
        f"{label} recorded by contactlab {version}"
        for label, version in json.loads(data.attrs["recorded_by"]).items()
    ]
    return f"<p>{escape('; '.join(said))}.</p>"
