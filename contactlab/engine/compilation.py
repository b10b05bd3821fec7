"""From a law to the compiled loop: its kernel by address, and the loop compiled once for all laws."""

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import numba

from contactlab.arrays import Array
from contactlab.compiled import INTERPRETED, is_compiled, kernel
from contactlab.engine.callback import law_errors
from contactlab.engine.law_kernels import compiled
from contactlab.engine.loop import advance
from contactlab.engine.plant import Plant
from contactlab.engine.run import Run
from contactlab.engine.step import Step
from contactlab.engine.tables import Tables
from contactlab.laws.base import (
    FRICTION_SIGNATURE,
    MULTIPLIER_SIGNATURE,
    PENALTY_SIGNATURE,
    ContactLaw,
    MultiplierLaw,
    PenaltyLaw,
)
from contactlab.laws.intake import function_of, said


@kernel
def no_force(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: Array
) -> tuple[float, float, float, float]:
    """Stands for the penalty law in a run of a multiplier law."""
    return 0.0, 0.0, 0.0, 0.0


@kernel
def no_friction(
    gap: float, gap_rate: float, slip: float, normal: float, memory: float, parameters: Array
) -> tuple[float, float, float, float]:
    """Stands for the friction with memory in a run of a law with set-valued friction."""
    return 0.0, 0.0, 0.0, 0.0


@kernel
def no_impulse(
    normal_rate: float,
    tangential_rate: float,
    gap_rate: float,
    slip: float,
    d_nn: float,
    d_nt: float,
    d_tt: float,
    parameters: Array,
) -> tuple[float, float, int]:
    """Stands for the multiplier law in a run of a penalty law."""
    return 0.0, 0.0, 0


def kernels_of(
    law: ContactLaw,
) -> tuple[tuple[Any, ...], Callable[[], AbstractContextManager[None]]]:
    """The law's kernels of normal force, friction and impulse; idle ones for those that it lacks.

    Returns:
        The kernels, and a context around their calls in which their exceptions come out as `LawError`.
    """
    compliant = isinstance(law, PenaltyLaw)
    force = function_of(law, "force") if compliant else no_force
    rubs = compliant and said(law, "friction_force") is not None
    rub = function_of(law, "friction_force") if rubs else no_friction
    solve = function_of(law, "solve") if isinstance(law, MultiplierLaw) else no_impulse
    chosen = [
        compiled(force, PENALTY_SIGNATURE),
        compiled(rub, FRICTION_SIGNATURE),
        compiled(solve, MULTIPLIER_SIGNATURE),
    ]
    callbacks = [callback for _, callback in chosen if callback is not None]
    return tuple(kernel for kernel, _ in chosen), lambda: law_errors(law.name, callbacks)


def compile_loop(plant: Plant, tables: Tables, step: Step, run: Run) -> None:
    """Compile the loop, or load its code, for laws that are called by address.

    A law is a first-class function of one type, so that the loop is compiled once for all laws; left
    to itself the compiler would take each law for a type of its own.
    """
    loop: Any = advance
    if INTERPRETED or loop.overloads:
        return
    if not is_compiled("advance"):
        print(
            "contactlab: compiling the engine; this happens once for an installation and takes "
            "up to a minute.",
            file=sys.stderr,
            flush=True,
        )
    loop.compile(
        (
            *(numba.typeof(memory) for memory in (plant, tables, step, run)),
            numba.types.FunctionType(PENALTY_SIGNATURE),
            numba.types.FunctionType(FRICTION_SIGNATURE),
            numba.types.FunctionType(MULTIPLIER_SIGNATURE),
            numba.types.boolean,
            PENALTY_SIGNATURE.args[-1],
            numba.types.int64,
        )
    )
    loop.disable_compile()
