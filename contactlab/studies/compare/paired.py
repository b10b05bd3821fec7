"""Paired comparison of laws: the outcome of a pair over motors that are drawn alike for all laws.

In every motor drawn a quantity of the first law is greater than that of the second by more than a margin, or
less, or both are practically equal, or there is no such number: a motor without a steady state is an outcome
too. An order is stated of a population where the test of "in at most `AGREED` of *all* its motors" is
rejected (exact binomial test, corrected for all claims); intervals of probabilities are those of Clopper and
Pearson (1934, Biometrika 26, 404).
"""

from collections.abc import Iterator
from itertools import combinations
from math import ceil, log, prod
from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contactlab.arrays import Array
from contactlab.studies.compare.bootstrap import LEVEL
from contactlab.studies.compare.multiple import holm

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

PERMUTATIONS: Final = 800
"""Permutations of the draws whose shares are those by chance."""

RESAMPLES: Final = 400
"""Resamples of the draws, in which the largest share is that of the same factor or not."""

EXCEEDED: Final = 0.25 * (1.0 - LEVEL)
"""Probability that chance exceeds a bound: a quarter of 5 % for first-order shares, one for joint
ones. The rest is for looks at growing draws."""

BATCH: Final = 2_000_000
"""Numbers that are permuted or resampled at once."""

ROUND_OFF: Final = 1e-9
"""Difference below which shares are equal."""

ROLES: Final = ("none", "alone", "among", "together")
"""What a factor is to an outcome: nothing that is seen; its share exceeds chance and is the largest one; its
share exceeds chance, and which one is the largest is not known; it exceeds chance together with others."""
NO_ROLE, ALONE, AMONG, TOGETHER = range(len(ROLES))


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


def least_draws(claims: int, looks: int) -> int:
    """Return the number of draws of one outcome that shows an order, of so many claims by so many looks."""
    return ceil(log((1.0 - LEVEL) / looks / claims) / log(AGREED))


def power(samples: int, claims: int, share: float) -> float:
    """Return the probability that an outcome of a share of all motors is stated by one of the looks.

    Args:
        samples: draws at most.
        claims: all that are tested, of which no other is stated.
        share: of the motors that have the outcome, from 0 to 1.
    """
    # Imported here, as above.
    from scipy.stats import binom

    looks, open_yet, drawn, stated = looks_up_to(samples), np.ones(1), 0, 0.0
    for look in looks:
        more = binom.pmf(np.arange(look - drawn + 1), look - drawn, share)
        open_yet, drawn = np.convolve(open_yet, more), look
        shown = claims * binom.sf(np.arange(look + 1) - 1, look, AGREED) <= (1.0 - LEVEL) / len(looks)
        stated += float(open_yet[shown].sum())
        open_yet[shown] = 0.0
    return stated


