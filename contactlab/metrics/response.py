"""What a run's contacts and motor do: numbers that laws differ in, without a right value."""

from typing import Final

import numpy as np

from contactlab.metrics.hertz import effective_mass, hertz_duration, stiffness
from contactlab.metrics.measure import Measure
from contactlab.metrics.metric import Metric
from contactlab.metrics.record import Record, needed

OCCUPIED: Final = 0.99
"""Share of the spectral energy below the bandwidth."""


def _reported(key: str, symbol: str, units: str, meaning: str, source: str = "") -> Metric:
    return Metric(key, symbol, units, meaning, source=source)


def peak_force(record: Record) -> float:
    """Largest normal force of any contact [N]."""
    return float(record.contacts("peak_normal_force").max())


def total_impulse(record: Record) -> float:
    """Sum of the normal impulses [N s]."""
    return float(record.contacts("normal_impulse").sum())


def mean_velocity(record: Record) -> float:
    """Mean rotor velocity of the last whole drive periods [rad/s]: the angle turned over the time."""
    span = record.last_periods()
    time, angle = record.time[span], record.series("rotor_angle")[span]
    return float((angle[-1] - angle[0]) / (time[-1] - time[0]))


def _mean_torque(record: Record) -> float:
    span = record.last_periods()
    # A mean force stands for the interval that ends at its time.
    force = record.series("friction_force")[span][1:]
    lengths = np.diff(record.time[span])
    radius = record.setting("rotor", "radius")
    return -radius * float(force @ lengths) / float(lengths.sum())


def _efficiency(record: Record) -> float:
    span = record.last_periods()
    load, drive = record.series("load_work")[span], record.series("drive_work")[span]
    given = float(drive[-1] - drive[0])
    done = float(load[-1] - load[0])
    # A load that drives is no load: what it gives is no share of what the drive gives.
    needed(given > 0.0 <= done)
    return done / given


def _share_of_work(record: Record, name: str) -> float:
    loss, drive = record.series(name), record.series("drive_work")
    given = float(drive[-1] - drive[0])
    needed(given > 0.0)
    return float(loss[-1] - loss[0]) / given


def _stick_share(record: Record) -> float:
    duration = float(record.contacts("duration").sum())
    needed(duration > 0.0)
    return float(record.contacts("stick_duration").sum()) / duration


def _restitution(record: Record) -> float:
    approach, separation = (
        record.contacts("approach_velocity"),
        record.contacts("separation_velocity"),
    )
    # The contact that the end of the run cut has no separation.
    whole = np.isfinite(separation) & (approach < 0.0)
    needed(bool(whole.any()))
    return float(np.median(-separation[whole] / approach[whole]))


def _hertz_ratio(record: Record) -> float:
    duration, approach = record.contacts("duration"), record.contacts("approach_velocity")
    falling = approach < 0.0
    needed(bool(falling.any()))
    expected = hertz_duration(effective_mass(record), stiffness(record), -approach[falling])
    return float(np.median(duration[falling] / expected))


def _bandwidth(record: Record) -> float:
    force, lengths = record.series("normal_force")[1:], record.intervals
    # The last record lies at the end of the run and its interval may be shorter.
    if abs(lengths[-1] - lengths[0]) > 1e-6 * lengths[0]:
        force, lengths = force[:-1], lengths[:-1]
    needed(force.size > 0 and bool(np.ptp(lengths) <= 1e-6 * lengths[0]) and bool(force.any()))
    energy = np.abs(np.fft.rfft(force)) ** 2
    # Every line but those at zero and at the Nyquist frequency stands for two.
    energy[1 : (force.size + 1) // 2] *= 2.0
    grown = np.cumsum(energy)
    line = int(np.searchsorted(grown, OCCUPIED * grown[-1]))
    return line / (force.size * float(lengths[0]))


MEASURES: Final[tuple[Measure[Record], ...]] = (
    Measure(
        _reported(
            "contact_count", "n_c", "1", "number of contacts, one that the end cuts included"
        ),
        lambda record: float(record.contact_count()),
    ),
    Measure(
        _reported("peak_force", "N_max", "N", "largest normal force", "paper, fig. 9"),
        peak_force,
    ),
    Measure(
        _reported("mean_impulse", "mean p_n", "N s", "mean normal impulse of a contact"),
        lambda record: float(record.contacts("normal_impulse").mean()),
    ),
    Measure(
        _reported("total_impulse", "sum p_n", "N s", "normal impulse of all contacts"),
        total_impulse,
    ),
    Measure(
        _reported("total_friction_impulse", "sum p_t", "N s", "friction impulse of all contacts"),
        lambda record: float(record.contacts("friction_impulse").sum()),
    ),
    Measure(
        _reported("contact_time", "sum t_c", "s", "time in contact"),
        lambda record: float(record.contacts("duration").sum()),
    ),
    Measure(
        _reported("contact_duration", "median t_c", "s", "median duration of a contact"),
        lambda record: float(np.median(record.contacts("duration"))),
    ),
    Measure(
        _reported(
            "stick_share", "sum t_st / sum t_c", "1", "share of the time in contact that sticks"
        ),
        _stick_share,
    ),
    Measure(
        _reported(
            "restitution",
            "median(-g_dot_1 / g_dot_0)",
            "1",
            "apparent restitution: separation over approach velocity. The drive works on through a "
            "contact, so that one is no bound",
            "Stronge (2000), Impact Mechanics, ch. 3",
        ),
        _restitution,
    ),
    Measure(
        _reported(
            "hertz_duration_ratio",
            "median(t_c / (3.21 (m^2 / (K^2 v))^(1/5))), m = 1/D_nn",
            "1",
            "duration of a contact over that of Hertz's free impact at the same approach velocity; "
            "longer than one as the motor's other modes and the drive press on",
            "Johnson (1985), Contact Mechanics, sec. 11.4, eq. 11.24",
        ),
        _hertz_ratio,
    ),
    Measure(
        _reported(
            "force_bandwidth",
            "f_99",
            "Hz",
            "frequency below which 99 % of the spectral energy of the recorded normal force lies; "
            "near half the record rate, the records do not resolve the force",
            "occupied bandwidth, Recommendation ITU-R SM.328",
        ),
        _bandwidth,
    ),
    Measure(
        _reported(
            "rotor_velocity",
            "mean Omega",
            "rad s-1",
            "mean rotor velocity of the last whole drive periods",
            "paper, fig. 8",
        ),
        mean_velocity,
    ),
    Measure(
        _reported(
            "final_rotor_velocity", "Omega(T)", "rad s-1", "rotor velocity at the last record"
        ),
        lambda record: float(record.series("rotor_velocity")[-1]),
    ),
    Measure(
        _reported(
            "torque",
            "mean(-R F)",
            "N m",
            "mean torque of friction on the rotor in the last whole drive periods",
        ),
        _mean_torque,
    ),
    Measure(
        _reported(
            "efficiency",
            "dW_l / dW_d",
            "1",
            "work on the load over work of the drive in the last whole drive periods; none where the load "
            "drives the motor",
        ),
        _efficiency,
    ),
    Measure(
        _reported("friction_share", "W_f / W_d", "1", "friction loss over work of the drive"),
        lambda record: _share_of_work(record, "friction_loss"),
    ),
    Measure(
        _reported(
            "normal_loss_share",
            "W_n / W_d",
            "1",
            "loss in normal damping and impacts over work of the drive",
        ),
        lambda record: _share_of_work(record, "contact_loss"),
    ),
)
"""Metrics that are reported."""
