"""From a law to the compiled loop: its kernel by address, and the loop compiled once for all laws."""

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import numba

from contactlab.compiled import INTERPRETED, is_compiled, kernel
from contactlab.engine.callback import law_errors
from contactlab.engine.kinematics import Run
from contactlab.engine.law_kernels import compiled
from contactlab.engine.loop import advance_compliant, advance_rigid
from contactlab.engine.state import SAMPLE, table
from contactlab.laws.base import (
    FRICTION_SIGNATURE,
    MULTIPLIER_SIGNATURE,
    PENALTY_SIGNATURE,
    ContactLaw,
    MultiplierLaw,
    PenaltyLaw,
)
from contactlab.laws.intake import function_of

NO_FORCE = kernel(lambda _1, _2, _3, _4, _5: (0.0, 0.0, 0.0, 0.0))
NO_FRICTION = kernel(lambda _1, _2, _3, _4, _5, _6: (0.0, 0.0, 0.0, 0.0))
NO_IMPULSE = kernel(lambda _1, _2, _3, _4, _5, _6, _7, _8: (0.0, 0.0, 0))
"""Kernels that stand for those that a law lacks."""

_compiled: set[object] = set()
"""Loops with the rooms for coordinates and tones that they are compiled for."""


def kernels_of(
    law: ContactLaw,
) -> tuple[tuple[Any, ...], Callable[[], AbstractContextManager[None]]]:
    """Give the law's kernels of normal force, friction and impulse; idle ones for those that it lacks.

    With them comes a context around their calls, in which their exceptions come out as `LawError`.
    """
    compliant = isinstance(law, PenaltyLaw)
    with law_errors(law.name):
        force = function_of(law, "force") if compliant else NO_FORCE
        has_friction = isinstance(law, PenaltyLaw) and law.friction_force is not None
        friction = function_of(law, "friction_force") if has_friction else NO_FRICTION
        solve = function_of(law, "solve") if isinstance(law, MultiplierLaw) else NO_IMPULSE
    chosen = [
        compiled(force, PENALTY_SIGNATURE),
        compiled(friction, FRICTION_SIGNATURE),
        compiled(solve, MULTIPLIER_SIGNATURE),
    ]
    callbacks = [callback for _, callback in chosen if callback is not None]
    return tuple(kernel for kernel, _ in chosen), lambda: law_errors(law.name, *callbacks)


def loop_for(law: ContactLaw, run: Run) -> Any:
    """Give the loop of a law's family, compiled or with its code loaded, for laws that are called by address.

    A law is a first-class function of one type, so that the loop is compiled once for all laws; left
    to itself the compiler would take each law for a type of its own.
    """
    loop: Any = advance_compliant if isinstance(law, PenaltyLaw) else advance_rigid
    room = loop, run.plant.phasors.shape
    if INTERPRETED or room in _compiled:
        return loop
    laws = (PENALTY_SIGNATURE, FRICTION_SIGNATURE, MULTIPLIER_SIGNATURE)
    signature = (
        numba.typeof(run),
        numba.typeof(table(SAMPLE, 1)),
        *(numba.types.FunctionType(each) for each in laws),
        PENALTY_SIGNATURE.args[-1],
        numba.types.int64,
    )
    if not is_compiled(loop.__name__):
        print(
            "contactlab: compiling the engine; this happens once for an installation and takes "
            "up to a minute.",
            file=sys.stderr,
            flush=True,
        )
    loop.disable_compile(False)
    loop.compile(signature)
    loop.disable_compile()
    _compiled.add(room)
    return loop
