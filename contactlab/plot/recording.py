"""A recorded run made ready to be drawn, and what an animation shows of it; nothing here knows matplotlib.

The picture of an animation lies in the plane of beam and rotor, its origin at the rotor's lowest point,
lengths in metres of the motor. Rotor and tip have their true size. What moves is magnified: the tip's
displacement along the surface and its gap from the surface, the tip's slope and the angle of the rotor, all
by one factor M. So drawn and true gap vanish together, and a tip that sticks travels with the marks of the
rotor.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import floor, log10
from typing import TYPE_CHECKING, Any, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.laws.base import FREE, SLIP, STICK
from contactlab.parameter import from_cf
from contactlab.results.netcdf import EMPTY, Groups, configuration_of, groups_of
from contactlab.results.summary import prefixed_unit

if TYPE_CHECKING:
    import xarray

COARSE: Final = 20
"""Records in a drive period below which lines between them would invent the motion."""

COLUMNS: Final = 2000
"""Pixel columns of the widest panel: finer detail than this is drawn as its envelope."""

LARGEST: Final = 1e30
"""Beyond this a diverged run is not drawn: the square of an axis range would overflow."""

ROUND_OFF: Final = 1e-9
"""Share of an impact, as a mean force, below which what is left beside it is no lasting force."""

NEEDED: Final = {
    "/": (
        "time", "contact_mode", "natural_frequency", "gap", "tip_tangential_displacement", "tip_slope",
        "rotor_angle", "rotor_velocity", "normal_force", "friction_force",
    ),
    "/contacts": ("start_time", "duration", "stick_duration"),
}  # fmt: skip
"""Variables of the groups of a dataset without which there is no picture."""


class UnfitRunError(ValueError):
    """A dataset that cannot be drawn; the message is a sentence that goes on from its name."""


@final
@dataclass(frozen=True)
class Recording:
    """A recorded run, or a part of one.

    Args:
        series: root variables over time, with a record at or before `start` and one at or after `end`, and
            `lasting_force`, the normal force without impacts.
        contacts: those that lie in the part, wholly or not, a row each.
        attributes: of the dataset.
        start, end: of the part [s].
        tip_length, radius, clearance: of tip end, rotor and the gap at rest [m].
        angle: from the tip's axis to the rotor's centre [rad].
        period: of the first tone, or else of the first natural frequency; endless without both [s].
    """

    series: Mapping[str, Array]
    contacts: Mapping[str, Array]
    attributes: Mapping[Any, Any]
    start: float
    end: float
    tip_length: float
    radius: float
    clearance: float
    angle: float
    period: float

    @property
    def law(self) -> str:
        """Name of the law, or those of a composed law's parts."""
        return law_named_in(self.attributes)

    @property
    def time(self) -> Array:
        """Times of the records [s]."""
        return np.asarray(self.series["time"], dtype=float)

    @property
    def path(self) -> tuple[Array, Array]:
        """The tip end from its place at rest [m], across the line of centres there and along it to the rotor.

        x = -L_tip sin th, y = u - w + L_tip (cos th - 1) with the rotor's way w, turned by the angle beta:
        (x cos beta - y sin beta, x sin beta + y cos beta).
        """
        # 1 - cos th without cancellation.
        versine = 2.0 * np.sin(0.5 * self.series["tip_slope"]) ** 2
        x = self.series["tip_tangential_displacement"]
        lift = self.series.get("rotor_normal_displacement", 0.0)
        y = self.series["tip_normal_displacement"] - lift - self.tip_length * versine
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        # A run that has diverged may not be finite.
        with np.errstate(invalid="ignore"):
            return x * cosine - y * sine, x * sine + y * cosine

    @property
    def coarse(self) -> bool:
        """Whether the records are too far apart to show how the tip moves between them."""
        time = self.time
        # A single record, of a run that failed at once, is a point as well.
        return time.size == 1 or (time.size > 2 and float(time[1] - time[0]) > self.period / COARSE)

    @property
    def impacts(self) -> tuple[Array, Array] | None:
        """Times [s] and normal impulses [N s] of the impacts of a rigid law; None of a compliant one."""
        if "largest_impact" not in self.contacts:
            return None
        begins, impulses = self.contacts["start_time"], self.contacts["largest_impact"]
        within = (begins >= self.start) & (begins <= self.end) & (impulses > 0.0)
        return begins[within], impulses[within]

    @property
    def unit(self) -> tuple[str, float]:
        """Unit of a time axis and its size [s]."""
        return prefixed_unit(self.end - self.start, "s")

    def between(self, start: float, end: float) -> "Recording":
        """Return a part; a start before the first record is the first record."""
        start = max(start, float(self.time[0]))
        first = max(int(np.searchsorted(self.time, start, side="right")) - 1, 0)
        last = int(np.searchsorted(self.time, end)) + 1
        begins = self.contacts["start_time"]
        meets = (begins + self.contacts["duration"] >= start) & (begins <= end)
        return replace(
            self,
            series={name: values[first:last] for name, values in self.series.items()},
            contacts={name: values[meets] for name, values in self.contacts.items()},
            start=start,
            end=end,
        )

    def spans(self) -> dict[str, Array]:
        """Return starts and ends of slip and of stick within the part [s], shape (span, 2)."""
        clipped = {}
        for mode, times in contact_spans(self.series, self.contacts).items():
            meets = (times[:, 1] >= self.start) & (times[:, 0] <= self.end)
            clipped[mode] = np.clip(times[meets], self.start, self.end)
        return clipped


