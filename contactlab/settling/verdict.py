"""Whether a run has settled, to which velocity and in what kind of motion, from its recorded periods."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import floor, inf, isfinite, isnan, nan
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.estimate import Estimate
from contactlab.motor.drive import Drive, NoPeriodError, period_of
from contactlab.settling.statistics import (
    LEAST_VALUES,
    PERIODIC,
    REPEATS,
    WITHOUT_CONTACT,
    approach,
    kind_without_period,
    repeats_after,
)
from contactlab.variables import INTERNAL

Columns = Mapping[str, NDArray[Any]]

COARSEST: Final = 1.0 / 8.0
"""Largest record interval over the period: at longer ones the rotor's angle between records is not known."""

CLOCK: Final = 1e-9
"""Round-off of the times, over the period."""

SETTLED, UNSETTLED, INCONCLUSIVE = "settled", "not settled", "inconclusive"

SHARE: Final = 0.01
"""Largest relative error of the velocity of a settled motor: less than laws differ by."""

AS_GOOD_AS_NONE: Final = 0.01
"""Velocity over its change since the start, below which a rotor comes to rest."""

FADING: Final = 0.9
"""Ratio of the last quarter's fluctuation to the one before, below which it decays."""

LATE: Final = 4
"""Number of equal parts of a run of which the last one is examined for contacts."""

DIGITS: Final = 6
"""Largest number of significant digits of an extrapolated number."""


def drive_period(drive: Drive) -> float:
    """Return the period of a drive [s]; zero where it has none."""
    try:
        return period_of(drive)
    except NoPeriodError:
        return 0.0


def configured_period(configuration: Mapping[str, Any]) -> float:
    """Return the period of a configuration's drive [s], else that of its first tone, else zero."""
    section = configuration.get("drive")
    drive = section if isinstance(section, Mapping) else {}
    try:
        return drive_period(Drive.two_mode(**{k: x for k, x in drive.items() if k != "signal"}))
    except (TypeError, ValueError):
        first = drive.get("frequency")
        return 1.0 / first if isinstance(first, int | float) and first > 0.0 else 0.0


class UnknownError(ValueError):
    """It is unknown whether a motor has settled; the message follows 'inconclusive:'.

    Args:
        reason: the message.
        longer: whether a longer run would help.
    """

    def __init__(self, reason: str, *, longer: bool = False) -> None:
        super().__init__(reason)
        self.longer = longer


@final
@dataclass(frozen=True)
class Periods:
    """Whole periods of the drive, counted back from the end.

    They begin in the middle of the longest pause between touch-downs, so that each has its own contacts.

    Args:
        velocity: mean rotor velocity of each [rad/s].
        ripple: range of the rotor velocity within the last [rad/s].
        blur: error of the mean velocity over their last half by the angle between records [rad/s]: at either
            end at most a quarter of the record interval times the change of the velocity within it.
        least_gap: of each [m].
        impulse: normal impulse of the contacts that begin in each [N s].
        touching: whether a contact begins, lasts or ends in each.
        memory: internal variables of the run at the end of each, and their range within the last, by name.
    """

    velocity: Array
    ripple: float
    blur: float
    least_gap: Array
    impulse: Array
    touching: NDArray[np.bool_]
    memory: Mapping[str, tuple[Array, float]]


