"""Correction of p-values for several tests of one family."""

import numpy as np
from numpy.typing import ArrayLike

from contactlab.arrays import Array


def holm(p_values: ArrayLike) -> Array:
    """Return p-values adjusted by Holm's step-down procedure, in the order and shape of the input.

        p'_(k) = max over j <= k of min((m - j + 1) p_(j), 1),  p_(1) <= ... <= p_(m)

    Rejecting where p' <= alpha makes the probability of any false rejection at most alpha, however the tests
    depend on each other. NaN is no test: it stays, and does not count in m.

    Source: Holm (1979), Scand. J. Stat. 6, 65.

    Raises:
        ValueError: a p-value is outside 0 to 1.

    >>> holm([0.01, 0.04, 0.03]).round(3).tolist()
    [0.03, 0.06, 0.06]
    """
    result = np.array(p_values, dtype=np.float64)
    if np.any((result < 0.0) | (result > 1.0)):
        raise ValueError(f"p_values are {np.nanmin(result):g} to {np.nanmax(result):g}; must be in 0 to 1.")
    flat = result.reshape(-1)
    tested = np.flatnonzero(~np.isnan(flat))
    order = tested[np.argsort(flat[tested], kind="stable")]
    scaled = flat[order] * np.arange(order.size, 0, -1)
    flat[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return result