_PARTS: Final = re.compile(r"of normal (\S+), damping (\S+), friction (\S+)$")


def law_named_in(attributes: Mapping[Any, Any]) -> str:
    """Return the name of a dataset's law, or those of a composed law's parts: "hertz_point + dahl".

    Attributes without a `law` name it in their `title`, after a comma.
    """
    title = str(attributes.get("title", ""))
    if parts := _PARTS.search(title):
        return " + ".join(name for name in parts.groups() if name != "none")
    return str(attributes.get("law") or title.rpartition(", ")[2] or "run")


def recording_of(run: "xarray.DataTree | Groups") -> Recording:
    """Take the tree or the groups of a run apart, complete or not.

    Raises:
        UnfitRunError: something is missing, or a length or a frequency is not positive.
    """
    groups = groups_of(run)
    for group, names in NEEDED.items():
        missing = [name for name in names if name not in groups.get(group, EMPTY).variables]
        if missing:
            raise UnfitRunError(f"lacks {', '.join(missing)} in the group {group}")
    root, attributes = groups["/"]
    configuration = configuration_of(attributes)
    try:
        contact, radius = configuration["contact"], float(configuration["rotor"]["radius"])
        tip_length, clearance = float(contact["tip_length"]), float(contact["clearance"])
        angle = float(contact.get("angle", 0.0))
        first = configuration.get("drive", {}).get("frequency")
        frequency = float(first or root["natural_frequency"].values[0])
    except (LookupError, TypeError, ValueError, AttributeError) as fault:
        raise UnfitRunError(
            "lacks contact.tip_length, contact.clearance, rotor.radius or drive.frequency in its attribute "
            "configuration"
        ) from fault
    if not (0.0 < tip_length < np.inf and 0.0 < radius < np.inf and 0.0 <= frequency < np.inf):
        raise UnfitRunError("has a tip length, a rotor radius or a drive frequency that is not positive")
    time, contacts = root["time"].values, groups["/contacts"].values
    series = {str(name): v.values for name, v in root.items() if tuple(v.dims) == ("time",)}
    return Recording(
        series=series | {"lasting_force": _lasting_force(series, contacts)},
        contacts=contacts,
        attributes=attributes,
        start=float(time[0]),
        end=float(time[-1]),
        tip_length=tip_length,
        radius=radius,
        clearance=clearance,
        angle=angle,
        period=1.0 / frequency if frequency else np.inf,
    )


def _lasting_force(series: Mapping[str, Array], contacts: Mapping[str, Array]) -> Array:
    """Return the normal force without impacts [N], means over the record intervals.

    An impact begins a contact, and a record at its time is from before it.
    """
    force, time = series["normal_force"], series["time"]
    if "largest_impact" not in contacts:
        return force
    after = np.searchsorted(time, contacts["start_time"], side="right")
    within = (after > 0) & (after < time.size)
    after, impulses = after[within], contacts["largest_impact"][within]
    sums = np.zeros_like(force)
    np.add.at(sums, after, impulses / (time[after] - time[after - 1]))
    left = force - sums
    return np.where(np.abs(left) > ROUND_OFF * sums, left, 0.0)


