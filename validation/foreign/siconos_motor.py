"""The motor with rigid contact as a Siconos model: Moreau-Jean time stepping.

    python siconos_motor.py problem.json result.json

Runs on a Python that has Siconos, and imports nothing else but NumPy. Coordinates are the normal
modes of the resonator (unit masses) and the rotor's angle alpha (mass J):

    qdd_j + c_j qd_j + k_j q_j = Re sum_k force_jk exp(i omega_k t) + contact
    J alphadd + C_r alphad = -tau + contact

One interaction with Newton's impact law and Coulomb friction couples them; its impulses
act on the tip along normal and tangent of `Touch` [N s].

Problem (SI): stiffness, damping [mode]; force_re, force_im [mode][tone]; omega [tone];
tip_displacement, tip_slope [mode]; tip_length, rotor_radius, clearance; rotor_inertia,
rotor_damping, load_torque, initial_velocity; friction_coefficient, restitution; duration, step.
"""

import json
import sys
from math import cos, hypot, sin
from pathlib import Path
from typing import Any

import numpy as np
import siconos.kernel as sk
import siconos.numerics as sn

MIDPOINT = 0.5
"""theta of the Moreau-Jean scheme: second order in flight; contact makes it first order."""


class Touch:
    """Gap of tip and rotor and its two directions, linear over one step.

        tip     L = (-l sin th, l cos th + u),   centre (0, l + clearance + R),   d = L - centre
        gap     g = |d| - R,   normal n = d / |d|,   tangent t = n turned by +90 degrees
        rates   gap rate = n . dL/dt,   slip = t . dL/dt - R alphad

    The relation is y = H q + b with H the Jacobian of (gap, slip) where the step begins; it is
    moved there before every step. A relation that Siconos would ask for gap and Jacobian itself
    cannot be written in Python: Siconos 4.4 crashes where it fetches the Jacobian from there.
    """

    def __init__(self, problem: dict[str, Any]) -> None:
        self.rows = np.array([problem["tip_displacement"], problem["tip_slope"]])
        self.arm, self.radius = problem["tip_length"], problem["rotor_radius"]
        self.clearance = problem["clearance"]
        modes = self.rows.shape[1]
        self.relation = sk.LagrangianLinearTIR(np.zeros((2, modes + 1)), np.zeros(2))
        # Views of the memory that Siconos computes with.
        self.jacobian, self.offset = self.relation.jachq(), self.relation.e()
        self.jacobian[1, -1] = -self.radius
        self.move(np.zeros(modes + 1))

    def move(self, q: np.ndarray) -> None:
        """Make the relation exact at coordinates q."""
        u, th = self.rows @ q[:-1]
        across = -self.arm * sin(th)
        # How far the tip end lies above the rotor's lowest point, without cancellation.
        rise = u - self.clearance - 2.0 * self.arm * sin(0.5 * th) ** 2
        distance = hypot(across, rise - self.radius)
        gap = (across**2 + rise**2 - 2.0 * self.radius * rise) / (distance + self.radius)
        nx, ny = across / distance, (rise - self.radius) / distance
        turn_x, turn_y = -self.arm * cos(th), -self.arm * sin(th)
        # Rows: n and t times dL/du = (0, 1) and dL/dth = (turn_x, turn_y).
        frame = np.array([[ny, nx * turn_x + ny * turn_y], [nx, nx * turn_y - ny * turn_x]])
        self.jacobian[:, :-1] = frame @ self.rows
        self.offset[0] = gap - self.jacobian[0] @ q


def drive_forces(problem: dict[str, Any], times: np.ndarray) -> np.ndarray:
    """Modal forces of the drive at times [s], shape (time, mode)."""
    phasors = np.array(problem["force_re"]) + 1j * np.array(problem["force_im"])
    turns = np.exp(1j * np.outer(times, problem["omega"]))
    return np.asarray((turns @ phasors.T).real)


def oscillators(problem: dict[str, Any]) -> Any:
    """Modes and rotor, undeformed, under the load torque."""
    modes = len(problem["stiffness"])
    rates = np.zeros(modes + 1)
    rates[-1] = problem["initial_velocity"]
    mass = np.diag([1.0] * modes + [problem["rotor_inertia"]])
    body = sk.LagrangianLinearTIDS(np.zeros(modes + 1), rates, mass)
    body.setKPtr(np.diag([*problem["stiffness"], 0.0]))
    body.setCPtr(np.diag([*problem["damping"], problem["rotor_damping"]]))
    body.setFExtPtr(np.append(np.zeros(modes), -problem["load_torque"]))
    return body


def solve(problem: dict[str, Any]) -> dict[str, Any]:
    """End state, and beginning [s] and impulses [N s] of every step that has one."""
    duration = problem["duration"]
    steps = round(duration / problem["step"])
    drive = drive_forces(problem, np.linspace(0.0, duration, steps + 1))
    body, touch = oscillators(problem), Touch(problem)
    force = body.fExt()
    law = sk.NewtonImpactFrictionNSL(problem["restitution"], 0.0, problem["friction_coefficient"], 2)
    contact = sk.Interaction(law, touch.relation)
    system = sk.NonSmoothDynamicalSystem(0.0, duration)
    system.insertDynamicalSystem(body)
    system.link(contact, body)
    simulation = sk.TimeStepping(
        system,
        sk.TimeDiscretisation(0.0, duration / steps),
        sk.MoreauJeanOSI(MIDPOINT),
        sk.FrictionContact(2, sn.SICONOS_FRICTION_2D_LEMKE),
    )
    impulses = np.zeros((steps, 2))
    for k in range(steps):
        touch.move(body.q())
        force[:-1] = 0.5 * (drive[k] + drive[k + 1])
        simulation.computeOneStep()
        impulses[k] = contact.lambda_(1)
        simulation.nextStep()
    q, rates = body.q(), body.velocity()
    u, th = touch.rows @ q[:-1]
    pushing = np.flatnonzero(impulses[:, 0] > 0.0)
    return {
        "step": duration / steps,
        "rotor_velocity": float(rates[-1]),
        "rotor_angle": float(q[-1]),
        "tip_normal_displacement": float(u),
        "tip_slope": float(th),
        "time": (pushing * (duration / steps)).tolist(),
        "normal_impulse": impulses[pushing, 0].tolist(),
        "friction_impulse": impulses[pushing, 1].tolist(),
    }


if __name__ == "__main__":
    source, target = map(Path, sys.argv[1:])
    target.write_text(json.dumps(solve(json.loads(source.read_text()))))
