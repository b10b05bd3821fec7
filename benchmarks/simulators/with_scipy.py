"""SciPy's answers with `solve_ivp`. It has no law of contact: what is solved is the user's own.

An impact is no question to it.
"""

from typing import NamedTuple

import block_and_ball
import entrant
import numpy as np
from block_and_ball import Event, Rates, Solve
from entrant import Numbers, Values
from scipy.integrate import solve_ivp


class Setting(NamedTuple):
    """Relative tolerance, and the velocity scale of steep friction [m/s], 0 for stick and slip by events."""

    tolerance: float
    scale: float


SETTINGS = {
    "LSODA, rtol 1e-3, v_s 1 mm/s": Setting(1e-3, 1e-3),
    "LSODA, rtol 1e-8, v_s 1 um/s": Setting(1e-8, 1e-6),
    "LSODA, rtol 1e-8, stick and slip by events": Setting(1e-8, 0.0),
}


def solver(method: str, rtol: float, atol: float, longest: float = np.inf) -> Solve:
    """Return a method of `solve_ivp` with tolerances and its longest step [s]."""

    def solve(
        rates: Rates, event: Event | None, grid: np.ndarray, state: list[float]
    ) -> tuple[np.ndarray, np.ndarray]:
        options = {"method": method, "rtol": rtol, "atol": atol, "max_step": longest, "t_eval": grid}
        if event is None:
            solved = solve_ivp(rates, (grid[0], grid[-1]), state, **options)
            return solved.t, solved.y.T
        event.terminal, event.direction = True, -1.0
        solved = solve_ivp(rates, (grid[0], grid[-1]), state, events=event, **options)
        stop = solved.y_events[0].reshape(-1, 2)
        return np.append(solved.t, solved.t_events[0]), np.vstack([solved.y.T, stop])

    return solve


def block(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a block on a plane, by LSODA; between events in steps of 1 ms at most."""
    tolerance, scale = setting
    if scale > 0.0:
        return block_and_ball.block(solver("LSODA", tolerance, tolerance * scale), scale, numbers)
    return block_and_ball.block(solver("LSODA", tolerance, tolerance * 1e-6, 1e-3), 0.0, numbers)


def bounce(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a ball whose landings are events, by RK45."""
    return block_and_ball.bounce(solver("RK45", setting.tolerance, 1e-9), numbers)


if __name__ == "__main__":
    entrant.serve(SETTINGS, {"block": block, "bounce": bounce})
