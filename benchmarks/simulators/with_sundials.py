"""Answers of SUNDIALS' CVODE, by scikit-sundae. It has no law of contact: what is solved is the user's own.

An impact is no question to it.
"""

from typing import Any, NamedTuple

import block_and_ball
import entrant
import numpy as np
from block_and_ball import Event, Rates, Solve
from entrant import Numbers, Values
from sksundae.cvode import CVODE


class Setting(NamedTuple):
    """Options of CVODE, and the velocity scale of steep friction [m/s], 0 for stick and slip by events."""

    options: dict[str, Any]
    scale: float


SETTINGS = {
    "CVODE's defaults, v_s 1 mm/s": Setting({}, 1e-3),
    "BDF, rtol 1e-8, v_s 1 um/s": Setting({"rtol": 1e-8, "atol": 1e-14}, 1e-6),
    "Adams, rtol 1e-8, stick and slip by events": Setting(
        {"method": "Adams", "rtol": 1e-8, "atol": 1e-14, "max_step": 1e-3}, 0.0
    ),
}


def solver(options: dict[str, Any]) -> Solve:
    """Return CVODE with options: it stops at a zero, and the next piece is begun anew at order 1."""

    def solve(
        rates: Rates, event: Event | None, grid: np.ndarray, state: list[float]
    ) -> tuple[np.ndarray, np.ndarray]:
        def derivatives(time: float, y: np.ndarray, result: np.ndarray) -> None:
            result[:] = rates(time, y)

        zeros: dict[str, Any] = {}
        if event is not None:

            def values(time: float, y: np.ndarray, result: np.ndarray) -> None:
                result[0] = event(time, y)

            values.terminal, values.direction = [True], [-1]
            zeros = {"eventsfn": values, "num_events": 1}
        solved = CVODE(derivatives, **options, **zeros).solve(grid, np.array(state))
        if not solved.success:
            raise RuntimeError(solved.message)
        return solved.t, solved.y

    return solve


def block(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a block on a plane."""
    return block_and_ball.block(solver(setting.options), setting.scale, numbers)


def bounce(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a ball whose landings are events."""
    return block_and_ball.bounce(solver(setting.options), numbers)


if __name__ == "__main__":
    entrant.serve(SETTINGS, {"block": block, "bounce": bounce})
