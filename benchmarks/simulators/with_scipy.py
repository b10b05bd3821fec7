"""SciPy's answers with `solve_ivp`: events where the ball lands, friction made steep, mu m g tanh(v / v_s).

It has no law of contact: what is solved is the user's own. An impact is no question to it.
"""

from math import tanh

import entrant
import numpy as np
from entrant import Numbers, Values
from scipy.integrate import solve_ivp

SETTINGS = {
    "LSODA, rtol 1e-3, v_s 1 mm/s": {"tolerance": 1e-3, "scale": 1e-3},
    "LSODA, rtol 1e-8, v_s 1 um/s": {"tolerance": 1e-8, "scale": 1e-6},
}


def block(setting: dict[str, float], numbers: Numbers) -> Values:
    """Answer for a block on a plane."""
    cone = numbers["friction"] * numbers["mass"] * numbers["gravity"]

    def rates(t: float, state: np.ndarray) -> tuple[float, float]:
        way, velocity = state
        friction = cone * tanh(velocity / setting["scale"])
        return velocity, (entrant.push_at(numbers, t, way) - friction) / numbers["mass"]

    end, rtol = numbers["duration"], setting["tolerance"]
    time = np.linspace(0.0, end, round(1000.0 * end) + 1)
    options = {"method": "LSODA", "rtol": rtol, "atol": rtol * setting["scale"], "t_eval": time}
    solved = solve_ivp(rates, (0.0, end), [0.0, 0.0], **options)
    return entrant.of_block(numbers, solved.t, solved.y[0], solved.y[1, -1])


def bounce(setting: dict[str, float], numbers: Numbers) -> Values:
    """Answer for a ball whose landings are events; below 10 um/s it rests, as there is no end to them."""

    def landing(_: float, state: np.ndarray) -> float:
        return float(state[0])

    landing.terminal, landing.direction = True, -1.0
    now, state, end = 0.0, [numbers["height"], 0.0], numbers["duration"]
    times, heights = [np.zeros(1)], [np.array([numbers["height"]])]
    while now < end:
        grid = np.append(np.arange(now, end, 1e-5), end)
        solved = solve_ivp(
            lambda _, y: (y[1], -numbers["gravity"]),
            (now, end),
            state,
            rtol=setting["tolerance"],
            atol=1e-9,
            t_eval=grid,
            events=landing,
        )
        times.append(solved.t)
        heights.append(solved.y[0])
        if not solved.t_events[0].size:
            break
        now, up = float(solved.t_events[0][0]), -numbers["restitution"] * float(solved.y_events[0][0][1])
        # Clear of the plate, or the landing would be found again at once.
        state = [1e-15, up]
        if up < 1e-5:
            state, now = [0.0, 0.0], end
            times.append(np.array([end]))
            heights.append(np.zeros(1))
    return entrant.of_bounce(numbers, np.concatenate(times), np.concatenate(heights), state[1])


if __name__ == "__main__":
    entrant.serve(SETTINGS, {"block": block, "bounce": bounce})
