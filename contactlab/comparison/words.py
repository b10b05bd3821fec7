"""What the numbers say, in sentences that follow from them by rule."""

from math import isfinite
from typing import Final

import numpy as np
import xarray

from contactlab.comparison.tables import Cell, Row, rows, slashed
from contactlab.metrics import FAIL, NOT_APPLICABLE, PASS

HEADLINES: Final = ("final_rotor_velocity", "peak_force", "stick_share", "friction_share")
"""Metrics whose differences between the laws are told."""

CLEAR: Final = 3.0
"""A difference of this many numerical errors is one between the laws."""


def differences(data: xarray.Dataset) -> list[str]:
    """How far the laws lie apart, against what is known of their numerical errors."""
    known = {row.key: row for row in rows(data)}
    return [sentence for key in HEADLINES if key in known and (sentence := _difference(known[key]))]


def _difference(row: Row) -> str:
    cells = {label: cell for label, cell in row.cells.items() if isfinite(cell.value)}
    if len(cells) < 2:
        return ""
    low = min(cells, key=lambda label: cells[label].value)
    high = max(cells, key=lambda label: cells[label].value)
    one, other = cells[low], cells[high]
    spread = other.value - one.value
    unit = "" if row.units == "1" else f" {slashed(row.units)}"
    meaning = row.brief[0].upper() + row.brief[1:]
    if spread == 0.0:
        return f"{meaning}: {one.value:.4g}{unit} with every law."
    said = f"{meaning}: from {one.value:.4g} ({low}) to {other.value:.4g}{unit} ({high})"
    errors = [cell.error for cell in (one, other)]
    if not all(map(isfinite, errors)):
        return f"{said}; without finer reruns nothing is known of the numerical error."
    error = sum(errors)
    ratio = spread / error if error > 0.0 else np.inf
    share = f"{spread:.3g}{unit}, {_times(ratio)} the numerical errors"
    lost = [label for label, cell in cells.items() if cell.error > abs(cell.value) > 0.0]
    if ratio < 1.0 and lost:
        return (
            f"{said}; with {_listed(lost)} it does not converge: its numerical error is larger "
            "than itself, and no value is known."
        )
    if ratio < 1.0:
        return f"{said}; the difference, {share}, is not resolved."
    if ratio < CLEAR:
        return f"{said}; the difference, {share}, is barely resolved."
    return f"{said}; the difference, {share}, is one between the laws."


def _times(ratio: float) -> str:
    return f"{ratio:.2g} times" if ratio < 1e3 else "more than 1000 times"


def verdicts(data: xarray.Dataset) -> dict[str, list[str]]:
    """Sentences on every law: what it passes, and what it fails with value, bound and reason."""
    table = rows(data)
    return {str(label): _verdict(str(label), table) for label in data["law"].values}


def _verdict(label: str, table: list[Row]) -> list[str]:
    judged = [(row, row.cells[label]) for row in table if row.threshold]
    passed = sum(cell.verdict == PASS for _, cell in judged)
    failed = [(row, cell) for row, cell in judged if cell.verdict == FAIL]
    absent = sum(cell.verdict == NOT_APPLICABLE for _, cell in judged)
    counted = len(judged) - absent
    if not counted:
        return ["No threshold applies."]
    first = f"Meets {passed} of {counted} thresholds"
    first += f"; {absent} more do not apply." if absent else "."
    return [first, *(_failure(row, cell) for row, cell in failed)]


def _failure(row: Row, cell: Cell) -> str:
    unit = "" if row.units == "1" else f" {slashed(row.units)}"
    doubt = ""
    if isfinite(cell.error) and abs(cell.value - float(row.threshold.split()[1])) < cell.error:
        doubt = f", within its numerical error of {cell.error:.2g}"
    reason = f" {row.reason[0].upper()}{row.reason[1:].rstrip('.')}." if row.reason else ""
    return (
        f"Fails {row.key} ({row.brief}): {cell.value:.4g}{unit} where it must be "
        f"{row.threshold}{unit}{doubt}.{reason}"
    )


def conclusion(data: xarray.Dataset) -> str:
    """One sentence on all laws together."""
    counts = {}
    for label, sentences in verdicts(data).items():
        counts[label] = len(sentences) - 1
    clean = [label for label, failures in counts.items() if not failures]
    if len(clean) == len(counts):
        return "Every law meets all thresholds that apply to it."
    rest = [f"{label} fails {count}" for label, count in counts.items() if count]
    if not clean:
        return f"No law meets all thresholds that apply to it: {_listed(rest)}."
    verb = "meets" if len(clean) == 1 else "meet"
    return f"{_listed(clean)} {verb} all thresholds that apply; {_listed(rest)}."


def _listed(words: list[str]) -> str:
    """Words in a sentence."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last