def periods_of(columns: Columns, rows: Columns, length: float, lasting: Iterable[str] = ()) -> Periods:
    """Divide a run into periods of the drive, at least `LEAST_VALUES`.

    The angle at the ends of a period is Hermite's cubic between the records around it, and the impulses are
    those of whole contacts: neither depends on where the records lie.

    Args:
        columns, rows: series and contacts, see `contactlab.variables`.
        length: period of the drive [s]; zero where there is none.
        lasting: names of the series of internal variables whose life is the run.

    Raises:
        UnknownError: a number is missing or not finite, the drive has no period, the records are too far
            apart, or the run is too short.
    """
    names = ("time", "rotor_angle", "rotor_velocity", "gap")
    if missing := [name for name in names if name not in columns]:
        raise UnknownError(f"the run has no {' and no '.join(missing)}")
    time, angle, velocity, gap = (np.asarray(columns[name], dtype=np.float64) for name in names)
    starts, impulses, separations = (
        np.asarray(rows.get(name, ()), dtype=np.float64)
        for name in ("start_time", "normal_impulse", "separation_velocity")
    )
    if starts.size != impulses.size:
        raise UnknownError("the run's contacts have no impulse")
    memory = {name: np.asarray(columns[name], dtype=np.float64) for name in lasting}
    if not all(
        np.isfinite(x).all() for x in (time, angle, velocity, gap, starts, impulses, *memory.values())
    ):
        raise UnknownError("some of the run's numbers are not finite")
    if not length > 0.0:
        raise UnknownError("the drive has no period")
    widest = float(np.diff(time).max(initial=0.0))
    if widest > COARSEST * length:
        raise UnknownError(
            f"records lie {widest:.3g} s apart, more than an eighth of the drive's period, {length:.3g} s; "
            "use a smaller record.interval"
        )
    cut = np.isnan(separations) if separations.size == starts.size else np.zeros(starts.size, dtype=bool)
    whole_until = float(starts[cut].min(initial=time[-1]))
    durations = np.asarray(rows.get("duration", np.zeros(starts.size)), dtype=np.float64)
    releases = (starts + (durations if durations.size == starts.size else 0.0))[~cut]
    starts, impulses = starts[~cut], impulses[~cut]
    end = float(time[-1]) - _pause((time[-1] - starts[starts > 0.5 * (time[0] + time[-1])]) / length) * length
    # The impulse of a contact that the end cuts is not whole.
    end -= length if end > whole_until else 0.0
    count = floor((end - time[0]) / length + CLOCK)
    if count < LEAST_VALUES:
        raise UnknownError(
            f"the run has {max(count, 0)} whole periods of the drive, and at least {LEAST_VALUES} are needed",
            longer=True,
        )
    ends = end - length * np.arange(count, -1, -1)
    bins = np.searchsorted(ends, starts, side="right") - 1
    inside = (bins >= 0) & (bins < count)
    impulse: Array = np.bincount(bins[inside], impulses[inside], count).astype(np.float64)
    records = np.searchsorted(time, ends - CLOCK * length)
    records[-1] = min(records[-1], time.size - 1)
    last = slice(max(int(records[-2]) - 1, 0), int(records[-1]) + 1)
    ripple = float(np.ptp(velocity[last]))
    begun = np.searchsorted(np.sort(starts[releases > starts]), ends[1:])
    over = np.searchsorted(np.sort(releases[releases > starts]), ends[:-1])
    across = np.searchsorted(np.sort(starts), ends) > np.searchsorted(np.sort(releases), ends)
    if "normal_force" in columns and (across | (ends > whole_until)).any():
        # A contact that goes on over periods has a part of its impulse in each.
        grown = np.append(0.0, np.cumsum(columns["normal_force"][1:] * np.diff(time)))
        impulse = np.diff(np.interp(ends, time, grown))
    # Hermite's cubic of the angle.
    after = np.clip(np.searchsorted(time, ends), 1, time.size - 1)
    before = after - 1
    step = time[after] - time[before]
    x = np.clip((ends - time[before]) / step, 0.0, 1.0)
    rise, first, second = angle[after] - angle[before], step * velocity[before], step * velocity[after]
    cubic = first + x * (3.0 * rise - 2.0 * first - second + x * (first + second - 2.0 * rise))
    return Periods(
        np.diff(angle[before] + x * cubic) / length,
        ripple,
        0.5 * widest * ripple / (0.5 * count * length),
        np.minimum.reduceat(gap, records[:-1]),
        impulse,
        (impulse != 0.0) | (begun > over) | (ends[1:] > whole_until),
        {name: (np.interp(ends[1:], time, x), float(np.ptp(x[last]))) for name, x in memory.items()},
    )


