"""The entry to the compiled engine: one function for runs and impacts under laws of every kind.

It calls the law by address, as first-class functions of one type, and is so compiled once for all laws. What
a kind of law does not need is None, and the code about it is compiled to nothing.
"""

from typing import Any, Final

import numba

from contactlab.arrays import Array
from contactlab.compilation import telling
from contactlab.compiled import INTERPRETED, inner_kernel, kernel
from contactlab.engine.binding import SIGNATURES, Bound
from contactlab.engine.context import Impacts, Law, Memory, Records, Run
from contactlab.engine.hybrid import run_law
from contactlab.engine.impact import evaluate_impacts, integrate_impacts

_compiled: set[object] = set()
"""Kinds of laws that the loop is compiled for, with the rooms for coordinates and tones."""

SECONDS: Final = {
    "runs under compliant laws": 27.0,
    "runs under rigid laws": 19.0,
    "runs under compliant laws with internal variables": 58.0,
    "runs under rigid laws with internal variables": 46.0,
    "impacts under compliant laws": 13.0,
    "impacts under rigid laws": 1.0,
    "impacts under compliant laws with internal variables": 24.0,
    "impacts under rigid laws with internal variables": 1.0,
}
"""What the loop is compiled for, and the time that an idle processor takes for each by itself [s]."""


def kind_of(bound: Bound, impacts: bool) -> str:
    """Return what the loop is compiled for."""
    family = "compliant" if bound.kernels[2] is None else "rigid"
    with_memory = "" if bound.plain else " with internal variables"
    return f"{'impacts' if impacts else 'runs'} under {family} laws{with_memory}"


def prepare_loop(bound: Bound, *given: Any) -> None:
    """Compile the loop for a kind of law, or load its code; `given` are its arguments up to the budget."""
    run, impacts = given[0], given[4]
    kind = kind_of(bound, impacts is not None)
    room = kind, run.plant["phasors"].shape
    if INTERPRETED or room in _compiled:
        return
    # Left to itself the compiler would take each law for a type of its own.
    kernels = [
        numba.types.none if each is None else numba.types.FunctionType(signature)
        for each, signature in zip(bound.kernels, SIGNATURES.values(), strict=True)
    ]
    row = SIGNATURES["force"].args[-1]
    rows = row, row.copy(readonly=False)
    whole, none = numba.types.int64, numba.types.none
    marks = whole if impacts is None else none, whole if bound.kernels[2] is None else none
    loop: Any = advance
    with telling(kind, SECONDS[kind]):
        loop.disable_compile(False)
        loop.compile((*map(numba.typeof, given), *rows, *marks, *kernels))
        loop.disable_compile()
    _compiled.add(room)


@kernel
def advance(
    run: Run,
    states: Any,
    motions: Array,
    records: Records,
    impacts: Impacts | None,
    parameters: Array,
    row: Array,
    budget: int | None,
    compliant: int | None,
    force: Any,
    friction: Any,
    solve: Any,
    rate: Any,
    guard: Any,
    jumps: Any,
    limits: Any,
    moment: Any,
) -> None:
    """Run a law, start after start, until the end, an ending, full contact storage or so many steps.

    States, shape (start,), and motions, shape (start, q or v, coordinate), take the place of the run's own.
    Call it again to go on: they and the records hold all that there is, however often a run is cut. With
    impacts these are integrated, see `contactlab.engine.impact`.

    It is compiled once for each combination of arguments that are None: impacts or budget, `solve` of
    compliant laws or `compliant` of rigid ones, and the last five kernels of laws that are plain.
    """
    law = Law(force, friction, solve, parameters, row, _memory_of(rate, guard, jumps, limits, moment))
    if impacts is None:
        if budget is not None:
            run_law(run, states, motions, records, law, compliant, solve, budget)
    elif solve is None:
        if compliant is not None:
            integrate_impacts(run, states, motions, records, impacts, law, compliant, solve)
    else:
        evaluate_impacts(run, states[0], impacts, law, solve)


@inner_kernel
def _memory_of(rate: Any, guard: Any, jumps: Any, limits: Any, moment: Any) -> Memory | None:
    if rate is None:
        return None
    return Memory(rate, guard, jumps, limits, moment)
