"""How a run ended, in a sentence: the value, the bound and the way out."""

from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.energy import LEDGER_LIMIT, SCALE
from contactlab.engine.contacts import EVENT_LIMIT
from contactlab.engine.diagnosis import Witness
from contactlab.engine.flight import MOST_HALVINGS
from contactlab.engine.kinematics import Run, contact_from
from contactlab.engine.ledger import openness_of
from contactlab.engine.plant import Plant, modes_of
from contactlab.engine.recorder import IDLE_LIMIT
from contactlab.engine.state import (
    CHATTERED,
    DIVERGED,
    INCONSISTENT,
    NOT_FINITE,
    START,
    UNFOLLOWED,
    UNSOLVED,
)
from contactlab.trajectory import Ending

FARTHEST = 1.0
"""Way of a tip [m] in a steady state from which on round-off, 2e-16 of it, is seen by a contact's force."""


def explain(run: Run, witness: Witness, contact_step: float) -> tuple[Ending, str]:
    """Give the ending of a run that stopped by itself, and a sentence on it."""
    state = run.state
    time, code = f"{state.time:.6g} s", state.ending
    if code == CHATTERED:
        return Ending.CHATTERED, (
            f"The contact chatters at {time}: more than {EVENT_LIMIT} touch-downs and friction "
            f"switches within {state.window:.3g} s, or no progress. The run stops there; a "
            f"shorter contact step than {contact_step:.3g} s or another law may pass it."
        )
    if code == DIVERGED:
        return Ending.DIVERGED, (
            f"The run diverges at {time}: {_runaway(run)}. Check the drive and the law's "
            f"parameters, or shorten the contact step, {contact_step:.3g} s."
        )
    if code == UNFOLLOWED:
        return Ending.DIVERGED, (
            f"The run diverges at {time}: the tip moves too fast to be followed, {MOST_HALVINGS} halvings "
            "of one step of its flight do not tell whether it touches. Check the drive and the start."
        )
    if code == INCONSISTENT:
        return Ending.INCONSISTENT, _inconsistency(state)
    answer = witness.not_finite()
    if answer or code == NOT_FINITE:
        return Ending.DIVERGED, (
            f"The run diverges at {time}: the law answers with {answer or witness.unknown()}. It must "
            "answer every state of a contact with finite numbers and no negative friction bound; mend the "
            "law, or its parameters."
        )
    return Ending.STALLED, (
        f"The run stalls at {time}: {_no_progress(state)}. {_lost_digits(run.plant) or _stiffness(witness)}"
    )


def balanced(state: Any, series: dict[str, Array], contact_step: float) -> tuple[Ending, str]:
    """Give the ending of a run that reached its end: complete, or with an open ledger and a sentence."""
    residual = float(np.abs(series["energy_residual"]).max())
    openness = openness_of(state, residual)
    # A ledger that is no number is not closed.
    if openness <= LEDGER_LIMIT:
        return Ending.COMPLETE, ""
    way_out = (
        "Choose a smaller solver.tolerance; if that does not close it, the energy that the law stores and "
        "loses does not fit its force."
        if state.compliant
        else f"Choose a shorter solver.contact_step than {contact_step:.3g} s."
    )
    return Ending.UNBALANCED, (
        f"The run reached its end, but its energy ledger is open by {openness:.3g} of the energy turned "
        f"over, {SCALE}; it must be at most {LEDGER_LIMIT:g}. {way_out}"
    )


def _runaway(run: Run) -> str:
    """Say in what way the state is no motor's."""
    modes, radius = modes_of(run.plant), run.plant.geometry.radius
    q, v = modes.q[:, START], modes.v[:, START]
    if not (np.isfinite(q).all() and np.isfinite(v).all()):
        return "the state is not finite"
    th = float(modes.row_th @ q)
    if abs(th) >= 1.0:
        return f"the tip leans by {th:.3g} rad, and 1 rad is the most"
    return (
        f"the tip lies {-contact_from(run.plant, q, v)[0]:.3g} m deep in the rotor, and a tenth of its "
        f"radius, {0.1 * radius:.3g} m, is the most"
    )


def _no_progress(state: Any) -> str:
    """Say how little a run moves."""
    if state.ending == UNSOLVED:
        return "no step in contact, however short, satisfies the law"
    if state.idle > IDLE_LIMIT:
        return f"more than {IDLE_LIMIT} steps in a row hardly move the clock"
    return (
        f"more than {state.most_steps} steps in contact within {state.window:.3g} s, where a few "
        "hundred are usual"
    )


def _lost_digits(plant: Plant) -> str:
    """Say whether the tones' steady state leaves no digits to a contact, in words; empty where it does."""
    sway = float(plant.tones["steady_u"].sum())
    if sway < FARTHEST:
        return ""
    return (
        f"The steady state of the tones moves the tip by {sway:.3g} m, and a gap that is summed from it is "
        f"good to {sway * np.finfo(np.float64).eps:.3g} m only. Leave out a tone that meets a mode without "
        "stiffness so slowly."
    )


def _stiffness(witness: Witness) -> str:
    """Say what of the law the steps are too long for, and the way out."""
    jump = witness.jump()
    if not jump:
        return "Check the law's parameters, or choose a larger solver.tolerance."
    return (
        f"The law's {jump}: for the steps that is a jump. Let the force change over a wider range; "
        "friction that jumps with the slip is set-valued and wants no kernel of its own."
    )


def _inconsistency(state: Any) -> str:
    """Say why a rigid contact closes and its law has no impulse for it."""
    time = float(state.time)
    friction, critical = state.friction_limit, state.critical_friction
    if friction < critical:
        return (
            f"The run ends at {time:.6g} s: the contact closes, and the law has no normal impulse that "
            "stops it. Check the law: an approach must be answered."
        )
    return (
        f"The run ends at {time:.6g} s in Painleve's paradox: the friction coefficient {friction:.6g} is "
        f"not below the critical {critical:.6g}, d_nn/|d_nt| of the contact there, so that the friction of "
        "its slip presses the bodies together more than the normal impulse parts them, and the law has no "
        "impulse that stops the approach. Lower the friction coefficient, or take a law that may stick or "
        "a compliant one."
    )
