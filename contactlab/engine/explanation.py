"""How a run ended, in a sentence: the value, the bound and the way out."""

from math import isfinite
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.engine.compliant import most_events
from contactlab.engine.flight import MOST_HALVINGS
from contactlab.engine.kinematics import contact_at, contact_from
from contactlab.engine.memory import SLIP_ROUND_OFF
from contactlab.engine.plant import modes_of, resolved_rate
from contactlab.engine.state import (
    CHATTERED,
    DIVERGED,
    INCONSISTENT,
    NOT_FINITE,
    START,
    UNFOLLOWED,
    UNSOLVED,
    Run,
)
from contactlab.laws.base import FREE, SET_VALUED, STICK
from contactlab.trajectory import LEDGER_LIMIT, SCALE, Ending, openness

FARTHEST: Final = 1.0
"""Way of a tip [m] in a steady state from which on round-off, 2e-16 of it, is seen by a contact's force."""

DIGITS: Final = 32.0 * float(np.finfo(np.float64).eps)
"""Round-off of a velocity that a step's forces make, over what each of them does by itself."""

RESOLVED: Final = 0.1
"""Angle [rad] by which the fastest vibration may turn within a step of first order."""

NEGLIGIBLE: Final = 1e-6
"""Share of the energy turned over below which the ledger of a contact is not judged."""

STATES: Final = 9
"""States at which a law is evaluated along the step that it did not solve."""

OF_FORCE: Final = ("normal force", "least friction", "friction bound", "stored energy", "normal loss")
OF_FRICTION: Final = (
    "friction",
    "rate of the friction's memory",
    "stored energy of the friction",
    "tangential stiffness",
)


def explain(run: Run, kernels: tuple[Any, ...], parameters: Array, contact_step: float) -> tuple[Ending, str]:
    """Return the ending of a run that stopped by itself, and a sentence on it; the kernels are its law's."""
    state, rule = run.state, run.propagator.rule
    time, pace = f"{state.time:.6g} s", f"within {state.watchdog.window:.3g} s"
    friction, critical = state.law.friction_limit, state.critical_friction
    shorter = f"a shorter contact step than {contact_step:.3g} s"
    if state.law.constrained:
        shorter = f"a smaller tolerance than {state.tolerance:.3g}"
    way_out = "A larger tolerance takes shorter flights as none; give the law damping or restitution below 1."
    if state.law.stepped:
        way_out = "Leave out the contact step: without one the law is solved in its limit, without chatter."
    elif state.law.compliant:
        way_out = "Give the law damping, or friction without a jump; a larger tolerance takes longer steps."
    endings = {
        CHATTERED: (
            Ending.CHATTERED,
            f"The contact chatters at {time}: more than {most_events(state)} touch-downs, friction switches "
            f"and guards {pace}, or no progress. The run stops there. {way_out}",
        ),
        DIVERGED: (
            Ending.DIVERGED,
            f"The run diverges at {time}: {_runaway(run)}. Check the drive and the law's parameters, or try "
            f"{shorter}.",
        ),
        UNFOLLOWED: (
            Ending.DIVERGED,
            f"The run diverges at {time}: the tip moves too fast to be followed, {MOST_HALVINGS} halvings "
            "of one step of its flight do not tell whether it touches. Check the drive and the start.",
        ),
        INCONSISTENT: (
            Ending.INCONSISTENT,
            f"The run ends at {time}: the contact closes, and the law has no normal impulse that stops it. "
            "Check the law: an approach must be answered."
            if friction < critical
            else f"The run ends at {time} in Painleve's paradox: the friction coefficient {friction:.6g} is "
            f"not below the critical {critical:.6g}, d_nn/|d_nt| of the contact there, so that the friction "
            "of its slip presses the bodies together more than the normal impulse parts them, and the law "
            "has no impulse that stops the approach. Lower the friction coefficient, or take a law that may "
            "stick or a compliant one.",
        ),
    }
    if state.ending in endings:
        return endings[int(state.ending)]
    reach = rule.longest * 0.5**rule.contact_level
    fault = _not_finite(run, kernels, parameters, reach)
    if fault or state.ending == NOT_FINITE:
        fault = fault or f"a value that is not finite near {_contact_text(_contact_after(run, 0.0))}"
        return Ending.DIVERGED, (
            f"The run diverges at {time}: the law returns {fault}. It must "
            "answer every state of a contact with finite numbers and no negative friction bound; mend the "
            "law, or its parameters."
        )
    reason = f"more than {state.watchdog.most_steps} steps in contact {pace}, where a few hundred are usual"
    if state.ending == UNSOLVED:
        reason = "no step in contact, however short, satisfies the law"
    elif state.watchdog.idle_steps > state.watchdog.most_idle:
        reason = f"more than {state.watchdog.most_idle} steps in a row hardly move the clock"
    why = (
        "A force that jumps with gap, gap rate or slip stalls the steps: check the law and its parameters, "
        "or choose a larger solver.tolerance. Friction that jumps with the slip is set-valued."
    )
    sway = float(run.plant.tones["steady_u"].sum())
    if sway >= FARTHEST:
        why = (
            f"The steady state of the tones moves the tip by {sway:.3g} m, and a gap that is summed "
            f"from it is good to {sway * np.finfo(np.float64).eps:.3g} m only. Leave out a tone that meets a "
            "mode without stiffness so slowly."
        )
    return Ending.STALLED, f"The run stalls at {time}: {reason}. {why}"


