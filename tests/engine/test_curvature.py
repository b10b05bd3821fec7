"""The bound of the gap's curvature, on which it rests that no touch-down is stepped over."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from support.motors import default_motor, hertz, random_motor

import contactlab as cl
from contactlab.engine.flight import curvature_bound
from contactlab.engine.initial_state import fresh_state
from contactlab.engine.kinematics import begin, flow_to, free_accelerations, tip_motion
from contactlab.engine.plant import modes_of
from contactlab.engine.preparation import prepared
from contactlab.engine.propagator import step_length
from contactlab.engine.state import BETWEEN, FLIGHT, START
from contactlab.motor.motor import Motor

DRIVES = ("tones", "resonant", "waveform", "oblique")
OPEN = 1e-4
"""Clearance [m] that none of the flights closes."""


def flying(seed: int, drive: str) -> Motor:
    """A motor in flight."""
    made = default_motor(**random_motor(seed) | {"clearance": OPEN})
    if drive == "resonant":
        frequency = float(made.modes.natural_frequency[seed % 2]) * (1.0 + 1e-4 * seed)
        made = replace(made, drive=cl.Drive.two_mode(100.0, 200.0, frequency=frequency))
    if drive == "waveform":
        time = np.linspace(0.0, 1e-3, 400)
        voltage = 100.0 * np.sin(2.0 * pi * 4e3 * np.array([[1.0], [1.7]]) * time) ** 3
        made = replace(made, drive=cl.Drive(waveform=cl.Waveform.sampled(time, voltage)))
    if drive == "oblique":
        made = replace(made, geometry=replace(made.geometry, angle=0.4))
    return made


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("seed", range(12))
def test_no_curvature_exceeds_its_bound_which_tends_to_that_at_the_start(seed: int, drive: str) -> None:
    motor, rng = flying(seed, drive), np.random.default_rng(seed)
    ready = prepared(motor, hertz(), 1e-3, None, None)
    state = fresh_state()
    ready.set_up(state, 1e-3)
    state.time = rng.uniform(0.0, 9e-4)
    run = ready.run_of(state)
    modes = modes_of(run.plant)
    rates = np.sqrt(np.maximum(modes["stiffness"], 1.0))
    modes["v"][:, START] = 10.0 ** rng.uniform(-5.0, -2.0) * rng.normal(size=rates.size)
    modes["q"][:, START] = 1e-3 * rng.normal(size=rates.size) / rates
    begin(run, ready.waves)
    run.step.kind = FLIGHT
    at_start = abs(free_accelerations(run, START, 0.0)[0])
    for level in range(0, 31, 3):
        h = state.length = step_length(run.propagator, level)
        bound = curvature_bound(run, tip_motion(run.plant, START), h)
        for s in np.linspace(0.0, h, 9):
            flow_to(run, s)
            assert abs(free_accelerations(run, BETWEEN, s)[0]) <= bound * (1.0 + 1e-9)
    # Over the last step the jerk adds nothing.
    assert bound <= 1.001 * at_start + 1.0
