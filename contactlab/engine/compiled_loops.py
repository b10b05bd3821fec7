"""The compiled loops, one for each kind of contact: what they are called with, and how long they compile."""

from typing import Any, Final, NamedTuple

import numpy as np

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.engine.binding import IMPACT, Bound
from contactlab.engine.compliant import step_compliant
from contactlab.engine.constrained import step_rigid
from contactlab.engine.impact import MOMENT, OUTCOME, evaluate_impacts, integrate_impacts
from contactlab.engine.loop import run_law
from contactlab.engine.state import ImpactBatch, Law, Memory, Records, Run

SECONDS: Final = {
    "compliant laws": 18.0,
    "rigid laws": 20.0,
    "compliant laws with internal variables": 24.0,
    "rigid laws with internal variables": 27.0,
    "impacts under rigid laws": 1.0,
    "impacts under rigid laws with internal variables": 1.0,
}
"""What the loop is compiled for, and the time that an idle processor takes for each by itself [s]."""


def kind_of(bound: Bound, impacts: bool) -> str:
    """Return what the loop is compiled for; that of a compliant law serves runs and impacts."""
    rigid = bound.kernels[IMPACT] is not None
    family = "compliant laws" if not rigid else "impacts under rigid laws" if impacts else "rigid laws"
    return family if bound.plain else f"{family} with internal variables"


class LoopData(NamedTuple):
    """All that the compiled loops read and write beside the kernels of a law.

    Plant, propagator and scratch of a step, each the only record of an array: of a record by itself the
    compiler would ask for a description of its fields at every call, which takes longer than the rest of it.
    States, shape (start,), motions, shape (start, q or v, coordinate), and records contain everything, so
    that another call continues the runs, by `budget` steps of each start. Where there are impacts, they are
    integrated or evaluated instead.
    """

    plant: Any
    propagator: Any
    step: Any
    states: Any
    motions: Array
    records: Records
    waves: Array
    parameters: Array
    row: Array
    budget: int
    impacts: ImpactBatch


NO_IMPACTS: Final = ImpactBatch(
    np.zeros((0, 5)), np.zeros(0, OUTCOME), np.zeros((0, 0), MOMENT), Records.of(0, 0, 0).series
)
"""Impacts of a run: none."""


@inner_kernel
def law_of(
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


@inner_kernel
def _memory_of(rate: Any, guard: Any, jump: Any, limits: Any) -> Memory | None:
    """Return the kernels of internal variables, None without: then code about these is compiled to nothing.

    By itself, as the compiler finds one type for the two results of a function, but none for two laws.
    """
    if rate is None:
        return None
    return Memory(rate, guard, jump, limits)


@kernel
def run_compliant(
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
    """Run a compliant law until the end, an ending, full contact storage or so many steps of each start.

    Impacts under it are integrated by the same code, most of which is that of a contact.

    Each of these functions is compiled for laws with internal variables, and for those without, whose last
    four kernels are None.
    """
    run = Run(data.plant[0], data.propagator[0], data.states[0], data.step[0])
    law = law_of(data, at_nodes, force, friction, impact, bound, rate, guard, jump, limits)
    if data.impacts.outcomes.size > 0:
        integrate_impacts(run, data.states, data.motions, data.records, data.impacts, law, data.waves)
    else:
        run_law(run, data.states, data.motions, data.records, law, step_compliant, data.budget, data.waves)


@kernel
def run_rigid(
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
    """Run a rigid law in its limit of no step or in time stepping, see `run_compliant`."""
    run = Run(data.plant[0], data.propagator[0], data.states[0], data.step[0])
    law = law_of(data, at_nodes, force, friction, impact, bound, rate, guard, jump, limits)
    run_law(run, data.states, data.motions, data.records, law, step_rigid, data.budget, data.waves)


@kernel
def evaluate_rigid(
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
    """Evaluate impacts of a rigid law."""
    law = law_of(data, at_nodes, force, friction, impact, bound, rate, guard, jump, limits)
    run = Run(data.plant[0], data.propagator[0], data.states[0], data.step[0])
    evaluate_impacts(run, data.states[0], data.impacts, law)


LOOPS: Final = {"run_compliant", "run_rigid", "evaluate_rigid"}
"""Names of the compiled loops, one for each kind of contact."""
