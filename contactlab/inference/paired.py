"""Paired comparison of laws: the outcome of a pair over motors that are drawn alike for all laws.

In every motor drawn a quantity of the first law is greater than that of the second by more than a margin, or
less, or both are practically equal, or there is no such number: a motor without a steady state is an outcome
too. An order is stated of a population where the test of "in at most `AGREED` of *all* its motors" is
rejected (exact binomial test, corrected for all claims); intervals of probabilities are those of Clopper and
Pearson (1934, Biometrika 26, 404).
"""

from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contactlab.arrays import Array
from contactlab.inference.bootstrap import LEVEL
from contactlab.inference.multiple import holm

AGREED: Final = 0.8
"""Share of the motors that must have one outcome before it is stated of a population. By three looks a single
pair and quantity needs 22 draws of one outcome, five quantities 29, and 66 pairs of them 48."""

FIRST_LOOK: Final = 16
"""Draws after which orders are tested for the first time; every further look has twice as many."""

OUTCOMES: Final = ("greater", "less", "equal", "none")
"""Outcomes of a pair in a motor: the first is greater or less by more than the margin, both are equal within
it, or one has no steady state, or too large an error to say so."""

VERDICTS: Final = (*OUTCOMES, "varies", "inconclusive")
"""What is stated of a pair in a population: its outcome, that none is that of most motors, or nothing."""
GREATER, LESS, EQUAL, NONE, VARIES, INCONCLUSIVE = range(len(VERDICTS))

UNTESTED: Final = -1
"""Outcome of a pair in a motor that counts as no draw, as of a quantity that no law has."""

BINS: Final = 4
"""Parts of equal numbers of draws into which the range of a factor is divided."""

PERMUTATIONS: Final = 500
"""Permutations of the draws whose shares are those by chance."""


@final
class Orders(NamedTuple):
    """Orders of pairs of laws.

    Args:
        share: of all draws, by outcome, shape (..., 4).
        low, high: 95 % interval of the probability of each, the same shape.
        p_value: of "no outcome in more than `AGREED` of the motors", corrected, shape (...).
        verdict: place in `VERDICTS`, shape (...).
    """

    share: Array
    low: Array
    high: Array
    p_value: Array
    verdict: Array


def looks_up_to(most: int) -> list[int]:
    """Return the numbers of draws at which orders are tested: 16, 32, 64 up to the most."""
    looks = [FIRST_LOOK]
    while 2 * looks[-1] <= most:
        looks.append(2 * looks[-1])
    return looks if most > FIRST_LOOK else [most]


def binomial_interval(times: ArrayLike, count: ArrayLike) -> tuple[Array, Array]:
    """Return the 95 % interval of a probability, of an event that came some times in a count."""
    # Imported here: a run needs no scipy.stats.
    from scipy.stats import beta

    times, count = np.asarray(times), np.asarray(count)
    tail = 0.5 * (1.0 - LEVEL)
    low = np.where(times > 0, beta.ppf(tail, np.maximum(times, 1), count - times + 1), 0.0)
    high = np.where(times < count, beta.ppf(1.0 - tail, times + 1, np.maximum(count - times, 1)), 1.0)
    return low, high


def orders(outcomes: Array, looks: int = 1) -> Orders:
    """Return the orders of pairs of laws.

    All that is claimed is one family: of every pair, operating point and quantity, that most motors have one
    outcome, and that they have not. The probability of any false claim is at most 5 % by Holm's correction,
    of which every one of several looks at growing draws has an equal part.

    Args:
        outcomes: place in `OUTCOMES` of a pair in a draw, or `UNTESTED`; shape (..., draw).
        looks: number of looks that are planned.
    """
    # Imported here, as above.
    from scipy.stats import binom

    count = (outcomes != UNTESTED).sum(axis=-1)
    times = np.stack([(outcomes == each).sum(axis=-1) for each in range(len(OUTCOMES))], axis=-1)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = times / count[..., None]
    most, trials = times.max(axis=-1), np.where(count > 0, count, np.nan)
    p_values = holm([binom.sf(most - 1, trials, AGREED), binom.cdf(most, trials, AGREED)])
    stated, denied = p_values <= (1.0 - LEVEL) / looks
    verdict = np.where(stated, times.argmax(axis=-1), np.where(denied, VARIES, INCONCLUSIVE))
    return Orders(share, *binomial_interval(times, count[..., None]), p_values[0], verdict)


def bins_of(values: Array) -> Array:
    """Return the number of the bin of each draw, by the rank of its value, shape (draw,)."""
    return np.asarray(np.argsort(np.argsort(values, kind="stable")) * min(BINS, values.size) // values.size)


def factor_shares(outcomes: Array, draws: Array) -> tuple[Array, Array]:
    """Return the share of each factor in the outcome, and the largest share by chance.

        S_i = sum_k Var(P(outcome k | factor i)) / sum_k Var(outcome k)

    the first-order Sobol index of the outcome (of several outputs: Gamboa et al. 2014, Electron. J. Stat. 8,
    575), over `BINS` of the factor, less the variance that as many bins have by chance (epsilon squared,
    Kelley 1935, Proc. Natl. Acad. Sci. 21, 554). The largest share by chance is the one that no factor
    exceeds in 95 % of the permutations of the draws.

    Args:
        outcomes: place in `OUTCOMES`, shape (..., draw).
        draws: shape (draw, factor).

    Returns:
        Shapes (..., factor) and (...); NaN where all outcomes are the same, and of fewer than eight draws.
    """
    count, factors = draws.shape
    if count < 2 * BINS or not factors:
        nothing = np.full((*outcomes.shape[:-1], factors), np.nan)
        return nothing, nothing.max(axis=-1, initial=-np.inf) * np.nan
    members = np.stack([bins_of(column) == n for column in draws.T for n in range(BINS)]).astype(float)
    members /= np.sqrt(members.sum(axis=1, keepdims=True))
    events = outcomes.reshape(-1, 1, count) == np.arange(len(OUTCOMES))[:, None]
    centred = events - events.mean(axis=-1, keepdims=True)
    total = (centred**2).sum(axis=(1, 2))[:, None]

    def shares(order: NDArray[np.int_]) -> Array:
        each = (centred[..., order] @ members.T) ** 2
        between = each.sum(axis=1).reshape(-1, factors, BINS).sum(axis=-1)
        noise = (total - between) / (count - BINS)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray((between - (BINS - 1) * noise) / total)

    rng = np.random.default_rng(0)
    chance = [shares(rng.permutation(count)).max(axis=-1) for _ in range(PERMUTATIONS)]
    bound = np.quantile(chance, LEVEL, axis=0)
    own = shares(np.arange(count))
    return own.reshape(*outcomes.shape[:-1], factors), bound.reshape(outcomes.shape[:-1])