def bins_of(values: Array, bins: int = BINS) -> Array:
    """Return the number of the bin of each draw, by the rank of its value, shape (draw,)."""
    return np.asarray(np.argsort(np.argsort(values, kind="stable")) * min(bins, values.size) // values.size)


@final
class Shares(NamedTuple):
    """Shares of factors in outcomes; NaN where all outcomes are the same, and of fewer than eight draws.

    Args:
        first: of each factor by itself, shape (..., factor).
        total: of each factor by itself and together with one other, the same shape.
        joint: of the interaction of two factors, shape (..., factor, factor).
        chance, joint_chance: which the largest of all shares exceeds by chance in 1.25 % of the cases.
        lead: share of the resamples in which the factor with the largest `first` has it, shape (...).
        role: place in `ROLES`, shape (..., factor).
    """

    first: Array
    total: Array
    joint: Array
    chance: float
    joint_chance: float
    lead: Array
    role: NDArray[np.int8]


def factor_shares(outcomes: Array, draws: Array) -> Shares:
    """Return the share of each factor in the outcomes, by itself and in all, and which factors turn them.

        S_i = sum_k Var(P(outcome k | factor i)) / sum_k Var(outcome k)
        T_i = S_i + sum_j S_ij

    S_i is the first-order Sobol index of the outcome (of several outputs: Gamboa et al. 2014, Electron. J.
    Stat. 8, 575) over `BINS` of the factor. S_ij is the share of the product of the halves of two factors,
    less what each half explains: T_i is the total-order index (Homma and Saltelli 1996, Reliab. Eng. Syst.
    Saf. 52, 1) but for interactions of three factors. Each is less the variance that as many bins have by
    chance (epsilon squared, Kelley 1935, Proc. Natl. Acad. Sci. 21, 554).

    S_i and S_ij are each held to the largest one in permutations of the draws, over all factors, or pairs of
    them, and outcomes: a factor without influence is named of any of them in at most 5 %. A factor is named
    alone where its share is the largest in 95 % of the resamples of the draws as well (bootstrap), and two
    for their interaction where no factor has a share by itself.

    Args:
        outcomes: place in `OUTCOMES`, shape (..., draw).
        draws: shape (draw, factor).
    """
    (count, factors), shape = draws.shape, outcomes.shape[:-1]
    rows = outcomes.reshape(prod(shape), 1, count)
    events = np.asarray(rows == np.arange(len(OUTCOMES))[:, None], float)
    varied = (events.any(axis=-1) & ~events.all(axis=-1)).any(axis=-1)
    first, lead = np.full((len(events), factors), np.nan), np.full(len(events), np.nan)
    joint, role = np.full((*first.shape, factors), np.nan), np.zeros(first.shape, np.int8)
    chance = joint_chance = np.nan
    if count >= 2 * BINS and factors and varied.any():
        # Outcomes that no row has are left out.
        events = events[varied][:, events[varied].any(axis=(0, 2))]
        centred, terms = events - events.mean(axis=-1, keepdims=True), _terms(draws)
        rng, largest_by_chance = np.random.default_rng(0), list[Array]()
        for size in _batches(PERMUTATIONS, events.size):
            order = rng.permuted(np.tile(np.arange(count), (size, 1)), axis=1)
            permuted = _shares(np.moveaxis(centred[..., order], 2, 0), *terms)
            largest_by_chance.append(np.stack([each.reshape(size, -1).max(axis=1) for each in permuted]))
        by_chance = np.concatenate(largest_by_chance, axis=1)
        bounds = np.quantile(by_chance, 1.0 - EXCEEDED, axis=1, method="higher") + ROUND_OFF
        chance, joint_chance = map(float, bounds)
        single, pairs = _shares(centred, *terms)
        first[varied], joint[varied] = single, pairs
        lead[varied] = _leads(events, draws, single.argmax(axis=-1), rng)
        above = single > chance
        largest = single == single.max(axis=-1, keepdims=True)
        alone = above & largest & (lead[varied] >= LEVEL)[:, None]
        among = above & ~alone.any(axis=-1, keepdims=True)
        together = (pairs > joint_chance).any(axis=-1) & ~above.any(axis=-1, keepdims=True)
        role[varied] = np.select([alone, among, together], [ALONE, AMONG, TOGETHER], NO_ROLE)
    several = (*shape, factors)
    first, joint = first.reshape(several), joint.reshape(*several, factors)
    total = first + joint.sum(axis=-1)
    return Shares(first, total, joint, chance, joint_chance, lead.reshape(shape), role.reshape(several))


def _batches(count: int, each: int) -> Iterator[int]:
    """Yield numbers of repetitions, of so many numbers each, that are done at once; `count` in all."""
    most = max(BATCH // each, 1)
    for since in range(0, count, most):
        yield min(most, count - since)


def _members(draws: Array) -> Array:
    """Return whether draws are in the bins of factors, 0 or 1, shape (draw, factor, bin)."""
    bins = np.stack([bins_of(column) for column in draws.T], axis=1)
    return np.asarray(bins[..., None] == np.arange(BINS), float)


def _terms(draws: Array) -> tuple[Array, Array]:
    """Return unit vectors of the bins, and of the products of the halves of two factors.

    A product is less what each half explains; it is zero where both are the same in all draws, and of a
    factor with itself. Shapes (draw, factor, bin) and (draw, pair), pairs in the order of `triu_indices`.
    """
    count, factors = draws.shape
    members = _members(draws)
    sides = np.stack([2.0 * bins_of(column, 2) - 1.0 for column in draws.T])
    products = np.zeros((count, factors * (factors - 1) // 2))
    for column, (a, b) in enumerate(combinations(sides, 2)):
        alone = np.stack([np.ones(count), a, b], axis=1)
        product = a * b - alone @ np.linalg.lstsq(alone, a * b)[0]
        if (length := np.linalg.norm(product)) > ROUND_OFF:
            products[:, column] = product / length
    return members / np.sqrt(members.sum(axis=0)), products


def _shares(centred: Array, members: Array, products: Array) -> tuple[Array, Array]:
    """Return first-order and joint shares, shapes (..., factor) and (..., factor, factor).

    Args:
        centred: events less their mean, shape (..., outcome, draw).
        members, products: of `_terms`.
    """
    count, factors, bins = members.shape
    total = (centred**2).sum(axis=(-2, -1))[..., None]

    def share(columns: Array, each: int, freedom: int) -> Array:
        explained = ((centred @ columns) ** 2).sum(axis=-2)
        between = explained.reshape(*explained.shape[:-1], -1, each).sum(axis=-1)
        noise = (total - between) / (count - 1 - freedom)
        return np.where(between > 0.0, (between - freedom * noise) / total, 0.0)

    first = share(members.reshape(count, -1), bins, bins - 1)
    joint = np.zeros((*first.shape, factors))
    upper = np.triu_indices(factors, 1)
    joint[..., *upper] = share(products, 1, 1)
    return first, joint + np.swapaxes(joint, -1, -2)


def _leads(events: Array, draws: Array, largest: NDArray[np.intp], rng: np.random.Generator) -> Array:
    """Return the share of resamples in which a factor explains more of the outcome than any other, (row,).

    Args:
        events: shape (row, outcome, draw).
        draws: shape (draw, factor).
        largest: factor of each row.
        rng: of the resamples.
    """
    count, factors = draws.shape
    members = _members(draws).reshape(count, -1)
    own, times = np.arange(factors) == largest[:, None], np.zeros(len(events))
    for size in _batches(RESAMPLES, events.size):
        weights = rng.multinomial(count, np.full(count, 1.0 / count), size).astype(float)
        sums = ((events * weights[:, None, None]) @ members) ** 2
        members_drawn = (weights @ members)[:, None, None]
        between = np.divide(sums, members_drawn, out=np.zeros_like(sums), where=members_drawn > 0.0).sum(
            axis=2
        )
        between = between.reshape(size, -1, factors, BINS).sum(axis=-1)
        second = np.where(own, -np.inf, between).max(axis=-1)
        times += (np.where(own, between, 0.0).sum(axis=-1) > second + ROUND_OFF).sum(axis=0)
    return times / RESAMPLES
