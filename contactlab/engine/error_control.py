"""Error control of collocated steps: what errors are relative to, and the length of the next step."""

from math import pi, sqrt

import numpy as np

from contactlab.compiler.kernels import inner_kernel
from contactlab.engine.propagator import step_length
from contactlab.engine.state import START, Law, Run

GROWTH = 2.0**6
"""What the error of a step grows by where it doubles: it goes as h^(NODES + 1)."""

IMPULSE_ROUND_OFF = 1e-13
"""Relative impulse of the tip that is round-off of the forces which hold its slip."""


@inner_kernel
def impulse_scale(run: Run, law: Law, rate: float, load: float, mobility: float) -> float:
    """Return the impulse [N s] that scales errors in a contact which begins now, under a load [N].

    It is the speed of the tip over its mobility D_nn [1/kg]: gap rate, vibration of its modes, and what drive
    and weight add in one step. For a soft contact it is the impulse of half a swing to the end of the tip's
    reach, down to round-off of the tip's motion; and at least that of the load in one step. Of a motion that
    is prescribed it is that of its largest load in one step.
    """
    state, plant = run.state, run.plant
    h = step_length(run.propagator, run.propagator.rule.contact_level)
    if plant.wave.led_gap != 0 and state.law.compliant != 0:
        depth, approach = plant.wave.depth, plant.wave.approach
        normal, least, most, _, _ = law.force(-depth, -approach, 0.0, state.impact_speed, law.parameters)
        return float(max(load, abs(normal), abs(least), abs(most)) * h)
    # The tip's speed u' = sum rho_u q' is at most that of all modes in step, each at the amplitude of its
    # energy, sqrt(v^2 + k q^2), with what its forces add in a step.
    speed, reach = 0.0, 0.0
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        swing = sqrt(mode.v[START] ** 2 + mode.stiffness * mode.q[START] ** 2)
        for k in range(plant.tone_count):
            phasor = plant.phasors[j, k]
            swing += h * sqrt(phasor.force_re**2 + phasor.force_im**2)
        swing += h * (abs(mode.constant) + abs(plant.forces[j, 0]))
        part = abs(mode.row_u) * swing
        speed += part
        if part > 0.0:
            # The way of a free mass has no end.
            reach += part / sqrt(mode.stiffness) if mode.stiffness > 0.0 else np.inf
    # Momentum of the mass 1/D_nn that the contact meets.
    speed += abs(rate)
    scale = speed / mobility
    # A soft contact stops the tip before it has taken that much: a force that grows to N over the reach L
    # acts for about pi L/speed.
    if 0.0 < reach < np.inf:
        deep = law.force(-reach, -speed, 0.0, state.impact_speed, law.parameters)[0]
        taken = max(abs(deep) * pi * reach / speed, IMPULSE_ROUND_OFF / state.tolerance * scale)
        # A law that has no force so deep has no say.
        if deep != 0.0 and taken < scale:
            scale = taken
    return max(scale, load * h)


@inner_kernel
def lengthen(run: Run, level: int, error: float) -> None:
    """Add up the error of a step over the tolerance, and choose the level of the next one by it."""
    state = run.state
    state.impulse_error += error * state.tolerance * state.impulse_scale
    state.level = state.level_before = level
    # The error goes as h^6 (eq. 3.10), and a step twice as long must be good with a factor of two in hand: a
    # rejected step costs as much as one that stands. Twice at most, as the power holds for small changes.
    for _ in range(2):
        if state.level > run.propagator.rule.contact_level and 2.0 * error * GROWTH < 1.0:
            state.level -= 1
            error *= GROWTH
