"""Kernels of laws and parts, evaluated by themselves."""

from typing import Any

from contactlab.laws import Friction, MultiplierLaw


def solve_of(law: MultiplierLaw, *state: float, **variables: float) -> Any:
    """Impulses [N s] and mode of a step: rates at its end, rates at its start, D_nn, D_nt, D_tt."""
    names = ("normal_rate", "tangential_rate", "gap_rate", "slip", "d_nn", "d_nt", "d_tt")
    return law.evaluate("solve", **dict(zip(names, state, strict=True)), **variables)


def state_of(friction: Friction, normal: float, slip: float, z: float = 0.0, stiffness: float = 1.0) -> Any:
    """Friction, rate of its variable, stored energy and stiffness over a constant normal stiffness."""
    of_normal = {"normal_stiffness": stiffness, "normal_stiffness_rate": 0.0}
    variables = {each.name: z for each in friction.internal_variables[:1]}
    return friction.evaluate("state", normal=normal, slip=slip, **of_normal, **variables)
