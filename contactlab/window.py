"""Contacts cut to a window of time: what of each lies between the first and the last record of a run."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.variables import EXTREMES, INTERNAL, SUMS

CLOCK: Final = 1e4
"""Units in the last place of the time within which two instants are one: durations are sums of many steps."""

Columns = Mapping[str, NDArray[Any]]


def joined(first: Mapping[str, float], second: Mapping[str, float]) -> dict[str, float]:
    """Return two successive parts of one contact as one."""
    sums = {name: first[name] + second[name] for name in first.keys() & SUMS}
    return {**first, **sums, **{name: max(first[name], second[name]) for name in first.keys() & EXTREMES}}


def cut_to_window(columns: Columns, rows: Columns, part: Mapping[str, float]) -> dict[str, NDArray[Any]]:
    """Return the contacts with what of them lies between the first and the last record.

    A contact that began before has no approach velocity, one that ends later no separation velocity. NaN
    stands for what cannot be known: the records give impulses and losses of a part, but not its extremes.

    Args:
        columns, rows: series and contacts, see `contactlab.variables`.
        part: of the first contact, as of `contactlab.trajectory.Trajectory`; empty if it is not known.
    """
    if not {"start_time", "duration"} <= rows.keys() or not np.size(columns.get("time", ())):
        return dict(rows)
    time = np.asarray(columns["time"], dtype=np.float64)
    starts = np.asarray(rows["start_time"], dtype=np.float64)
    ends, near = starts + rows["duration"], CLOCK * float(np.spacing(np.abs(time).max()))
    early, late = starts < time[0] - near, ends > time[-1] + near
    if not (early | late).any():
        return dict(rows)
    kept = ~((early & (ends <= time[0] + near)) | (late & (starts >= time[-1] - near)))
    whole = {name: np.asarray(values, dtype=np.float64)[kept] for name, values in rows.items()}
    result = {name: values.copy() for name, values in whole.items()}
    for i in np.flatnonzero((early | late)[kept]).tolist():
        known = part and starts[kept][i] < time[0] and abs(part["start_time"] - time[0]) <= near
        known = known and ends[kept][i] <= time[-1] + near
        values = part if known else _of_records(columns, time, whole, i, near)
        for name in values.keys() & result.keys():
            result[name][i] = values[name]
    return result


def _of_records(
    columns: Columns, time: Array, rows: Mapping[str, Array], i: int, near: float
) -> dict[str, float]:
    """Return what the records tell of the part of a contact in their window, NaN for the rest."""
    starts, ends = rows["start_time"], rows["start_time"] + rows["duration"]
    begin, end = max(starts[i], time[0]), min(ends[i], time[-1])
    early, late = bool(starts[i] < begin), bool(ends[i] > end)
    # The stretch reaches to a record in flight on either side; other contacts in it must be whole.
    touching = np.searchsorted(np.sort(starts), time + near, side="right") != np.searchsorted(
        np.sort(ends), time - near
    )
    cut = bool(begin <= time[0])
    before = np.flatnonzero(cut | (~touching & (time <= begin)))
    after = np.flatnonzero(late | (~touching & (time >= end)))
    values = dict.fromkeys(SUMS, np.nan)
    if before.size and after.size:
        left, right = (0 if cut else int(before[-1])), (time.size - 1 if late else int(after[0]))
        inside = (starts >= time[left] - near) & (ends <= time[right] + near)
        across = (starts < time[right]) & (ends > time[left]) & ~inside
        across[i] = inside[i] = False
        increments = _increments(columns, time) if not across.any() else {}
        for name in increments.keys() & rows.keys():
            values[name] = float(increments[name][left:right].sum() - rows[name][inside].sum())
        if not late and np.any(columns.get("contact_energy", np.zeros(time.size))[right]):
            # The law stores energy while apart, which is lost later.
            values["energy_loss"] = np.nan
    values |= {"start_time": begin, "duration": end - begin}
    # A largest value that is zero is that of every part.
    for name in ("impact_energy_gain", *EXTREMES):
        values[name] = 0.0 if name in rows and rows[name][i] == 0.0 else np.nan
    if "stick_duration" in rows:
        shares = {0.0: 0.0, float(rows["duration"][i]): end - begin}
        values["stick_duration"] = shares.get(float(rows["stick_duration"][i]), np.nan)
    if early:
        values["approach_velocity"] = np.nan
    if late:
        missing = [name for name in rows if name.startswith(INTERNAL)]
        values |= dict.fromkeys(("separation_velocity", *missing), np.nan)
    return values


def _increments(columns: Columns, time: Array) -> dict[str, Array]:
    """Return what impulses and losses of contacts grow by over the record intervals."""
    result: dict[str, Array] = {}
    for way in ("normal", "friction"):
        if f"{way}_force" in columns:
            result[f"{way}_impulse"] = columns[f"{way}_force"][1:] * np.diff(time)
    if {"friction_loss", "contact_loss"} <= columns.keys():
        result["energy_loss"] = np.diff(columns["friction_loss"]) + np.diff(columns["contact_loss"])
    return result
