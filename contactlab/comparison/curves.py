"""Recorded data of a law made ready to be drawn beside that of others; nothing here knows matplotlib."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import xarray
from scipy.ndimage import median_filter

from contactlab.comparison.arrays import Array, column, contacts_hold, holds, series
from contactlab.comparison.reruns import Refined

PERIODS: Final = 2.0
"""Drive periods at the end of a run that are drawn as path and phase portrait."""

MARGIN: Final = 0.1
"""Time before touch-down and after release that is drawn with a contact, in its duration."""

SCARCE: Final = 5
"""Records in a contact below which a line through them would invent the force."""


IMPACT: Final = 0.1
"""Share of a contact in which a rigid law's impact is over."""


APART: Final = 0.1
"""Flight between two contacts that makes them two, in drive periods."""


@final
@dataclass(frozen=True)
class Contact:
    """One contact of a law.

    Args:
        time: middles of the record intervals, from touch-down [s].
        normal, friction: mean forces of the intervals [N].
        start, duration: of the contact [s].
        peak: largest normal force in it [N].
    """

    time: Array
    normal: Array
    friction: Array
    start: float
    duration: float
    peak: float


def one_contact(law: Refined, near: float, length: float = 0.0) -> Contact | None:
    """The contact whose touch-down is nearest to a time; None where it was not recorded.

    A rigid law with restitution touches in a row of impacts, which are one contact here.

    Args:
        law: with its reruns.
        near: [s].
        length: time that is drawn at least [s].
    """
    tree = law.best
    if not contacts_hold(tree, "start_time", "duration", "peak_normal_force"):
        return None
    if not holds(tree, "normal_force", "friction_force"):
        return None
    starts = column(tree, "start_time")
    ends = starts + column(tree, "duration")
    first = last = int(np.argmin(np.abs(starts - near)))
    apart = APART * law.run.period
    while first > 0 and starts[first] - ends[first - 1] < apart:
        first -= 1
    while last + 1 < starts.size and starts[last + 1] - ends[last] < apart:
        last += 1
    start, duration = float(starts[first]), float(ends[last] - starts[first])
    time = series(tree, "time")
    earlier = np.append(time[:1], time[:-1])
    # In the interval of the touch-down the force acts after it only.
    middle = 0.5 * (np.where(time > start, np.maximum(earlier, start), earlier) + time)
    # It jumps at touch-down: a line from the record before would give it to the open gap.
    place = int(np.searchsorted(middle, start))
    middle = np.insert(middle, place, start)
    forces = {
        name: np.insert(series(tree, name), place, 0.0)
        for name in ("normal_force", "friction_force")
    }
    extent = max(duration, length)
    shown = (middle >= start - MARGIN * extent) & (middle <= start + (1.0 + MARGIN) * extent)
    if np.count_nonzero(shown) < SCARCE:
        return None
    return Contact(
        time=middle[shown] - start,
        normal=forces["normal_force"][shown],
        friction=forces["friction_force"][shown],
        start=start,
        duration=duration,
        peak=float(column(tree, "peak_normal_force")[first : last + 1].max()),
    )


def one_contact_each(laws: Sequence[Refined]) -> list[tuple[int, Contact]]:
    """The same contact of every law that recorded it, with its place among the laws."""
    near = next((t for t in map(last_whole_contact, laws) if t is not None), None)
    if near is None:
        return []
    found = [one_contact(law, near) for law in laws]
    length = max((contact.duration for contact in found if contact is not None), default=0.0)
    again = [(i, one_contact(law, near, length)) for i, law in enumerate(laws)]
    return [(i, contact) for i, contact in again if contact is not None]


def last_whole_contact(law: Refined) -> float | None:
    """Touch-down of the strongest contact in the last drive periods that the end did not cut [s]."""
    tree = law.best
    if not contacts_hold(tree, "start_time", "duration", "normal_impulse"):
        return None
    starts, end = column(tree, "start_time"), float(series(tree, "time")[-1])
    ends = starts + column(tree, "duration")
    # Other laws touch at other times: their contact shall be whole as well.
    settled = end - 0.5 * law.run.period
    whole = np.flatnonzero((ends < settled) & (starts > end - (PERIODS + 1.0) * law.run.period))
    if not whole.size:
        whole = np.flatnonzero(ends < end)
    if not whole.size:
        return None
    return float(starts[whole[np.argmax(column(tree, "normal_impulse")[whole])]])


def ceiling(contacts: list[Contact]) -> float:
    """Largest normal force that is drawn [N].

    An impact of a rigid law is a spike as high as the record interval is short, beside which all
    other forces would be a line at zero. It ends at one and a half times the largest of what each law
    exerts after the first tenth of its contact.
    """
    bodies = []
    for contact in contacts:
        after = contact.time > IMPACT * contact.duration
        bodies.append(float(np.max(contact.normal[after], initial=0.0)))
    return 1.5 * max(bodies, default=0.0)


def last_periods(law: Refined) -> xarray.Dataset:
    """The series of the last drive periods."""
    root = law.best.to_dataset(inherit=False)
    time = root["time"].values
    first = int(np.searchsorted(time, time[-1] - PERIODS * law.run.period))
    return root.isel(time=slice(max(first - 1, 0), None))


def gap_rate(window: xarray.Dataset) -> tuple[Array, Array]:
    """Gap in the middle of every record interval [m] and its mean rate there [m/s]."""
    gap, time = window["gap"].values, window["time"].values
    return 0.5 * (gap[1:] + gap[:-1]), np.diff(gap) / np.diff(time)


def velocity(tree: xarray.DataTree) -> Array:
    """Rotor velocity over time [rad/s]; NaN where it was not recorded."""
    if not holds(tree, "rotor_velocity"):
        return np.full(series(tree, "time").size, np.nan)
    return series(tree, "rotor_velocity")


def smoothed(law: Refined, values: Array) -> Array:
    """Running median over a drive period: without the records that a moving impact passes."""
    time = series(law.best, "time")
    size = int(np.searchsorted(time, time[0] + law.run.period))
    return np.asarray(median_filter(values, size=max(size, 1), mode="nearest"), dtype=float)
