"""Runs of several laws in one motor -> scorecard, tables, figures, and one page that holds them all."""

from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Final

import xarray
from tqdm import tqdm

from contactlab.comparison.findings import conclusion, differences, verdicts
from contactlab.comparison.reruns import Refined, refined
from contactlab.comparison.runs import Source, collect
from contactlab.comparison.scorecard import PLUS_MINUS, Cell, as_csv, as_latex, rows, scorecard
from contactlab.metrics import FAIL, NOT_APPLICABLE, PASS, Metric
from contactlab.results.files import whole_file, whole_netcdf

PAGE: Final = Path(__file__).with_name("report.html")  # the page without its words

CAPTIONS: Final = {
    "contact_force": "Normal force and friction of one contact, means over the record intervals. Peaks of "
    "rigid impacts grow without bound as the step falls; they are named, not drawn.",
    "tip_trajectory": "Path of the tip in the last two drive periods.",
    "rotor_velocity": "Rotor velocity, with its numerical error as a band that may be thinner than the line. "
    "Below: range of the laws, in black, and numerical error of each, as medians over a drive period.",
    "energy_flow": "Where the work of the drive has gone by the end of the run.",
    "phase_portrait": "Mean gap rate and slip over the gap in the last two drive periods.",
}


def compare(
    sources: Sequence[Source], output: str | Path | None = None, *, refine: bool = True
) -> xarray.Dataset:
    """Compare contact laws in one motor.

    Args:
        sources: run folders, their datasets, folders of such folders, or runs in memory; all of one
            motor with one drive.
        output: folder for tables, figures and the report; None writes nothing.
        refine: whether every law is run again at finer steps, with more friction and on a larger basis;
            what follows from these is not applicable without.

    Returns:
        Values, verdicts and numerical errors over the dimensions `law` and `metric`, the energy flow over
        `law` and `term`.

    Raises:
        ComparisonError: the runs cannot be compared; a sentence each.
        OSError: the folder cannot be written to.
    """
    runs, notes = collect(sources)
    bar = tqdm(runs, unit=" laws", disable=None, delay=1.0, leave=False)
    laws = [refined(run) if refine else Refined(run) for run in bar]
    data = scorecard(laws, notes)
    if output is None:
        return data
    # It brings the plotting.
    from contactlab.comparison.figures import draw_all

    folder = Path(output)
    folder.mkdir(parents=True, exist_ok=True)
    with whole_netcdf(folder / "metrics.nc") as partial:
        data.to_netcdf(partial, engine="netcdf4")
    report = page(data, draw_all(laws, data, folder))
    texts = {"scorecard.csv": as_csv(data), "scorecard.tex": as_latex(data), "report.html": report}
    for name, text in texts.items():
        with whole_file(folder / name) as partial:
            partial.write_text(text, encoding="utf-8")
    return data


def page(data: xarray.Dataset, pictures: Iterable[Path]) -> str:
    """Write the report: one page that holds its pictures, PNG files, itself and fetches nothing."""
    labels, notes = [str(label) for label in data["law"].values], data.attrs["notes"].splitlines()
    table = rows(data)
    code = {k.removesuffix("_version"): v for k, v in data.attrs.items() if "_version" in k}
    versions = [f"{k} {v}" for k, v in code.items()] + [f"revision {data.attrs['git_revision']}"]
    said = {
        "title": escape("Contact laws compared" if len(labels) > 1 else f"Contact law {labels[0]}"),
        "conclusion": escape(conclusion(data)),
        "differences": _list(differences(data)),
        "head": "".join(f"<th>{escape(word)}</th>" for word in ("metric", "must be", *labels)),
        "scorecard": "\n".join(_row(*row) for row in table),
        "pictures": "\n".join(map(_picture, pictures)),
        "verdicts": "\n".join(f"<h3>{escape(k)}</h3>{_list(v)}" for k, v in verdicts(data).items()),
        "notes": f"<h2>Notes</h2>{_list(notes)}" if notes else "",
        "definitions": "\n".join(_definition(metric) for metric, _ in table),
        "configurations": "\n".join(_configuration(data.sel(law=label)) for label in labels),
        "versions": escape("; ".join(versions)),
    }
    return Template(PAGE.read_text(encoding="utf-8")).substitute(said).replace("&lt;=", "\u2264")


def _list(sentences: Iterable[str]) -> str:
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return items and f"<ul>{items}</ul>"


def _row(metric: Metric, cells: dict[str, Cell]) -> str:
    line = f"<tr><td title='{escape(metric.meaning)}'>{escape(metric.brief + metric.bracketed)}</td>"
    line += f"<td>{escape(metric.threshold)}</td>"
    for cell in cells.values():
        kind = {PASS: "pass", FAIL: "fail", NOT_APPLICABLE: "none"}.get(cell.verdict, "")
        number, sign, error = cell.number.partition(f" {PLUS_MINUS}")
        small = f" <small>{PLUS_MINUS}{error}</small>" if sign else ""
        line += f"<td class='{kind}'>{number}{small} {cell.word}</td>"
    return f"{line}</tr>"


def _picture(path: Path) -> str:
    said, data = escape(CAPTIONS[path.stem]), b64encode(path.read_bytes()).decode()
    image = f"<img alt='{said}' src='data:image/png;base64,{data}'>"
    return f"<figure>{image}<figcaption>{said}</figcaption></figure>"


def _definition(metric: Metric) -> str:
    """Give key, symbol, meaning and the threshold's reason of a metric."""
    limit = f" Must be {metric.threshold}: {metric.reason}." if metric.threshold else ""
    source = f" Source: {metric.source}." if metric.source else ""
    text = escape(f"{metric.symbol}{metric.bracketed}: {metric.meaning}.{limit}{source}")
    return f"<li><code>{escape(metric.key)}</code> = {text}</li>"


def _configuration(law: xarray.Dataset) -> str:
    said = {str(key): escape(str(law[key].item())) for key in law.coords if not law[key].dims}
    return (
        f"<h3>{said['law']}</h3><p>{said['run']}, recorded by contactlab {said['contactlab_version']}; "
        f"values at {said['refined']}.</p><details><summary>Configuration</summary>"
        f"<pre>{said['configuration']}</pre></details>"
    )
