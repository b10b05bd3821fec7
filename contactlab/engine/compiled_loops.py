"""The units that the engine is compiled in: what each is called with, how long it compiles, and who needs it.

The loop of runs is one unit for all laws; a step in contact, of which there are a compliant and a rigid one,
is another that the loop calls by its address, and so are impacts. Each is compiled for laws with internal
variables, and for those without, whose last four kernels are None.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, Final, NamedTuple, final

import numba
import numpy as np
from numba import types
from numba.extending import overload

from contactlab.compiler.ahead import Signature, compile_all
from contactlab.compiler.kernels import INTERPRETED, inner_kernel, kernel, unit_kernel
from contactlab.compiler.notice import telling
from contactlab.engine.binding import Bound, signatures_of_loop
from contactlab.engine.compliant import step_compliant
from contactlab.engine.constrained import step_rigid
from contactlab.engine.impact import MOMENT, OUTCOME, evaluate_impacts, integrate_impacts
from contactlab.engine.loop import LoopData, run_law
from contactlab.engine.path import run_path
from contactlab.engine.path_contact import Path
from contactlab.engine.state import ImpactBatch, Law, Memory, Records, Run
from contactlab.processes import processors

NO_IMPACTS: Final = ImpactBatch(
    np.zeros((0, 5)), np.zeros(0, OUTCOME), np.zeros((0, 0), MOMENT), Records.of(0, 0, 0).series
)
"""Impacts of a run: none."""


@inner_kernel
def _law_of(
    data: LoopData,
    at_nodes: Any,
    force: Any,
    friction: Any,
    impact: Any,
    bound: Any,
    rate: Any,
    guard: Any,
    jump: Any,
    limits: Any,
) -> Law:
    """Return a law's kernels with its parameters."""
    memory = _memory_of(rate, guard, jump, limits)
    return Law(at_nodes, force, friction, impact, bound, data.parameters, data.row, memory)


def _memory_of(rate: Any, guard: Any, jump: Any, limits: Any) -> Memory | None:
    """Return the kernels of internal variables; None without, and code about these is compiled to nothing."""
    return None if rate is None else Memory(rate, guard, jump, limits)


@overload(_memory_of, strict=False)
def _typed_memory(rate: Any, guard: Any, jump: Any, limits: Any) -> Any:  # noqa: ARG001 - the compiler's own
    """Return the function for the types of the kernels: one type of the result for each."""
    if rate is types.none:
        return lambda rate, guard, jump, limits: None  # noqa: ARG005
    return lambda rate, guard, jump, limits: Memory(rate, guard, jump, limits)


@kernel
def run_loop(
    step: Any,
    data: LoopData,
    at_nodes: Any,
    force: Any,
    friction: Any,
    impact: Any,
    bound: Any,
    rate: Any,
    guard: Any,
    jump: Any,
    limits: Any,
) -> None:
    """Run any law, see `run_law`."""
    run_law(data, _law_of(data, at_nodes, force, friction, impact, bound, rate, guard, jump, limits), step)


@unit_kernel
def contact_compliant(run: Run, law: Law) -> int:
    """Take a step in contact under a compliant law."""
    return step_compliant(run, law)


@unit_kernel
def contact_rigid(run: Run, law: Law) -> int:
    """Take a step in contact under a rigid law, in its limit of no step or in time stepping."""
    return step_rigid(run, law)


@kernel
def impacts_compliant(
    loop: Any,
    step: Any,
    data: LoopData,
    impacts: ImpactBatch,
    at_nodes: Any,
    force: Any,
    friction: Any,
    impact: Any,
    bound: Any,
    rate: Any,
    guard: Any,
    jump: Any,
    limits: Any,
) -> None:
    """Integrate impacts of a compliant law."""
    law = _law_of(data, at_nodes, force, friction, impact, bound, rate, guard, jump, limits)
    kernels = (at_nodes, force, friction, impact, bound, rate, guard, jump, limits)
    integrate_impacts(data, impacts, law, loop, step, kernels)


@kernel
def impacts_rigid(
    data: LoopData,
    impacts: ImpactBatch,
    at_nodes: Any,
    force: Any,
    friction: Any,
    impact: Any,
    bound: Any,
    rate: Any,
    guard: Any,
    jump: Any,
    limits: Any,
) -> None:
    """Evaluate impacts of a rigid law."""
    evaluate_impacts(
        data, impacts, _law_of(data, at_nodes, force, friction, impact, bound, rate, guard, jump, limits)
    )


@kernel
def path_loop(
    path: Path,
    at_nodes: Any,
    force: Any,
    friction: Any,
    impact: Any,
    bound: Any,
    rate: Any,
    guard: Any,
    jump: Any,
    limits: Any,
) -> None:
    """Take any law along a path, see `run_path`."""
    memory = _memory_of(rate, guard, jump, limits)
    run_path(path, Law(at_nodes, force, friction, impact, bound, path.parameters, path.row, memory))


