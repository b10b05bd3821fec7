"""Runs a Hertz motor with CVODE of SUNDIALS: Adams' method, one smooth phase after the other."""

from dataclasses import dataclass

import numpy as np
from sksundae.cvode import CVODE

from foreign.cvode_motor import FLIGHT, SLIP_BACKWARD, SLIP_FORWARD, STICK, Array, HertzMotor, Roots
from foreign.problem import Problem

LONGEST_STEP = 2e-6
"""Signs of root functions are compared from step to step: a dip within one step would be missed [s]."""

STEP_LIMIT = 1_000_000
PHASE_LIMIT = 10_000


@dataclass(frozen=True)
class CvodeRun:
    """End state, sums of impulses [N s], time in contact and in stick [s], each touch-down [s]."""

    rotor_velocity: float
    rotor_angle: float
    tip_normal_displacement: float
    tip_slope: float
    normal_impulse: float
    friction_impulse: float
    time_in_contact: float
    time_in_stick: float
    start_time: list[float]


def absolute_tolerance(problem: Problem, rtol: float) -> Array:
    """A hundredth of rtol times the static size of every state."""
    force = np.abs(np.array(problem["force_re"]) + 1j * np.array(problem["force_im"])).sum(axis=1)
    rate = np.sqrt(problem["stiffness"])
    size = force / rate**2
    tip_speed = float(np.abs(problem["tip_displacement"]) @ (size * rate))
    rotor = tip_speed / problem["rotor_radius"]
    impulse = tip_speed / float(np.square(problem["tip_displacement"]).sum())
    angle = rotor / problem["omega"][0]
    return 1e-2 * rtol * np.array([*size, *(size * rate), rotor, angle, impulse, impulse])


def next_phase(motor: HertzMotor, t: float, y: Array, phase: str, root: int) -> str:
    """The phase that follows when a root function ended one; a slip at zero is made exactly zero."""
    if phase == FLIGHT:
        now = motor.instant(y, motor.free_acceleration(t, y))
        return SLIP_FORWARD if now.slip >= 0.0 else SLIP_BACKWARD
    if root == 0:
        return FLIGHT
    if phase == STICK:
        # Past F = mu N the tip slips backwards, for friction opposes it.
        return SLIP_BACKWARD if root == 1 else SLIP_FORWARD
    slip = motor.instant(y, motor.free_acceleration(t, y)).slip
    y[2 * motor.modes] += slip / motor.problem["rotor_radius"]
    now = motor.instant(y, motor.free_acceleration(t, y))
    friction = motor.sticking_force(now)
    if abs(friction) <= motor.mu * motor.normal_force(now):
        return STICK
    return SLIP_BACKWARD if friction > 0.0 else SLIP_FORWARD


def run_phase(
    motor: HertzMotor, t: float, y: Array, phase: str, rtol: float
) -> tuple[float, Array, int | None]:
    """Integrate a phase; its last time, state and the root that ended it, None at the run's end."""
    roots = Roots(motor, phase)
    solver = CVODE(
        motor.right_hand_side(phase),
        method="Adams",
        rtol=rtol,
        atol=absolute_tolerance(motor.problem, rtol),
        max_step=LONGEST_STEP,
        max_num_steps=STEP_LIMIT,
        eventsfn=roots,
        num_events=len(roots.direction),
    )
    result = solver.solve([t, motor.problem["duration"]], y)
    if not result.success:
        raise RuntimeError(f"CVODE gave up in {phase} after {t} s: {result.message}")
    end, state = float(result.t[-1]), np.array(result.y[-1])
    if result.i_events is None:
        return end, state, None
    return end, state, int(np.flatnonzero(result.i_events[-1])[0])


def solve(problem: Problem, stiffness: float, friction_coefficient: float, rtol: float) -> CvodeRun:
    """Run a motor from rest.

    Args:
        problem: the motor; its tip must not begin inside the rotor.
        stiffness: K [N m^-3/2].
        friction_coefficient: mu [1].
        rtol: relative tolerance of CVODE.
    """
    motor = HertzMotor(problem, stiffness, friction_coefficient)
    n = motor.modes
    t, y, phase = 0.0, np.zeros(2 * n + 4), FLIGHT
    y[2 * n] = problem["initial_velocity"]
    starts: list[float] = []
    time_in = {FLIGHT: 0.0, STICK: 0.0, SLIP_FORWARD: 0.0, SLIP_BACKWARD: 0.0}
    for _ in range(PHASE_LIMIT):
        begin = t
        t, y, root = run_phase(motor, t, y, phase, rtol)
        time_in[phase] += t - begin
        if root is None:
            break
        if phase == FLIGHT:
            starts.append(t)
        phase = next_phase(motor, t, y, phase, root)
    else:
        raise RuntimeError(f"More than {PHASE_LIMIT} phases up to {t} s.")
    u, th = motor.rows @ y[:n]
    rotor_velocity, rotor_angle, normal_impulse, friction_impulse = y[2 * n :]
    return CvodeRun(
        rotor_velocity=float(rotor_velocity),
        rotor_angle=float(rotor_angle),
        tip_normal_displacement=float(u),
        tip_slope=float(th),
        normal_impulse=float(normal_impulse),
        friction_impulse=float(friction_impulse),
        time_in_contact=problem["duration"] - time_in[FLIGHT],
        time_in_stick=time_in[STICK],
        start_time=starts,
    )
