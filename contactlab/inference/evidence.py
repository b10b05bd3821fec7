"""Bayes factors of laws in words, "not distinguishable" where evidences are too close.

B = Z_1 / Z_2 is by how much the data change the odds of law 1 over law 2. Words of Jeffreys (1961), Theory
of Probability, app. B: above 3 substantial, 10 strong, 30 very strong, 100 decisive. Evidence is of law and
prior together: an even range that is ten times as wide takes ln 10 from a parameter that the data determine.
Odds are stated only where the law with the larger evidence covers the data.
"""

from collections.abc import Sequence
from math import exp, hypot, log, nan
from typing import Final, NamedTuple, final

LEAST: Final = log(3.0)
"""Smallest significant |ln B|."""

ERRORS: Final = 3.0
"""Smallest significant |ln B| in units of its error."""

_WORDS: Final = (
    (log(100.0), "decisive"),
    (log(30.0), "very strong"),
    (log(10.0), "strong"),
    (LEAST, "substantial"),
)


@final
class Evidence(NamedTuple):
    """The logarithm of the evidence of a law, its error, and how the law's predictions cover the data.

    Args:
        label: of the law.
        log_evidence, error: ln Z and its standard deviation.
        covers: whether the 90 % intervals contain 90 % of the data within the binomial error.
        share: of the data that they contain [1]; NaN where it is not known.
    """

    label: str
    log_evidence: float
    error: float
    covers: bool = True
    share: float = nan


def strength(difference: float, error: float) -> str:
    """Return Jeffreys' word for a difference of ln Z of either sign; empty where it is not significant."""
    size = abs(difference)
    if not size >= max(LEAST, ERRORS * error):
        return ""
    return next(word for limit, word in _WORDS if size >= limit)


def ranked(evidences: Sequence[Evidence]) -> list[Evidence]:
    """Return the evidences in falling order."""
    return sorted(evidences, key=lambda item: -item.log_evidence)


def sentences(evidences: Sequence[Evidence]) -> list[str]:
    """Return a sentence on the law with the largest evidence and each of the others."""
    first, *others = ranked(evidences)
    result = []
    for other in others:
        difference = first.log_evidence - other.log_evidence
        error = hypot(first.error, other.error)
        shown = f"ln B = {difference:.1f} +- {error:.1g}"
        if not first.covers:
            whose = "those of no law here do" if not any(x.covers for x in evidences) else "its own do not"
            result.append(
                f"{first.label} has a larger evidence than {other.label} ({shown}), but no odds follow "
                f"from it: 90 % intervals must contain about 90 % of the data, and {whose} ({first.label} "
                f"{first.share:.1%}, {other.label} {other.share:.1%})."
            )
        elif word := strength(difference, error):
            odds = f"{exp(difference):.3g}" if difference < log(1e6) else f"10^{difference / log(10.0):.0f}"
            pair = f"{first.label} against {other.label}"
            result.append(f"The evidence for {pair} is {word}: odds of {odds} to 1 ({shown}).")
        else:
            result.append(f"{first.label} and {other.label} are not distinguishable ({shown}).")
    return result
