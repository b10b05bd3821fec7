"""Kernels of laws and parts, evaluated by themselves."""

from functools import cache
from types import SimpleNamespace
from typing import Any

from contactlab.engine.binding import functions_of, row_of
from contactlab.engine.rigid import impact_impulses, lasting_impulses
from contactlab.engine.state import HEAD
from contactlab.laws import Friction, MultiplierLaw
from contactlab.laws.base import SLIP


@cache
def _kernels_and_row(law: MultiplierLaw) -> Any:
    return functions_of(law), row_of(law)


def stepped(
    law: MultiplierLaw, *state: float, mode: int = SLIP, step: float = 1.0, variables: tuple[float, ...] = ()
) -> Any:
    """Impulses [N s] and mode of a step: rates at its end, rates at its start, D_nn, D_nt, D_tt."""
    normal_rate, tangential_rate, gap_rate, slip, *d = state
    kernels, row = _kernels_and_row(law)
    row = row.copy()
    row[HEAD : HEAD + len(variables)] = variables
    bound = SimpleNamespace(impact=kernels["impact"], bound=kernels["bound"], parameters=row)
    flags = SimpleNamespace(sticks=law.sticks, projects=law.projects)
    run: Any = SimpleNamespace(state=SimpleNamespace(length=step, mode=mode, law=flags))
    rates, matrix = (normal_rate, tangential_rate), (d[0], d[1], d[2])
    if gap_rate < 0.0 or not law.projects:
        return impact_impulses(run, bound, gap_rate, rates, slip, matrix)  # type: ignore[arg-type]
    return lasting_impulses(run, bound, rates, slip, matrix)  # type: ignore[arg-type]


def state_of(friction: Friction, normal: float, slip: float, z: float = 0.0, stiffness: float = 1.0) -> Any:
    """Friction, rate of its variable, stored energy and stiffness over a constant normal stiffness."""
    of_normal = {"normal_stiffness": stiffness, "normal_stiffness_rate": 0.0}
    variables = {each.name: z for each in friction.internal_variables[:1]}
    return friction.evaluate("state", normal=normal, slip=slip, **of_normal, **variables)
