"""A pressed motor of three modes at 39 kHz, against an integration of its own equations and a long run."""

from pathlib import Path
from typing import Final

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import contactlab as cl

FREQUENCY: Final = 39e3
MODES: Final = np.array(
    [
        [38.4e3, 0.010, 4.1, 0.3, 2.1, 0.1],
        [39.3e3, 0.012, -0.2, 4.4, 0.2, 1.9],
        [39.9e3, 0.011, 1.2, -1.6, -0.4, 0.5],
    ]
)
"""Frequency [Hz], damping ratio, displacement along y and x [kg^-1/2] and couplings [N/V kg^-1/2] of each."""

PRELOAD, BEARING, VOLTAGE, LOAD = 20.0, 600.0, 60.0, 2e-3
STIFFNESS, FRICTION, CREEP = 1e10, 0.3, 1e-2
TIP, RADIUS, CLEARANCE, INERTIA = 19e-3, 25e-3, 1e-6, 4.8e-5
MASS: Final = 2.0 * INERTIA / RADIUS**2
"""That of a disc [kg]."""


def setup_in(folder: Path) -> cl.Setup:
    head = "frequency [Hz],damping_ratio,uy,ux,coupling_1 [N/V],coupling_2 [N/V]"
    np.savetxt(folder / "modes.csv", MODES, delimiter=",", header=head, comments="", fmt="%.17g")
    numbers = {
        "drive.voltage_1": VOLTAGE,
        "drive.voltage_2": VOLTAGE,
        "drive.frequency": FREQUENCY,
        "contact.preload": PRELOAD,
        "contact.clearance": CLEARANCE,
        "contact.tip_length": TIP,
        "contact.friction_coefficient": FRICTION,
        "rotor.bearing_damping": BEARING,
        "rotor.radius": RADIUS,
        "rotor.inertia": INERTIA,
        "rotor.load_torque": LOAD,
        "law.normal.stiffness": STIFFNESS,
        "law.friction.creep_velocity": CREEP,
    }
    groups = ["resonator=modal", f"resonator.file={folder / 'modes.csv'}", "drive=two_phase", "law=composed"]
    parts = ["law/normal=hertz_point", "law/friction=regularised"]
    return cl.build([*groups, *parts, *(f"{key}={value!r}" for key, value in numbers.items())])


def rates(time: float, y: np.ndarray) -> np.ndarray:
    """Rates of three amplitudes, the rotor's lift, their rates, and the rotor's angle and velocity."""
    q, v, lift, rises, spin = y[:3], y[3:6], y[6], y[7], y[9]
    omega, across, along = 2.0 * np.pi * MODES[:, 0], MODES[:, 2], MODES[:, 3]
    lean, leans = -(along @ q) / TIP, -(along @ v) / TIP
    # From the rotor's centre to the tip's end.
    x, height = -TIP * np.sin(lean), RADIUS + CLEARANCE + lift - across @ q + TIP * (1.0 - np.cos(lean))
    moves = np.array([-TIP * np.cos(lean) * leans, across @ v - TIP * np.sin(lean) * leans])
    distance = np.hypot(x, height)
    normal = np.array([x, -height]) / distance
    tangent = np.array([-normal[1], normal[0]])
    pressed = STIFFNESS * max(RADIUS - distance, 0.0) ** 1.5
    slip = tangent @ (moves - np.array([0.0, rises])) - RADIUS * spin
    rubs = -FRICTION * pressed * slip / np.hypot(slip, CREEP)
    force = pressed * normal + rubs * tangent
    turn = 2.0 * np.pi * FREQUENCY * time
    driven = VOLTAGE * (MODES[:, 4] * np.sin(turn) + MODES[:, 5] * np.cos(turn))
    by_lean = -TIP * (np.cos(lean) * force[0] + np.sin(lean) * force[1])
    accelerates = driven + across * force[1] - along / TIP * by_lean
    accelerates -= omega * (2.0 * MODES[:, 1] * v + omega * q)
    rotor = [rises, (-force[1] - PRELOAD - BEARING * rises) / MASS, spin, (-RADIUS * rubs - LOAD) / INERTIA]
    return np.concatenate([v, accelerates, rotor])


@pytest.mark.long
def test_a_pressed_motor_settles_where_its_equations_and_a_long_run_do(tmp_path: Path) -> None:
    setup, period = setup_in(tmp_path), 1.0 / FREQUENCY
    settled = cl.steady(setup)
    last = 600 * period
    start = np.zeros(10)
    start[6] = -CLEARANCE
    own = solve_ivp(rates, (0.0, last), start, "DOP853", [last - period, last], rtol=1e-10, atol=1e-14)
    run = setup.run(duration=last, record_interval=period)
    velocity = (own.y[8, 1] - own.y[8, 0]) / period
    assert settled.details.kind == "periodic"
    assert settled.orbit.map.touches
    assert settled.orbit.stable
    assert settled.velocity.value == pytest.approx(velocity, rel=1e-6)
    assert settled.velocity.value == pytest.approx(np.diff(run.series["rotor_angle"])[-1] / period, rel=1e-6)
