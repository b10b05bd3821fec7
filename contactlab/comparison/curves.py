"""Recorded data of a law made ready to be drawn beside that of others; nothing here knows matplotlib."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from scipy.ndimage import median_filter

from contactlab.arrays import Array
from contactlab.comparison.reruns import Refined

PERIODS: Final = 2.0  # drive periods at the end of a run that are drawn as path and phase portrait
MARGIN: Final = 0.1  # time before touch-down and after release that is drawn, in durations
SCARCE: Final = 5  # records in a contact below which a line through them would invent the force
APART: Final = 0.1  # flight between two contacts that makes them two, in drive periods


class Contact(NamedTuple):
    """One contact: middles of its records from touch-down [s], their mean normal and friction force [N]."""

    time: Array
    forces: Array
    start: float
    duration: float
    peak: float


def one_contact_each(laws: Sequence[Refined]) -> dict[int, Contact]:
    """Give the same contact of every law that recorded it, by its place among the laws.

    A rigid law with restitution touches in a row of impacts, which are one contact here. A law with too
    few records of it has none.
    """
    columns = ("start_time", "duration", "normal_impulse", "peak_normal_force")
    touching = {
        i: law
        for i, law in enumerate(laws)
        if law.best.touches(*columns) and law.best.holds("normal_force", "friction_force")
    }
    near = next((t for t in map(_last_whole_contact, touching.values()) if t is not None), None)
    if near is None:
        return {}
    rows = {i: _row_of_impacts(law, near) for i, law in touching.items()}
    length = max(duration for _, duration, _ in rows.values())
    found = {i: _recorded(touching[i], length, *row) for i, row in rows.items()}
    return {i: contact for i, contact in found.items() if contact.time.size >= SCARCE}


def _last_whole_contact(law: Refined) -> float | None:
    """Give the touch-down of the strongest of the last contacts that the end did not cut [s]."""
    rows, end = law.best.rows, float(law.best.time[-1])
    starts, ends = rows["start_time"], rows["start_time"] + rows["duration"]
    # Other laws touch at other times: their contact shall be whole as well.
    settled = end - 0.5 * law.period
    whole = np.flatnonzero((ends < settled) & (starts > end - (PERIODS + 1.0) * law.period))
    whole = whole if whole.size else np.flatnonzero(ends < end)
    return float(starts[max(whole, key=rows["normal_impulse"].item)]) if whole.size else None


def _row_of_impacts(law: Refined, near: float) -> tuple[float, float, float]:
    """Give start [s], duration [s] and peak force [N] of the contact that begins nearest to a time [s]."""
    rows = law.best.rows
    starts, ends = rows["start_time"], rows["start_time"] + rows["duration"]
    row = np.append(0, np.cumsum(starts[1:] - ends[:-1] >= APART * law.period))
    mine = np.flatnonzero(row == row[np.argmin(np.abs(starts - near))])
    start, end = float(starts[mine[0]]), float(ends[mine[-1]])
    return start, end - start, float(rows["peak_normal_force"][mine].max())


def _recorded(law: Refined, length: float, start: float, duration: float, peak: float) -> Contact:
    """Give the records of a contact, over a length of time [s]."""
    run = law.best
    earlier = np.append(run.time[:1], run.time[:-1])
    # In the interval of the touch-down the force acts after it only.
    middle = 0.5 * (np.where(run.time > start, np.maximum(earlier, start), earlier) + run.time)
    # It jumps at touch-down: a line from the record before would give it to the open gap.
    place = int(np.searchsorted(middle, start))
    since = np.insert(middle, place, start) - start
    shown = (since >= -MARGIN * length) & (since <= (1.0 + MARGIN) * length)
    both = [run.columns["normal_force"], run.columns["friction_force"]]
    return Contact(since[shown], np.insert(both, place, 0.0, axis=1)[:, shown], start, duration, peak)


def last_periods(law: Refined) -> slice:
    """Give the records of the last drive periods."""
    time = law.best.time
    first = int(np.searchsorted(time, time[-1] - PERIODS * law.period))
    return slice(max(first - 1, 0), None)


def smoothed(law: Refined, values: Array) -> Array:
    """Give the running median over a drive period: without the records that a moving impact passes.

    What is not positive has no place on a logarithmic axis: NaN.
    """
    time = law.best.time
    size = int(np.searchsorted(time, time[0] + law.period))
    median = median_filter(values, size=max(size, 1), mode="nearest")
    return np.where(median > 0.0, median, np.nan)
