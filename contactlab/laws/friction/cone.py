"""Coulomb's cone: the largest friction that a normal force can give."""

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel

Array = NDArray[np.float64]


@kernel
def cone_bound(normal: float, slip: float, parameters: Array, at: int) -> float:
    """Largest friction [N]: mu_s N in stick, where the slip is exactly zero, and mu N in slip.

    Args:
        normal: N [N]; a pull gives no friction.
        slip: [m/s].
        parameters, at: mu and mu_s / mu stand first.
    """
    ratio = parameters[at + 1] if slip == 0.0 else 1.0
    return float(parameters[at] * ratio * max(normal, 0.0))
