"""Response of contacts and motor: numbers without a right value, and whether the motor has settled."""

from math import isnan
from typing import Final

import numpy as np

from contactlab import config
from contactlab.laws.base import MultiplierLaw
from contactlab.laws.hertz_penalty import HertzPenalty
from contactlab.metrics.catalogue import SETTLED, UNSETTLED, metric, without_records
from contactlab.metrics.constraints import stiffness
from contactlab.metrics.run import NotApplicableError, Run, needed, positive
from contactlab.motor.motor import lever_of
from contactlab.settling.verdict import SHARE

ASSUMED_STIFFNESS: Final = float(HertzPenalty().stiffness or 0.0)
"""Contact stiffness at which the impulse of an impact is expressed as a force [N m^-1.5]."""


@without_records(
    "n_c", "number of contacts, those that the run's start or end cuts included", usual=True, sums=True
)
def contact_count(run: Run) -> float:
    needed("start_time" in run.rows)
    return float(run.rows["start_time"].size)


@without_records("N_max", "largest normal force", "N", source="paper, fig. 9", usual=True)
def peak_force(run: Run) -> float:
    return float(run.contacts("peak_normal_force").max())


def finite_peak(run: Run) -> float:
    """Return the largest normal force [N]; the force of an impulse is infinite."""
    needed(not issubclass(run.law_classes.get("", object), MultiplierLaw))
    return peak_force(run)


@without_records(
    "max N_l",
    "largest normal force while contacts last: without the impacts of rigid laws, whose force is infinite",
    "N",
)
def peak_lasting_force(run: Run) -> float:
    if "peak_lasting_force" in run.rows:
        return float(run.contacts("peak_lasting_force").max())
    return finite_peak(run)


@without_records("max p_i", "largest normal impulse of an impact under a rigid law", "N s")
def largest_impact(run: Run) -> float:
    return float(run.contacts("largest_impact").max())


@metric(
    "K^(2/5) (5 p_i^2 / (16 m))^(3/5), m = 1/D_nn",
    "force that the largest impact's impulse stands for: the peak of an elastic Hertz contact with that "
    f"impulse, of an assumed stiffness of {ASSUMED_STIFFNESS:g} N/m^1.5, the default of hertz_penalty",
    "N",
    source="Johnson (1985), Contact Mechanics, sec. 11.4",
)
def equivalent_impact_force(run: Run) -> float:
    # An elastic impact of the speed v has the impulse 2 m v, and the depth d of K d^(5/2) = 5 m v^2 / 4.
    energy = 5.0 * positive(largest_impact(run)) ** 2 / (16.0 * effective_mass(run))
    return float(ASSUMED_STIFFNESS**0.4 * energy**0.6)


@without_records("mean p_n", "mean normal impulse of a contact, of those cut what lies in the run", "N s")
def mean_impulse(run: Run) -> float:
    return float(run.contacts("normal_impulse").mean())


@without_records("sum p_n", "normal impulse of all contacts", "N s", usual=True, sums=True)
def total_impulse(run: Run) -> float:
    return float(run.contacts("normal_impulse").sum())


@without_records("sum p_t", "friction impulse of all contacts", "N s", usual=True, sums=True)
def total_friction_impulse(run: Run) -> float:
    return float(run.contacts("friction_impulse").sum())


@without_records("sum t_c", "time in contact", "s", usual=True, sums=True)
def contact_time(run: Run) -> float:
    return float(run.contacts("duration").sum())


@without_records("median t_c", "median duration of a whole contact", "s")
def contact_duration(run: Run) -> float:
    return float(np.median(run.whole_contacts("duration")))


@without_records("sum(t_st) / sum(t_c)", "share of the time in contact that sticks", usual=True)
def stick_share(run: Run) -> float:
    return float(run.contacts("stick_duration").sum()) / positive(contact_time(run))


@without_records(
    "median(-gdot_1 / gdot_0)",
    "apparent restitution: separation over approach velocity. As the drive works on, one is no bound",
    source="Stronge (2000), Impact Mechanics, ch. 3",
)
def restitution(run: Run) -> float:
    approach, separation = run.contacts("approach_velocity"), run.contacts("separation_velocity")
    # A contact that the start or the end of the run cuts has no approach or no separation.
    whole = np.isfinite(separation) & (approach < 0.0)
    needed(whole.any())
    return float(np.median(-separation[whole] / approach[whole]))


def effective_mass(run: Run) -> float:
    """Return the mass that a normal impact meets, 1/D_nn of the undeformed motor [kg]."""
    # The mass does not depend on the law, which may not be installed.
    solver = run.configuration.get("solver")
    if not isinstance(solver, dict):
        raise NotApplicableError
    changes = {"law": {"name": "lagrange_stick"}, "solver": {**solver, "tolerance": None}}
    try:
        modes = config.rebuild({**run.configuration, **changes}).motor.modes
    except config.ConfigurationError as fault:
        raise NotApplicableError from fault
    # At rest the normal is (0, -1) and the slope moves the tip end along the tangent alone.
    return 1.0 / positive(float(modes.tip_displacement @ modes.tip_displacement))