def balanced(
    run: Run, series: dict[str, Array], modes: NDArray[np.int8], contact_step: float
) -> tuple[Ending, str]:
    """Return the ending of a run that reached its end: complete, or unbalanced with a sentence."""
    state = run.state
    # Eq. 6.4.
    start = float(state.initial_energy)
    # The records know of contacts as well; without any flight there is neither a least nor a most.
    seen = [float(each) - start for each in (state.least_remainder, state.most_remainder)]
    # A residual that is no number stays the largest: `max` keeps its first argument.
    residual = float(np.abs(series["energy_residual"]).max())
    residual = max([residual, *(abs(each) for each in seen if isfinite(each))])
    share = openness(residual, float(state.turnover), 0.0, start)
    if not share <= LEDGER_LIMIT:
        share = openness(max(residual - _round_off(run), 0.0), float(state.turnover), 0.0, start)
    opened = _opened_by_contact(series, modes, float(state.turnover)) if share <= LEDGER_LIMIT else np.nan
    if opened <= LEDGER_LIMIT:
        return Ending.COMPLETE, ""
    swing, unresolved = contact_step * resolved_rate(run.plant), ""
    if swing > RESOLVED:
        unresolved = (
            f"A step holds the contact's force, and the fastest mode or tone turns by {swing:.2g} rad "
            f"meanwhile: the error is of first order in this angle, and more than {RESOLVED:g} rad is long. "
        )
    way_out = (
        "Choose a smaller solver.tolerance; if that does not close it, the energy that the law stores and "
        "loses does not fit its force."
        if state.law.compliant or state.law.constrained
        else f"{unresolved}Choose a shorter solver.contact_step than {contact_step:.3g} "
        "s, or leave it out: the law is solved in its limit then."
    )
    # A ledger that is no number is not closed.
    if share <= LEDGER_LIMIT:
        return Ending.UNBALANCED, (
            f"The run reached its end, but in contact its energy ledger opens by {opened:.3g} of what a "
            f"contact stores and loses; it must be at most {LEDGER_LIMIT:g}. {way_out}"
        )
    return Ending.UNBALANCED, (
        f"The run reached its end, but its energy ledger is open by {share:.3g} of the energy turned "
        f"over, {SCALE}; it must be at most {LEDGER_LIMIT:g}. {way_out}"
    )


