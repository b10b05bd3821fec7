"""Residual modes that make the mass of a rigid impact independent of the number of kept modes.

The kept modes Phi = (u, theta) of a structure with a rigid tip of mass matrix M leave out, at the tip,

    R = G - Phi diag(1/k) Phi'      flexibility: G is the static one of the whole structure,
    Y = M^-1 - Phi Phi'             inverse mass: an impulse meets the tip alone, at first.

Both are sums over the modes left out, of phi phi' / k and of phi phi', and positive definite. Two residual
modes w with the frequencies omega^2 have the same sums,

    sum_i w_i w_i' = Y,   sum_i w_i w_i' / omega_i^2 = R   <=>   R c = Y c / omega^2,   w = Y c,   c' Y c = 1,

so that, with any number of kept modes and these as they are, D is M^-1 without the rotor, and tip loads and
voltages bend the structure as they bend the whole. It is the Gauss quadrature with one node of the spectrum
left out: what it errs by is omega^2 (sum phi phi' / k^2 - R Y^-1 R) and higher powers of omega^2.

Static correction with the responses to tip loads (Rubin 1975) has R and the next sum in place of Y: it is the
better one at low frequencies, and its impacts meet less of what is left out. Without M, Y is infinite and the
interface massless: see Monjaraz-Tec, Gross and Krack (2022), Comput. Struct. 260, 106698.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import check_shape, checked_arguments
from contactlab.motor.motor import NormalModes


@checked_arguments()
def add_residual_modes(
    modes: NormalModes,
    mass: Array,
    flexibility: Array,
    *,
    voltage_response: Array | None = None,
    damping: Callable[[Array], Array] | None = None,
) -> NormalModes:
    """Return the modes and two residual modes behind them, with which a rigid impact meets the tip's mass.

    What they move other points by is not known, and taken as zero.

    Args:
        modes: kept modes of the structure with its tip.
        mass: M of the rigid tip in (u, theta), [kg, kg m; kg m, kg m^2], shape (2, 2).
        flexibility: R, by which a force and a moment at the tip bend the modes left out, [m/N, 1/N; 1/N,
            1/(N m)], shape (2, 2).
        voltage_response: u and theta of the modes left out under a constant volt [m/V; 1/V], shape
            (2, electrode); None is zero.
        damping: c_j [1/s] of modes with these omega_j^2 [1/s^2]; None is the damping ratio of the stiffest
            kept mode.

    Raises:
        ValueError: if R or Y is not symmetric and positive definite; the latter where the kept modes alone
            move more easily than a body of this mass.

    Example:
        >>> import contactlab as cl
        >>> beam = cl.RitzResonator()
        >>> tip = np.diag([beam.tip_mass, beam.tip_inertia])
        >>> modes = cl.add_residual_modes(beam.modes, tip, np.diag([1e-7, 0.01]))
        >>> for each in beam.modes, modes:
        ...     print(each.stiffness.size, f"{1.0 / (each.tip_displacement**2).sum():.6f} kg")
        4 0.002877 kg
        6 0.001181 kg
    """
    for name, matrix in {"mass": mass, "flexibility": flexibility}.items():
        check_shape(name, matrix, (2, 2), "displacement and slope by force and moment")
        _check_definite(name, matrix)
    electrodes = modes.coupling.shape[1]
    response = np.zeros((2, electrodes)) if voltage_response is None else voltage_response
    check_shape("voltage_response", response, (2, electrodes), "a column an electrode")
    kept = np.stack([modes.tip_displacement, modes.tip_slope])
    mobility = np.linalg.inv(mass) - kept @ kept.T
    _check_definite("the inverse mass that the kept modes leave out", mobility)
    root = np.linalg.cholesky(mobility)
    half = np.linalg.solve(root, flexibility)
    inverse, vectors = np.linalg.eigh(np.linalg.solve(root, half.T))
    shapes, squares = root @ vectors[:, ::-1], 1.0 / inverse[::-1]
    # A mode's sign is free.
    shapes *= np.where(shapes[0] + shapes[1] < 0.0, -1.0, 1.0)
    if damping is None:
        stiffest = modes.stiffness.argmax()
        rates = modes.damping[stiffest] * np.sqrt(squares / modes.stiffness[stiffest])
    else:
        rates = damping(squares)
    return replace(
        modes,
        stiffness=np.append(modes.stiffness, squares),
        damping=np.append(modes.damping, rates),
        coupling=np.vstack([modes.coupling, squares[:, None] * np.linalg.solve(shapes, response)]),
        tip_displacement=np.append(modes.tip_displacement, shapes[0]),
        tip_slope=np.append(modes.tip_slope, shapes[1]),
        points={name: np.append(row, np.zeros(2)) for name, row in modes.points.items()},
    )


def _check_definite(name: str, matrix: Array) -> None:
    scale = np.sqrt(np.abs(matrix[0, 0] * matrix[1, 1]))
    symmetric = abs(matrix[0, 1] - matrix[1, 0]) <= 1e-9 * scale
    if not (symmetric and matrix[0, 0] > 0.0 and np.linalg.det(matrix) > 0.0):
        raise ValueError(f"{name} is {matrix.tolist()}; it must be symmetric and positive definite.")
