"""How a run ended, in a sentence: the value, the bound and the way out."""

import numpy as np

from contactlab.arrays import Array
from contactlab.energy import LEDGER_LIMIT, SCALE
from contactlab.engine.balance import openness_of
from contactlab.engine.diagnosis import Witness
from contactlab.engine.inconsistency import inconsistency
from contactlab.engine.plant import Plant
from contactlab.engine.readout import energy_of
from contactlab.engine.run import (
    CHATTERED,
    DIVERGED,
    ENDING,
    EVENT_LIMIT,
    IDLE,
    IDLE_LIMIT,
    INCONSISTENT,
    MOST_STEPS,
    NOT_FINITE,
    TIME,
    UNFOLLOWED,
    UNSOLVED,
    WINDOW,
    Run,
)
from contactlab.engine.step import Step
from contactlab.engine.touchdown import MOST_HALVINGS
from contactlab.motor.geometry import contact_frame
from contactlab.trajectory import Ending

FARTHEST = 1.0
"""Way of a tip [m] in a steady state from which on round-off, 2e-16 of it, is seen by a contact's force."""


def explain(
    plant: Plant, step: Step, run: Run, witness: Witness, contact_step: float
) -> tuple[Ending, str]:
    """The ending of a run that stopped by itself, and a sentence on it."""
    time, code = f"{run.real[TIME]:.6g} s", run.whole[ENDING]
    if code == CHATTERED:
        return Ending.CHATTERED, (
            f"The contact chatters at {time}: more than {EVENT_LIMIT} touch-downs and friction "
            f"switches within {run.real[WINDOW]:.3g} s, or no progress. The run stops there; a "
            f"shorter contact step than {contact_step:.3g} s or another law may pass it."
        )
    if code == DIVERGED:
        return Ending.DIVERGED, (
            f"The run diverges at {time}: {_runaway(plant, step)}. Check the drive and the law's "
            f"parameters, or shorten the contact step, {contact_step:.3g} s."
        )
    if code == UNFOLLOWED:
        return Ending.DIVERGED, (
            f"The run diverges at {time}: the tip moves too fast to be followed, {MOST_HALVINGS} halvings "
            "of one step of its flight do not tell whether it touches. Check the drive and the start."
        )
    if code == INCONSISTENT:
        return Ending.INCONSISTENT, inconsistency(run)
    answer = witness.not_finite()
    if answer or code == NOT_FINITE:
        return Ending.DIVERGED, (
            f"The run diverges at {time}: the law answers with {answer or witness.unknown()}. It must "
            "answer every state of a contact with finite numbers and no negative friction bound; mend the "
            "law, or its parameters."
        )
    return Ending.STALLED, (
        f"The run stalls at {time}: {_no_progress(run)}. {_lost_digits(plant) or _stiffness(witness)}"
    )


def balanced(
    run: Run, series: dict[str, Array], compliant: bool, contact_step: float
) -> tuple[Ending, str]:
    """The ending of a run that reached its end: complete, or with a ledger that is open and a sentence."""
    residual = float(np.abs(series["energy_residual"]).max())
    openness = openness_of(run, float(energy_of(series)[0]), residual)
    # A ledger that is no number is not closed.
    if openness <= LEDGER_LIMIT:
        return Ending.COMPLETE, ""
    way_out = (
        "Choose a smaller solver.tolerance; if that does not close it, the energy that the law stores and "
        "loses does not fit its force."
        if compliant
        else f"Choose a shorter solver.contact_step than {contact_step:.3g} s."
    )
    return Ending.UNBALANCED, (
        f"The run reached its end, but its energy ledger is open by {openness:.3g} of the energy turned "
        f"over, {SCALE}; it must be at most {LEDGER_LIMIT:g}. {way_out}"
    )


def _runaway(plant: Plant, step: Step) -> str:
    """In what way the state is no motor's."""
    if not (np.isfinite(step.q).all() and np.isfinite(step.v).all()):
        return "the state is not finite"
    u, th = float(plant.row_u @ step.q), float(plant.row_th @ step.q)
    if abs(th) >= 1.0:
        return f"the tip leans by {th:.3g} rad, and 1 rad is the most"
    gap = contact_frame(u, th, plant.tip_length, plant.radius, plant.clearance)[0]
    return (
        f"the tip lies {-gap:.3g} m deep in the rotor, and a tenth of its radius, "
        f"{0.1 * plant.radius:.3g} m, is the most"
    )


def _no_progress(run: Run) -> str:
    """How little a run moves."""
    if run.whole[ENDING] == UNSOLVED:
        return "no step in contact, however short, satisfies the law"
    if run.whole[IDLE] > IDLE_LIMIT:
        return f"more than {IDLE_LIMIT} steps in a row hardly move the clock"
    return (
        f"more than {run.whole[MOST_STEPS]} steps in contact within {run.real[WINDOW]:.3g} s, where a few "
        "hundred are usual"
    )


def _lost_digits(plant: Plant) -> str:
    """Whether the tones' steady state leaves no digits to a contact, in words; empty where it does."""
    sway = float(plant.steady_u.sum())
    if sway < FARTHEST:
        return ""
    return (
        f"The steady state of the tones moves the tip by {sway:.3g} m, and a gap that is summed from it is "
        f"good to {sway * np.finfo(np.float64).eps:.3g} m only. Leave out a tone that meets a mode without "
        "stiffness so slowly."
    )


def _stiffness(witness: Witness) -> str:
    """What of the law the steps are too long for, and the way out."""
    jump = witness.jump()
    if not jump:
        return "Check the law's parameters, or choose a larger solver.tolerance."
    return (
        f"The law's {jump}: for the steps that is a jump. Let the force change over a wider range; "
        "friction that jumps with the slip is set-valued and wants no kernel of its own."
    )
