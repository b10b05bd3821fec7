"""A study as files: dataset, figures, and one page that holds them all."""

from collections.abc import Iterable
from html import escape
from pathlib import Path
from typing import Final

import xarray

from contactlab.comparison.page import bulleted, filled, pictured
from contactlab.results.files import whole_file, whole_netcdf
from contactlab.studies import validate_tables as tables

PAGE: Final = Path(__file__).with_name("validation.html")  # the page without its words

CAPTIONS: Final = {
    "prediction_error": "Mean held-out error of every law with its 95 % interval. Bands are floors: the "
    "errors of the best impulse of each impact, which have seen what they are judged by; none is "
    "drawn at zero.",
    "paired_differences": "By how much the law of a row is worse than that of a column on the same impacts, "
    "in thousandths of the approach. Grey numbers are differences whose interval holds zero.",
    "residuals": "What laws miss, over incidence (0 is head-on), approach speed and slip: medians in bins of "
    "equal numbers, the band the quartiles of the first. Below: gap rate and slip after the impact, "
    "measured less predicted; slip is positive along that before the impact.",
    "impacts": "The impacts, with the least error that any law has. Rings: above noise under every law, the "
    "worst with their numbers in the file.",
}

LEGEND: Final = (
    "The error is ||v+ - v+ predicted|| / ||v-|| in the norm of the kinetic energy. Laws of one group are "
    "those that the data cannot tell from the first of them. A compliant law is fitted on as many impacts of "
    "the other folds as stand under 'fitted on', drawn by the seed, and judged on all that are held out."
)


def write(data: xarray.Dataset, folder: Path) -> None:
    """Write validation.nc, figures and validation.html into a folder, each whole or not at all.

    Raises:
        OSError: the folder cannot be written to.
    """
    # It brings the plotting.
    from contactlab.studies.validate_figures import draw_all

    folder.mkdir(parents=True, exist_ok=True)
    with whole_netcdf(folder / "validation.nc") as partial:
        data.to_netcdf(partial, engine="netcdf4")
    text = page(data, draw_all(data, folder))
    with whole_file(folder / "validation.html") as partial:
        partial.write_text(text, encoding="utf-8")


def page(data: xarray.Dataset, pictures: Iterable[Path]) -> str:
    """Write the page of a study: it holds its pictures, PNG files, itself and fetches nothing."""
    attributes = data.attrs
    notes = [
        *attributes["data_notes"].splitlines(),
        f"{attributes['left_out']} impacts are left out by flags.",
    ]
    code = {k.removesuffix("_version"): v for k, v in attributes.items() if k.endswith("_version")}
    versions = [f"{k} {v}" for k, v in code.items()] + [f"revision {attributes['git_revision']}"]
    ran = (
        f"{data.sizes['impact']} impacts in {attributes['folds']} folds, seed {attributes['seed']}; "
        f"{attributes['resamples']} resamples for every interval. Digest of the data: "
        f"{attributes['data_digest']}."
    )
    said = {
        "title": escape(attributes["title"]),
        "headline": escape(tables.headline(data)),
        "order": bulleted(tables.order(data)),
        "warnings": bulleted(tables.warnings(data)),
        "table": _table(tables.HEAD, tables.rows(data)),
        "legend": escape(LEGEND),
        "pictures": "\n".join(pictured(path, CAPTIONS[path.stem]) for path in pictures),
        "parameters": _parameters(data),
        "unexplained": escape(tables.unexplained(data)),
        "data": bulleted(
            [f"{attributes['source']}. Licence: {attributes['licence'] or 'not stated'}.", *notes]
        ),
        "ran": escape(ran),
        "versions": escape("; ".join(versions)),
    }
    return filled(PAGE, said)


def _table(head: Iterable[str], body: Iterable[Iterable[str]]) -> str:
    lines = ["".join(f"<th>{escape(word)}</th>" for word in head)]
    lines += ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in body]
    return "".join(f"<tr>{line}</tr>" for line in lines)


def _parameters(data: xarray.Dataset) -> str:
    lines = ["<th>law</th><th>parameter</th><th>value</th><th>unit</th><th></th>"]
    for one in tables.parameters(data):
        value = f"{one.middle:.4g} <small>{one.low:.4g} to {one.high:.4g}</small>"
        cells = (escape(one.law), escape(one.name), value, escape(one.units), escape(one.doubt))
        lines.append("".join(f"<td>{cell}</td>" for cell in cells))
    return "".join(f"<tr>{line}</tr>" for line in lines)