def contact_spans(series: Mapping[str, Array], contacts: Mapping[str, Array]) -> dict[str, Array]:
    """Return starts and ends of slip and of stick in the order of time [s], shape (span, 2).

    A contact begins and ends when its row says so; inside, the mode changes half-way between two
    records that differ. A contact without a record inside takes the mode of its larger part.
    """
    starts, duration = contacts["start_time"], contacts["duration"]
    ends = starts + duration
    time, mode = series["time"], series["contact_mode"]
    owner = np.searchsorted(starts, time, side="right") - 1
    inside = (mode > 0) & (owner >= 0)
    inside[inside] = time[inside] <= ends[owner[inside]]
    time, mode, owner = time[inside], mode[inside], owner[inside]

    unseen = np.setdiff1d(np.arange(starts.size), owner)
    sticks = contacts["stick_duration"][unseen] >= 0.5 * duration[unseen]
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


def handy_unit(values: Iterable[Array | float], units: str) -> tuple[str, float]:
    """Return the unit in which values are handy numbers, empty for a number, and its size in SI.

    Only units without exponents have prefixes.

    Args:
        values: [SI] what is drawn together; values that are not finite do not count.
        units: in the words of the CF conventions.
    """
    largest = max((float(np.max(np.abs(x), initial=0.0, where=np.isfinite(x))) for x in values), default=0.0)
    if units.replace(" ", "").isalpha() and largest > 0.0:
        return prefixed_unit(largest, units)
    return ("" if units == "1" else from_cf(units)), 1.0


def extent(values: Array) -> tuple[float, float]:
    """Return the middle and the width of the values that can be drawn; zeros where none can."""
    if not np.isfinite(values).any():
        return 0.0, 0.0
    least, most = float(np.nanmin(values)), float(np.nanmax(values))
    return 0.5 * (most + least), most - least


def drawable(values: Array) -> Array:
    """Leave a gap where a diverged run has nothing that could be drawn."""
    return np.where(np.abs(values) < LARGEST, values, np.nan)


def envelope(x: Array, y: Array) -> tuple[Array, Array]:
    """Return a line that looks the same on `COLUMNS` pixel columns, in four points a column.

    Every column keeps its first and its last point and spans its smallest to its largest value,
    so no peak is lost and no slope is drawn that is not there.
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
    """Return the line of means over intervals: horizontal over each, vertical between two."""
    return envelope(np.repeat(edges, 2)[1:-1], np.repeat(drawable(means), 2))


REACH: Final = 0.1
"""How far the drawn vibration may reach, in parts of the smaller of tip length and rotor radius."""

LITTLE: Final = 1e-9
"""Pace of the clock that counts time in contact, where there is none."""


@final
@dataclass(frozen=True)
class Film:
    """What is shown, one value a frame.

    Args:
        run: the part of a run that is shown.
        magnification: M.
        time: of the frames [s], the ends of equal intervals of the part.
        tangential, gap, slope, angle, velocity: of the tip end [m], the tip [rad] and the rotor
            [rad, rad/s] at these times.
        normal, friction: force on the tip [N], mean since the frame before, so that no impact falls
            between two frames.
        mode: contact mode since the frame before: free if there was no contact, else what lasted
            longer.
    """

    run: Recording
    magnification: float
    time: Array
    tangential: Array
    gap: Array
    slope: Array
    angle: Array
    velocity: Array
    normal: Array
    friction: Array
    mode: NDArray[np.int8]

    @property
    def size(self) -> float:
        """Length that sets the scale of the picture [m]."""
        return min(self.run.tip_length, self.run.radius)

    @property
    def peak(self) -> float:
        """Largest force of any frame [N], 1 if there is none."""
        return float(np.nanmax(np.hypot(self.normal, self.friction), initial=0.0)) or 1.0

    def tip_end(self, tangential: Array, gap: Array) -> Array:
        """Return the points where tip ends are drawn [m], shape (point, 2)."""
        angle = self.magnification * tangential / self.run.radius
        height = self.magnification * gap
        # 1 - cos without cancellation.
        versine = 2.0 * np.sin(0.5 * angle) ** 2
        return np.column_stack(
            ((self.run.radius + height) * np.sin(angle), self.run.radius * versine - height * np.cos(angle))
        )

    def axes_of_contact(self, frame: int) -> tuple[Array, Array]:
        """Return the normal at the tip, from the rotor's centre, and the tangent in the picture."""
        angle = self.magnification * self.tangential[frame] / self.run.radius
        sine, cosine = np.sin(angle), np.cos(angle)
        return np.array((sine, -cosine)), np.array((cosine, sine))

    def force_on_rotor(self, frame: int) -> Array:
        """Return the force on the rotor in the axes of the picture [N], shape (2,)."""
        normal, tangent = self.axes_of_contact(frame)
        return np.asarray(-self.normal[frame] * normal - self.friction[frame] * tangent)


