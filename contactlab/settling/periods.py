"""What a run does in each period of its drive, mean rotor velocity and impulse, from recorded numbers."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import floor
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.motor.drive import Drive, NoPeriodError, period_of

Columns = Mapping[str, NDArray[Any]]

COARSEST: Final = 1.0 / 8.0
"""Record interval over the period beyond which the rotor's angle between records is not known: the jump of
its acceleration at a contact makes an error of the velocity's change in a period times an eighth of this."""

CLOCK: Final = 1e-9
"""Part of a period that is round-off of the times."""


def drive_period(drive: Drive) -> float:
    """Return the period of a drive [s]; zero where it has none."""
    try:
        return period_of(drive)
    except NoPeriodError:
        return 0.0


def period_told(configuration: Mapping[str, Any]) -> float:
    """Return the drive's period in a configuration [s]; that of the first tone where it has no second.

    Zero where there is none.
    """
    section = configuration.get("drive")
    drive = section if isinstance(section, Mapping) else {}
    try:
        return drive_period(Drive.two_mode(**drive))
    except (TypeError, ValueError):
        first = drive.get("frequency")
        return 1.0 / first if isinstance(first, int | float) and first > 0.0 else 0.0


class UnknownError(ValueError):
    """The numbers do not show whether a motor has settled; the message continues 'inconclusive:'.

    Args:
        reason: the message.
        longer: whether a longer run would tell.
    """

    def __init__(self, reason: str, *, longer: bool = False) -> None:
        super().__init__(reason)
        self.longer = longer


@final
@dataclass(frozen=True)
class Recorded:
    """The columns of a run that tell what it does in a period, SI.

    Args:
        period: of the drive [s]; zero where there is none.
        time, angle, velocity: of the rotor at the records.
        gap: at the records.
        start_time, end_time, normal_impulse: a number a contact, of those that have ended.
        whole_until: time from which on a contact lasts that has not [s]; the end where there is none.
        memory: internal variables of the law whose life is the run, at the records, by name.
    """

    period: float
    time: Array
    angle: Array
    velocity: Array
    gap: Array
    start_time: Array
    end_time: Array
    normal_impulse: Array
    whole_until: float
    memory: Columns = field(default_factory=dict)

    @classmethod
    def of(cls, columns: Columns, rows: Columns, period: float, lasting: Iterable[str] = ()) -> "Recorded":
        """Take them out of the series and the contacts of a run; an UnknownError names what is not there."""
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
        numbers = time, angle, velocity, gap, starts, impulses, *memory.values()
        if not all(np.isfinite(values).all() for values in numbers):
            raise UnknownError("some of the run's numbers are not finite")
        cut = np.isnan(separations) if separations.size == starts.size else np.zeros(starts.size, dtype=bool)
        until = float(starts[cut].min(initial=time[-1]))
        durations = np.asarray(rows.get("duration", np.zeros(starts.size)), dtype=np.float64)
        ended = starts + (durations if durations.size == starts.size else 0.0)
        return cls(
            period, time, angle, velocity, gap, starts[~cut], ended[~cut], impulses[~cut], until, memory
        )


@final
@dataclass(frozen=True)
class Periods:
    """Whole periods of the drive, counted back from the end.

    They begin in the middle of the longest pause between touch-downs, so that none is counted now here, now
    there.

    Args:
        length: of a period [s].
        velocity: mean rotor velocity of each [rad/s].
        ripple: range of the rotor velocity within the last [rad/s].
        blur: error of the mean velocity over their last half by the angle between records [rad/s]: at either
            end at most a quarter of the record interval times what the velocity changes by within it.
        least_gap: of each [m].
        impulse: normal impulse of the contacts that begin in each [N s].
        touching: whether a contact begins, lasts or ends in each.
        memory: internal variables of the run at the end of each, and their range within the last, by name.
    """

    length: float
    velocity: Array
    ripple: float
    blur: float
    least_gap: Array
    impulse: Array
    touching: NDArray[np.bool_]
    memory: Mapping[str, tuple[Array, float]] = field(default_factory=dict)


def periods_of(run: Recorded, least: int) -> Periods:
    """Take a run apart into at least so many periods.

    The angle at the ends of a period is Hermite's polynomial between the records around it, and the impulses
    are those of whole contacts: neither depends on where the records fall.

    Raises:
        UnknownError: the drive has no period, the records are too far apart, or the run is too short.
    """
    length, time = run.period, run.time
    if not length > 0.0:
        raise UnknownError("the drive has no period")
    widest = float(np.diff(time).max(initial=0.0))
    if widest > COARSEST * length:
        raise UnknownError(
            f"records lie {widest:.3g} s apart, more than an eighth of the drive's period, {length:.3g} s; a "
            "smaller record.interval tells"
        )
    late = run.start_time[run.start_time > 0.5 * (time[0] + time[-1])]
    end = float(time[-1]) - _pause((time[-1] - late) / length) * length
    # The impulse of a contact that the end cuts is not whole.
    end -= length if end > run.whole_until else 0.0
    count = floor((end - time[0]) / length + CLOCK)
    if count < least:
        text = f"the run has {max(count, 0)} whole periods of the drive, and it takes {least} to tell"
        raise UnknownError(text, longer=True)
    ends = end - length * np.arange(count, -1, -1)
    bins = np.searchsorted(ends, run.start_time, side="right") - 1
    inside = (bins >= 0) & (bins < count)
    impulse: Array = np.bincount(bins[inside], run.normal_impulse[inside], count).astype(np.float64)
    records = np.searchsorted(time, ends - CLOCK * length)
    records[-1] = min(records[-1], time.size - 1)
    last = slice(max(int(records[-2]) - 1, 0), int(records[-1]) + 1)
    ripple = float(np.ptp(run.velocity[last]))
    lasting = run.end_time > run.start_time
    begun = np.searchsorted(np.sort(run.start_time[lasting]), ends[1:])
    over = np.searchsorted(np.sort(run.end_time[lasting]), ends[:-1])
    return Periods(
        length,
        np.diff(_angle_at(run, ends)) / length,
        ripple,
        0.5 * widest * ripple / (0.5 * count * length),
        np.minimum.reduceat(run.gap, records[:-1]),
        impulse,
        (impulse != 0.0) | (begun > over) | (ends[1:] > run.whole_until),
        {name: (np.interp(ends[1:], time, x), float(np.ptp(x[last]))) for name, x in run.memory.items()},
    )


def _pause(phases: Array) -> float:
    """Return the middle of the longest pause between touch-downs, in periods before the end."""
    phases = np.sort(phases % 1.0)
    if not phases.size:
        return 0.0
    pauses = np.diff(np.append(phases, phases[0] + 1.0))
    longest = int(pauses.argmax())
    return float((phases[longest] + 0.5 * pauses[longest]) % 1.0)


def _angle_at(run: Recorded, times: Array) -> Array:
    """Return the rotor's angle at times between records, by Hermite's cubic."""
    after = np.clip(np.searchsorted(run.time, times), 1, run.time.size - 1)
    before = after - 1
    step = run.time[after] - run.time[before]
    x = np.clip((times - run.time[before]) / step, 0.0, 1.0)
    rise = run.angle[after] - run.angle[before]
    first, second = step * run.velocity[before], step * run.velocity[after]
    cubic = first + x * (3.0 * rise - 2.0 * first - second + x * (first + second - 2.0 * rise))
    return np.asarray(run.angle[before] + x * cubic)