@final
class EngineUnit(NamedTuple):
    """What is compiled as one, and the time that an idle processor takes for it [s]."""

    kernel: Any
    name: str
    seconds: float
    seconds_with_variables: float


RUNS: Final = EngineUnit(run_loop, "runs", 9.0, 12.0)
CONTACTS: Final = {
    True: EngineUnit(contact_compliant, "compliant contacts", 8.0, 11.0),
    False: EngineUnit(contact_rigid, "rigid contacts", 8.0, 11.0),
}
"""Steps in contact by whether a law is compliant."""

IMPACTS: Final = {
    True: EngineUnit(impacts_compliant, "impacts under compliant laws", 1.0, 1.0),
    False: EngineUnit(impacts_rigid, "impacts under rigid laws", 1.0, 1.0),
}
"""Impacts by whether a law is compliant."""


PATHS: Final = EngineUnit(path_loop, "laws on paths", 5.0, 7.0)


_path_types: Final[dict[tuple[object, ...], Any]] = {}


def path_loop_of(bound: Bound, path: Path) -> Callable[..., None]:
    """Return the function of a path and a law's kernels; compile it where it is new.

    A path is of the types alone that are to come.
    """
    if not INTERPRETED:
        # The compiler makes the type of a record anew each time, which takes as long as a path.
        room = tuple((each.dtype, each.ndim, each.flags.c_contiguous, each.flags.writeable) for each in path)
        if room not in _path_types:
            _path_types[room] = numba.typeof(path)
        signature = Signature(PATHS.kernel, types.void(_path_types[room], *_kernel_types(bound)))
        if not signature.is_there():
            seconds = PATHS.seconds if bound.plain else PATHS.seconds_with_variables
            with telling(name_of([PATHS], bound.plain), seconds):
                signature.compile()
    return path_loop


def units_of(compliant: bool, impacts: bool) -> list[EngineUnit]:
    """Return the units that runs or impacts take, each after those that call it."""
    if impacts and not compliant:
        return [IMPACTS[False]]
    return [*([IMPACTS[True]] if impacts else []), RUNS, CONTACTS[compliant]]


def name_of(units: list[EngineUnit], plain: bool) -> str:
    """Return what units are, for laws without internal variables or with them."""
    names = " and ".join(unit.name for unit in units)
    return names if plain else f"{names} with internal variables"


def loop_of(bound: Bound, compliant: bool, data: LoopData, impacts: bool) -> Callable[..., None]:
    """Return the function of data, impacts if there are any, and a law's kernels; compile what it lacks.

    The data are of the types alone that are to come.
    """
    units = units_of(compliant, impacts)
    if INTERPRETED:
        codes = [unit.kernel for unit in units]
    else:
        signatures = _signatures(units, bound, data)
        missing = [i for i in range(len(units)) if not signatures[i].is_there()]
        seconds = [units[i].seconds if bound.plain else units[i].seconds_with_variables for i in missing]
        usual = max(seconds, default=0.0) if processors() > 1 else sum(seconds)
        with telling(name_of([units[i] for i in missing], bound.plain), usual):
            compile_all([signatures[i] for i in missing])
        # A call by the address alone drops exceptions; one of the kernel itself, which is looked up in every
        # call of the loop, passes them on.
        callees = [each.kernel.compiled if bound.may_raise else each.code for each in signatures[1:]]
        codes = [units[0].kernel, *callees]
    entry, *callees = codes
    return partial(entry, *callees)


def _kernel_types(bound: Bound) -> list[Any]:
    """Return the types of a law's kernels: left to itself the compiler would take each law for a type."""
    return [
        types.none if each is None else types.FunctionType(signature)
        for each, signature in zip(bound.of_loop, signatures_of_loop(), strict=True)
    ]


def _signatures(units: list[EngineUnit], bound: Bound, data: LoopData) -> list[Signature]:
    """Return the units with the types of their arguments and result."""
    kernels = _kernel_types(bound)
    tuple_of: Any = types.BaseTuple.from_types
    kinds = numba.typeof(data)
    records = data.plant, data.propagator, data.states, data.step
    run = tuple_of([numba.typeof(each).dtype for each in records], Run)
    memory = types.none if bound.plain else tuple_of(kernels[5:], Memory)
    law = tuple_of([*kernels[:5], numba.typeof(data.parameters), numba.typeof(data.row), memory], Law)
    made: list[Signature] = []
    for unit in reversed(units):
        if unit in CONTACTS.values():
            made.append(Signature(unit.kernel, types.int64(run, law)))
            continue
        callees = [types.FunctionType(each.types) for each in reversed(made)]
        impacts = [numba.typeof(NO_IMPACTS)] if unit in IMPACTS.values() else []
        made.append(Signature(unit.kernel, types.void(*callees, kinds, *impacts, *kernels)))
    return made[::-1]
