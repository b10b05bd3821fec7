"""Whether what a run says of itself agrees: contacts with records, forces with impulses, gap with motion.

No law can break these. One that is open is a fault of the solver or of the file.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from contactlab.laws.base import FREE
from contactlab.metrics.measure import Measure
from contactlab.metrics.metric import ROUND_OFF, Metric
from contactlab.metrics.record import Record, needed
from contactlab.motor.geometry import contact_frame

Array = NDArray[np.float64]

RESOLVED: Final = 1e-12
"""Share of the motor's energy below which a contact is a graze that round-off decides."""

CLOCK: Final = 8.0
"""Units in the last place of the time that two instants may differ by and still be one."""


def _phantoms(record: Record) -> float:
    start, duration = record.contacts("start_time"), record.contacts("duration")
    impulse = np.abs(record.contacts("normal_impulse"))
    resolution = CLOCK * np.spacing(np.maximum(start + duration, record.time[-1]))
    # The last contact may be one that the end of the run cuts at its first instant.
    inside = start < record.time[-1] - resolution
    empty = inside & ((duration < 0.0) | ((duration <= resolution) & (impulse == 0.0)))
    overlap = start[1:] < (start + duration)[:-1] - resolution[1:]
    return float(empty.sum() + overlap.sum()) / start.size


def _closing_release(record: Record) -> float:
    approach, separation = (
        record.contacts("approach_velocity"),
        record.contacts("separation_velocity"),
    )
    closing = float(np.nanmax(np.append(-separation, 0.0)))
    # A start in contact may be opening; any other contact begins by closing.
    later = record.contacts("start_time") > 0.0
    opening = float(np.max(np.append(approach[later], 0.0)))
    # Of the whole motion: the rates of a tip that only grazes are round-off.
    rates = np.abs(np.diff(record.series("gap")) / record.intervals)
    scale = max(float(np.abs(approach).max()), float(rates.max()))
    needed(scale > 0.0)
    return max(closing, opening) / scale


def _missed_contact(record: Record) -> float:
    gap, free = record.series("gap"), record.series("contact_mode") == FREE
    time = record.time
    # A record at the very instant of a touch-down or a release may carry either mode.
    if "start_time" in record.rows and record.rows["start_time"].size:
        start = np.sort(record.contacts("start_time"))
        end = np.sort(start + record.contacts("duration"))
        near = CLOCK * np.spacing(time[-1])
        begun = np.searchsorted(start, time + near, side="right")
        ended = np.searchsorted(end, time - near, side="left")
        free = free & (begun == ended)
    return float(np.max(np.append(-gap[free], 0.0))) / _motion(record)


def _peak_deficit(record: Record) -> float:
    peak = record.contacts("peak_normal_force")
    impulse, duration = record.contacts("normal_impulse"), record.contacts("duration")
    scale = max(float(np.abs(peak).max()), _least_force(record))
    mean = impulse[duration > 0.0] / duration[duration > 0.0]
    over_mean = float(np.max(np.append(mean - peak[duration > 0.0], 0.0)))
    over_records = float(record.series("normal_force").max()) - float(peak.max())
    return max(over_mean, over_records, 0.0) / scale


def _motion(record: Record) -> float:
    """How far the tip goes in the normal direction [m], from the first record on."""
    half = 0.5 * float(np.ptp(record.series("tip_normal_displacement")))
    needed(half > 0.0)
    return half


def _least_force(record: Record) -> float:
    """A force that is round-off [N]: its work over the tip's amplitude is none of the motor's energy."""
    energy = record.series("kinetic_energy") + record.series("strain_energy")
    return RESOLVED * float(energy.max()) / _motion(record)


def _depth_deficit(record: Record) -> float:
    depth = -float(record.series("gap").min()) - float(record.contacts("max_penetration").max())
    return max(depth, 0.0) / _motion(record)


def _gap_mismatch(record: Record) -> float:
    lengths = (
        record.setting("contact", "tip_length"),
        record.setting("rotor", "radius"),
        record.setting("contact", "clearance"),
    )
    u, slope = record.series("tip_normal_displacement"), record.series("tip_slope")
    pairs = zip(u.tolist(), slope.tolist(), strict=True)
    expected = np.array([contact_frame(rise, turn, *lengths)[0] for rise, turn in pairs])
    return float(np.abs(record.series("gap") - expected).max()) / _motion(record)


MEASURES: Final[tuple[Measure[Record], ...]] = (
    Measure(
        Metric(
            "phantom_contacts",
            "contacts with t_c <= 0 or t_s < end of the one before, over all",
            "1",
            "share of the contacts that have no length, or begin before the one before has ended",
            "<=",
            0.0,
            "a contact takes time, and there is one tip",
            "definition of a contact",
        ),
        _phantoms,
    ),
    Measure(
        Metric(
            "closing_release",
            "max(-g_dot_1, g_dot_0, 0) / max|g_dot|",
            "1",
            "largest gap rate of the wrong sign: closing at a release, or opening at a touch-down, over the "
            "fastest rate of the gap",
            "<=",
            1e-3,
            "a gap that opens does not close; a first-order law finds its release within a step, a "
            "thousandth of a contact",
            "definition of touch-down and release",
        ),
        _closing_release,
    ),
    Measure(
        Metric(
            "missed_contact",
            "max(-g, 0) without contact / A",
            "1",
            "deepest overlap of tip and rotor outside of every contact, over half the range of the "
            "tip's normal motion",
            "<=",
            1e-3,
            "where the bodies overlap there is contact; a first-order law's release is off by a step, in "
            "which the gap changes by less than this",
            "0 <= g outside of contact",
        ),
        _missed_contact,
    ),
    Measure(
        Metric(
            "peak_deficit",
            "max(p_n / t_c - N_max, max N - max N_max, 0) / max(max N_max, 1e-12 E / A)",
            "1",
            "mean forces that exceed the peak which their contact states, over the largest peak; what is "
            "round-off against the motor's energy is none",
            "<=",
            ROUND_OFF,
            "no mean is above its maximum, but for round-off",
            "definition of a mean",
        ),
        _peak_deficit,
    ),
    Measure(
        Metric(
            "depth_deficit",
            "max(-min g - max d_max, 0) / A",
            "1",
            "recorded overlap beyond the largest penetration that the contacts state, over half "
            "the range of the tip's normal motion",
            "<=",
            1e-2,
            "no record lies deeper than the deepest point; a rigid law states its depth once a step, and "
            "an impact's step sinks by a part of approach times step, a few thousandths here",
            "definition of a maximum",
        ),
        _depth_deficit,
    ),
    Measure(
        Metric(
            "gap_mismatch",
            "max|g - g(u, theta)| / A",
            "1",
            "recorded gap against that of the recorded displacements, over half the range of the "
            "tip's normal motion",
            "<=",
            ROUND_OFF,
            "both are the same geometry, but for round-off",
            "paper, eqs. 35-37",
        ),
        _gap_mismatch,
    ),
)
"""Metrics of a run's agreement with itself."""
