"""Recorded data made ready to be drawn; nothing here knows matplotlib."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.results.summary import prefixed_unit

PERIODS: Final = 3
"""Drive periods at the end of a run that are shown in detail."""

COARSE: Final = 20
"""Records in a drive period below which lines between them would invent the motion."""

COLUMNS: Final = 2000
"""Pixel columns of the widest panel: finer detail than this is drawn as its envelope."""

LARGEST: Final = 1e30
"""Beyond this a diverged run is not drawn: the square of an axis range would overflow."""


@final
@dataclass(frozen=True)
class Window:
    """The last part of a run.

    Args:
        start, end: of the window [s].
        series: root variables from the last record at or before `start`.
        contacts: rows of the contacts that lie in the window, wholly or in part.
        coarse: whether the records are too far apart to join them with lines.
    """

    start: float
    end: float
    series: xarray.Dataset
    contacts: xarray.Dataset
    coarse: bool

    @property
    def unit(self) -> tuple[str, float]:
        """Unit of a time axis over the window and its size [s]."""
        return prefixed_unit(self.end - self.start, "s")


def last_periods(
    root: xarray.Dataset, contacts: xarray.Dataset, configuration: Mapping[str, Any]
) -> Window:
    """Choose the last `PERIODS` drive periods of a run, or all of a shorter one, from its three parts."""
    period = drive_period(root, configuration)
    time = root["time"].values
    end = float(time[-1])
    start = max(float(time[0]), end - PERIODS * period)
    # The record before the start lets the lines reach the edge of their panel.
    first = max(int(np.searchsorted(time, start, side="right")) - 1, 0)
    ends = contacts["start_time"] + contacts["duration"]
    return Window(
        start=start,
        end=end,
        series=root.isel(time=slice(first, None)),
        contacts=contacts.isel(contact=(ends >= start).values),
        # A single record, of a run that failed at once, is a point as well.
        coarse=time.size == 1 or (time.size > 2 and float(time[1] - time[0]) > period / COARSE),
    )


def drive_period(root: xarray.Dataset, configuration: Mapping[str, Any]) -> float:
    """Give the period of the first tone [s], or else of the first natural frequency; endless without both."""
    frequency = (
        configuration.get("drive", {}).get("frequency") or root["natural_frequency"].values[0]
    )
    return 1.0 / float(frequency) if frequency else np.inf


def contact_spans(series: xarray.Dataset, contacts: xarray.Dataset) -> dict[str, Array]:
    """Find the times of slip and stick.

    A contact begins and ends when its row says so; inside, the mode changes half-way between two
    records that differ. A contact without a record inside takes the mode of its larger part.

    Args:
        series: `time` [s] and `contact_mode`, shape (time,).
        contacts: `start_time`, `duration` and `stick_duration` [s], shape (contact,).

    Returns:
        For slip and stick each, starts and ends [s], shape (span, 2), in the order of time.
    """
    starts, duration = contacts["start_time"].values, contacts["duration"].values
    ends = starts + duration
    time, mode = series["time"].values, series["contact_mode"].values
    owner = np.searchsorted(starts, time, side="right") - 1
    inside = (mode > 0) & (owner >= 0)
    inside[inside] = time[inside] <= ends[owner[inside]]
    time, mode, owner = time[inside], mode[inside], owner[inside]

    unseen = np.setdiff1d(np.arange(starts.size), owner)
    sticks = contacts["stick_duration"].values[unseen] >= 0.5 * duration[unseen]
    new = np.diff(owner, prepend=-1) != 0
    first = np.flatnonzero(new | (np.diff(mode, prepend=mode[:1]) != 0))
    last = np.append(first[1:], time.size) - 1 if first.size else first
    between = 0.5 * (time + np.append(time[1:], time[-1:]))
    left = np.where(new[first], starts[owner[first]], between[first - 1])
    follows = np.append(~new[first[1:]], False) if first.size else first.astype(bool)
    right = np.where(follows, between[last], ends[owner[last]])

    spans = {}
    for value, name in ((1, "slip"), (2, "stick")):
        seen = mode[first] == value
        rest = unseen[sticks == (value == 2)]
        begin = np.concatenate((left[seen], starts[rest]))
        finish = np.concatenate((right[seen], ends[rest]))
        spans[name] = np.column_stack((begin, finish))[np.argsort(begin, kind="stable")]
    return spans


def extent(values: Array) -> tuple[float, float]:
    """Give the middle and the width of the values that can be drawn; zeros where none can."""
    if not np.isfinite(values).any():
        return 0.0, 0.0
    least, most = float(np.nanmin(values)), float(np.nanmax(values))
    return 0.5 * (most + least), most - least


def drawable(values: Array) -> Array:
    """Leave a gap where a diverged run has nothing that could be drawn."""
    return np.where(np.abs(values) < LARGEST, values, np.nan)


def envelope(x: Array, y: Array) -> tuple[Array, Array]:
    """Give a line that looks the same on `COLUMNS` pixel columns, in four points a column.

    Every column keeps its first and its last point and spans its smallest to its largest value,
    so no peak is lost and no slope is drawn that is not there.

    Args:
        x: ascending, shape (point,).
        y: shape (point,), NaN where nothing is drawn.
    """
    if x.size <= 4 * COLUMNS:
        return x, y
    first = np.unique(np.searchsorted(x, np.linspace(x[0], x[-1], COLUMNS + 1)[:-1]))
    last = np.append(first[1:], x.size) - 1
    centre = 0.5 * (x[first] + x[last])
    lowest, highest = np.fmin.reduceat(y, first), np.fmax.reduceat(y, first)
    return (
        np.column_stack((x[first], centre, centre, x[last])).ravel(),
        np.column_stack((y[first], lowest, highest, y[last])).ravel(),
    )


def steps(edges: Array, means: Array) -> tuple[Array, Array]:
    """Give the line of means over intervals: horizontal over each, vertical between two."""
    return envelope(np.repeat(edges, 2)[1:-1], np.repeat(drawable(means), 2))
