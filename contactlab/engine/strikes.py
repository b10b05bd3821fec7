"""Many impacts under one law: what `contactlab.engine.impact` needs, and what became of each."""

from functools import cache
from typing import Any, Final, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.engine.arguments import check_law, check_tolerance
from contactlab.engine.context import Impacts, Run
from contactlab.engine.impact import MOMENT, OUTCOME, WAY
from contactlab.engine.plant import MODES, TONES, Plant, plant_record
from contactlab.engine.preparation import DEFAULT_TOLERANCE, Prepared, fresh_state, take_in
from contactlab.engine.propagator import Propagator, Workspace
from contactlab.engine.state import INCONSISTENT, PRESSED, RUNNING, STATE, one
from contactlab.laws.base import ContactLaw, MultiplierLaw
from contactlab.trajectory import Ending

PIECE: Final = 500
"""Impacts between two looks at Ctrl-C."""


@final
class Struck(NamedTuple):
    """What became of impacts.

    Args:
        outcomes: records of `OUTCOME`, shape (impact,).
        histories: records of `MOMENT`, shape (impact, record).
        endings, reasons: how each ended, shape (impact,), and a sentence where it is not COMPLETE.
    """

    outcomes: Any
    histories: Any
    endings: NDArray[np.int8]
    reasons: tuple[str, ...]


def velocities(law: ContactLaw, contacts: Array, tolerance: float | None) -> Array:
    """Give gap rates and slips after impacts, shape (impact, 2), NaN where there are none; see `struck`.

    A law is asked whether it contradicts itself for its first parameters alone.
    """
    outcomes = _Striking(law, tolerance, once=True).strike(contacts, 0)[0]
    return np.column_stack([outcomes["normal_rate"], outcomes["slip"]])


def struck(law: ContactLaw, contacts: Array, tolerance: float | None, history: int) -> Struck:
    """Give what becomes of impacts u_n, u_t [m/s], D_nn, D_nt, D_tt [1/kg], shape (impact, 5), C-contiguous.

    Raises:
        TypeError, ValueError: no law, or a tolerance that it cannot have.
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.
        KeyboardInterrupt: somebody pressed Ctrl-C.
    """
    striking = _Striking(law, tolerance, once=False)
    outcomes, histories = striking.strike(contacts, history)
    endings = np.full(len(outcomes), Ending.COMPLETE, np.int8)
    reasons = [""] * len(outcomes)
    told: dict[int, tuple[int, Ending]] = {}
    for i in np.flatnonzero(outcomes["ending"] != RUNNING):
        code = int(outcomes["ending"][i])
        if code not in told:
            ending, reasons[i] = striking.explain(contacts[i])
            told[code] = int(i), ending
        else:
            reasons[i] = f"As impact {told[code][0]}."
        endings[i] = told[code][1]
    return Struck(outcomes, histories, endings, tuple(reasons))


@cache
def _body() -> tuple[Plant, Propagator]:
    """Give a free body over a plate, and its steps, in units of the first."""
    plant = one(plant_record(MODES, TONES))
    plant["mode_count"], plant["geometry"] = 2, (WAY, WAY, 0.0)
    return plant, Workspace().propagator(plant, 1.0, 1.0, False)


class _Striking:
    """A law that is ready to be asked, and the room that it needs."""

    def __init__(self, law: ContactLaw, tolerance: float | None, *, once: bool) -> None:
        check_law(law)
        check_tolerance(law, tolerance)
        law = law.on_rotor(WAY)
        parameters, row, bound, errors = take_in(law, once)
        tolerance = DEFAULT_TOLERANCE if tolerance is None else tolerance
        self.ready = Prepared(law, 1.0, 1.0, tolerance, *_body(), bound, parameters, row, errors)

    def strike(self, contacts: Array, history: int) -> tuple[Any, Any]:
        """Return the outcomes of impacts, and so many records of each."""
        outcomes, histories = np.zeros(len(contacts), OUTCOME), np.zeros((len(contacts), history), MOMENT)
        self._integrate(contacts, outcomes, histories)
        return outcomes, histories

    def _integrate(self, contacts: Array, outcomes: Any, histories: Any) -> Run:
        ready = self.ready
        states: Any = np.zeros(2, STATE)
        states[0] = fresh_state()
        ready.set_up(states[0], 1.0)
        run = ready.run_of(states[1])
        states[0]["phase"] = PRESSED
        # With room for one contact the loop ends when that is over.
        states[0]["stored"] = run.step["contacts"].size - 2
        motions = np.zeros((1, 2, 2))
        count = histories.shape[1]
        records = ready.records(count + 2 if count else 0, run)
        silent = records.series[:0]
        # The impulses of a rigid law take no time.
        size = len(contacts) if isinstance(ready.law, MultiplierLaw) else PIECE
        for i in range(0, len(contacts), size):
            some = slice(i, i + size)
            impacts = Impacts(contacts[some], outcomes[some], histories[some], silent)
            ready.advance(run, states, motions, records, 0, impacts)
        return run

    def explain(self, contact: Array) -> tuple[Ending, str]:
        """Say why an impact has no numbers."""
        law = self.ready.law
        if not isinstance(law, MultiplierLaw):
            outcomes, histories = np.zeros(1, OUTCOME), np.zeros((1, 0), MOMENT)
            run = self._integrate(contact[None], outcomes, histories)
            longest = float(run.propagator.rule.longest)
            return self.ready._replace(contact_step=longest).explain(run)
        outcomes, _ = self.strike(contact[None], 0)
        rate, slip, nn, nt, _ = contact
        where = f"a gap rate of {rate:.6g} m/s and a slip of {slip:.6g} m/s"
        if outcomes[0]["ending"] != INCONSISTENT:
            return Ending.DIVERGED, (
                f"The law answers an impact at {where} with no finite impulse; mend the law, or its "
                "parameters."
            )
        critical = nn / abs(nt) if nt else np.inf
        if law.friction_limit < critical:
            return Ending.INCONSISTENT, (
                f"The law has no normal impulse that stops {where}; check the law: an approach must be "
                "answered."
            )
        return Ending.INCONSISTENT, (
            f"Painleve's paradox at {where}: the friction coefficient {law.friction_limit:.6g} is not below "
            f"the critical {critical:.6g}, D_nn/|D_nt|, so that the friction of the slip presses the bodies "
            "together more than the normal impulse parts them. Lower it, or take a law that may stick or a "
            "compliant one."
        )
