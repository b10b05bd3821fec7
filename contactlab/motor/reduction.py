"""Normal modes of a structure by its mass and stiffness matrices, as a finite-element program writes them.

The lowest modes Phi of K phi = omega^2 M phi are kept. What the others yield to a load b at rest, K^-1 b less
Phi diag(1/omega^2) Phi' b, follows as pseudo-modes, so that statics are exact.

Sources: MacNeal (1971), Comput. Struct. 1, 581; Rubin (1975), AIAA J. 13, 995.
"""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import scipy

from contactlab.arrays import Array
from contactlab.checks import check_shape, checked_arguments
from contactlab.motor.bodies import FLAT
from contactlab.motor.motor import NormalModes

DEPENDENT: Final = 1e-8
"""Energy of a static response over the largest one below which the kept modes and the others contain it."""


@checked_arguments(damping_ratio="1", tip_length="m")
def reduced(
    mass: Any,
    stiffness: Any,
    uy: Array,
    ux: Array,
    coupling: Array,
    *,
    modes: int = 6,
    damping_ratio: float = 0.01,
    tip_length: float = FLAT,
    static_correction: bool = True,
    points: Mapping[str, Array] | None = None,
) -> NormalModes:
    """Return the normal modes of a held structure.

        >>> import contactlab as cl
        >>> import numpy as np
        >>> chain = 2.0 * np.eye(5) - np.eye(5, k=1) - np.eye(5, k=-1)
        >>> end, voltage = np.eye(5)[4], np.eye(5)[:, :1]
        >>> made = cl.reduced(np.eye(5), 1e8 * chain, end, 0.5 * end, voltage, modes=2)
        >>> f"{made.tip_displacement**2 @ (1.0 / made.stiffness):.4e} m/N"  # 5/6 of a spring
        '8.3333e-09 m/N'

    Args:
        mass, stiffness: M [kg] and K [N/m], symmetric, K positive definite, shape (dof, dof), dense or sparse
            (`scipy.io.mmread` reads Matrix Market).
        uy, ux: displacement of the contact point towards the rotor and along its surface by each degree of
            freedom [1], shape (dof,).
        coupling: force on each degree of freedom per voltage [N/V], shape (dof, electrode).
        modes: number of modes that are kept.
        damping_ratio: of every mode [1].
        tip_length: of the contact's geometry [m]; the default is a flat contact.
        static_correction: whether pseudo-modes follow, one at most for each of these loads.
        points: displacement of other points by each degree of freedom [1], shape (dof,), by name, to record.

    Raises:
        ValueError: shapes do not fit, or K is not positive definite.
    """
    shape = np.shape(stiffness)
    if len(shape) != 2 or shape[0] != shape[1] or np.shape(mass) != shape:
        raise ValueError(f"mass has shape {np.shape(mass)} and stiffness {shape}; both must be square alike.")
    count = shape[0]
    check_shape("uy", uy, (count,), "one number a degree of freedom")
    check_shape("ux", ux, (count,), "one number a degree of freedom")
    check_shape("coupling", coupling, (count, -1), "a row a degree of freedom and a column an electrode")
    for name, row in (points or {}).items():
        check_shape(f"points[{name!r}]", row, (count,), "one number a degree of freedom")
    if not 1 <= modes < count:
        raise ValueError(f"modes is {modes}; it must be at least 1 and less than {count}, the size.")
    if not 0.0 <= damping_ratio < 1.0:
        raise ValueError(
            f"damping_ratio is {damping_ratio}; it must be at least 0 and below 1, which is critical. 3 % is "
            "0.03."
        )
    m, k = scipy.sparse.csc_array(mass), scipy.sparse.csc_array(stiffness)
    loads = np.column_stack([uy, ux, coupling])
    try:
        squares, shapes = scipy.sparse.linalg.eigsh(k, modes, m, sigma=0.0, v0=np.ones(count))
        static = scipy.sparse.linalg.splu(k).solve(loads)
    except (RuntimeError, scipy.sparse.linalg.ArpackError) as error:
        raise ValueError("stiffness is singular; it must be positive definite.") from error
    if not squares.min() > 0.0:
        raise ValueError(f"stiffness has the eigenvalue {squares.min():g} 1/s^2; all must be positive.")
    shapes /= np.sqrt(np.sum(shapes * (m @ shapes), axis=0))
    if static_correction:
        rest = static - shapes @ ((shapes.T @ loads) / squares[:, None])
        energy, directions = np.linalg.eigh(rest.T @ (k @ rest))
        scale = np.sum(static * loads, axis=0).max()
        rest = rest @ directions[:, energy > DEPENDENT * scale]
        others, vectors = scipy.linalg.eigh(rest.T @ (k @ rest), rest.T @ (m @ rest))
        squares, shapes = np.append(squares, others), np.hstack([shapes, rest @ vectors])
    # A mode's sign is free: it moves towards the rotor, or along its surface.
    shapes *= np.where((shapes.T @ (uy + ux)) < 0.0, -1.0, 1.0)
    return NormalModes(
        stiffness=squares,
        damping=2.0 * damping_ratio * np.sqrt(squares),
        coupling=shapes.T @ coupling,
        tip_displacement=shapes.T @ uy,
        tip_slope=-(shapes.T @ ux) / tip_length,
        points={name: shapes.T @ row for name, row in (points or {}).items()},
    )
