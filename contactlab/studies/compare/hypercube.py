"""The draws: points of Latin hypercubes, sliced by the sense of the rotor at the start.

One draw of parameters and start serves every law: common random numbers. The draws up to each look are one
or several Latin hypercubes.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.studies.compare.factors import START, START_KEY, Factor
from contactlab.studies.compare.paired import looks_up_to

SEED: Final = 0
"""Seed of the draws by default."""


def drawn(factors: Sequence[Factor], count: int, seed: int = SEED) -> Array:
    """Return the draws, shape (draw, factor); those up to a look are the first ones of any greater number.

    Each block between two looks is a Latin hypercube, sliced by the sense of the rotor at the start (Qian
    2012, J. Am. Stat. Assoc. 107, 393): the halves that start backwards and forwards are Latin hypercubes
    themselves, so that every other factor has as many starts of either sense in each part of its range. The
    places are independent otherwise. Points of a sequence of low discrepancy are not: of a Sobol' sequence
    some quarters of one factor are halves of another.

    Args:
        factors: what is drawn.
        count: of the draws.
        seed: of the places.
    """
    starts = [factor.name == START or START_KEY in factor.keys for factor in factors]
    looks = [0, *looks_up_to(count)]
    blocks = [_hypercube(until - since, np.array(starts), [seed, since]) for since, until in pairwise(looks)]
    uniform = np.concatenate(blocks)
    every = [factor.at(uniform[:, n]) for n, factor in enumerate(factors)]
    return np.reshape(every, (len(factors), count)).T


def _hypercube(count: int, starts: NDArray[np.bool_], seed: Sequence[int]) -> Array:
    """Return points of a Latin hypercube in two slices in turn, shape (draw, factor), from 0 to 1.

    Args:
        count: of the points; of an odd number the last one is anywhere.
        starts: whether a factor is the start, whose halves are the slices.
        seed: of the places.
    """
    rng, half = np.random.default_rng(seed), -(-count // 2)
    shape = (half, 2, starts.size)
    cells = rng.permuted(np.broadcast_to(np.arange(half)[:, None, None], shape), axis=0)
    # Each of `half` parts of a range has a point of either slice, one in its lower and one in its upper half.
    upper = rng.integers(2, size=(half, starts.size))
    upper = np.take_along_axis(np.stack([upper, 1 - upper], axis=1), cells, axis=0)
    slices = np.arange(2)[:, None]
    places = np.where(starts, cells + half * slices, 2 * cells + upper) + rng.random(shape)
    return np.asarray(places.reshape(2 * half, starts.size)[:count] / (2 * half))
