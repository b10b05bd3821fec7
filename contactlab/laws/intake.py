"""What a law is asked when it is taken in: whether it contradicts itself where every contact passes.

The contract of `contactlab.testing` asks more, and lets the law run; this costs a run next to nothing.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from itertools import product
from math import isfinite, nan
from numbers import Real
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import shown
from contactlab.laws.base import (
    ELASTOPLASTIC,
    EVEN,
    ODD,
    PENALTY_SIGNATURE,
    RATE_DEPENDENT,
    SET_VALUED,
    SLIP,
    STICK,
    ContactLaw,
    PenaltyLaw,
)
from contactlab.laws.declaration import LawError

Kernel = Callable[..., Any]
State = tuple[float, ...]

KINDS = {
    SET_VALUED: "SET_VALUED",
    ELASTOPLASTIC: "ELASTOPLASTIC",
    RATE_DEPENDENT: "RATE_DEPENDENT",
}

GUARDS = 16
"""Numbers on either side of a law's parameters, where no kernel has any business."""

LURES = (nan, 1.0, -1.0)
"""What they are: an answer that changes with them was made from them."""

DEPTHS = (1e-12, 1e-9)
"""Penetrations that every contact begins and ends with [m], whatever is out of a law's domain."""

SPEEDS = (-0.01, 0.0, 0.01)
"""Gap rates and slips [m/s]."""

IMPACTS = tuple(
    (-0.01, slip, -0.01, slip, 1e3, d_nt, 2e3) for slip, d_nt in product(SPEEDS, (-50.0, 0.0, 50.0))
)
"""Arguments of a rigid kernel: approach, slip and Delassus matrix of a motor's tip."""

ROUND_OFF = 1e-9


def guarded(parameters: Array, guard: float = nan) -> Array:
    """Put the parameters between guards, so that a kernel that reads beyond them finds no number."""
    padded = np.full(parameters.size + 2 * GUARDS, guard)
    padded[GUARDS:-GUARDS] = parameters
    # As the kernels are compiled for it: one for another kind of array would be compiled anew.
    padded.flags.writeable = bool(PENALTY_SIGNATURE.args[-1].mutable)
    return padded[GUARDS:-GUARDS]


def said(law: ContactLaw, name: str) -> Any:
    """Give what a law says of itself in a property, or in its method `parameters`.

    Raises:
        LawError: it raised an exception, which is the cause.
    """
    try:
        value = getattr(law, name)
        return value() if name == "parameters" else value
    # A property is any code of somebody else's.
    except (Exception, SystemExit) as error:
        words = f"{law.name}: its {name} raised {type(error).__name__}: {error}. Mend the law."
        raise LawError(words) from error


def function_of(law: ContactLaw, name: str) -> Any:
    """Give the function behind one of a law's kernels.

    Raises:
        LawError: there is none.
    """
    function = said(law, name)
    if not callable(function):
        raise LawError(f"{law.name}: its {name} is {shown(function)}; it must be a function.")
    return function


def kernel_parameters(law: ContactLaw) -> Array:
    """Give what the kernels of a law receive.

    Raises:
        LawError: it is no row of numbers, or raised an exception.
    """
    given = said(law, "parameters")
    try:
        values = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        values = None
    if values is None or values.ndim != 1:
        raise LawError(f"{law.name}: parameters() gives {shown(given)}; it must give numbers.")
    return values


def check_words(law: ContactLaw) -> None:
    """Refuse a law that contradicts itself in what it says, of its friction above all.

    Raises:
        LawError: with a sentence on each contradiction.
    """
    limit = said(law, "friction_limit")
    faults = []
    if not isinstance(limit, Real) or not float(limit) >= 0.0:
        faults = [f"friction_limit is {shown(limit)}; it must be a number and not negative."]
    elif not isinstance(law.violations, Mapping):
        faults = [f"violations is {shown(law.violations)}; it must give reasons by name."]
    elif isinstance(law, PenaltyLaw):
        faults = list(misfits(law))
    if faults:
        raise LawError(" ".join(f"{law.name}: {words}" for words in faults))


def misfits(law: PenaltyLaw) -> Iterator[str]:
    """Give what a law says of its friction and contradicts, in sentences."""
    kind, kernel = said(law, "friction_kind"), said(law, "friction_force")
    remembered = said(law, "internal_variables")
    if kind not in KINDS:
        known = ", ".join(KINDS.values())
        yield f"friction_kind is {shown(kind)}; it must be {known} of contactlab.laws.base."
        return
    if kind == SET_VALUED and kernel is not None:
        yield (
            "it has a kernel of friction, but its friction_kind is SET_VALUED, which has none. Say "
            "ELASTOPLASTIC or RATE_DEPENDENT, or leave the kernel out."
        )
    if kind != SET_VALUED and kernel is None:
        yield (
            f"its friction_kind is {KINDS[kind]}, but it has no kernel of friction. Give it one, or say "
            "SET_VALUED."
        )
    if not isinstance(remembered, tuple) or not all(isinstance(one, str) for one in remembered):
        yield f"internal_variables is {shown(remembered)}; it must be a tuple of texts."
    elif len(remembered) > 1:
        yield f"it remembers {', '.join(remembered)}; it can remember one quantity at most."
    elif (kind == SET_VALUED and remembered) or (kind == ELASTOPLASTIC and not remembered):
        yield (
            f"its friction_kind is {KINDS[kind]} and its internal_variables {shown(remembered)}; "
            "set-valued friction remembers nothing, and a spring its stretch."
        )
    if law.internal_parity not in (ODD, EVEN):
        yield f"internal_parity is {shown(law.internal_parity)}; it must be ODD or EVEN."


