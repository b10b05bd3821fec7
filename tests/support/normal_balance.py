"""The ledger of a normal force, dV/dt = N dd/dt - loss, by its kernels at one state."""

from typing import Any

import numpy as np

from contactlab.laws.base import NormalForce


def evaluate(normal: NormalForce, kernel: str, depth: float, rate: float, z: Any, **more: Any) -> Any:
    """A kernel of a normal force at a depth, its rate and internal variables."""
    names = [each.name for each in normal.internal_variables]
    values = np.array(z, dtype=float)
    known = {
        "depth": depth,
        "depth_rate": rate,
        "z": values,
        **dict(zip(names, values.tolist(), strict=True)),
    }
    return normal.evaluate(kernel, **known, **more)


def forces(normal: NormalForce, depth: float, rate: float = 0.0, z: Any = ()) -> tuple[float, ...]:
    """Force, stored energy, stiffness, its slope and loss."""
    if normal.force is None:
        return *normal.evaluate("elastic", depth=depth), 0.0
    return tuple(evaluate(normal, "force", depth, rate, z))