def _round_off(run: Run) -> float:
    """Return the round-off of the ledger [J] of a contact at rest, which turns nothing over.

    It is the work of its impulses p at the round-off of the velocities: that of a slip which is located, and
    that of D p, which cancels in each step what the load does.
    """
    state, modes = run.state, modes_of(run.plant)
    _, _, _, n_u, n_th, t_u, t_th = contact_at(run.plant, START)
    rows = (
        n_u * modes["row_u"] + n_th * modes["row_th"],
        t_u * modes["row_u"] + t_th * modes["row_th"] + modes["row_r"],
    )
    impulses = float(state.total.normal_impulse), float(state.total.friction_impulse)
    # D p of a step is that of the whole impulse over the number of steps; its round-off then adds up over all
    # of them.
    share = DIGITS / max(int(state.contact_steps), 1)
    return float(
        sum(
            abs(p) * (SLIP_ROUND_OFF + share * abs(p) * (row @ row))
            for p, row in zip(impulses, rows, strict=True)
        )
    )


def _opened_by_contact(series: dict[str, Array], modes: NDArray[np.int8], turned_over: float) -> float:
    """Return how far the ledger opens between flight and contact, over what a contact stores and loses [1].

    A stored energy that contradicts the force is missing from the ledger only while the contact lasts.
    """
    stored, residual = series["contact_energy"], series["energy_residual"]
    if not stored.max() > 0.0:
        return 0.0
    touches = modes != FREE
    begins = np.flatnonzero(touches[1:] & ~touches[:-1])
    if not begins.size:
        return 0.0
    # The last record of the flight before each record in contact.
    before = np.maximum.accumulate(np.where(touches, -1, np.arange(touches.size)))
    seen = touches & (before >= 0)
    opened = np.abs(residual[seen] - residual[before[seen]]).max(initial=0.0)
    if opened <= NEGLIGIBLE * turned_over:
        return 0.0
    lost = (series["contact_loss"][-1] + series["friction_loss"][-1]) / begins.size
    return float(opened / (stored.max() + max(lost, 0.0)))


def _runaway(run: Run) -> str:
    """Return in what way the state is no motor's."""
    modes, radius = modes_of(run.plant), run.plant.geometry.radius
    q, v = modes["q"][:, START], modes["v"][:, START]
    if not (np.isfinite(q).all() and np.isfinite(v).all()):
        return "the state is not finite"
    th = float(modes["row_th"] @ q)
    if abs(th) >= 1.0:
        return f"the tip leans by {th:.3g} rad, and 1 rad is the most"
    return (
        f"the tip lies {-contact_from(run.plant, q, v)[0]:.3g} m deep in the rotor, and a tenth of its "
        f"radius, {0.1 * radius:.3g} m, is the most"
    )


def _not_finite(run: Run, kernels: tuple[Any, ...], parameters: Array, reach: float) -> str:
    """Return the first inadmissible value along the step, in words; empty for none."""
    state = run.state
    if not state.law.compliant:
        impulses = {"normal": state.normal.node[0], "friction": state.friction.node[0]}
        values = [f"{name} impulse {p}" for name, p in impulses.items() if not np.isfinite(p)]
        return f"{' and '.join(values)} at {_contact_text(_contact_after(run, 0.0))}" if values else ""
    for time in np.linspace(0.0, reach, STATES):
        contact = _contact_after(run, time)
        if not contact[0] < 0.0:
            continue
        values = kernels[0](*contact, state.impact_speed, parameters)
        forces = dict(zip(OF_FORCE, values, strict=True))
        if state.law.friction_kind != SET_VALUED:
            forces |= zip(OF_FRICTION, kernels[1](*contact, values[0], parameters), strict=True)
        for name, value in forces.items():
            if not np.isfinite(value) or (name == "friction bound" and value < 0.0):
                return f"{name} {value} at {_contact_text(contact)}"
    return ""


def _contact_after(run: Run, time: float) -> tuple[float, float, float]:
    """Return gap [m], gap rate and slip [m/s] after some time [s] of straight motion from the run's end."""
    modes = modes_of(run.plant)
    q, v = modes["q"][:, START] + time * modes["v"][:, START], modes["v"][:, START]
    gap, rate, slip = contact_from(run.plant, q, v)
    return gap, rate, 0.0 if run.state.mode == STICK else slip


def _contact_text(contact: tuple[float, float, float]) -> str:
    """Return gap, gap rate and slip as text."""
    return "a gap of {:.6g} m, a gap rate of {:.6g} m/s and a slip of {:.6g} m/s".format(*contact)
