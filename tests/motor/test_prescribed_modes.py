"""A mode whose coordinate the voltages are: tones lead it as a waveform does, in flight and in contact."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PPoly

import contactlab as cl
from contactlab.motor.motor import FLAT, free_reach

A, B, CLEARANCE, FREQUENCY, STIFFNESS, FRICTION, MASS = 1e-6, 2e-6, 0.3e-6, 40e3, 5e6, 0.2, 1e-3
OMEGA, ROOT = 2.0 * pi * FREQUENCY, 1e15
LAW = cl.Composed(cl.Linear(STIFFNESS), cl.Undamped(), cl.Coulomb(FRICTION))


def tones() -> cl.Drive:
    return cl.Drive(np.array([FREQUENCY]), np.array([[-A], [-1j * B]], complex))


def waveform() -> cl.Drive:
    angle = 2.0 * pi * np.arange(512) / 512
    rows = np.stack([-A * np.cos(angle), B * np.sin(angle)])
    return cl.Drive(waveform=cl.Waveform.sampled(angle / OMEGA, rows, 7, 1.0 / FREQUENCY))


def both() -> cl.Drive:
    """Half of the amplitude by a tone, half by a waveform."""
    half = waveform()
    pieces = half.waveform.pieces
    path = replace(half.waveform, pieces=type(pieces)(0.5 * pieces.c, pieces.x))
    return cl.Drive(tones().frequency, 0.5 * tones().phasors, path)


def slider(
    drive: cl.Drive, start: cl.ModalState | None = None, preload: np.ndarray | None = None
) -> cl.Motor:
    """A tip on an ellipse, u = -A cos and x = B sin, over a slider of a gram."""
    modes = cl.NormalModes(
        stiffness=np.zeros(2),
        damping=np.zeros(2),
        coupling=np.diag([-ROOT, ROOT]),
        tip_displacement=np.array([1.0 / ROOT, 0.0]),
        tip_slope=np.array([0.0, -1.0 / (FLAT * ROOT)]),
        prescribed=np.array([True, True]),
    )
    rotor = cl.Rotor(inertia=MASS * FLAT**2)
    return cl.Motor(modes, drive, cl.ContactGeometry(FLAT, FLAT, CLEARANCE), rotor, preload, start)


def velocity_of_slider(time: np.ndarray) -> np.ndarray:
    """Integrate m dV/dt = mu N sign(v_tip - V), whose slip reverses at events; nothing sticks here."""

    def slip(t, y):
        return B * OMEGA * np.cos(OMEGA * t) - y[0]

    slip.terminal = True
    values, t, y, sign = np.zeros(time.size), 0.0, [0.0], 1.0
    while t < time[-1]:
        solution = solve_ivp(
            lambda s, _, force=sign * FRICTION * STIFFNESS: [
                force * max(A * np.cos(OMEGA * s) - CLEARANCE, 0.0) / MASS
            ],
            (t, time[-1]),
            y,
            "DOP853",
            events=slip,
            dense_output=True,
            rtol=1e-12,
            atol=1e-15,
            max_step=0.005 / FREQUENCY,
        )
        inside = (time >= t) & (time <= solution.t[-1])
        values[inside] = solution.sol(time[inside])[0]
        # Past the zero by no more than the clock resolves.
        t, y, sign = solution.t[-1] + 1e-15, solution.y[:, -1], -sign
    return values


@pytest.mark.parametrize("drive", [tones, waveform, both])
def test_a_tip_on_an_ellipse_takes_a_slider_along(drive) -> None:
    run = cl.simulate(
        slider(drive()), LAW, duration=2.0 / FREQUENCY, record_interval=1.0 / FREQUENCY / 64, tolerance=1e-10
    )
    assert run.complete
    time = run["time"].values
    np.testing.assert_allclose(run["gap"], CLEARANCE - A * np.cos(OMEGA * time), rtol=0.0, atol=1e-15)
    speed = np.abs(run["rotor_velocity"].values) * FLAT
    expected = np.abs(velocity_of_slider(time))
    np.testing.assert_allclose(speed, expected, rtol=0.0, atol=1e-7 * expected.max())
    # What the tip gives is in the slider or lost in its slip.
    gained = float(run["drive_work"][-1])
    assert gained > 0.0
    assert np.abs(run["energy_residual"]).max() < 1e-9 * gained


def test_nothing_else_moves_a_prescribed_mode() -> None:
    elsewhere = cl.ModalState(np.full(2, ROOT * 1e-3), np.full(2, -ROOT))
    pressed = np.full(2, ROOT * 1e3)
    run = cl.simulate(slider(tones(), elsewhere, pressed), LAW, duration=1e-5, record_interval=1e-7)
    expected = CLEARANCE - A * np.cos(OMEGA * run["time"].values)
    np.testing.assert_allclose(run["gap"], expected, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("velocity", [0.3, -0.2])
def test_a_floor_of_constant_velocity_does_the_work_of_its_impulse(velocity: float) -> None:
    """p = (1 + e) m (V + v) takes p V from the drive: the ball has that, less (1 - e^2) m (V + v)^2 / 2."""
    modes = cl.NormalModes(
        stiffness=np.zeros(2),
        damping=np.zeros(2),
        coupling=np.array([[ROOT, 0.0], [0.0, 0.0]]),
        tip_displacement=np.array([1.0 / ROOT, 1.0]),
        tip_slope=np.zeros(2),
        prescribed=np.array([True, False]),
    )
    line = PPoly(np.array([[[velocity, 0.0]], [[0.0, 0.0]]]), [0.0, 1.0])
    drive = cl.Drive(waveform=cl.Waveform(line))
    start = cl.ModalState(np.zeros(2), np.array([0.0, 0.5]))
    motor = cl.Motor(modes, drive, cl.ContactGeometry(FLAT, FLAT, 1e-3), start=start)
    run = cl.simulate(motor, cl.Newton(restitution=0.7), duration=8e-3, record_interval=1e-5)
    impulse = 1.7 * (velocity + 0.5)
    np.testing.assert_allclose(run.contacts["normal_impulse"], [impulse], rtol=1e-12)
    np.testing.assert_allclose(run["drive_work"][-1], impulse * velocity, rtol=1e-12)
    assert np.abs(run["energy_residual"]).max() < 1e-12


def test_a_shaken_floor_throws_a_ball() -> None:
    """The floor's way is prescribed and the ball is free: v+ = (1 + e) v_floor - e v-."""
    modes = cl.NormalModes(
        stiffness=np.zeros(2),
        damping=np.zeros(2),
        coupling=np.array([[ROOT], [0.0]]),
        tip_displacement=np.array([1.0 / ROOT, 1.0]),
        tip_slope=np.zeros(2),
        prescribed=np.array([True, False]),
    )
    drive = cl.Drive(np.array([100.0]), np.array([[-1j * 1e-4]]))
    start = cl.ModalState(np.zeros(2), np.array([0.0, 0.5]))
    motor = cl.Motor(modes, drive, cl.ContactGeometry(FLAT, FLAT, 1e-3), start=start)
    run = cl.simulate(motor, cl.Newton(restitution=0.7), duration=4e-3, record_interval=1e-5)
    time, rate = run.contacts["start_time"].values[0], 2.0 * pi * 100.0
    floor = 1e-4 * rate * np.cos(rate * time)
    assert 1e-4 * np.sin(rate * time) + 0.5 * time == pytest.approx(1e-3, rel=1e-12)
    assert run.contacts["approach_velocity"].values[0] == pytest.approx(-(0.5 + floor), rel=1e-12)
    assert run.contacts["separation_velocity"].values[0] == pytest.approx(0.7 * (0.5 + floor), rel=1e-9)


def test_the_reach_of_a_prescribed_tip_is_its_amplitude() -> None:
    assert free_reach(slider(tones())) == pytest.approx(A, rel=1e-6)
