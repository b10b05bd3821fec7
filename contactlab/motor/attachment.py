"""A rigid body attached to the truncated modes of a structure through their residual flexibility.

Modes that carry the tip share its mass among themselves: the mass that a rigid impact meets,
1 / sum_j u_j^2, then depends on their number and falls to the tip's only in the limit. Here the tip is a
substructure of its own. The structure without it is reduced as by MacNeal (1971): n modes q with the
frequencies k_j and the motion x = (u, theta) of its contact Phi q, and the residual flexibility R of all
others, which have no mass. To their interface the tip adds its mass matrix M:

    T = qd'qd / 2 + xd' M xd / 2,
    V = q' diag(k) q / 2 + (x - Phi q - S U)' R^-1 (x - Phi q - S U) / 2 - U' Gamma' q,

with the voltages U and the static response S of the interface to them by the modes left out. Whatever n is,

* an impulse at the tip meets M alone, D = M^-1 without the rotor;
* tip loads bend the structure by Phi diag(1/k) Phi' + R, its whole static flexibility, and constant voltages
  move the tip as they move the structure;
* natural frequencies err by omega^2 sum phi_j^2 / k_j^2 over the modes left out, of which truncation has
  the sum of phi_j^2 / k_j: by n^-7 and n^-5 (deflection, slope) of a beam in place of n^-3 and n^-1.

Without M this is the massless boundary of Monjaraz-Tec, Gross and Krack (2022), Comput. Struct. 260, 106698.
"""

from collections.abc import Callable

import numpy as np
from scipy.linalg import block_diag

from contactlab.arrays import Array
from contactlab.checks import check_shape
from contactlab.motor.eigenpairs import resolved_eigenpairs
from contactlab.motor.motor import NormalModes


def attach_tip(
    modes: NormalModes,
    mass: Array,
    flexibility: Array,
    *,
    voltage_response: Array | None = None,
    damping: Callable[[Array], Array] | None = None,
) -> NormalModes:
    """Return the normal modes of a structure with a rigid tip, two more than those of the structure.

    Args:
        modes: the structure without the tip; its tip displacement and slope are those of the interface.
        mass: M of the tip about the interface in (u, theta), [kg, kg m; kg m, kg m^2], shape (2, 2).
        flexibility: R, by which a force and a moment on the interface bend the modes left out,
            [m/N, 1/N; 1/N, 1/(N m)], shape (2, 2).
        voltage_response: S, u and theta of the modes left out under a constant volt [m/V; 1/V], shape
            (2, electrode); None is zero.
        damping: c_j [1/s] of modes with these omega_j^2 [1/s^2]. None is the damping of the structure's
            modes, and in R that of its stiffest mode in proportion to stiffness; what couples the assembled
            modes is neglected.

    Raises:
        ValueError: if M or R is not symmetric and positive definite, or a mode not resolved.

    Example:
        >>> import contactlab as cl
        >>> beam = cl.RitzResonator(tip_mass=0.0, tip_inertia=0.0).modes
        >>> tip = cl.attach_tip(beam, np.diag([1e-3, 1e-7]), np.diag([1e-7, 0.1]))
        >>> tip.stiffness.size, f"{1.0 / (tip.tip_displacement**2).sum():.6f} kg"
        (6, '0.001000 kg')
    """
    for name, matrix in {"mass": mass, "flexibility": flexibility}.items():
        check_shape(name, matrix, (2, 2), "displacement and slope by force and moment")
        even = np.allclose(matrix, matrix.T, rtol=1e-9, atol=0.0)
        if not (even and matrix[0, 0] > 0.0 and np.linalg.det(matrix) > 0.0):
            raise ValueError(f"{name} is {matrix.tolist()}; it must be symmetric and positive definite.")
    count = modes.stiffness.size
    response = np.zeros((2, modes.coupling.shape[1])) if voltage_response is None else voltage_response
    check_shape("voltage_response", response, (2, modes.coupling.shape[1]), "a column an electrode")
    # Elongation of the residual spring, x - Phi q.
    spring = np.hstack([-np.stack([modes.tip_displacement, modes.tip_slope]), np.eye(2)])
    residual = spring.T @ np.linalg.solve(flexibility, spring)
    masses = block_diag(np.eye(count), mass)
    squares, vectors = resolved_eigenpairs(
        block_diag(np.diag(modes.stiffness), np.zeros((2, 2))) + residual, masses
    )
    # A mode's sign is free: the coordinate with most of its kinetic energy is positive.
    largest = (vectors * (masses @ vectors)).argmax(axis=0)
    vectors = vectors * np.sign(vectors[largest, np.arange(count + 2)])
    if damping is None:
        stiffest = modes.stiffness.argmax()
        delay = modes.damping[stiffest] / modes.stiffness[stiffest]
        matrix = block_diag(np.diag(modes.damping), np.zeros((2, 2))) + delay * residual
        dampings = np.sum(vectors * (matrix @ vectors), axis=0)
    else:
        dampings = damping(squares)
    held = spring.T @ np.linalg.solve(flexibility, response)
    return NormalModes(
        stiffness=squares,
        damping=dampings,
        coupling=vectors.T @ (np.vstack([modes.coupling, np.zeros_like(response)]) + held),
        tip_displacement=vectors[count].copy(),
        tip_slope=vectors[count + 1].copy(),
        shape_coupling=modes.shape_coupling,
        capacitance=modes.capacitance,
        loss_tangent=modes.loss_tangent,
    )
