"""What a foreign solver receives: a motor in normal modes as plain numbers; and the motors of its tests."""

from typing import Any

from support.motors import default_motor, parameters_with

CASE_A = "case A"

MOTORS: dict[str, dict[str, float]] = {
    CASE_A: {},
    "no clearance, loaded and damped, turning backwards": {
        "clearance": 0.0,
        "load_torque": 2e-3,
        "rotor_damping": 1e-4,
        "initial_velocity": -0.9,
        "friction_coefficient": 0.2,
    },
    "ratio three to two, six shapes, slippery": {
        "frequency": 3000.0,
        "frequency_ratio": 1.5,
        "phase": 1.0,
        "friction_coefficient": 0.1,
        "shapes": 6,
    },
    "small light rotor under load, short tip": {
        "rotor_radius": 10e-3,
        "tip_length": 12e-3,
        "rotor_inertia": 4e-6,
        "phase": -2.0,
        "load_torque": 5e-4,
    },
}
"""Changes to the motor of case A, see `motors.DEFAULTS`."""


Problem = dict[str, Any]
"""A motor in normal modes, unit masses, SI; signs as in `contactlab.motor.geometry`.

    qdd_j + damping_j qd_j + stiffness_j q_j
        = Re sum_k (force_re + i force_im)_jk exp(i omega_k t) + contact
    u = tip_displacement . q,   th = tip_slope . q
"""

NUMBERS = (
    *("tip_length", "rotor_radius", "clearance", "rotor_inertia", "rotor_damping", "load_torque"),
    *("initial_velocity", "friction_coefficient"),
)


def problem_from(changes: dict[str, float], duration: float) -> Problem:
    """The motor of case A with some parameters changed, for a time [s]."""
    p, motor = parameters_with(**changes), default_motor(**changes)
    modes = motor.modes
    force = modes.coupling @ motor.drive.phasors
    return Problem(
        stiffness=modes.stiffness.tolist(),
        damping=modes.damping.tolist(),
        force_re=force.real.tolist(),
        force_im=force.imag.tolist(),
        omega=motor.drive.angular_frequency.tolist(),
        tip_displacement=modes.tip_displacement.tolist(),
        tip_slope=modes.tip_slope.tolist(),
        **{name: p[name] for name in NUMBERS},
        restitution=0.0,
        duration=duration,
    )


def problem_of(name: str) -> Problem:
    """One of `MOTORS` as a problem."""
    # The reference numbers of case A are those at 5 ms.
    return problem_from(MOTORS[name], 5e-3 if name == CASE_A else 3e-3)