def fault_of_answers(
    law: ContactLaw, parameters: Array, force: Kernel, friction_force: Kernel, solve: Kernel
) -> str:
    """Say what a law's kernels answer to a contact and cannot be, in a sentence; empty for a sound law.

    Args:
        law: taken in.
        parameters: what its kernels receive.
        force, friction_force, solve: its compiled kernels; idle ones are not asked.
    """
    kind = law.friction_kind if isinstance(law, PenaltyLaw) else None
    stops = "kernel_is_consistent" not in law.violations
    try:
        _ask(kind, stops, force, friction_force, solve, parameters.tobytes())
    except _AnswerError as fault:
        return f"{law.name}: {fault}"
    return ""


class _AnswerError(Exception):
    """What is wrong with an answer."""


# A sweep asks for the same law again and again; a fault is not remembered.
@lru_cache(maxsize=1024)
def _ask(
    kind: int | None,
    stops: bool,
    force: Kernel,
    friction_force: Kernel,
    solve: Kernel,
    parameters: bytes,
) -> None:
    """Ask the kernels of a law with a kind of friction, or of a rigid one that stops every approach or not.

    Raises:
        _AnswerError: with a sentence on the first answer that cannot be; others may follow from it.
    """
    rows = [guarded(np.frombuffer(parameters), lure) for lure in LURES]
    if kind is None:
        for state in IMPACTS:
            where = (
                f"in an impact with a gap rate of {state[0]:g} m/s and a slip of {state[1]:g} m/s"
            )
            p_n, p_t, mode = _answer("solve", solve, state, rows, 3, where)
            if mode not in (SLIP, STICK):
                raise _AnswerError(
                    f"the mode is {mode} {where}; it must be SLIP or STICK of contactlab.laws.base."
                )
            # Without an impulse there is no answer, of which a run tells.
            left = state[0] + state[4] * p_n + state[5] * p_t
            if stops and p_n > 0.0 and left < ROUND_OFF * state[0]:
                raise _AnswerError(
                    f"its kernel solve leaves an approach of {-left:g} m/s {where}; the impulse must stop "
                    "it."
                )
        return
    for depth, rate, slip in product(DEPTHS, SPEEDS, SPEEDS):
        where = f"at a gap of {-depth:g} m, a gap rate of {rate:g} m/s and a slip of {slip:g} m/s"
        begun = (-depth, rate, slip, abs(rate))
        normal, bound, *_ = _answer("force", force, begun, rows, 4, where)
        if bound < -ROUND_OFF * abs(normal):
            raise _AnswerError(
                f"the friction bound is {bound:g} N {where}; it must not be negative. Where the normal "
                "force pulls there is no friction."
            )
        if kind != SET_VALUED:
            # Every touch-down begins with a variable of zero; what else it may be, the law alone knows.
            asked = (-depth, rate, slip, normal, 0.0)
            _answer("friction_force", friction_force, asked, rows, 4, where)


def _answer(
    name: str, kernel: Kernel, state: State, rows: list[Array], count: int, where: str
) -> Any:
    """Give the answer to one state.

    Raises:
        _AnswerError: it cannot be one, whatever it means.
    """
    answer, *others = (kernel(*state, row) for row in rows)
    if not isinstance(answer, tuple) or len(answer) != count:
        found = f"{len(answer)} numbers" if isinstance(answer, tuple) else shown(answer)
        raise _AnswerError(f"its kernel {name} gives {found}; it must give {count} numbers.")
    # No number is the same as no number.
    if any(repr(answer) != repr(other) for other in others):
        raise _AnswerError(
            f"its kernel {name} reads parameters that there are not: its answer changes with what lies "
            f"beyond the {rows[0].size} that parameters() gives."
        )
    if not all(map(isfinite, answer)):
        numbers = ", ".join(f"{number:g}" for number in answer)
        # There are guards between the parts of a composed law.
        parts = bool(np.isnan(rows[0]).any())
        hint = " A part may have read beyond its own coefficients." if parts else ""
        raise _AnswerError(
            f"its kernel {name} gives {numbers} {where}; all must be finite, as every contact begins and "
            f"ends there.{hint}"
        )
    return answer
