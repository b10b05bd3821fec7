"""The motor as the engine sees it: unit-mass oscillators, tones and three contact rows.

Every coordinate is a scalar oscillator

    qdd_j + c_j qd_j + k_j q_j = a_j + Re sum_k force_jk exp(i omega_k t)
                                 + row_u[j] f_u + row_th[j] f_th + row_r[j] F.

The rotor is the last one, q = sqrt(J) alpha with k = 0, c = C_r / J, a = -tau / sqrt(J) and
row_r = -R / sqrt(J): one more row in the tangential direction, which puts R^2 / J into the Delassus
matrix, and a huge inertia turns it into a belt. Reading the rows gives u, th and -R Omega (from
the rates); the contact force acts through the same rows.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.compiled import kernel
from contactlab.motor.motor import Motor

RESONANCE_MARGIN = 1e-9
"""Smallest |k - omega^2 + i c omega| / (k + omega^2) of a drivable mode: below, the steady state is lost."""

NEARLY_RESONANT = 1e-2
"""The same number below which a steady state is not split off: it would be fifty times and more what moves
a mode that rests, and its round-off that of the gap."""


class Plant(NamedTuple):
    """Constant arrays of a motor; j runs over coordinates, k over tones.

    Args:
        stiffness, damping: k_j [1/s^2], c_j [1/s].
        constant: constant force a_j.
        row_u, row_th, row_r: contact rows.
        omega: tones [rad/s].
        force_re, force_im: force phasors, shape (coordinate, tone). Real and imaginary parts stand
            apart because complex products are slow in compiled loops this short.
        steady_re, steady_im: steady-state displacement phasors, shape (coordinate, tone); zero where
            mode and tone are nearly resonant.
        steady_u, steady_th: their amplitudes seen at the tip, shape (tone,) [m], [rad].
        near: coordinate and tone of every nearly resonant pair, shape (pair, 2).
        tip_length, radius, clearance: contact geometry [m].
    """

    stiffness: Array
    damping: Array
    constant: Array
    row_u: Array
    row_th: Array
    row_r: Array
    omega: Array
    force_re: Array
    force_im: Array
    steady_re: Array
    steady_im: Array
    steady_u: Array
    steady_th: Array
    near: NDArray[np.int64]
    tip_length: float
    radius: float
    clearance: float


def plant_of(motor: Motor) -> Plant:
    """Assemble the plant of a motor.

    Raises:
        ValueError: a tone meets an undamped mode, whose response would grow without bound.
    """
    modes, rotor, geometry = motor.modes, motor.rotor, motor.geometry
    root = sqrt(rotor.inertia)
    stiffness = np.append(modes.stiffness, 0.0)
    damping = np.append(modes.damping, rotor.damping / rotor.inertia)
    omega = motor.drive.angular_frequency
    force = np.vstack([modes.coupling @ motor.drive.phasors, np.zeros((1, omega.size))])
    dynamic = stiffness[:, None] - omega**2 + 1j * damping[:, None] * omega
    margin = np.abs(dynamic[:-1]) / (stiffness[:-1, None] + omega**2)
    if margin.size and margin.min() < RESONANCE_MARGIN:
        mode, tone = np.unravel_index(margin.argmin(), margin.shape)
        raise ValueError(
            f"The tone at {motor.drive.frequency[tone]} Hz meets mode {mode + 1} at "
            f"{modes.natural_frequency[mode]} Hz, which has no damping: its response grows without "
            "bound. Give the resonator damping or move the tone."
        )
    near = np.argwhere(margin < NEARLY_RESONANT)
    steady = force / dynamic
    steady[near[:, 0], near[:, 1]] = 0.0
    preload = np.zeros(modes.stiffness.size) if motor.preload is None else motor.preload
    row_u = np.append(modes.tip_displacement, 0.0)
    row_th = np.append(modes.tip_slope, 0.0)
    return Plant(
        stiffness=stiffness,
        damping=damping,
        constant=np.append(preload, -rotor.load_torque / root),
        row_u=row_u,
        row_th=row_th,
        row_r=np.append(np.zeros(modes.stiffness.size), -geometry.rotor_radius / root),
        omega=omega,
        force_re=force.real.copy(),
        force_im=force.imag.copy(),
        steady_re=steady.real.copy(),
        steady_im=steady.imag.copy(),
        steady_u=np.abs(row_u @ steady),
        steady_th=np.abs(row_th @ steady),
        near=np.ascontiguousarray(near, dtype=np.int64),
        tip_length=geometry.tip_length,
        radius=geometry.rotor_radius,
        clearance=geometry.clearance,
    )


def resolved_rate(plant: Plant) -> float:
    """Fastest rate that persists [rad/s] of tones and modes; zero where nothing vibrates."""
    rates = persisting_rates(plant.stiffness[:-1], plant.damping[:-1])
    return float(max(rates.max(initial=0.0), plant.omega.max(initial=0.0)))


def persisting_rates(stiffness: Array, damping: Array) -> Array:
    """Rate of each mode [rad/s] from k_j and c_j, an overdamped one by its slow root k/c."""
    slow = np.full_like(stiffness, np.inf)
    np.divide(stiffness, damping, out=slow, where=damping > 0.0)
    return np.asarray(np.minimum(np.sqrt(stiffness), slow), dtype=np.float64)


def motion_rate(plant: Plant) -> float:
    """Rate [rad/s] of what makes the contacts: the fastest tone that drives, or the slowest mode if faster.

    A tone without amplitude moves nothing. Zero where nothing vibrates.
    """
    loud = np.any((plant.force_re != 0.0) | (plant.force_im != 0.0), axis=0)
    rates = np.sqrt(plant.stiffness[plant.stiffness > 0.0])
    slowest = float(rates.min(initial=np.inf))
    return max(float(plant.omega[loud].max(initial=0.0)), slowest if rates.size else 0.0)


def fastest_rate(plant: Plant) -> float:
    """Fastest rate of any transient [1/s]."""
    return float((plant.damping + np.sqrt(plant.stiffness)).max())


@kernel
def delassus(
    plant: Plant, n_u: float, n_th: float, t_u: float, t_th: float
) -> tuple[float, float, float]:
    """D_nn, D_nt, D_tt [1/kg] of D = G M^-1 G', rotor included, for the directions of `contact_frame`."""
    nn = 0.0
    nt = 0.0
    tt = 0.0
    for j in range(plant.stiffness.size):
        normal = n_u * plant.row_u[j] + n_th * plant.row_th[j]
        tangential = t_u * plant.row_u[j] + t_th * plant.row_th[j] + plant.row_r[j]
        nn += normal * normal
        nt += normal * tangential
        tt += tangential * tangential
    return nn, nt, tt