def film_of(run: Recording, start: float, end: float, frames: int) -> Film:
    """Choose what a number of frames show of a run, from start to end [s].

    Raises:
        UnfitRunError: this part has diverged.
    """
    run = run.between(start, end)
    edges, time = np.linspace(start, end, frames + 1), run.time
    spans = contact_spans(run.series, run.contacts)
    size = min(run.tip_length, run.radius)

    def recorded(name: str) -> Array:
        return drawable(np.asarray(run.series[name], dtype=float))

    def at_frames(name: str) -> Array:
        return np.interp(edges[1:], time, recorded(name))

    def motion(values: Array) -> Array:
        # What is larger than the motor itself has diverged.
        values = np.where(np.abs(values) < size, values, np.nan)
        if not np.isfinite(values).any():
            raise UnfitRunError(f"has diverged between {start:g} s and {end:g} s, there is nothing to draw")
        return values

    def clock(times: Array) -> Array:
        # Recorded forces are means over an interval, of which a contact may have been a part only: the
        # impulse belongs to that part, and where there was none to all of the interval.
        return LITTLE * times + sum(_time_spent(times, those) for those in spans.values())

    def means(name: str) -> Array:
        impulse = np.concatenate(([0.0], np.cumsum(recorded(name)[1:] * np.diff(time))))
        mean = np.diff(np.interp(clock(edges), clock(time), impulse)) / np.diff(edges)
        # What is left of a difference of sums is no force.
        return np.where(np.abs(mean) > 1e-6 * np.nanmax(np.abs(mean), initial=0.0), mean, 0.0)

    tangential, gap = motion(drawable(run.path[0])), motion(recorded("gap"))
    reach, magnification = float(np.nanmax(np.abs((tangential, gap)))), 1.0
    if reach > 0.0:
        # The largest 1, 2 or 5 times a power of ten that keeps the vibration in the picture.
        largest = REACH * size / reach
        magnifications = 10.0 ** floor(log10(largest)) * np.array([1.0, 2.0, 5.0])
        magnification = float(magnifications[magnifications <= largest * (1.0 + 1e-9)].max())
    return Film(
        run=run,
        magnification=magnification,
        time=edges[1:],
        tangential=np.interp(edges[1:], time, tangential),
        gap=np.interp(edges[1:], time, gap),
        slope=at_frames("tip_slope"),
        angle=at_frames("rotor_angle"),
        velocity=at_frames("rotor_velocity"),
        normal=means("normal_force"),
        friction=means("friction_force"),
        mode=_modes(edges, run, spans),
    )


def _modes(edges: Array, run: Recording, spans: dict[str, Array]) -> NDArray[np.int8]:
    """Return the contact mode of every interval between edges."""
    lasted = {mode: np.diff(_time_spent(edges, times)) for mode, times in spans.items()}
    # A contact of no duration is one all the same.
    starts = np.searchsorted(run.contacts["start_time"], edges, side="right")
    touched = (np.diff(starts) > 0) | (lasted["slip"] + lasted["stick"] > 0.0)
    sticks = (lasted["stick"] > 0.0) & (lasted["stick"] >= lasted["slip"])
    return np.where(touched, np.where(sticks, STICK, SLIP), FREE).astype(np.int8)


def _time_spent(time: Array, spans: Array) -> Array:
    """Return how much of disjoint, ascending spans lies before a time."""
    if not spans.size:
        return np.zeros_like(time)
    lengths = spans[:, 1] - spans[:, 0]
    after = np.cumsum(lengths)
    return np.interp(time, spans.ravel(), np.column_stack((after - lengths, after)).ravel())
