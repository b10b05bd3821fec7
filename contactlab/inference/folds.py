"""The folds of a cross-validation: which impacts are held out together."""

import numpy as np
from numpy.typing import NDArray


def folds_of(measurement: NDArray[np.int64], folds: int, seed: int) -> NDArray[np.int64]:
    """Return the number of the fold, from 0, in which each impact is held out, shape (impact,).

    The measurements are shuffled by the seed, and each goes to the fold with the fewest impacts so far: its
    impacts stay together. Folds differ in size by one at most where each impact is a measurement of its own.
    The same seed gives the same folds.

    Args:
        measurement: number of the measurement that each impact belongs to, from 0 without gaps.
        folds: number of folds.
        seed: of the shuffle.
    """
    sizes = np.bincount(measurement)
    filled, fold = np.zeros(folds, dtype=np.int64), np.empty(sizes.size, dtype=np.int64)
    for place in np.random.default_rng([seed, folds]).permutation(sizes.size):
        fold[place] = np.argmin(filled)
        filled[fold[place]] += sizes[place]
    return fold[measurement]
