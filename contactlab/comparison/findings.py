"""What the numbers say, in sentences that follow from them by rule."""

from collections.abc import Iterator
from math import inf, isfinite
from typing import Final

import xarray

from contactlab.comparison import measured
from contactlab.comparison.causes import listed
from contactlab.comparison.scorecard import Cell, rows
from contactlab.comparison.weighing import CLEAR, on_other_basis, pairs, shares_said, weighed
from contactlab.metrics import FAIL, NOT_APPLICABLE, PASS, Metric

# Metrics of transient runs whose differences between the laws are told.
HEADLINES: Final = ("final_rotor_velocity", "peak_force", "stick_share", "friction_share")


def headline(data: xarray.Dataset) -> list[str]:
    """Say what must be read first: what is not settled, and whether the laws differ by more than all else."""
    return [*first(data), *differences(data)]


def first(data: xarray.Dataset) -> list[str]:
    """Say what must be known of the laws before their values are read."""
    return [*filter(None, data.attrs["first"].splitlines())]


def differences(data: xarray.Dataset) -> list[str]:
    """Say how far the laws lie apart, against what else could explain it, the rotor velocity first.

    Of settled motors that is everything in `contactlab.comparison.causes.CAUSES`; of runs as they were
    recorded it is their numerical errors alone. Of measured impacts it is which of them are in the file.
    """
    if "cause" in data.dims:
        velocity, *others = [*map(str, weighed(data))] or [""]
        between = [f"Between {low} and {high}: {verdict}" for low, high, verdict in _inner(data)]
        said = [velocity, on_other_basis(data), *between, *others, _not_varied(data), shares_said(data)]
        return [*filter(None, said), *measured.differences(data)]
    known = {metric.key: _difference(metric, cells) for metric, cells in rows(data)}
    return [*(known[key] for key in HEADLINES if known[key]), *measured.differences(data)]


def _not_varied(data: xarray.Dataset) -> str:
    """State which of the laws' own parameters no comparison has varied; empty where there is none."""
    laws = zip(data["law"].values, data["not_varied"].values, strict=True)
    fixed = listed([f"{names} of {law}" for law, names in laws if names])
    return f"Not varied: {fixed}. `--range law.NAME=SHARE` varies a parameter." if fixed else ""


def _inner(data: xarray.Dataset) -> Iterator[tuple[str, str, str]]:
    """Give the pairs of laws that are not the outermost, and what their velocities differ by and why."""
    every = pairs(data)
    if len(every) > 1:
        for pair in every:
            if pair.apart < max(each.apart for each in every):
                yield *pair.laws, f"{pair.apart:.2g} rad/s apart. {pair.verdict}"


def _difference(metric: Metric, cells: dict[str, Cell]) -> str:
    cells = {label: cell for label, cell in cells.items() if isfinite(cell.value)}
    if len(cells) < 2:
        return ""
    low, *_, high = sorted(cells, key=lambda label: cells[label].value)
    one, other = cells[low], cells[high]
    spread, error = other.value - one.value, one.error + other.error
    meaning, unit = _capital(metric.brief), metric.unit
    if spread == 0.0:
        return f"{meaning}: {one.value:.4g}{unit} with every law."
    said = f"{meaning}: from {one.value:.4g} ({low}) to {other.value:.4g}{unit} ({high})"
    if not isfinite(error):
        return f"{said}; without finer reruns nothing is known of the numerical error."
    ratio = spread / error if error > 0.0 else inf
    lost = [label for label, cell in cells.items() if cell.error > abs(cell.value) > 0.0]
    if ratio < 1.0 and lost:
        return (
            f"{said}; with {listed(lost)} it does not converge: its numerical error is larger "
            "than itself, and no value is known."
        )
    times = f"{ratio:.2g} times" if ratio < 1e3 else "more than 1000 times"
    verdict = "resolved" if ratio >= CLEAR else "barely resolved" if ratio >= 1.0 else "not resolved"
    return (
        f"{said}; the difference of the transient, {spread:.3g}{unit}, {times} the numerical errors, is "
        f"{verdict}; what it owes to basis, parameters and start is not weighed."
    )


def verdicts(data: xarray.Dataset) -> dict[str, list[str]]:
    """Say of every law what it passes, and what it fails with value, bound and reason."""
    judged = [(metric, cells) for metric, cells in rows(data) if metric.judges_law]
    said = {}
    for label in map(str, data["law"].values):
        found = [cells[label].verdict for _, cells in judged]
        absent = found.count(NOT_APPLICABLE)
        first = f"Meets {found.count(PASS)} of {len(found) - absent} thresholds"
        first += f"; {absent} more do not apply." if absent else "."
        first = first if absent < len(found) else "No threshold applies."
        failed = ((m, cells[label]) for m, cells in judged if cells[label].verdict == FAIL)
        said[label] = [first, *(_failure(metric, cell) for metric, cell in failed)]
    return said


def _failure(metric: Metric, cell: Cell) -> str:
    doubt, unit = "", metric.unit
    if isfinite(cell.error) and abs(cell.value - metric.bound) < cell.error:
        doubt = f", within its numerical error of {cell.error:.2g}"
    return (
        f"Fails {metric.key} ({metric.brief}): {cell.value:.4g}{unit} where it must be "
        f"{metric.threshold}{unit}{doubt}. {_capital(metric.reason)}."
    )


def conclusion(data: xarray.Dataset) -> str:
    """Count for every law the thresholds that it meets and fails and those that do not apply."""
    judged = [cells for metric, cells in rows(data) if metric.judges_law]
    parts = []
    for label in map(str, data["law"].values):
        found = [cells[label].verdict for cells in judged]
        met, failed, absent = (found.count(verdict) for verdict in (PASS, FAIL, NOT_APPLICABLE))
        parts.append(f"{label} meets {met}, fails {failed}, and {absent} do not apply")
    return (
        f"Of {len(judged)} plausibility thresholds {'; '.join(parts)}. They test laws and numerics for "
        "contradictions; values without a threshold, such as forces and velocities, are not held against a "
        "measurement by them."
    )


def _capital(words: str) -> str:
    return words[0].upper() + words[1:]