def _pause(phases: Array) -> float:
    """Return the middle of the longest pause between touch-downs, in periods before the end."""
    phases = np.sort(phases % 1.0)
    if not phases.size:
        return 0.0
    pauses = np.diff(np.append(phases, phases[0] + 1.0))
    longest = int(pauses.argmax())
    return float((phases[longest] + 0.5 * pauses[longest]) % 1.0)


@final
@dataclass(frozen=True)
class Settling:
    """Extrapolation of a run to the steady state of its motor.

    Args:
        velocity, error: estimated mean rotor velocity of the steady state, and its error to 95 % [rad/s];
            NaN where nothing is estimated, infinite error where the limit is not determined.
        now: mean rotor velocity at the end of the run [rad/s].
        drift: change of the mean rotor velocity per period, at the end [rad/s].
        impulse_drift: relative change of the normal impulse per period, at the end [1].
        scale: of a difference of velocities [rad/s]: the largest of the estimate, the range of the velocity
            within a period, and a small part of its change since the start.
        kind: of motion, see `contactlab.settling.statistics`, with 'over 2 periods' and the like where it
            repeats itself so; empty where it is unknown.
        reason: why the steady state is unknown; else empty.
        longer: whether a longer run would help.
        memory_share: largest relative error of an internal variable of the run [1].
    """

    velocity: float = nan
    error: float = nan
    now: float = nan
    drift: float = nan
    impulse_drift: float = nan
    scale: float = nan
    kind: str = ""
    reason: str = ""
    longer: bool = True
    memory_share: float = 0.0

    @property
    def share(self) -> float:
        """Largest relative error of velocity or internal variables at the end [1]; NaN if unknown."""
        off = abs(self.now - self.velocity) + self.error
        if self.reason or not isfinite(off):
            return nan
        return max(off / self.scale if off > 0.0 else 0.0, self.memory_share)

    @property
    def verdict(self) -> str:
        """'settled', 'not settled' or 'inconclusive'."""
        if isnan(self.share):
            return INCONCLUSIVE
        if self.share <= SHARE:
            return SETTLED
        return UNSETTLED if abs(self.now - self.velocity) > self.error else INCONCLUSIVE

    @property
    def motion(self) -> str:
        """Kind of motion of a settled run; else empty."""
        return self.kind if self.verdict == SETTLED else ""

    @property
    def estimate(self) -> str:
        """The estimate with its error, '-2.25 +- 0.28 rad/s'."""
        return f"{Estimate(self.velocity, self.error).text(digits=DIGITS)} rad/s"

    @cached_property
    def sentence(self) -> str:
        """Summary in a line of plain ASCII."""
        if self.verdict == SETTLED:
            kind = self.motion or "in a motion of a kind that is not yet known"
            drift = f", changes by {abs(self.drift):.2g} rad/s per period" if "period" in kind else ""
            return f"settled: {kind}, {self.estimate}{drift}"
        if self.verdict == UNSETTLED:
            return f"not settled: {self._apart} the estimated {self.estimate}"
        if self.reason:
            return f"inconclusive: {self.reason}"
        if not isfinite(self.error):
            return (
                f"inconclusive: {self.now:.4g} rad/s at the end changes by {abs(self.drift):.2g} rad/s per "
                "period, and the run does not show where to"
            )
        return f"inconclusive: {self.now:.4g} rad/s at the end, and {self.estimate} estimated"

    @property
    def _apart(self) -> str:
        """Return how far the velocity at the end is from the estimate."""
        if self.now * self.velocity < 0.0 or abs(self.velocity) <= self.error:
            return f"{self.now:.4g} rad/s at the end, against"
        share = abs(self.now / self.velocity - 1.0)
        return f"{100.0 * share:.2g} % {'below' if abs(self.now) < abs(self.velocity) else 'above'}"

    @property
    def short(self) -> str:
        """Summary in a few words."""
        if self.verdict == SETTLED:
            return f"settled{self.motion and ': '}{self.motion}, {self.estimate}"
        if self.verdict == UNSETTLED:
            return f"not settled: {self.estimate} estimated"
        return "settled or not: inconclusive"

    def way_out(self, end: float) -> str:
        """Return the advice for a run that has not settled by its end [s]; empty for one that has."""
        if self.verdict == SETTLED or not self.longer:
            return ""
        longer = f"solver.until=steady solver.duration={10.0 * end:.1g}"
        return f"Let it run on, {longer}, or find its steady state at once: contactlab steady."

    @property
    def attributes(self) -> dict[str, Any]:
        """Attributes of a dataset: 1 settled, 0 not, -1 unknown; numbers in rad/s."""
        return {
            "settled": {SETTLED: 1, UNSETTLED: 0, INCONCLUSIVE: -1}[self.verdict],
            "settled_velocity": self.velocity,
            "settled_velocity_error": self.error,
            "motion": self.motion,
            "settling": self.sentence,
        }


