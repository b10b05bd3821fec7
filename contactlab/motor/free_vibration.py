"""How far the tip comes towards the rotor where nothing touches it."""

import numpy as np

from contactlab.motor.geometry import contact_frame
from contactlab.motor.motor import Motor

PERIODS, SAMPLES = 20, 20_000
"""Of the slowest tone that are looked through; tones that do not repeat themselves have met in most ways."""


def free_reach(motor: Motor) -> float:
    """Give what the tip bridges of the clearance in the steady state of free vibration [m].

    That is the largest of clearance less gap, with u and th of the sum of all modes' answers
    Q_j = f_j / (k_j - omega^2 + i c_j omega) to all tones, and of the preload's; zero without either. It is
    sampled, to a thousandth of itself. Not a number where a rigid body follows a constant force.
    """
    modes, geometry = motor.modes, motor.geometry
    omega, force = motor.drive.angular_frequency, modes.coupling @ motor.drive.phasors
    loud = np.any(force != 0.0, axis=0)
    omega, force = omega[loud], force[:, loud]
    q = np.zeros((modes.stiffness.size, 1))
    if omega.size:
        dynamic = modes.stiffness[:, None] - omega**2 + 1j * modes.damping[:, None] * omega
        time = np.linspace(0.0, PERIODS * 2.0 * np.pi / omega.min(), SAMPLES)
        q = np.real(force / dynamic @ np.exp(1j * np.multiply.outer(omega, time)))
    if motor.preload is not None:
        with np.errstate(divide="ignore", invalid="ignore"):
            still = np.where(motor.preload == 0.0, 0.0, motor.preload / modes.stiffness)
        q = q + still[:, None]
    lengths = geometry.tip_length, geometry.rotor_radius, geometry.clearance
    seen = zip((modes.tip_displacement @ q).tolist(), (modes.tip_slope @ q).tolist(), strict=True)
    least = min(contact_frame(u, th, *lengths)[0] for u, th in seen)
    return float(geometry.clearance - least) if np.isfinite(q).all() else float("nan")
