"""A rigid contact goes the paper's way step by step, written out here with matrices.

Where the contact goes in the end does not tell: a scheme without its corrector tends to the same motion.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import block_diag, expm
from support.kernels import solve_of

from contactlab.laws import LagrangeSlip, LagrangeStick
from contactlab.motor import Drive, RitzResonator
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, Motor, Rotor
from contactlab.testing.plants import first, last, run

Array = NDArray[np.float64]
Law = LagrangeSlip | LagrangeStick

STEP = 1e-6
"""Of the contact [s]: a ninth of the contact, so that every part of a step shows."""

APPROACH = 0.2
"""Gap rate at the touch-down [m/s]."""

DIGIT = 2e-17
"""Round-off of a gap [m] that is a distance less the rotor's radius."""

laws = pytest.mark.parametrize("law", [LagrangeStick(0.3), LagrangeSlip(0.3)], ids=lambda x: x.name)
spins = pytest.mark.parametrize("spin", [5.0, 20.0, -20.0])


def thrown_resonator(spin: float) -> Motor:
    """A resonator that approaches a loaded, damped rotor, its tip turning with `spin` [rad/s]."""
    modes = RitzResonator().modes
    u, th = modes.tip_displacement, modes.tip_slope
    return Motor(
        modes,
        Drive(),
        ContactGeometry(clearance=1e-12),
        Rotor(damping=1e-4, load_torque=0.05, initial_velocity=2.0),
        preload=-0.5 * u,
        start=ModalState(np.zeros(u.size), APPROACH * u / (u @ u) + spin * th / (th @ th)),
    )


class Body:
    """Matrices of a motor without drive: M = 1, the rotor last, and its exact flow under constant force."""

    def __init__(self, motor: Motor) -> None:
        modes, rotor, self.geometry = motor.modes, motor.rotor, motor.geometry
        assert motor.preload is not None
        assert motor.start is not None
        root = np.sqrt(rotor.inertia)
        self.stiffness = np.append(modes.stiffness, 0.0)
        self.damping = np.append(modes.damping, rotor.damping / rotor.inertia)
        self.constant = np.append(motor.preload, -rotor.load_torque / root)
        self.rows = np.zeros((3, self.stiffness.size))
        self.rows[0, :-1], self.rows[1, :-1] = modes.tip_displacement, modes.tip_slope
        self.rows[2, -1] = -self.geometry.rotor_radius / root
        self.q = np.append(motor.start.displacement, 0.0)
        self.v = np.append(motor.start.velocity, root * rotor.initial_velocity)

    def flow(self, h: float) -> tuple[Array, Array, Array, Array]:
        """State after h without contact, and displacements and rates per unit of a constant force."""
        count = self.stiffness.size
        parts = []
        for j in range(count):
            rate = np.array([[0.0, 1.0, 0.0], [-self.stiffness[j], -self.damping[j], 1.0], [0.0, 0.0, 0.0]])
            parts.append(expm(rate * h))
        whole = block_diag(*parts)
        state = np.column_stack([self.q, self.v, self.constant]).ravel()
        q, v, _ = (whole @ state).reshape(count, 3).T
        answer = np.array([part[:2, 2] for part in parts])
        return q, v, answer[:, 0], answer[:, 1]

    def frame(self, q: Array) -> tuple[float, Array]:
        """Gap [m] and the normal and tangential row of the contact, shape (2, coordinate)."""
        g = self.geometry
        u, th, _ = self.rows @ q
        x, y = -g.tip_length * np.sin(th), g.tip_length * np.cos(th) + u
        y -= g.tip_length + g.clearance + g.rotor_radius
        distance = np.hypot(x, y)
        n = np.array([x, y]) / distance
        t = np.array([-n[1], n[0]])
        lever = -g.tip_length * np.array([np.cos(th), np.sin(th)])
        normal = n[1] * self.rows[0] + (n @ lever) * self.rows[1]
        tangential = t[1] * self.rows[0] + (t @ lever) * self.rows[1] + self.rows[2]
        return float(distance - g.rotor_radius), np.stack([normal, tangential])