@metric(
    "median(t_c / (3.21 (m^2 / (K^2 v))^(1/5))), m = 1/D_nn",
    "duration of a contact over that of Hertz's free impact at the same approach velocity; longer than one "
    "as the motor's other modes and the drive press on",
    source="Johnson (1985), Contact Mechanics, sec. 11.4, eq. 11.24",
)
def hertz_duration_ratio(run: Run) -> float:
    duration, approach = run.whole_contacts("duration"), run.whole_contacts("approach_velocity")
    falling = approach < 0.0
    needed(falling.any())
    velocity = -approach[falling]
    # The depth of a free impact; 2.94 is 2 int_0^1 dx / sqrt(1 - x^(5/2)).
    deepest = (1.25 * effective_mass(run) * velocity**2 / stiffness(run)) ** 0.4
    return float(np.median(duration[falling] / (2.94 * deepest / velocity)))


@metric(
    "f_99",
    "frequency below which 99 % of the spectral energy of the recorded normal force less its mean lies; near "
    "half the record rate, the records do not resolve the force",
    "Hz",
    source="occupied bandwidth, Recommendation ITU-R SM.328",
)
def force_bandwidth(run: Run) -> float:
    force, lengths = run.series("normal_force")[1:], run.intervals
    # The last record lies at the end of the run and its interval may be shorter.
    if abs(lengths[-1] - lengths[0]) > 1e-6 * lengths[0]:
        force, lengths = force[:-1], lengths[:-1]
    needed(force.size > 0 and np.ptp(lengths) <= 1e-6 * lengths[0])
    # A force that is constant but for round-off has no band.
    needed(np.ptp(force) > 1e-9 * np.max(np.abs(force)))
    # The mean of a pressed contact has nearly all of the energy, and no frequency.
    energy = np.abs(np.fft.rfft(force - force.mean())) ** 2
    # Every line but those at zero and at the Nyquist frequency stands for two.
    energy[1 : (force.size + 1) // 2] *= 2.0
    grown = np.cumsum(energy)
    return int(np.searchsorted(grown, 0.99 * grown[-1])) / (force.size * float(lengths[0]))


@metric(
    "mean Omega",
    "mean rotor velocity of the last whole drive periods; see `unsettled_share`",
    "rad s-1",
    source="paper, fig. 8",
)
def rotor_velocity(run: Run) -> float:
    span = run.last_periods()
    return run.gain("rotor_angle", span) / run.gain("time", span)


@without_records(
    "Omega(T)",
    "rotor velocity at the last record; one of a transient where the run has not settled",
    "rad s-1",
    usual=True,
)
def final_rotor_velocity(run: Run) -> float:
    return float(run.series("rotor_velocity")[-1])


@metric("mean(-R F)", "mean torque of friction on the rotor in the last whole drive periods", "N m")
def torque(run: Run) -> float:
    lever = lever_of(run.setting("rotor.radius"))
    needed(not isnan(lever))
    span = run.last_periods()
    # A mean force stands for the interval that ends at its time.
    force = run.series("friction_force")[span][1:]
    lengths = np.diff(run.time[span])
    return -lever * float(force @ lengths) / float(lengths.sum())


@metric(
    "dW_l / dW_d",
    "work on the load over work of the drive in the last whole drive periods; none where the load drives",
)
def efficiency(run: Run) -> float:
    span = run.last_periods()
    values, done = run.gain("drive_work", span), run.gain("load_work", span)
    needed(values > 0.0 <= done)
    return done / values


@without_records("W_f / W_d", "friction loss over work of the drive", usual=True)
def friction_share(run: Run) -> float:
    return run.gain("friction_loss") / positive(run.gain("drive_work"))


@without_records("W_n / W_d", "loss in normal damping and impacts over work of the drive", usual=True)
def normal_loss_share(run: Run) -> float:
    return run.gain("contact_loss") / positive(run.gain("drive_work"))


@metric(
    "(|Omega_n - Omega_inf| + error) / max(|Omega_inf|, ripple, swing / 100)",
    "largest share by which the mean rotor velocity at the end of a run may be off its steady one",
    bound=SHARE,
    verdicts=(SETTLED, UNSETTLED),
    reason="laws differ by a few per cent in steady-state speed, so the remaining transient must be smaller. "
    "A failure means that the run is too short, not that the law is implausible. Speeds below the ripple, or "
    "1 % of the total change, are scaled by these instead",
    source="`contactlab.settling`",
)
def unsettled_share(run: Run) -> float:
    return run.settling.share


@metric(
    "Omega_inf",
    "mean rotor velocity of the steady state, from the exponential approach of the means of whole drive "
    "periods in the last half of the run",
    "rad s-1",
    source="Seber and Wild (2003), Nonlinear Regression, sec. 5.3",
)
def settled_velocity(run: Run) -> float:
    return run.settling.velocity


@metric(
    "error of Omega_inf",
    "error of the estimated velocity of the steady state, to 95 %: of its scatter, of the window and of the "
    "curvature, distance^2 / (2 swing)",
    "rad s-1",
    source="Seber and Wild (2003), Nonlinear Regression, sec. 5.3",
)
def settled_velocity_error(run: Run) -> float:
    return run.settling.error


@metric("|Delta Omega|", "change of the mean rotor velocity from a drive period to the next", "rad s-1")
def velocity_drift(run: Run) -> float:
    return abs(run.settling.drift)


@metric(
    "|Delta P| / P, P = sum(p_n)", "relative change of the contacts' normal impulse from a period to the next"
)
def impulse_drift(run: Run) -> float:
    return run.settling.impulse_drift
