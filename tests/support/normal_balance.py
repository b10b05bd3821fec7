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


def imbalance(normal: NormalForce, depth: float, rate: float, z: Any = ()) -> float:
    """dV/dt less N dd/dt - loss along the flow, over the size of its terms [1]."""
    now = np.array(z, dtype=float)
    rates = np.zeros(now.size)
    if normal.rate is not None:
        rates[:] = [evaluate(normal, "rate", depth, rate, now, which=k) for k in range(now.size)]
    h = 1e-5 * depth / max(abs(rate), *np.abs(rates), 1e-300)
    ends = [forces(normal, depth + s * h * rate, rate, now + s * h * rates)[1] for s in (1.0, -1.0)]
    force, _, _, _, loss = forces(normal, depth, rate, now)
    stored, power = (ends[0] - ends[1]) / (2.0 * h), force * rate
    return abs(stored - power + loss) / (abs(stored) + abs(power) + abs(loss))


def lost_by(normal: NormalForce, event: int, depth: float, rate: float, z: Any) -> float:
    """What a jump does to the stored energy, over it [1]."""
    now = np.array(z, dtype=float)
    after = [evaluate(normal, "jump", depth, rate, now, which=k, event=event) for k in range(now.size)]
    stored = forces(normal, depth, rate, now)[1]
    return abs(forces(normal, depth, rate, after)[1] - stored) / stored
