"""The folds of a cross-validation: which impacts are held out together."""

import numpy as np
from numpy.typing import NDArray


def folds_of(same: NDArray[np.int64], folds: int, seed: int) -> NDArray[np.int64]:
    """Give the number of the fold, from 0, in which each impact is held out, shape (impact,).

    Groups of equal impacts are shuffled by the seed and dealt out, so that folds differ by one group at most.
    The same seed gives the same folds.

    Args:
        same: group of each impact, from 0, shape (impact,); see `MeasuredImpacts.groups`.
        folds: how many.
        seed: of the shuffle.
    """
    groups = int(same.max(initial=-1)) + 1
    fold = np.empty(groups, dtype=np.int64)
    fold[np.random.default_rng([seed, folds]).permutation(groups)] = np.arange(groups) % folds
    return np.asarray(fold[same])
