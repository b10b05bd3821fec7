"""Whether a run has settled, to which velocity and in what kind of motion, and how that is said."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, isnan, nan
from typing import Any, Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.estimate import Estimate
from contactlab.settling.approach import LEAST_VALUES, approach
from contactlab.settling.periods import Columns, Periods, Recorded, UnknownError, periods_of
from contactlab.settling.statistics import REPEATS, kind_without_period, repeats_after
from contactlab.variables import INTERNAL

SETTLED, UNSETTLED, INCONCLUSIVE = "settled", "not settled", "inconclusive"

SHARE: Final = 0.01
"""Largest share by which the velocity of a motor that has settled may be off its steady one: what remains is
below what laws differ in."""

AS_GOOD_AS_NONE: Final = 0.01
"""Velocity over what it has changed by since the start, below which a rotor is taken to come to rest."""

FADING: Final = 0.9
"""What is left of a fluctuation from the last quarter but one to the last, below which it dies down."""

LATE: Final = 4
"""A run's last part of so many shows what it does in the end."""

WITHOUT_CONTACT: Final = "without contact"

DIGITS: Final = 6
"""Significant digits of an extrapolated number at most."""


@final
@dataclass(frozen=True)
class Settling:
    """What a run's recorded numbers say of the steady state of its motor.

    Args:
        velocity, error: estimated mean rotor velocity of the steady state, and its error to 95 % [rad/s];
            NaN where nothing is estimated, infinite error where the run does not show how far it goes.
        now: mean rotor velocity at the end of the run [rad/s].
        drift: change of the mean rotor velocity from a period to the next, at the end [rad/s].
        impulse_drift: relative change of the normal impulse from a period to the next, at the end [1].
        scale: by which a difference of velocities is measured [rad/s]: the estimate, or the range of the
            velocity within a period where that is larger, or a small part of what it has changed by.
        kind: of motion, of a run that has settled: 'period one', 'period 2', ..., 'quasi-periodic',
            'chaotic', 'irregular' or 'without contact'; empty where none is to be told.
        reason: why nothing can be told; empty where something can.
        longer: whether a longer run tells more.
        memory_share: largest share by which an internal variable of the run may be off its steady value [1].
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
        """Largest share by which the velocity at the end is off its steady one [1]; NaN if not known.

        Or an internal variable of the run is off its own, where that is more.
        """
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
        """Return the kind of motion of a run that has settled; empty for others."""
        return self.kind if self.verdict == SETTLED else ""

    @property
    def estimate(self) -> str:
        """Return the estimate with its error, '-2.25 +- 0.28 rad/s'."""
        return f"{Estimate(self.velocity, self.error).text(most=DIGITS)} rad/s"

    @cached_property
    def sentence(self) -> str:
        """Return verdict, motion and numbers in a line of ASCII."""
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
        """Return verdict and estimate."""
        if self.verdict == SETTLED:
            return f"settled{self.motion and ': '}{self.motion}, {self.estimate}"
        return (
            f"not settled: {self.estimate} estimated"
            if self.verdict == UNSETTLED
            else "settled or not: inconclusive"
        )

    def way_out(self, end: float) -> str:
        """Return how a motor that has not settled by the end of a run [s] may; empty where it has."""
        if self.verdict == SETTLED or not self.longer:
            return ""
        longer = f"solver.until=steady solver.duration={10.0 * end:.1g}"
        return f"Let it run on, {longer}, or find its steady state at once: contactlab steady."

    @property
    def attributes(self) -> dict[str, Any]:
        """Return the attributes of a dataset: 1 settled, 0 not, -1 inconclusive; numbers in rad/s."""
        return {
            "settled": {SETTLED: 1, UNSETTLED: 0, INCONCLUSIVE: -1}[self.verdict],
            "settled_velocity": self.velocity,
            "settled_velocity_error": self.error,
            "motion": self.motion,
            "settling": self.sentence,
        }


def settling_of(columns: Columns, rows: Columns, period: float, lasting: Iterable[str] = ()) -> Settling:
    """Judge a run by its series, its contacts (see `contactlab.variables`) and its drive's period [s].

    Args:
        columns, rows: the series and the contacts.
        period: of the drive [s].
        lasting: names of the series of internal variables whose life is the run. Where one of them has not
            settled, no steady velocity is estimated: it still depends on where the variable goes.
    """
    try:
        run = periods_of(Recorded.of(columns, rows, period, lasting), LEAST_VALUES)
    except UnknownError as unknown:
        return Settling(reason=str(unknown), longer=unknown.longer)
    result = approach(run.velocity)
    swing = float(np.abs(run.velocity - result.now).max())
    memory_share, flowing = _memory_of(run)
    known = isfinite(result.error) and not flowing
    impulse = approach(run.impulse)
    touching = bool(run.touching[-max(run.touching.size // LATE, 1) :].any())
    return Settling(
        result.limit if known else nan,
        result.error + run.blur if not flowing else inf,
        result.now,
        result.drift,
        abs(impulse.drift / impulse.now) if touching and impulse.now else 0.0,
        max(abs(result.limit), run.ripple, AS_GOOD_AS_NONE * swing),
        _kind_of(run) if touching else WITHOUT_CONTACT,
        flowing or ("" if touching else _still_nearing(run.least_gap)),
        memory_share=memory_share,
    )


def _memory_of(run: Periods) -> tuple[float, str]:
    """Return the largest share by which an internal variable is off its steady value, and a reason if large.

    A difference is measured by the steady value, or the range of the variable within a period where that is
    larger, or a small part of what it has changed by.
    """
    share, reason = 0.0, ""
    for name, (values, ripple) in run.memory.items():
        result = approach(values)
        swing = float(np.abs(values - result.now).max())
        scale = max(abs(result.limit), ripple, AS_GOOD_AS_NONE * swing)
        off = abs(result.distance) + result.error
        own = off / scale if off > 0.0 else 0.0
        if own > max(share, SHARE):
            limit = Estimate(result.limit, result.error).text(most=DIGITS)
            reason = (
                f"the law's internal variable {name.removeprefix(INTERNAL)} is {result.now:.4g} at the end, "
                f"changes by {abs(result.drift):.2g} per period, and tends to "
                f"{limit if isfinite(result.error) else 'no value that the run shows'}"
            )
        share = max(share, own)
    return share, reason


def _still_nearing(gap: Array) -> str:
    """Return that a tip which is free may yet touch."""
    result = approach(gap)
    if result.distance <= 0.0 or result.limit - result.error > 0.0:
        return ""
    return f"the tip is free, but comes nearer to the rotor, of which it is {result.now:.2g} m clear at least"


def _kind_of(run: Periods) -> str:
    """Tell what kind of motion the last half of the periods shows, in velocity and impulse."""
    half = run.velocity.size // 2
    scale = max(float(np.abs(run.velocity[half:]).mean()), run.ripple) or 1.0
    # A contact that lasts through all of them has no impulse in any.
    mean = run.impulse[half:].mean() or 1.0
    states = np.column_stack([run.velocity[half:] / scale, run.impulse[half:] / mean])
    # Of what moves on by less than it shakes, only the shaking tells the kind.
    steps = np.arange(len(states))
    shaking = states - np.column_stack([np.polyval(np.polyfit(steps, x, 1), steps) for x in states.T])
    count = repeats_after(1.0 + shaking, REPEATS)
    if count == 1:
        return "period one"
    before, after = (float(np.std(part[:, 1])) for part in np.array_split(shaking, 2))
    if after < FADING * before:
        return ""
    return (
        f"period {count}" if count else kind_without_period(shaking[:, 1 if run.impulse[half:].any() else 0])
    )
