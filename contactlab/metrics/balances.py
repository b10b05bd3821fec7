"""Invariants of a run, which no law can break: a failure is a fault of the solver or of the file."""

from typing import Final

import numpy as np

from contactlab.laws.base import FREE
from contactlab.metrics.catalogue import ROUND_OFF, invariant
from contactlab.metrics.run import Run, has_limits, needed, positive
from contactlab.motor.geometry import ContactGeometry
from contactlab.trajectory import LEDGER_LIMIT, SCALE, openness
from contactlab.window import CLOCK

RESOLVED: Final = 1e-12  # share of the motor's energy, or of the normal impulses, that is round-off

STORED: Final = ("kinetic_energy", "strain_energy", "contact_energy")
SPENT: Final = ("damping_loss", "friction_loss", "contact_loss", "load_work")


@invariant(
    f"max|r| / {SCALE}",
    "energy balance error over the energy turned over",
    bound=LEDGER_LIMIT,
    reason="the contact's share of the drive work, in which laws differ, is a few per cent: an error of one "
    "per cent could hide it. A first-order law at its default step has a tenth of that",
    source="first law of thermodynamics",
)
def energy_residual(run: Run) -> float:
    stored, spent = (np.sum([run.series(n) for n in names], axis=0) for names in (STORED, SPENT))
    work, load = run.series("drive_work"), run.series("load_work")
    residual = stored - stored[0] - (work - work[0]) + (spent - spent[0])
    by_drive, by_load = (float(np.abs(part - part[0]).max()) for part in (work, load))
    needed(max(by_drive, by_load, float(stored[0])) > 0.0)
    return openness(float(np.abs(residual).max()), by_drive, by_load, float(stored[0]))


@invariant(
    "|J dOmega + R sum p_t + tau T + C_r dalpha| / max(R sum|p_t|, J max|Omega|, |tau T|, |C_r dalpha|, "
    f"{RESOLVED / ROUND_OFF:g} R sum|p_n|)",
    "angular momentum of the rotor that friction impulses, load and damping do not explain",
    bound=ROUND_OFF,
    reason="action equals reaction at any step: both sides add up the same impulses but for round-off. A "
    "rigid law that projects corrects the angle by a step h of the change of velocity: the scale of a damped "
    "rotor has C_r h / J of its impulses, with the largest damping of the run, where that is less than one. "
    "Friction that is no digit of the normal force is round-off",
    source="Newton's third law; paper, eq. 48 with the radius",
)
def rotor_momentum(run: Run) -> float:
    inertia, radius = run.setting("rotor.inertia"), run.setting("rotor.radius")
    fastest, push = np.abs(run.series("rotor_velocity")).max(), run.contacts("friction_impulse")
    values = positive(radius * float(np.abs(push).sum()))
    load = run.integral("rotor.load_torque", "N m", "time")
    damped = run.integral("rotor.damping", "N m s rad-1", "rotor_angle")
    missing = inertia * run.gain("rotor_velocity") + radius * float(push.sum()) + load + damped
    projects = getattr(run.law_classes.get(""), "projects", False)
    largest = max(value for value, _ in run.course("rotor.damping", "N m s rad-1"))
    corrected = largest * run.contact_step / inertia if projects else 0.0
    needed(corrected < 1.0)
    pressed = RESOLVED / ROUND_OFF * radius * float(np.abs(run.contacts("normal_impulse")).sum())
    scale = max(values, inertia * float(fastest), abs(load), abs(damped), pressed)
    return abs(missing) / max(scale, corrected * values / ROUND_OFF)


@invariant(
    "max(|sum p - sum F dt|) / sum(|p_n| + |p_t|)",
    "impulses of the contacts against the recorded mean forces, normal and tangential",
    bound=ROUND_OFF,
    reason="a recorded force is the mean of its interval: both are the same integral but for round-off",
    source="definition of impulse and of mean force",
)
def impulse_balance(run: Run) -> float:
    missing, size = [], 0.0
    for way in ("normal", "friction"):
        forces, impulses = run.series(f"{way}_force")[1:], run.contacts(f"{way}_impulse")
        missing.append(abs(float(forces @ run.intervals) - float(impulses.sum())))
        # Friction with cohesion may be all that there is.
        size += float(np.abs(impulses).sum())
    return max(missing) / positive(size)


