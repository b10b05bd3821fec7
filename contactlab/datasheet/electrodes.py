"""Charge and current of the electrodes during a run, from the motion of every normal mode.

The modes follow from the start of the run: exactly under the drive, and under the mean contact force of each
record interval.

Source: Andersen, Blanke and Helbo (2001), eqs. 19, 20, 26 and 32.
"""

import numpy as np
from scipy.linalg import expm

from contactlab.arrays import Array
from contactlab.motor import Motor
from contactlab.motor.geometry import contact_frame
from contactlab.trajectory import Trajectory


def modal_motion(run: Trajectory) -> tuple[Array, Array]:
    """Return displacement [m kg^1/2] and velocity [m s^-1 kg^1/2] of every mode at the records of a run.

    Each has the shape (mode, time). A force is spread over its record interval: the error is of second order
    in the interval where the force is smooth. The run must begin at t = 0 of its drive, from the start of its
    motor.
    """
    modes, drive, start = run.motor.modes, run.motor.drive, run.motor.start
    w, k, c = drive.angular_frequency, modes.stiffness[:, None], modes.damping[:, None]
    amplitude = run.motor.force_phasors / (k - w**2 + 1j * c * w)
    turns = np.exp(1j * np.multiply.outer(w, run.time))
    motion = np.stack([(amplitude @ turns).real, (1j * w * amplitude @ turns).real])
    free = np.zeros((k.size, 3, 3))
    free[:, 0, 1], free[:, 1, 0], free[:, 1, 1], free[:, 1, 2] = 1.0, -k[:, 0], -c[:, 0], 1.0
    step = expm(free * run.record_interval)
    flow, push = step[:, :2, :2], step[:, :2, 2]
    at = np.zeros((k.size, 2)) - motion[:, :, 0].T
    if start is not None:
        at += np.column_stack([start.displacement, start.velocity])
    motion[:, :, 0] += at.T
    for i, force in enumerate(_contact_forces(run), start=1):
        at = np.einsum("jab,jb->ja", flow, at) + push * force[:, None]
        motion[:, :, i] += at.T
    return motion[0], motion[1]


def _contact_forces(run: Trajectory) -> Array:
    """Return the mean force on every mode in each record interval [N kg^-1/2], shape (interval, mode)."""
    modes, lengths = run.motor.modes, run.motor.geometry
    read = ("tip_normal_displacement", "rotor_normal_displacement", "tip_slope")
    rise, lift, turn = (0.5 * (run.series[name][1:] + run.series[name][:-1]) for name in read)
    normal, tangential = (run.series[name][1:] for name in ("normal_force", "friction_force"))
    forces = np.zeros((normal.size, modes.stiffness.size))
    for i in np.flatnonzero((normal != 0.0) | (tangential != 0.0)):
        sizes = lengths.tip_length, lengths.rotor_radius, lengths.clearance
        _, n_u, n_th, t_u, t_th = contact_frame(rise[i] - lift[i], turn[i], *sizes)
        forces[i] = modes.approach * (normal[i] * n_u + tangential[i] * t_u)
        forces[i] += modes.tip_slope * (normal[i] * n_th + tangential[i] * t_th)
    return forces if run.motor.preload is None else forces + run.motor.preload


def currents(run: Trajectory) -> Array:
    """Return the currents into the electrodes at the records of a run [A], shape (electrode, time).

    I = dQ/dt of the charge, and the current in phase with the voltage that the dielectric's loss takes, as of
    a capacitance C_p (1 - i tan delta). Not a number where the capacitance is not known, or the drive has a
    waveform.
    """
    modes, drive = run.motor.modes, run.motor.drive
    if drive.waveform is not None:
        return np.full((modes.coupling.shape[1], run.time.size), np.nan)
    w = drive.angular_frequency
    turns = np.exp(1j * np.multiply.outer(w, run.time))
    rate = (1j * w * (1.0 - 1j * modes.loss_tangent) * drive.phasors @ turns).real
    return modes.charge(modal_motion(run)[1], rate)


def dielectric_loss(motor: Motor) -> float:
    """Return the power that heats the patches' dielectric, sum omega C_p tan(delta) U^2 / 2 [W].

    The sum runs over electrodes and frequencies; tones of one frequency are one tone.
    """
    modes, drive = motor.modes, motor.drive
    if modes.loss_tangent == 0.0:
        return 0.0
    if modes.capacitance is None:
        return float("nan")
    frequencies, which = np.unique(drive.frequency, return_inverse=True)
    phasors = np.zeros((len(drive.phasors), frequencies.size), dtype=complex)
    np.add.at(phasors.T, which, drive.phasors.T)
    energy = np.einsum("ek,ef,fk->k", phasors.conj(), modes.capacitance, phasors).real
    return float(np.pi * modes.loss_tangent * frequencies @ energy)