@dataclass
class Course:
    """States after every step of a contact, and how it ended.

    Args:
        states: u, theta, rates of the normal and the tangent, gap, after each step.
        duration: of the contact [s], up to the release.
        impulse: normal and friction impulse of all of it [N s].
    """

    states: list[Array]
    duration: float
    impulse: Array


def course_of(motor: Motor, law: Law, touch: float) -> Course:
    """Eqs. 49-59 step by step from a touch-down until the contact would pull."""
    body = Body(motor)
    body.q, body.v, _, _ = body.flow(touch)
    states: list[Array] = []
    impulse = np.zeros(2)
    before = np.zeros(2)
    while len(states) < 100:
        q_free, v_free, answer_q, answer_v = body.flow(STEP)
        _, rows = body.frame(body.q)
        at_start = rows @ body.v

        def solve(rows: Array, v: Array, mobility: Array, start: Array) -> Array:
            d = rows @ (mobility[:, None] * rows.T)
            ends = rows @ v
            numbers = (*ends, *start, d[0, 0], d[0, 1], d[1, 1])
            return np.array(solve_of(law, *numbers)[:2])

        predicted = solve(rows, v_free, answer_v / STEP, at_start)
        q = q_free + answer_q * (predicted @ rows) / STEP
        # Onto the closed gap along its gradient: the metric of the masses, which are one.
        gap, rows = body.frame(q)
        q = q - gap * rows[0] / (rows[0] @ rows[0])
        _, rows = body.frame(q)
        p = solve(rows, v_free, answer_v / STEP, at_start)
        if p[0] <= 0.0:
            # The force falls linearly from that of the step before to nothing.
            s = STEP * before[0] / (before[0] - p[0])
            end = len(states) * STEP + s
            return Course(states, end, impulse + 0.5 * before / STEP * s)
        impulse = impulse + p
        # The force of an impact is none that falls.
        before = p if states else np.zeros(2)
        body.q, body.v = q, v_free + answer_v * (p @ rows) / STEP
        gap, rows = body.frame(body.q)
        states.append(np.array([*(body.rows @ body.q)[:2], *(rows @ body.v), gap]))
    raise AssertionError("The contact does not end.")


@cache
def touch_of(spin: float) -> float:
    return first(run(thrown_resonator(spin), LagrangeStick(0.3), 1e-8, STEP), "start_time")


@cache
def expected_course(spin: float, law: Law) -> Course:
    return course_of(thrown_resonator(spin), law, touch_of(spin))


@laws
@spins
@pytest.mark.parametrize("steps", [1, 2, 4, 8])
def test_every_step_is_predicted_projected_and_corrected(law: Law, spin: float, steps: int) -> None:
    u, th, _, slip, gap = expected_course(spin, law).states[steps - 1]
    # A little further, so that the last step is whole: a step that is cut is not projected.
    end = touch_of(spin) + steps * STEP * (1.0 + 1e-12)
    found = run(thrown_resonator(spin), law, end, STEP)
    # The length of the tip and of a step make a slope and a velocity of it.
    assert last(found, "tip_normal_displacement") == pytest.approx(u, abs=DIGIT)
    assert last(found, "tip_slope") == pytest.approx(th, abs=DIGIT / 19e-3)
    assert last(found, "slip_velocity") == pytest.approx(slip, abs=10.0 * DIGIT / STEP)
    assert last(found, "gap") == pytest.approx(gap, abs=DIGIT)


@laws
@spins
def test_a_release_is_where_the_force_that_falls_from_the_last_step_ends(law: Law, spin: float) -> None:
    course = expected_course(spin, law)
    end = touch_of(spin) + course.duration + 10.0 * STEP
    found = run(thrown_resonator(spin), law, end, STEP)
    assert first(found, "duration") == pytest.approx(course.duration, rel=1e-6)
    size = 1e-8 * np.abs(course.impulse).max()
    for name, impulse in zip(("normal_impulse", "friction_impulse"), course.impulse, strict=True):
        assert first(found, name) == pytest.approx(impulse, abs=size)
