"""The table of a study and its sentences: for the terminal, the page and files alike."""

from collections.abc import Iterator
from math import isfinite
from typing import Final, NamedTuple

import numpy as np
import xarray

from contactlab.inference.cross_validation_data import laws_in
from contactlab.inference.ranking import PLUS_MINUS

HEAD: Final = ("law", "kind", "held-out error", "95 % interval", "group", "fitted on")

SHOWN: Final = 40
"""Impacts that are listed; the dataset has all of them."""


class Parameter(NamedTuple):
    """A fitted parameter of a law: median of the folds, and their least and greatest."""

    law: str
    name: str
    middle: float
    low: float
    high: float
    units: str
    doubt: str


def rows(data: xarray.Dataset) -> Iterator[tuple[str, ...]]:
    """Give the cells of the table under `HEAD`, a row for each law, baseline and floor."""
    for label in data["law"].values:
        here = data.sel(law=label)
        low, high = here["prediction_error_interval"].values
        used, group = int(here["fitted_on"]), int(here["group"])
        yield (
            str(label),
            str(here["kind"].item()),
            f"{float(here['prediction_error']):.4f}",
            f"{low:.4f} to {high:.4f}",
            str(group or ""),
            str(used or ""),
        )


def as_text(data: xarray.Dataset) -> str:
    """Write the table for a terminal."""
    cells = [HEAD, *rows(data)]
    widths = [max(len(row[column]) for row in cells) for column in range(len(HEAD))]
    lines = ("  ".join(f"{word:<{w}}" for word, w in zip(row, widths, strict=True)).rstrip() for row in cells)
    return "\n".join(lines)


def parameters(data: xarray.Dataset) -> Iterator[Parameter]:
    """Give every parameter that was fitted."""
    for label in data["law"].values:
        here = data.sel(law=label)
        doubts = {
            **dict.fromkeys(_names(here["at_end"].item()), "on an end of its range"),
            **dict.fromkeys(_names(here["cannot_tell"].item()), "cannot tell"),
        }
        for name in map(str, data["parameter"].values):
            values = here["value"].sel(parameter=name).values
            if np.isfinite(values).any():
                units = str(here["units"].sel(parameter=name).item())
                ends = float(values.min()), float(values.max())
                doubt = doubts.get(name, "")
                yield Parameter(str(label), name, float(np.median(values)), *ends, units, doubt)


def headline(data: xarray.Dataset) -> str:
    """Say which law predicts best, and how far it is from what no law can be better than."""
    laws = laws_in(data)
    best, floor = laws.isel(law=0), data.isel(law=-1)
    error, least = float(best["prediction_error"]), float(floor["prediction_error"])
    first = laws["law"].values[laws["group"].values == 1]
    low, high = best["prediction_error_interval"].values
    said = f"{best['law'].item()} predicts best: {error:.4f} {PLUS_MINUS} {0.5 * (high - low):.4f}"
    if len(first) > 1:
        said += f", and the data cannot tell it from {', '.join(map(str, first[1:]))}"
    return f"{said}. The best impulse that there is leaves {least:.4f}."


def order(data: xarray.Dataset) -> list[str]:
    """Say the order of the laws, and what the plainest things do."""
    laws = laws_in(data)
    said: list[str] = data.attrs["order"].splitlines()
    best = str(laws["law"].values[0])
    for label in data["law"].values[data["kind"].values == "baseline"]:
        here = data.sel(law=label, other=best)
        apart = float(here["difference"])
        low, high = here["difference_interval"].values
        said.append(
            f"{best} beats the baseline {label} by {apart:.4f} {PLUS_MINUS} {0.5 * (high - low):.4f}."
            if low > 0.0
            else f"The data cannot tell {best} from the baseline {label}."
        )
    return said


def warnings(data: xarray.Dataset) -> list[str]:
    """Return what limits the result: copied rows, undetermined parameters, impacts without an answer."""
    said = [copies] if (copies := data.attrs.get("copies")) else []
    for label in map(str, data["law"].values):
        here = data.sel(law=label)
        if names := here["cannot_tell"].item():
            said.append(f"{label}: cannot tell {names}.")
        if names := here["at_end"].item():
            said.append(f"{label}: {names} on an end of the range; the best may lie beyond.")
        if names := here["unmoved"].item():
            said.append(f"{label}: cannot tell {names}, which change nothing that is predicted; held.")
        if count := int(here["unanswered"]):
            said.append(
                f"{label}: no answer to {count} of {data.sizes['impact']} impacts, taken as no change."
            )
    return said


def unexplained(data: xarray.Dataset) -> str:
    """Say which impacts have an error above noise under every law."""
    if not isfinite(float(data["noise_bound"].max())):
        return f"It cannot be told which impacts no law explains, as the noise is {data.attrs['noise']}."
    numbers = data["impact"].values[data["unexplained"].values != 0]
    noise = data.attrs["noise"]
    if not numbers.size:
        return f"Every impact is explained by some law: its error is below that of noise, {noise}."
    least = laws_in(data)["error"].min("law").sel(impact=numbers).values
    worst = numbers[np.argsort(-least, kind="stable")]
    listed = ", ".join(map(str, worst[:SHOWN]))
    rest = f" and {numbers.size - SHOWN} more, in the dataset" if numbers.size > SHOWN else ""
    return (
        f"No law explains {numbers.size} of {data.sizes['impact']} impacts: under every law their error "
        f"is above that of noise, {noise}; by number in their file, the worst first: {listed}{rest}."
    )


def _names(text: str) -> list[str]:
    return [name for name in text.split(", ") if name]