@invariant(
    f"|sum W - (W_f + W_n)| / max(sum|W|, {RESOLVED / ROUND_OFF:g} E)",
    "energy loss of the contacts against the recorded losses of friction and contact; not applicable to a "
    "run that starts in flight with energy that a contact before has stored",
    bound=ROUND_OFF,
    reason="every loss is that of one contact: both sides add up the same numbers but for round-off",
    source="first law of thermodynamics",
)
def loss_balance(run: Run) -> float:
    losses, start = run.contacts("energy_loss"), run.time[0]
    stored, begins = float(run.series("contact_energy")[0]), float(run.contacts("start_time")[0])
    needed(start == 0.0 or stored == 0.0 or begins <= start + CLOCK * np.spacing(run.time[-1]))
    missing = float(losses.sum()) - run.gain("friction_loss") - run.gain("contact_loss")
    energy = run.series("kinetic_energy") + run.series("strain_energy")
    scale = max(float(np.abs(losses).sum()), RESOLVED / ROUND_OFF * float(energy.max()))
    return abs(missing) / positive(scale)


@invariant(
    "share with t_c <= 0 or t_s before the last end",
    "share of the contacts without duration, or that overlap the previous contact",
    bound=0.0,
    reason="a contact takes time, and there is one tip",
    source="definition of a contact",
)
def phantom_contacts(run: Run) -> float:
    start, duration = run.contacts("start_time"), run.contacts("duration")
    impulse = np.abs(run.contacts("normal_impulse"))
    resolution = CLOCK * np.spacing(np.maximum(start + duration, run.time[-1]))
    # The end of the run may truncate the last contact at its first instant.
    inside = start < run.time[-1] - resolution
    empty = inside & ((duration < 0.0) | ((duration <= resolution) & (impulse == 0.0)))
    overlap = start[1:] < (start + duration)[:-1] - resolution[1:]
    return float(empty.sum() + overlap.sum()) / start.size


@invariant(
    "max(-gdot_1, gdot_0, 0) / max(|gdot|)",
    "largest gap rate of the wrong sign: closing at a release or opening at a touch-down, over the fastest; "
    "the latter is left out for laws that define the gap at which contacts begin",
    bound=1e-3,
    reason="a gap that opens does not close; a first-order law is late by a step, 1e-3 of a contact",
    source="definition of touch-down and release",
)
def closing_release(run: Run) -> float:
    approach, separation = run.contacts("approach_velocity"), run.contacts("separation_velocity")
    closing = float(np.nanmax(np.append(-separation, 0.0)))
    # A start in contact may be opening; any other contact begins by closing.
    later = (run.contacts("start_time") > 0.0) & (not _defines_contact(run))
    opening = float(np.nanmax(np.append(approach[later], 0.0)))
    # The whole motion counts: the rates of a tip that only grazes are round-off.
    rates = np.abs(np.diff(run.series("gap")) / run.intervals)
    fastest = float(np.nanmax(np.append(np.abs(approach), 0.0)))
    return max(closing, opening) / positive(max(fastest, float(rates.max(initial=0.0))))


@invariant(
    "max(-g, 0) / A without contact",
    "deepest overlap of tip and rotor without contact, over half the range of the tip's normal motion; not "
    "applicable to laws that define the gap at which contacts begin",
    bound=1e-3,
    reason="bodies that overlap touch; a first-order release is off by a step, which moves the gap by less",
    source="0 <= g outside of contact",
)
def missed_contact(run: Run) -> float:
    needed(not _defines_contact(run))
    gap, free, time = run.series("gap"), run.series("contact_mode") == FREE, run.time
    # A record at the very instant of a touch-down or a release may carry either mode.
    if run.touches("start_time"):
        start = np.sort(run.contacts("start_time"))
        end = np.sort(start + run.contacts("duration"))
        near = CLOCK * np.spacing(time[-1])
        begun = np.searchsorted(start, time + near, side="right")
        ended = np.searchsorted(end, time - near, side="left")
        free = free & (begun == ended)
    return float(np.max(np.append(-gap[free], 0.0))) / _motion(run)


