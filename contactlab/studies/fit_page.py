"""The page of a fit: one file that holds its pictures itself and fetches nothing; and its tables as text."""

from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Final

import numpy as np

from contactlab.inference.evidence import ranked, sentences
from contactlab.inference.result import Answer, Row
from contactlab.results.files import whole_file
from contactlab.results.provenance import checkout_state, versions
from contactlab.studies import fit_figures as figures

PAGE: Final = Path(__file__).with_name("fit.html")  # the page without its words

CAPTIONS: Final = {
    "corner": "Posterior of each parameter and of each pair: half of it lies in the dark area, 90 % in the "
    "light one. A red line is the truth, where it is known.",
    "predictions": "What was measured, and the 90 % band of what the posterior predicts, noise included; "
    "of many impacts one interval, of middling length, stands as dashed lines for all.",
}

HEADS: Final = ("best", "mean", "sd", "5 %", "95 %")
TRUTH: Final = "truth"
"""The last column, of data that were made."""


def page(answers: Sequence[Answer], pictures: Mapping[str, Iterable[Path]]) -> str:
    """Write the page; pictures are PNG files by the label of their answer."""
    evidences = [one.evidence for one in answers]
    said = sentences(evidences)
    origin = answers[0].origin
    code = {name.removesuffix("_version"): version for name, version in versions().items()}
    code["revision"] = str(checkout_state()[0])
    words = {
        "title": escape(f"Fit of {', '.join(one.label for one in answers)}"),
        "data": escape(f"{origin['data']}, SHA-256 {origin['digest']}"),
        "headline": f"<p class='headline'>{escape(said[0])}</p>" if said else "",
        "evidence": _evidence(answers) + _list(said[1:]) if said else "",
        "answers": "\n".join(_answer(one, pictures[one.label]) for one in answers),
        "configuration": escape("\n".join(f"{one.label}:\n{one.origin['configuration']}" for one in answers)),
        "versions": escape("; ".join(f"{name} {version}" for name, version in code.items())),
    }
    return Template(PAGE.read_text(encoding="utf-8")).substitute(words)


def save(answers: Sequence[Answer], folder: Path) -> list[str]:
    """Write posteriors, pictures and the page into a folder that exists, and give the names of the files.

    Raises:
        OSError: the folder cannot be written to.
    """
    pictures, names = {}, []
    for one in answers:
        ending = f"_{one.file}" if len(answers) > 1 else ""
        one.save(folder / f"posterior{ending}.nc")
        pictures[one.label] = figures.save(one, folder, ending)
        names.append(f"posterior{ending}.nc")
    with whole_file(folder / "fit.html") as partial:
        partial.write_text(page(answers, pictures), encoding="utf-8")
    return ["fit.html", *names]


def as_text(answers: Sequence[Answer]) -> str:
    """Write tables and sentences for a terminal."""
    lines = []
    for one in answers:
        rows = table(one.rows())
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines += [f"{one.label}", *(_aligned(row, widths) for row in rows), *one.sentences(), ""]
    if len(answers) > 1:
        for evidence in ranked([one.evidence for one in answers]):
            lines.append(f"{evidence.label:<28} ln Z = {evidence.log_evidence:.2f} +- {evidence.error:.2f}")
        lines += ["", *sentences([one.evidence for one in answers])]
    return "\n".join(lines).rstrip()


def table(rows: Sequence[Row]) -> list[list[str]]:
    """Write heads and rows of the table of a posterior; the truth is a column where any is known."""
    known = any(row.covered is not None for row in rows)
    heads = ["", *HEADS, *([TRUTH] if known else [])]
    return [heads, *([row.name, *_cells(row)][: len(heads)] for row in rows)]


def _cells(row: Row) -> list[str]:
    """Write the numbers of a row; the unit stands with the mean."""
    numbers = (row.best, row.mean, row.deviation, row.low, row.high, row.truth)
    found = ["" if np.isnan(number) else f"{number:.4g}" for number in numbers]
    if row.unit != "1":
        found[1] += f" {row.unit}"
    if row.covered is False:
        found[-1] += " (outside)"
    return found


def _aligned(row: Sequence[str], widths: Sequence[int]) -> str:
    first, *others = (cell.rjust(width) for cell, width in zip(row, widths, strict=True))
    return "  ".join([row[0].ljust(len(first)), *others]).rstrip()


def _answer(answer: Answer, pictures: Iterable[Path]) -> str:
    rows = answer.rows()
    names = [row.name for row in rows]
    heads, *lines = table(rows)
    found = _table(heads, lines) + _list(answer.sentences())
    related = [
        [name, *(f"{number:.2f}" for number in line)]
        for name, line in zip(names, answer.correlation(), strict=True)
    ]
    shown = "\n".join(_picture(path) for path in pictures)
    correlation = f"<h3>Correlation</h3>{_table(['', *names], related)}" if len(rows) > 1 else ""
    return f"<h2>{escape(answer.label)}</h2>{found}{shown}{correlation}"


def _evidence(answers: Sequence[Answer]) -> str:
    best, *_ = ordered = ranked([one.evidence for one in answers])
    rows = [
        [
            one.label,
            f"{one.log_evidence:.2f} ± {one.error:.2f}",
            f"{one.log_evidence - best.log_evidence:.2f}",
        ]
        for one in ordered
    ]
    return "<h2>Evidence</h2>" + _table(["", "ln Z", "less the largest"], rows)


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = ["<tr>" + "".join(f"<th>{escape(head)}</th>" for head in heads) + "</tr>"]
    lines += ["<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows]
    return f"<div class='box'><table>{''.join(lines)}</table></div>"


def _list(said: Iterable[str]) -> str:
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in said)
    return items and f"<ul>{items}</ul>"


def _picture(path: Path) -> str:
    kind = path.stem.partition("_")[0]
    said, data = escape(CAPTIONS[kind]), b64encode(path.read_bytes()).decode()
    image = f"<img alt='{said}' src='data:image/png;base64,{data}'>"
    return f"<figure>{image}<figcaption>{said}</figcaption></figure>"
