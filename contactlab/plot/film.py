"""What an animation shows, frame by frame; nothing here knows matplotlib.

The picture lies in the plane of beam and rotor, its origin at the rotor's lowest point, lengths in
metres of the motor. Rotor and tip have their true size. What moves is magnified: the tip's
displacement along the surface and its gap from the surface, the tip's slope and the angle of the
rotor, all by one factor M. So drawn and true gap vanish together, and a tip that sticks travels with
the marks of the rotor.
"""

from dataclasses import dataclass
from math import floor, log10
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.laws.base import FREE, SLIP, STICK
from contactlab.plot.recording import Recording, UnfitRunError, contact_spans, drawable

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
        steps = 10.0 ** floor(log10(largest)) * np.array([1.0, 2.0, 5.0])
        magnification = float(steps[steps <= largest * (1.0 + 1e-9)].max())
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
