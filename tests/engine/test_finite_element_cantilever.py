"""A cantilever by its matrices, which strikes a Hertzian stop, against integrations by SciPy and SUNDIALS."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import contactlab as cl
from contactlab.arrays import Array
from contactlab.engine import simulate
from contactlab.motor.bodies import FLAT
from contactlab.motor.finite_element import HermiteBeam

ELEMENTS, GAP, STIFFNESS, DURATION = 12, 2e-4, 1e9, 0.012
RIGIDITY, MASS, LENGTH = 210e9 * 0.01 * 1e-9 / 12.0, 7850.0 * 0.01 * 1e-3, 0.1


def cantilever() -> cl.Motor:
    """A steel strip of 100 x 10 x 1 mm, clamped at one end; a volt is a newton at its middle."""
    size = np.full(ELEMENTS, LENGTH / ELEMENTS)
    beam = HermiteBeam(size, np.full(ELEMENTS, RIGIDITY))
    stiffness = np.linalg.inv(beam.cantilever @ beam.cantilever.T)
    end, middle = np.zeros((2, 2 * ELEMENTS))
    end[-2], middle[ELEMENTS - 2] = 1.0, 1.0
    modes = cl.reduced(
        beam.mass_matrix(np.full(ELEMENTS, MASS)),
        0.5 * (stiffness + stiffness.T),
        end,
        np.zeros_like(end),
        middle[:, None],
        modes=4,
        damping_ratio=0.005,
    )
    drive = cl.Drive(np.array([90.0]), np.array([[2.0 + 0j]]))
    return cl.Motor(modes, drive, cl.ContactGeometry(FLAT, FLAT, GAP), cl.Rotor(inertia=1e18 * FLAT**2))


def rates(motor: cl.Motor) -> object:
    modes = motor.modes
    count, row = modes.stiffness.size, modes.approach
    constant = 0.0 if motor.preload is None else motor.preload

    def rate(t: float, y: Array) -> Array:
        q, v = y[:count], y[count:]
        depth = max(float(row @ q) - GAP, 0.0)
        force = modes.coupling[:, 0] * 2.0 * np.cos(2.0 * np.pi * 90.0 * t) - row * STIFFNESS * depth**1.5
        force = force + constant
        return np.concatenate([v, force - modes.damping * v - modes.stiffness * q])

    return rate


def test_the_cantilever_has_the_frequencies_of_the_closed_form() -> None:
    """cos(b) cosh(b) = -1."""
    b = np.array([1.8751040687, 4.6940911330, 7.8547574382])
    expected = b**2 / (2.0 * np.pi * LENGTH**2) * np.sqrt(RIGIDITY / MASS)
    assert cantilever().modes.natural_frequency[:3] == pytest.approx(expected, rel=2e-4)


@pytest.mark.parametrize("pressed", [False, True], ids=["stop", "rotor on a spring"])
def test_scipy_and_sundials_end_where_the_engine_ends(pressed: bool) -> None:
    cvode = pytest.importorskip("sksundae.cvode")
    motor = cantilever()
    if pressed:
        motor = cl.on_bearing(motor, cl.Bearing(mass=0.01, preload=0.5, stiffness=1e3, damping=0.1))
    law = cl.HertzPenalty(stiffness=STIFFNESS, friction_coefficient=0.0)
    run = simulate(motor, law, duration=DURATION, record_interval=1e-5, tolerance=1e-12)
    assert run.contacts["start_time"].size >= 3
    count, rate = motor.modes.stiffness.size, rates(motor)
    assert callable(rate)
    start = np.zeros(2 * count)
    if motor.start is not None:
        start[:count] = motor.start.displacement
    apart = run.series["tip_normal_displacement"] - run.series["rotor_normal_displacement"]
    travel, some = np.abs(apart).max(), slice(None, None, run.time.size // 20)
    time, ours, row = run.time[some], apart[some], motor.modes.approach
    scipy = solve_ivp(rate, (0.0, DURATION), start, "DOP853", time, rtol=1e-12, atol=1e-16, max_step=2e-6)
    assert row @ scipy.y[:count] == pytest.approx(ours, abs=1e-8 * travel)

    def into(t: float, y: Array, out: Array) -> None:
        out[:] = rate(t, y)

    solver = cvode.CVODE(into, method="Adams", rtol=1e-12, atol=1e-16, max_step=2e-6, max_num_steps=10**6)
    sundials = solver.solve(time, start)
    assert sundials.success
    assert row @ sundials.y[:, :count].T == pytest.approx(ours, abs=1e-8 * travel)
