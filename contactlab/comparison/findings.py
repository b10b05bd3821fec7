"""What the numbers say, in sentences that follow from them by rule."""

from collections.abc import Sequence
from math import inf, isfinite
from typing import Final

import xarray

from contactlab.comparison.tables import Cell, Row, rows
from contactlab.metrics import FAIL, NOT_APPLICABLE, PASS

HEADLINES: Final = ("final_rotor_velocity", "peak_force", "stick_share", "friction_share")
"""Metrics whose differences between the laws are told."""

CLEAR: Final = 3.0
"""A difference of this many numerical errors is one between the laws."""


def differences(data: xarray.Dataset) -> list[str]:
    """Say how far the laws lie apart, against what is known of their numerical errors."""
    known = {row.metric: row for row in rows(data)}
    return [sentence for key in HEADLINES if key in known and (sentence := _difference(known[key]))]


def _difference(row: Row) -> str:
    cells = {label: cell for label, cell in row.cells.items() if isfinite(cell.value)}
    if len(cells) < 2:
        return ""
    low, *_, high = sorted(cells, key=lambda label: cells[label].value)
    one, other = cells[low], cells[high]
    spread = other.value - one.value
    meaning = row.brief[0].upper() + row.brief[1:]
    if spread == 0.0:
        return f"{meaning}: {one.value:.4g}{row.unit} with every law."
    said = f"{meaning}: from {one.value:.4g} ({low}) to {other.value:.4g}{row.unit} ({high})"
    error = one.error + other.error
    if not isfinite(error):
        return f"{said}; without finer reruns nothing is known of the numerical error."
    ratio = spread / error if error > 0.0 else inf
    lost = [label for label, cell in cells.items() if cell.error > abs(cell.value) > 0.0]
    if ratio < 1.0 and lost:
        return (
            f"{said}; with {_listed(lost)} it does not converge: its numerical error is larger "
            "than itself, and no value is known."
        )
    times = f"{ratio:.2g} times" if ratio < 1e3 else "more than 1000 times"
    verdict = "one between the laws" if ratio >= CLEAR else "barely resolved"
    return (
        f"{said}; the difference, {spread:.3g}{row.unit}, {times} the numerical errors, is "
        f"{verdict if ratio >= 1.0 else 'not resolved'}."
    )


def verdicts(data: xarray.Dataset) -> dict[str, list[str]]:
    """Say of every law what it passes, and what it fails with value, bound and reason."""
    judged = [row for row in rows(data) if row.threshold]
    return {str(label): _verdict(str(label), judged) for label in data["law"].values}


def _verdict(label: str, judged: Sequence[Row]) -> list[str]:
    said = [row.cells[label].verdict for row in judged]
    absent = said.count(NOT_APPLICABLE)
    if absent == len(judged):
        return ["No threshold applies."]
    first = f"Meets {said.count(PASS)} of {len(judged) - absent} thresholds"
    first += f"; {absent} more do not apply." if absent else "."
    failed = (row for row in judged if row.cells[label].verdict == FAIL)
    return [first, *(_failure(row, row.cells[label]) for row in failed)]


def _failure(row: Row, cell: Cell) -> str:
    doubt = ""
    if isfinite(cell.error) and abs(cell.value - float(row.threshold.split()[1])) < cell.error:
        doubt = f", within its numerical error of {cell.error:.2g}"
    reason = f" {row.reason[0].upper()}{row.reason[1:].rstrip('.')}." if row.reason else ""
    return (
        f"Fails {row.metric} ({row.brief}): {cell.value:.4g}{row.unit} where it must be "
        f"{row.threshold}{row.unit}{doubt}.{reason}"
    )


def conclusion(data: xarray.Dataset) -> str:
    """Say one sentence on all laws together."""
    counts = {label: len(sentences) - 1 for label, sentences in verdicts(data).items()}
    clean = [label for label, failures in counts.items() if not failures]
    if len(clean) == len(counts):
        return "Every law meets all thresholds that apply to it."
    rest = _listed([f"{label} fails {count}" for label, count in counts.items() if count])
    if not clean:
        return f"No law meets all thresholds that apply to it: {rest}."
    verb = "meets" if len(clean) == 1 else "meet"
    return f"{_listed(clean)} {verb} all thresholds that apply; {rest}."


def _listed(words: Sequence[str]) -> str:
    """Set words into a sentence."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last
