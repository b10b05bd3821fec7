"""Tracks of a body: its free flights, and the velocities at the impacts between them.

Between impacts a body with gravity g along -y moves, with s the time since the mean of its samples, by

    x = x_m + v_x s,    y = y_m + v_y s - g s^2/2,    angle = a_m + w s

fitted to each flight by least squares. Two flights meet along the normal n of the surface at the instant t of
the impact, n . (r_before(t) - r_after(t)) = 0, which is linear in t, as both fall alike. Errors of the fits
propagate linearly to t and to the velocities then. Each coordinate has a noise of its own, which follows from
the residuals of all flights.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from typing import Any, Final, NamedTuple, final

import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.special import chdtri, ndtri

from contactlab.arrays import Array
from contactlab.estimate import Estimate
from contactlab.motor.table import MeasurementError, Table, refuse
from contactlab.parameter import from_cf
from contactlab_data.measured.bodies import BodyImpacts, sign_note
from contactlab_data.measured.columns import jacobian_is_checked
from contactlab_data.measured.impacts import MeasuredImpacts

CHANCE: Final = 0.01
"""Probability that noise adds a break to a file, and that it fails one kind of check of its impacts."""

FEWEST: Final = 5
"""Smallest number of samples of a flight: then it has more residuals than parameters."""

MOST_BETWEEN: Final = 2
"""Largest number of samples of neither flight at an impact: a line through two fits always."""

GRAVITY: Final = 9.81
"""Default of the acceleration along -y [m/s^2]."""

POSITIONS: Final = {"x": "m", "y": "m", "angle": "rad"}
"""Coordinates with their units; the angle is optional."""

CONSTANTS: Final = ("mass", "inertia", "radius", "scale", "gravity", "normal_x", "normal_y", "height")
"""Names of what is stated once for all samples."""

_VERTICAL: Final = 1
_PIXEL: Final = "px"
_ROUNDS: Final = 20


@final
@dataclass(frozen=True, eq=False)
class Motion:
    """Samples of a body, in SI.

    Args:
        time: increasing within a track, shape (sample,).
        position: x, y and the angle if it is measured, shape (sample, coordinate).
        track: label of the track, shape (sample,); its samples are in a row.
        gravity: acceleration along -y.
        normal, tangential: rows of the contact Jacobian, shape (coordinate,).
        mass: mass or moment of inertia, shape (coordinate,).
    """

    time: Array
    position: Array
    track: NDArray[np.float64]
    gravity: float
    normal: Array
    tangential: Array
    mass: Array

    @property
    def parts(self) -> list[tuple[int, int]]:
        """First sample and end of each track."""
        return [*pairwise([0, *(np.flatnonzero(np.diff(self.track)) + 1).tolist(), len(self.track)])]


class Phase(NamedTuple):
    """Motion between two breaks, fitted as a flight.

    Attributes:
        start, end: first sample, and the one after the last.
        time: mean of the samples' times.
        position, velocity: at that time, the position as if there were no fall since, shape (coordinate,).
        spread: sum of s^2 [s^2].
        squares: sums of squared residuals of the flight, shape (coordinate,).
        straight: that of y about a straight line [m^2].
        fall, bend: acceleration along -y by a fit that leaves it free [m/s^2], and its information [s^4].
    """

    start: int
    end: int
    time: float
    position: Array
    velocity: Array
    spread: float
    squares: Array
    straight: float
    fall: float
    bend: float

    @classmethod
    def of(cls, motion: Motion, start: int, end: int) -> "Phase":
        """Fit the samples from start to end."""
        time, position = motion.time[start:end], motion.position[start:end]
        s = time - time.mean()
        spread, curve = float(s @ s), 0.5 * s**2
        bent = curve - curve.mean() - s * (s @ curve) / spread
        raised = position - position[0]
        raised[:, _VERTICAL] += motion.gravity * curve
        middle = raised.mean(axis=0)
        velocity = s @ (raised - middle) / spread
        residuals = raised - middle - np.outer(s, velocity)
        bend, squares = float(bent @ bent), np.sum(residuals**2, axis=0)
        straight = float(np.sum((residuals[:, _VERTICAL] - motion.gravity * bent) ** 2))
        fall = motion.gravity - float(bent @ residuals[:, _VERTICAL]) / bend
        middle += position[0]
        return cls(start, end, float(time.mean()), middle, velocity, spread, squares, straight, fall, bend)

    def at(self, time: float | Array, fall: Array) -> tuple[Array, Array]:
        """Return position and velocity at some times, shapes (..., coordinate), by acceleration -fall."""
        s = np.asarray(time - self.time)[..., None]
        return self.position + self.velocity * s - 0.5 * fall * s**2, self.velocity - fall * s

    def flies(self, motion: Motion, noise: Array, chance: float) -> bool:
        """Return whether it falls or moves along the normal, which noise feigns with a small probability."""
        falling = abs(self.fall) * self.bend**0.5 / noise[_VERTICAL]
        error = (np.sum((motion.normal * noise) ** 2) / self.spread) ** 0.5
        moving = abs(motion.normal @ self.velocity) / error
        return bool(motion.gravity == 0.0 or max(falling, moving) > _bound(chance))


class Break(NamedTuple):
    """Break between two phases, and why it is no impact; no reason if it is.

    Attributes:
        track: its label.
        time, position: of the break.
        velocity: before and after, shape (2 coordinate,), with its covariance.
        reach: largest distance from the surface that errors and the time between the flights explain [m].
        reason: a few words.
    """

    track: float
    time: float
    position: Array
    velocity: Array
    covariance: Array
    reach: float
    reason: str


def phases_of(motion: Motion) -> tuple[list[Phase], Array]:
    """Return the phases of a motion, and the noise of each coordinate, shape (coordinate,).

    The breaks minimise the sum of the chi-squares of all phases, each a flight or a straight line, and of a
    penalty for each break: the chi-square that the parameters of another phase take off by chance with the
    probability `CHANCE` anywhere in the file. The noise follows from the residuals, over samples less
    parameters, and begins with the median second difference.

    Raises:
        MeasurementError: no phase has `FEWEST` samples.
    """
    size = len(motion.time)
    # Rounding of the sums of squares of so many samples.
    least = np.ptp(motion.position, axis=0) * (np.finfo(float).eps * size) ** 0.5 + 1e-100
    noise = np.maximum(_rough_noise(motion), least)
    penalty = float(chdtri(2 * motion.position.shape[1], CHANCE / size))
    phases, ends = list[Phase](), list[tuple[int, int]]()
    for _ in range(_ROUNDS):
        before, ends = ends, [x for part in motion.parts for x in _pieces(motion, part, noise, penalty)]
        if ends == before:
            break
        phases = [Phase.of(motion, *each) for each in ends if each[1] - each[0] >= FEWEST]
        if not phases:
            raise MeasurementError(
                f"no {FEWEST} samples in a row follow a flight or a line; check time, scale and gravity."
            )
        squares = np.sum([each.squares for each in phases], axis=0)
        squares[_VERTICAL] = sum(min(each.squares[_VERTICAL], each.straight) for each in phases)
        freedom = sum(each.end - each.start - 2 for each in phases)
        noise = np.maximum((squares / freedom) ** 0.5, least)
    return phases, noise


def _rough_noise(motion: Motion) -> Array:
    """Return the noise by the median second difference, which breaks do not move, shape (coordinate,)."""
    result = []
    for start, end in motion.parts:
        time, position = motion.time[start:end], motion.position[start:end]
        fallen = position[:, _VERTICAL] + 0.5 * motion.gravity * (time - time[0]) ** 2
        every = np.column_stack([position, fallen])
        late = ((time[1:-1] - time[:-2]) / (time[2:] - time[:-2]))[:, None]
        second = every[1:-1] - (1.0 - late) * every[:-2] - late * every[2:]
        result.append(np.abs(second) / np.sqrt(1.0 + (1.0 - late) ** 2 + late**2))
    middle = np.median(np.concatenate(result), axis=0) / ndtri(0.75)
    middle[_VERTICAL] = min(middle[_VERTICAL], middle[-1])
    # Positions in whole pixels have no smaller noise than their rounding.
    steps = [np.diff(np.unique(column)) for column in motion.position.T]
    rounding = np.array([step.min() if step.size else 0.0 for step in steps]) / 12.0**0.5
    return np.asarray(np.maximum(middle[:-1], rounding))


def _pieces(motion: Motion, part: tuple[int, int], noise: Array, penalty: float) -> list[tuple[int, int]]:
    """Return first samples and ends of the phases of a track, by optimal partitioning with pruning (PELT)."""
    first, last = part
    least, starts = np.zeros(last - first + 1), np.zeros(last - first + 1, dtype=np.int64)
    candidates = np.empty(0, dtype=np.int64)
    for size in range(1, last - first + 1):
        candidates = np.append(candidates, size - 1)
        chi_squares = _chi_squares(motion, first + int(candidates[0]), first + size, noise)
        total = least[candidates] + chi_squares[candidates - candidates[0]]
        starts[size], least[size] = candidates[np.argmin(total)], total.min() + penalty
        candidates = candidates[total <= least[size]]
    ends = [last - first]
    while ends[-1]:
        ends.append(int(starts[ends[-1]]))
    return [(first + start, first + end) for end, start in pairwise(ends)][::-1]


def _chi_squares(motion: Motion, start: int, end: int, noise: Array) -> Array:
    """Return the chi-square of the better kind of phase from each sample to the end, shape (sample,)."""
    time, position = motion.time[start:end][::-1], motion.position[start:end][::-1]
    # Relative to the last sample, so that sums over long tracks do not cancel.
    s, values = time - time[0], (position - position[0]) / noise
    fallen = values[:, _VERTICAL] + 0.5 * motion.gravity / noise[_VERTICAL] * s**2
    values = np.column_stack([values, fallen])
    count, sum_s, sums = np.arange(1.0, len(s) + 1.0), np.cumsum(s), np.cumsum(values, axis=0)
    spread = np.cumsum(s**2) - sum_s**2 / count
    slope = np.cumsum(s[:, None] * values, axis=0) - (sum_s / count)[:, None] * sums
    squares = np.cumsum(values**2, axis=0) - sums**2 / count[:, None]
    squares[1:] -= slope[1:] ** 2 / spread[1:, None]
    squares[:2] = 0.0
    worse = np.maximum(squares[:, _VERTICAL], squares[:, -1])
    return np.asarray(np.maximum(squares.sum(axis=1) - worse, 0.0)[::-1])


def breaks_of(motion: Motion, phases: Sequence[Phase], noise: Array, height: float | None) -> list[Break]:
    """Return the breaks before or after a flight, with the reasons of those that are no impacts.

    Args:
        motion: of all tracks.
        phases: of `FEWEST` samples and more.
        noise: of each coordinate, shape (coordinate,).
        height: of the surface along its normal [m]; None is the median of the impacts.
    """
    pairs = [(a, b) for a, b in pairwise(phases) if motion.track[a.start] == motion.track[b.start]]
    pairs = [pair for pair in pairs if any(each.flies(motion, noise, CHANCE) for each in pair)]
    result = [_break(motion, *pair, noise, CHANCE / len(pairs)) for pair in pairs]
    heights = np.array([motion.normal @ each.position for each in result])
    impacts = [not each.reason for each in result]
    if height is None and any(impacts):
        height = float(np.median(heights[impacts]))
    for place, each in enumerate(result):
        if not each.reason and height is not None and abs(heights[place] - height) > each.reach:
            result[place] = each._replace(reason="distance from the surface")
    return result


def _bound(chance: float) -> float:
    """Return the absolute value that a standard normal variable exceeds with a probability."""
    return -float(ndtri(0.5 * chance))


def _break(motion: Motion, before: Phase, after: Phase, noise: Array, chance: float) -> Break:
    """Return the break between two phases; each check fails a true impact with the probability `chance`."""
    size, normal, bound, both = len(noise), motion.normal, _bound(chance), (before, after)
    fall = np.where(np.arange(size) == _VERTICAL, motion.gravity, 0.0)
    last, first = motion.time[before.end - 1], motion.time[after.start]
    middle = float(0.5 * (last + first))
    (left, old), (right, new) = before.at(middle, fall), after.at(middle, fall)
    change, noise_n = float(normal @ (new - old)), float(np.sum((normal * noise) ** 2))
    turns = abs(change) > bound * (noise_n / before.spread + noise_n / after.spread) ** 0.5
    # Without a change there is no instant.
    inverse = 1.0 / change if turns else 0.0
    time = middle + float(normal @ (left - right)) * inverse
    (place, old), (_, new) = before.at(time, fall), after.at(time, fall)
    # Rows are linear in the errors of position and velocity before, then after, which are independent.
    variances = np.concatenate([noise**2 / n for each in both for n in (each.end - each.start, each.spread)])
    position = np.concatenate([normal, normal * (time - before.time), np.zeros(2 * size)])
    apart = position - np.concatenate([np.zeros(2 * size), normal, normal * (time - after.time)])
    instant = apart * inverse
    rows = np.kron([[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]], np.eye(size))
    rows -= np.outer(np.tile(fall, 2), instant)
    covariance, velocity = rows * variances @ rows.T, np.concatenate([old, new])

    def beyond(row: Array, share: float = 1.0) -> bool:
        """Return whether a function of the velocities with a gradient is positive beyond its error."""
        return bool(share * (row @ velocity) > bound * (row @ covariance @ row) ** 0.5)

    still = np.zeros(size)
    incoming, outgoing = np.append(normal, still), np.append(still, normal)
    # Noise of half the distance between the flights moves a sample next to the instant to the other flight.
    early = bound * float(instant**2 @ variances + 4.0 * noise_n * inverse**2) ** 0.5
    passed = {
        f"more than {MOST_BETWEEN} samples of no flight": after.start - before.end <= MOST_BETWEEN,
        "rest, or too short a flight": all(each.flies(motion, noise, chance) for each in both),
        "a residual above the noise": all(
            np.sum(each.squares / noise**2) <= chdtri(size * (each.end - each.start - 2), chance)
            for each in both
        ),
        "no change of the normal velocity": turns,
        "no meeting of the flights": last - early <= time <= first + early,
        "no approach before": beyond(-incoming),
        "an approach after": not beyond(-outgoing),
        "a gain of energy": not beyond(np.tile(motion.mass, 2) * np.append(-old, new), 0.5),
    }
    height = position + (normal @ old) * instant
    # A contact lasts no longer than the gap between the flights, and the body approaches no faster meanwhile.
    reach = bound * float(height**2 @ variances) ** 0.5 + float(abs(normal @ old) * (first - last))
    reason = next((text for text, good in passed.items() if not good), "")
    if not passed["no meeting of the flights"]:
        time, place = middle, 0.5 * (left + right)
    return Break(float(motion.track[before.start]), time, place, velocity, covariance, reach, reason)


def impacts_of_tracks(table: Table, title: str) -> MeasuredImpacts:
    """Return the impacts of a table of positions over time, with their tracks; the title is the default one.

    Raises:
        MeasurementError: a column is missing, unknown or in a wrong unit, times do not increase, or there is
            no impact.
    """
    motion, height = _motion(table)
    phases, noise = phases_of(motion)
    breaks = breaks_of(motion, phases, noise, height)
    sentences = _sentences(motion, phases, noise, breaks)
    number = np.array([at for at, each in enumerate(breaks, 1) if not each.reason], dtype=np.int64)
    if not number.size:
        raise MeasurementError(f"it has no impact. {' '.join(sentences)}")
    impacts, size = [breaks[at - 1] for at in number], len(noise)
    velocity = np.array([each.velocity for each in impacts])
    covariance = np.array([each.covariance for each in impacts])
    geometry = np.diag(motion.mass), motion.normal, motion.tangential
    mass, normal, tangential = (np.broadcast_to(x, (number.size, *x.shape)) for x in geometry)
    jump = np.kron([-1.0, 1.0], np.eye(size))
    bodies = BodyImpacts(
        *(velocity[:, :size], velocity[:, size:], mass, normal, tangential),
        covariance=jump @ covariance @ jump.T,
        rotation=2 if size > 2 else None,
    )
    # Errors before and after depend on each other by the instant. The former act on the gap rate after by the
    # measured restitution, and on the slip at most by themselves.
    passed = -bodies.jacobian
    passed[:, 0] *= (bodies.contact(bodies.after) / bodies.contact(bodies.before))[:, :1]
    errors = np.concatenate([passed, bodies.jacobian], axis=2)
    texts = table.texts
    keep = jacobian_is_checked(texts, applies=size > 2)
    notes = [*texts.get("note", "").splitlines(), *sentences]
    if size > 2:
        angles = {name: unit == "rad" for name, unit in POSITIONS.items()}
        notes.append(sign_note(bodies, angles, keep=keep))
    return MeasuredImpacts.of_bodies(
        bodies,
        covariance=errors @ covariance @ errors.transpose(0, 2, 1),
        title=texts.get("title", title),
        source=texts.get("source", ""),
        licence=texts.get("licence", ""),
        left_out=len(breaks) - number.size,
        number=number,
        notes=tuple(notes),
        # Impacts of a track share a flight.
        measurement=np.array([int(x.track) for x in impacts]) if len(motion.parts) > 1 else None,
        tracks=_dataset(motion, phases, breaks, sentences),
    )


def _motion(table: Table) -> tuple[Motion, float | None]:
    """Return the motion in a table, and the height of the surface if it is stated."""
    names = [name for name in POSITIONS if name in table.names]
    turns, scaled = "angle" in names, _PIXEL in map(table.unit, table.names)
    idle = (*(() if turns else ("inertia", "radius")), *(() if scaled else ("scale",)))
    table.check_names(name for name in ("time", *POSITIONS, "track", *CONSTANTS) if name not in idle)

    def number(name: str, units: str, default: float | None = None, above: float = -inf) -> float:
        if name not in table.names and default is not None:
            return default
        if name not in table.names:
            raise MeasurementError(
                f"{name} is missing; it must be stated, as '# {name}: 1 {from_cf(units)}'."
            )
        values = column(name, units)
        odd = (values != values[0]) | ~(values > above)
        limit = f" and greater than {above:g}" if above > -inf else ""
        refuse(
            odd, lambda at: f"{name} is {values[at]:g} in {table.places[at]}; it must be a constant{limit}."
        )
        return float(values[0])

    def column(name: str, units: str) -> Array:
        if table.unit(name) == _PIXEL and units == "m":
            return table.numbers(name, _PIXEL) * number("scale", "m px-1", above=0.0)
        return table.numbers(name, units)

    track = table.numbers("track", "1") if "track" in table.names else np.ones(len(table.places))
    refuse(track % 1.0 != 0.0, lambda at: f"track is {track[at]:g} in {table.places[at]}; it must be whole.")
    order = np.argsort(track, kind="stable")
    time, track = column("time", "s")[order], track[order]
    late = (np.diff(time) <= 0.0) & (np.diff(track) == 0.0)
    refuse(
        late,
        lambda at: (
            f"time is {time[at + 1]:.9g} s in {table.places[order[at + 1]]}; it must be greater than "
            f"{time[at]:.9g} s, that of the row before."
        ),
    )
    position = np.column_stack([column(name, POSITIONS[name])[order] for name in names])
    gravity, mass = number("gravity", "m s-2", GRAVITY), [number("mass", "kg", above=0.0)] * 2
    up = complex(number("normal_x", "1", 0.0), number("normal_y", "1", -1.0 if gravity < 0.0 else 1.0))
    if not up:
        raise MeasurementError("normal_x and normal_y are 0; one of them must not be.")
    up /= abs(up)
    normal, tangential = [up.real, up.imag], [up.imag, -up.real]
    if turns:
        normal, tangential = [*normal, 0.0], [*tangential, number("radius", "m", above=0.0)]
        mass.append(number("inertia", "kg m2", above=0.0))
    rows = (np.array(x) for x in (normal, tangential, mass))
    motion = Motion(time, position, track, gravity, *rows)
    for start, end in motion.parts:
        if end - start < 2 * FEWEST:
            raise MeasurementError(
                f"track {track[start]:g} has {end - start} samples; it must have at least {2 * FEWEST}, "
                f"{FEWEST} before and {FEWEST} after an impact."
            )
        position[start:end, 2:] = np.unwrap(position[start:end, 2:], axis=0)
    return motion, number("height", "m") if "height" in table.names else None


def _sentences(motion: Motion, phases: Sequence[Phase], noise: Array, breaks: Sequence[Break]) -> list[str]:
    """Return sentences on the impacts, the breaks that are none, the noise, and the fall of the flights."""
    reasons = [each.reason for each in breaks]
    sizes = [f"{each:.3g} {unit} in {x}" for each, (x, unit) in zip(noise, POSITIONS.items(), strict=False)]
    result = [
        f"{reasons.count('')} of {len(breaks)} breaks in the tracks are impacts.",
        f"The noise of the positions is {', '.join(sizes)}, by the residuals of the flights.",
    ]
    for reason in dict.fromkeys(filter(None, reasons)):
        numbers = ", ".join(f"{at}" for at, each in enumerate(reasons, 1) if each == reason)
        result.append(f"Breaks with {reason}, left out: {numbers}.")
    flights = [each for each in phases if each.squares[_VERTICAL] <= each.straight]
    if motion.gravity and flights:
        weight = sum(each.bend for each in flights)
        fall, error = sum(x.bend * x.fall for x in flights) / weight, float(noise[_VERTICAL]) / weight**0.5
        if abs(fall - motion.gravity) > _bound(CHANCE) * error:
            result.append(
                f"Warning: flights fall by {Estimate(fall, error).text()} m/s^2; gravity is "
                f"{motion.gravity:g}. Check scale and times; the air may slow the body down."
            )
    return result


def _dataset(
    motion: Motion, phases: Sequence[Phase], breaks: Sequence[Break], sentences: Sequence[str]
) -> xarray.Dataset:
    """Return samples with their flights, and breaks, in SI."""
    fitted, size = np.full_like(motion.position, np.nan), motion.position.shape[1]
    fall = np.where(np.arange(size) == _VERTICAL, motion.gravity, 0.0)
    for each in phases:
        if each.squares[_VERTICAL] <= each.straight:
            fitted[each.start : each.end] = each.at(motion.time[each.start : each.end], fall)[0]
    variables: dict[str, Any] = {
        "sample_track": ("sample", motion.track),
        "sample_time": ("sample", motion.time, {"units": "s"}),
        "sample_position": (("sample", "coordinate"), motion.position),
        "flight_position": (("sample", "coordinate"), fitted),
        "break_track": ("break", [each.track for each in breaks]),
        "break_time": ("break", [each.time for each in breaks], {"units": "s"}),
        "break_position": (("break", "coordinate"), [each.position for each in breaks]),
        "reason": ("break", np.array([each.reason for each in breaks], dtype=object)),
    }
    about = {"gravity": motion.gravity, "findings": "\n".join(sentences)}
    return xarray.Dataset(variables, {"coordinate": [*POSITIONS][:size]}, about)