def settling_of(columns: Columns, rows: Columns, period: float, lasting: Iterable[str] = ()) -> Settling:
    """Extrapolate a run to its steady state; arguments as of `periods_of`.

    While an internal variable has not settled, no steady velocity is estimated: it depends on the variable.
    """
    try:
        run = periods_of(columns, rows, period, lasting)
    except UnknownError as unknown:
        return Settling(reason=str(unknown), longer=unknown.longer)
    result = approach(run.velocity)
    swing = float(np.abs(run.velocity - result.now).max())
    memory_share, flowing = _memory_of(run)
    known = isfinite(result.error) and not flowing
    impulse, gap = approach(run.impulse), approach(run.least_gap)
    touching = bool(run.touching[-(run.touching.size // LATE) :].any())
    reason = flowing
    if not reason and not touching and gap.distance > 0.0 and gap.limit <= gap.error:
        reason = f"the tip is free, but approaches the rotor, of which it is {gap.now:.2g} m clear at least"
    return Settling(
        result.limit if known else nan,
        result.error + run.blur if not flowing else inf,
        result.now,
        result.drift,
        abs(impulse.drift / impulse.now) if touching and impulse.now else 0.0,
        max(abs(result.limit), run.ripple, AS_GOOD_AS_NONE * swing),
        _kind_of(run) if touching else WITHOUT_CONTACT,
        reason,
        memory_share=memory_share,
    )


def _memory_of(run: Periods) -> tuple[float, str]:
    """Return the largest relative error of an internal variable, and the reason if it is large."""
    share, reason = 0.0, ""
    for name, (values, ripple) in run.memory.items():
        result = approach(values)
        swing = float(np.abs(values - result.now).max())
        scale = max(abs(result.limit), ripple, AS_GOOD_AS_NONE * swing)
        off = abs(result.distance) + result.error
        own = off / scale if off > 0.0 else 0.0
        if own > max(share, SHARE):
            limit = Estimate(result.limit, result.error).text(digits=DIGITS)
            reason = (
                f"the law's internal variable {name.removeprefix(INTERNAL)} is {result.now:.4g} at the end, "
                f"changes by {abs(result.drift):.2g} per period, and tends to "
                f"{limit if isfinite(result.error) else 'no value that the run shows'}"
            )
        share = max(share, own)
    return share, reason


def _kind_of(run: Periods) -> str:
    """Return the kind of motion of the last half of the periods, from velocity and impulse."""
    half = run.velocity.size // 2
    scale = max(float(np.abs(run.velocity[half:]).mean()), run.ripple) or 1.0
    # A contact that lasts through all of them has no impulse in any.
    mean = run.impulse[half:].mean() or 1.0
    states = np.column_stack([run.velocity[half:] / scale, run.impulse[half:] / mean])
    # The kind is that of the fluctuation about a slow trend.
    steps = np.arange(len(states))
    shaking = states - np.column_stack([np.polyval(np.polyfit(steps, x, 1), steps) for x in states.T])
    count = repeats_after(1.0 + shaking, REPEATS)
    if count == 1:
        return PERIODIC
    before, after = (float(np.std(part[:, 1])) for part in np.array_split(shaking, 2))
    if after < FADING * before:
        return ""
    return f"{PERIODIC} over {count} periods" if count else kind_without_period(shaking)
