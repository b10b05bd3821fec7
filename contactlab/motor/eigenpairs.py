"""Eigenvalues of symmetric matrices, refused where double precision does not resolve them."""

from typing import Any

import numpy as np
from scipy.linalg import eigh

from contactlab.arrays import Array

RESOLVED = 1e-9
"""Smallest eigenvalue over the largest that is still known.

The eigenvalues of a symmetric matrix are found to within a few units of round-off of the largest one
(8 at most in what was measured), so that omega^2 is right to 2e-6 here, and omega to 1e-6."""

UNRESOLVED = (
    "Dimensions, materials, placement and tip together give modes that double precision does not "
    "resolve: mass and stiffness must be finite and positive definite, and the highest natural "
    f"frequency at most {RESOLVED**-0.5:.0f} times the lowest. Check the orders of magnitude, or take "
    "fewer modes."
)


def resolved_eigenpairs(a: Array, b: Array | None = None, **options: Any) -> tuple[Array, Array]:
    """Solve a x = lambda b x for symmetric matrices, eigenvalues ascending, or refuse it by UNRESOLVED."""
    if not all(np.isfinite(matrix).all() for matrix in (a, b) if matrix is not None):
        raise ValueError(UNRESOLVED)
    eigenvalues, vectors = eigh(a, b, **options)
    # Not the other way round: nothing is larger than what is no number.
    if not eigenvalues[0] > RESOLVED * eigenvalues[-1]:
        raise ValueError(UNRESOLVED)
    return eigenvalues, vectors
