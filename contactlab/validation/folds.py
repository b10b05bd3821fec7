"""The folds of a cross-validation: which impacts are held out together."""

import numpy as np
from numpy.typing import NDArray


def folds_of(impacts: int, folds: int, seed: int) -> NDArray[np.int64]:
    """Give the number of the fold, from 0, in which each impact is held out, shape (impact,).

    The impacts are shuffled by the seed and dealt out, so that folds differ in size by one at most. The same
    seed gives the same folds.
    """
    fold = np.empty(impacts, dtype=np.int64)
    fold[np.random.default_rng([seed, folds]).permutation(impacts)] = np.arange(impacts) % folds
    return fold
