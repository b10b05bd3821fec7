"""Whether the books of a run close: energy, angular momentum and impulses."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from contactlab.energy import LEDGER_LIMIT, SCALE, openness
from contactlab.metrics.declared import corrects_displacements
from contactlab.metrics.measure import Measure
from contactlab.metrics.metric import ROUND_OFF, Metric
from contactlab.metrics.record import Record, needed

Array = NDArray[np.float64]


def _energy_residual(record: Record) -> float:
    # From the terms, not from the recorded residual: the metric judges the numbers that are shown.
    stored = _sum(record, "kinetic_energy", "strain_energy", "contact_energy")
    spent = _sum(record, "damping_loss", "friction_loss", "contact_loss", "load_work")
    work, load = record.series("drive_work"), record.series("load_work")
    residual = stored - stored[0] - (work - work[0]) + (spent - spent[0])
    by_drive, by_load = (float(np.abs(part - part[0]).max()) for part in (work, load))
    needed(max(by_drive, by_load, float(stored[0])) > 0.0)
    return openness(float(np.abs(residual).max()), by_drive, by_load, float(stored[0]))


def _sum(record: Record, *names: str) -> Array:
    return np.asarray(np.sum([record.series(name) for name in names], axis=0))


def _rotor_momentum(record: Record) -> float:
    inertia, radius = record.setting("rotor", "inertia"), record.setting("rotor", "radius")
    damping, torque = record.setting("rotor", "damping"), record.setting("rotor", "load_torque")
    velocity, angle = record.series("rotor_velocity"), record.series("rotor_angle")
    push = record.contacts("friction_impulse")
    given = radius * float(np.abs(push).sum())
    needed(given > 0.0)
    load = float(torque * (record.time[-1] - record.time[0]))
    damped = float(damping * (angle[-1] - angle[0]))
    missing = float(inertia * (velocity[-1] - velocity[0]) + radius * push.sum() + load + damped)
    # A rigid law that puts displacements back onto the closed gap at the end of a step h has an angle that
    # follows the velocity to within h times what friction changes of it, R sum|p_t| / J. What damping
    # makes of that must stay below what is to be seen.
    corrected = damping * record.contact_step / inertia if corrects_displacements(record) else 0.0
    needed(corrected < 1.0)
    # Where friction is the least of the terms, the others round off more than it weighs.
    scale = max(given, inertia * float(np.abs(velocity).max()), abs(load), abs(damped))
    return abs(missing) / max(scale, corrected * given / ROUND_OFF)


def _impulse_balance(record: Record) -> float:
    worst = 0.0
    scale = float(np.abs(record.contacts("normal_impulse")).sum())
    needed(scale > 0.0)
    for force, impulse in (
        ("normal_force", "normal_impulse"),
        ("friction_force", "friction_impulse"),
    ):
        pushed = float(record.series(force)[1:] @ record.intervals)
        worst = max(worst, abs(pushed - float(record.contacts(impulse).sum())))
    return worst / scale


MEASURES: Final[tuple[Measure[Record], ...]] = (
    Measure(
        Metric(
            "energy_residual",
            f"max|r| / {SCALE}",
            "1",
            "energy that the ledger cannot account for, over the energy turned over",
            "<=",
            LEDGER_LIMIT,
            "the contact's share of the drive work, what laws differ in, is a few per cent: a ledger "
            "open by one per cent could hide it. A first-order law at its default step is "
            "open by a tenth of that at most, a compliant law by far less",
            "first law of thermodynamics",
        ),
        _energy_residual,
    ),
    Measure(
        Metric(
            "rotor_momentum",
            "|J dOmega + R sum p_t + tau T + C_r dalpha| / max(R sum|p_t|, J max|Omega|, |tau T|, "
            "|C_r dalpha|)",
            "1",
            "angular momentum of the rotor that friction impulses, load and damping do not explain",
            "<=",
            ROUND_OFF,
            "action equals reaction at any step: both sides add up the same impulses, only round-off "
            "(seven digits in single precision) is between them. A rigid law that projects corrects the "
            "angle too, by a step h of the change of velocity: a damped rotor is judged up to C_r h / J of "
            "its impulses, where that is less than one",
            "Newton's third law; paper, eq. 48 with the radius",
        ),
        _rotor_momentum,
    ),
    Measure(
        Metric(
            "impulse_balance",
            "max over n, t of |sum p - sum F dt| / sum|p_n|",
            "1",
            "impulses of the contacts against the recorded mean forces",
            "<=",
            ROUND_OFF,
            "a recorded force is the mean of its interval, so that both are the same integral up to "
            "round-off (seven digits in single precision)",
            "definition of impulse and of mean force",
        ),
        _impulse_balance,
    ),
)
"""Metrics of the books."""
