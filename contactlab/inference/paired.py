"""Paired comparison of laws: the sign of a difference over motors that are drawn alike for all laws.

Everything but the law is equal within a pair, so that a difference is the law's. What is open is whether its
sign and size survive where the motor is not exactly known: the sign probability, that two laws differ in one
sense in a motor drawn at random, has an exact interval (Clopper and Pearson 1934, Biometrika 26, 404), and
an order is stated where the test of "at most `AGREED`" is rejected, corrected for the number of pairs.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.inference.bootstrap import LEVEL
from contactlab.inference.multiple import holm

AGREED: Final = 0.8
"""Share of motors in which two laws have one order, or none, before it counts as theirs. A single pair is
decided by 14 draws of one sign, 66 pairs by 33 to 37 (by three looks)."""

FIRST_LOOK: Final = 16
"""Draws after which orders are tested for the first time; every further look has twice as many."""

VERDICTS: Final = ("greater", "less", "equal", "varies", "inconclusive")
"""Orders of two laws: the first is greater or less, they are equal, the sign varies over the motors drawn, or
the draws are too few to tell."""
GREATER, LESS, EQUAL, VARIES, INCONCLUSIVE = range(len(VERDICTS))


@final
class Orders(NamedTuple):
    """Orders of pairs of laws.

    Args:
        share: of draws in which the first law is greater, less, and equal, shape (..., 3).
        low, high: 95 % interval of the probability of each, the same shape.
        p_value: of "no order in more than `AGREED` of the motors", corrected, shape (...).
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


def orders(signs: Array, looks: int = 1) -> Orders:
    """Return the orders of pairs of laws.

    Of each quantity, claims of an order are a family and claims that there is none another: in each, the
    probability of a false claim is at most 5 % by Holm's correction for all pairs and operating points. Every
    one of several looks at growing draws has an equal part of it.

    Args:
        signs: of the difference of a pair in a draw, 1, -1 or 0 where they are equal; NaN where one of the
            two has no steady state. Shape (..., quantity, draw).
        looks: number of looks that are planned.
    """
    # Imported here: a run needs no scipy.stats.
    from scipy.stats import beta, binom

    count = np.isfinite(signs).sum(axis=-1)[..., None]
    times = np.stack([(signs == sign).sum(axis=-1) for sign in (1, -1, 0)], axis=-1)
    tail = 0.5 * (1.0 - LEVEL)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = times / count
    low = np.where(times > 0, beta.ppf(tail, np.maximum(times, 1), count - times + 1), 0.0)
    high = np.where(times < count, beta.ppf(1.0 - tail, times + 1, np.maximum(count - times, 1)), 1.0)
    most = times.max(axis=-1)
    agree, disagree = np.ones((2, *most.shape))
    for quantity in range(most.shape[-1]):
        here, trials = most[..., quantity], count[..., quantity, 0]
        # Where a law has no steady state in any draw there is no test.
        trials = np.where(trials > 0, trials, np.nan)
        agree[..., quantity] = holm(binom.sf(here - 1, trials, AGREED))
        disagree[..., quantity] = holm(binom.cdf(here, trials, AGREED))
    level = (1.0 - LEVEL) / looks
    verdict = np.where(
        agree <= level, times.argmax(axis=-1), np.where(disagree <= level, VARIES, INCONCLUSIVE)
    )
    return Orders(share, low, high, agree, verdict)


def classes(equal: Array) -> Array:
    """Return the class of each law: all pairs of laws of a class are equal, shape (law,).

    Args:
        equal: whether two laws are equal, shape (law, law).
    """
    if len(equal) < 2:
        return np.ones(len(equal), dtype=int)
    # Imported here, as above.
    from scipy.cluster.hierarchy import fcluster, linkage

    apart = ~np.asarray(equal, dtype=bool)
    # Complete linkage: equality of pairs is not transitive.
    tree = linkage(apart[np.triu_indices(len(apart), 1)].astype(float), "complete")
    return np.asarray(fcluster(tree, 0.5, "distance"))


def log_bayes_factors(values: Array, errors: Sequence[float]) -> Array:
    """Return the expected log Bayes factor of one measurement for each law against each other.

    E[ln p_a(y) - ln p_b(y)] of y = x + e, where x is a draw of law a and e the normal error of the
    measurement. The density p of a law is the kernel estimate of its draws by Scott's rule, without x itself,
    widened by the error (Kass and Raftery 1995, J. Am. Stat. Assoc. 90, 773: 3 is strong evidence).

    Args:
        values: of the draws, shape (law, draw); NaN where there is none.
        errors: standard deviations of the measurement.

    Returns:
        Shape (error, law, law), NaN on the diagonal and where a law has fewer than three draws.
    """
    # Imported here, as above.
    from scipy.special import logsumexp

    result = np.full((len(errors), len(values), len(values)), np.nan)
    known = {law: each for law, row in enumerate(values) if (each := row[np.isfinite(row)]).size > 2}
    # The mean over the error by Gauss and Hermite.
    nodes, weights = np.polynomial.hermite_e.hermegauss(7)
    weights = weights / weights.sum()
    for number, error in enumerate(errors):
        for a, own in known.items():
            y = own[:, None] + error * nodes

            def log_density(law: int, own: int = a, y: Array = y, error: float = error) -> Array:
                centres = known[law]
                width = np.hypot(error, np.std(centres) * centres.size**-0.2)
                exponent = -0.5 * ((y[:, :, None] - centres) / width) ** 2
                if law == own:
                    exponent[np.arange(len(y)), :, np.arange(len(y))] = -np.inf
                return np.asarray(logsumexp(exponent, axis=2) - np.log(width * (centres.size - (law == own))))

            for b in known.keys() - {a}:
                result[number, a, b] = np.mean((log_density(a) - log_density(b)) @ weights)
    return result
