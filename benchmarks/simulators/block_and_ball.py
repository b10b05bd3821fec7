"""Equations of motion with events, of entrants that solve the user's own. Needs NumPy only."""

from collections.abc import Callable
from math import copysign, tanh
from typing import Any

import entrant
import numpy as np
from entrant import Numbers, Values

Rates = Callable[[float, Any], tuple[float, float]]
Event = Callable[[float, Any], float]

Solve = Callable[[Rates, Event | None, np.ndarray, list[float]], tuple[np.ndarray, np.ndarray]]
"""Solver: rates, a function at whose falling zero it stops, times of output [s] and the state at the first.

It returns the times, of which the last is that of the zero if there was one, and states, shape (time, 2).
"""


def block(solve: Solve, scale: float, numbers: Numbers) -> Values:
    """Answer for a block on a plane: steep friction mu m g tanh(v / scale), or stick and slip at scale 0.

    Stick ends where the load leaves the cone, slip where the velocity is zero.
    """
    mass, end = numbers["mass"], numbers["duration"]
    cone = numbers["friction"] * mass * numbers["gravity"]
    grid = np.linspace(0.0, end, round(1000.0 * end) + 1)

    def load(time: float, state: Any) -> float:
        return entrant.push_at(numbers, time, state[0])

    def steep(time: float, state: Any) -> tuple[float, float]:
        return state[1], (load(time, state) - cone * tanh(state[1] / scale)) / mass

    if scale > 0.0:
        time, states = solve(steep, None, grid, [0.0, 0.0])
        return entrant.of_block(numbers, time, states[:, 0], states[-1, 1])

    def side_of(push: float) -> float:
        return copysign(1.0, push) if abs(push) > cone else 0.0

    def rates(time: float, state: Any) -> tuple[float, float]:
        return (state[1], (load(time, state) - side * cone) / mass) if side else (0.0, 0.0)

    def margin(time: float, state: Any) -> float:
        return side * state[1] if side else cone - abs(load(time, state))

    pieces, state = [], [0.0, 0.0]
    # Sign of the slip, 0 in stick.
    side = side_of(load(0.0, state))
    while grid.size > 1:
        time, states = solve(rates, margin, grid, state)
        pieces.append((time, states))
        grid = np.append(time[-1], grid[grid > time[-1]])
        state = [states[-1, 0], 0.0]
        push = load(time[-1], state)
        side = side_of(push) if side else copysign(1.0, push)
    time, states = (np.concatenate(each) for each in zip(*pieces, strict=True))
    return entrant.of_block(numbers, time, states[:, 0], states[-1, 1])


def bounce(solve: Solve, numbers: Numbers) -> Values:
    """Answer for a ball whose landings are events; below 10 um/s it rests, as there is no end to them."""
    end, state = numbers["duration"], [numbers["height"], 0.0]
    pieces = [(np.zeros(1), np.array([numbers["height"]]))]
    grid = np.append(np.arange(0.0, end, 1e-5), end)
    while grid.size > 1:
        time, states = solve(lambda _, y: (y[1], -numbers["gravity"]), lambda _, y: y[0], grid, state)
        pieces.append((time, states[:, 0]))
        # Clear of the plate, or the landing would be found again at once.
        state = [1e-15, -numbers["restitution"] * float(states[-1, 1])]
        grid = np.append(time[-1], grid[grid > time[-1]])
        if state[1] < 1e-5:
            state, grid = [0.0, 0.0], grid[-1:]
            pieces.append((grid, np.zeros(1)))
    time, height = (np.concatenate(each) for each in zip(*pieces, strict=True))
    return entrant.of_bounce(numbers, time, height, state[1])
