"""A ball on a vibrating table: its bounce, the multipliers in closed form, and the doubling of its period.

The table is w = A sin(2 pi t/T), with A (2 pi/T)^2 = gamma g. In its frame the ball is a rigid body that is
pressed on by g and shaken by the table's acceleration. A bounce a period leaves the table with the velocity
g T/2 at the phase where the table moves with W = (1 - e)/(1 + e) g T/2. Flights and impacts in a row,

    w(t) + u (t' - t) - g (t' - t)^2/2 = w(t'),    u' = (1 + e) dw(t') - e (u - g (t' - t)),

have there, with the table's acceleration a = -gamma g sin(phase), a derivative of

    determinant e^2,    trace 1 + e^2 + (1 + e)^2 a/g.

So a bounce a period is stable from a = 0, gamma = pi (1 - e)/(1 + e), to a = -2 g (1 + e^2)/(1 + e)^2, where
a multiplier is -1 and the period doubles: Holmes (1982), J. Sound Vib. 84, 173; Guckenheimer and Holmes
(1983), Nonlinear Oscillations, sec. 2.4, there for a ball that flies high.
"""

from math import pi, sin

import numpy as np
import pytest

import contactlab as cl
from contactlab.testing.plants import FLAT

G, FREQUENCY = 9.81, 50.0
PERIOD = 1.0 / FREQUENCY

ASIDE = (1e4, 60.0)
"""Stiffness [1/s^2] and damping [1/s] of the ball along the table, where nothing happens."""


def phase_of(restitution: float, gamma: float) -> float:
    """Phase of the bounce [rad]."""
    return float(np.arccos(pi * (1.0 - restitution) / ((1.0 + restitution) * gamma)))


def gamma_at(restitution: float, acceleration: float) -> float:
    """Strength of the table at which a bounce meets an acceleration, in g, downwards."""
    return float(np.hypot(pi * (1.0 - restitution) / (1.0 + restitution), acceleration))


def doubling(restitution: float) -> float:
    """Acceleration at which the period doubles, in g, downwards."""
    return 2.0 * (1.0 + restitution**2) / (1.0 + restitution) ** 2


def multipliers_of(restitution: float, gamma: float) -> np.ndarray:
    trace = 1.0 + restitution**2 - (1.0 + restitution) ** 2 * gamma * sin(phase_of(restitution, gamma))
    return np.roots([1.0, -trace, restitution**2])


def ball(restitution: float, gamma: float) -> cl.Motor:
    """The ball on its way from one bounce to the next, a thousandth too high, at the table's phase 0."""
    omega = 2.0 * pi * FREQUENCY
    amplitude, phase = gamma * G / omega**2, phase_of(restitution, gamma)
    flown, up = PERIOD - phase / omega, 0.5 * G * PERIOD
    height = amplitude * sin(phase) + up * flown - 0.5 * G * flown**2
    rate = up - G * flown - amplitude * omega
    modes = cl.NormalModes(
        stiffness=np.array([0.0, ASIDE[0]]),
        damping=np.array([0.0, ASIDE[1]]),
        coupling=np.array([[1.0, 0.0], [0.0, 0.0]]),
        tip_displacement=np.array([1.0, 0.0]),
        tip_slope=np.array([0.0, -1.0 / FLAT]),
        shape_coupling=np.zeros((2, 2)),
    )
    # The table's acceleration, -A omega^2 sin(omega t), as a force away from the gap.
    drive = cl.Drive(np.array([FREQUENCY]), np.array([[1j * gamma * G], [0.0]]))
    start = cl.ModalState(np.array([-1.001 * height, 0.0]), np.array([-rate, 0.0]))
    geometry, rotor = cl.ContactGeometry(FLAT, FLAT, 0.0), cl.Rotor(inertia=FLAT**2)
    return cl.Motor(modes, drive, geometry, rotor, preload=np.array([G, 0.0]), start=start)


def bounce(restitution: float, gamma: float) -> cl.Steady:
    law = cl.Newton(friction_coefficient=0.0, restitution=restitution)
    return cl.steady(ball(restitution, gamma), law, belt=0.0, contact_step=2e-11)


@pytest.mark.parametrize(("restitution", "share"), [(0.5, 0.4), (0.5, 0.97), (0.8, 0.8)])
def test_multipliers_of_a_bounce_are_those_of_its_closed_form(restitution: float, share: float) -> None:
    gamma = gamma_at(restitution, share * doubling(restitution))
    result, expected = bounce(restitution, gamma), multipliers_of(restitution, gamma)
    assert (result.kind, result.periods) == ("periodic", 1)
    assert result.orbit is not None
    # Beside them are those of the way along the table.
    aside = np.exp(np.roots([1.0, ASIDE[1], ASIDE[0]]) * PERIOD)
    for value in (*expected, *aside):
        assert np.abs(result.orbit.multipliers - value).min() < 1e-6
    assert result.motion.contacts["approach_velocity"] == pytest.approx(
        -G * PERIOD / (1.0 + restitution), rel=1e-6
    )


@pytest.mark.parametrize("restitution", [0.5, 0.8])
def test_the_period_doubles_where_a_multiplier_is_minus_one(restitution: float) -> None:
    below, above = (gamma_at(restitution, share * doubling(restitution)) for share in (0.995, 1.02))
    assert bounce(restitution, below).periods == 1
    assert min(multipliers_of(restitution, above).real) < -1.0
    doubled = bounce(restitution, above)
    assert (doubled.kind, doubled.periods) == ("periodic", 2)
    approaches = doubled.motion.contacts["approach_velocity"]
    assert approaches.size == 2
    assert abs(np.diff(approaches)[0]) > 0.01 * abs(approaches[0])


def test_impacts_lose_what_the_restitution_says() -> None:
    restitution = 0.8
    result = bounce(restitution, gamma_at(restitution, 0.5 * doubling(restitution)))
    approach = G * PERIOD / (1.0 + restitution)
    lost = 0.5 * (1.0 - restitution**2) * approach**2 / PERIOD
    assert result.average("contact_loss")[0] == pytest.approx(lost, rel=1e-6)
    # What the table gives: its force moves with the ball in its frame.
    assert result.average("drive_work")[0] == pytest.approx(lost, rel=1e-6)
