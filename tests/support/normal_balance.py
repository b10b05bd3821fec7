"""The ledger of a normal force, dV/dt = N dd/dt - loss, asked of its kernels at one state."""

from typing import Any

import numpy as np

from contactlab.laws.base import NormalForce


def answer(normal: NormalForce, depth: float, rate: float = 0.0, z: Any = ()) -> tuple[float, ...]:
    """Give force, stored energy, stiffness, its slope and loss."""
    row = np.array(normal.coefficients())
    if normal.force is None:
        return *normal.elastic(depth, row, 0), 0.0
    return tuple(normal.force(depth, rate, np.array(z, dtype=float), row, 0))


def imbalance(normal: NormalForce, depth: float, rate: float, z: Any = ()) -> float:
    """Give dV/dt less N dd/dt - loss along the flow, over the size of its terms [1]."""
    row, now = np.array(normal.coefficients()), np.array(z, dtype=float)
    flow: Any = normal.rate or (lambda *_: 0.0)
    rates = np.array([flow(k, depth, rate, now, row, 0) for k in range(now.size)])
    h = 1e-5 * depth / max(abs(rate), *np.abs(rates), 1e-300)
    ends = [answer(normal, depth + s * h * rate, rate, now + s * h * rates)[1] for s in (1.0, -1.0)]
    force, _, _, _, loss = answer(normal, depth, rate, now)
    stored, power = (ends[0] - ends[1]) / (2.0 * h), force * rate
    return abs(stored - power + loss) / (abs(stored) + abs(power) + abs(loss))


def lost_by(normal: NormalForce, event: int, depth: float, rate: float, z: Any) -> float:
    """Give what a jump does to the stored energy, over it [1]."""
    row, now = np.array(normal.coefficients()), np.array(z, dtype=float)
    after = [normal.jump(k, event, depth, rate, now, row, 0) for k in range(now.size)]
    stored = answer(normal, depth, rate, now)[1]
    return abs(answer(normal, depth, rate, after)[1] - stored) / stored