@invariant(
    "max(p_n / t_c - N_max, max N - max N_max, 0) / max(max N_max, 1e-12 E / A)",
    "mean forces above the recorded peak of their contact, over the largest peak",
    bound=ROUND_OFF,
    reason="no mean is above its maximum, but for round-off",
    source="definition of a mean",
)
def peak_deficit(run: Run) -> float:
    peak = run.contacts("peak_normal_force")
    impulse, duration = run.contacts("normal_impulse"), run.contacts("duration")
    # A force is round-off if its work over the tip's amplitude is none of the motor's energy.
    energy = run.series("kinetic_energy") + run.series("strain_energy")
    scale = max(float(np.abs(peak).max()), RESOLVED * float(energy.max()) / _motion(run))
    mean = impulse[duration > 0.0] / duration[duration > 0.0]
    over_mean = float(np.max(np.append(mean - peak[duration > 0.0], 0.0)))
    # The first record has the mean of the interval before the run.
    over_records = float(run.series("normal_force")[1:].max()) - float(peak.max())
    return max(over_mean, over_records, 0.0) / scale


@invariant(
    "max(-min g - max d_max - max(|gdot_0| h / 2), 0) / A, h = p_i / N_max",
    "recorded overlap beyond the largest penetration of the contacts, over half the range of the tip's "
    "normal motion",
    bound=1e-2,
    reason="no record lies deeper than the deepest point. Time stepping of a rigid law knows the depth where "
    "steps begin: in the step h of an impact a constant force stops the approach, and the gap sinks by "
    "gdot_0 h / 2 at most; what other forces add in a step is a few thousandths",
    source="definition of a maximum",
)
def depth_deficit(run: Run) -> float:
    depth = -float(run.series("gap").min()) - float(run.contacts("max_penetration").max())
    # An impact in the limit of no step has an infinite force and takes no time; a compliant law has none.
    if "largest_impact" in run.rows and np.isfinite(run.rows["peak_normal_force"]).all():
        impulse, peak = run.contacts("largest_impact"), run.contacts("peak_normal_force")
        stepped = impulse > 0.0
        approach = np.abs(run.contacts("approach_velocity")[stepped])
        depth -= float((0.5 * approach * impulse[stepped] / peak[stepped]).max(initial=0.0))
    return max(depth, 0.0) / _motion(run)


@invariant(
    "max|g - g(u, theta)| / A",
    "recorded gap against that of recorded displacements, over half the range of the tip's normal motion",
    bound=ROUND_OFF,
    reason="both are the same geometry, but for round-off",
    source="paper, eqs. 35-37",
)
def gap_mismatch(run: Run) -> float:
    geometry = ContactGeometry(
        tip_length=run.setting("contact.tip_length"),
        rotor_radius=run.setting("rotor.radius"),
        clearance=run.setting("contact.clearance"),
        # Runs of before the angle lack it.
        angle=run.settings.get("contact.angle", 0.0),
    )
    u, slope = run.series("tip_normal_displacement"), run.series("tip_slope")
    if "rotor_normal_displacement" in run.columns:
        u = u - run.series("rotor_normal_displacement")
    pairs = zip(u.tolist(), slope.tolist(), strict=True)
    expected = np.array([geometry.frame(rise, turn)[0] for rise, turn in pairs])
    return float(np.abs(run.series("gap") - expected).max()) / _motion(run)


def _defines_contact(run: Run) -> bool:
    """Return whether the law or one of its parts defines the gaps at which a contact begins and ends."""
    return any(map(has_limits, run.law_classes.values()))


def _motion(run: Run) -> float:
    """Return half the range of the tip's normal motion [m]."""
    return positive(0.5 * float(np.ptp(run.series("tip_normal_displacement"))))
