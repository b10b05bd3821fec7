"""The order of laws by their held-out errors, and which of them the data can part."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final, NamedTuple

from contactlab.inference.bootstrap import LEVEL, Resampled

PLUS_MINUS: Final = "+-"

SAME: Final = 1e-6
"""Difference of two errors that is none of two laws but of where their fits have ended."""

SHOWN: Final = 1e-4
"""Difference below which its four decimals say nothing."""


class Pair(NamedTuple):
    """How far the errors of two laws lie apart: mean difference, first less second, and its interval."""

    better: str
    worse: str
    apart: float
    low: float
    high: float

    @property
    def parted(self) -> bool:
        """Whether the interval holds no zero, and the laws do not predict the same."""
        return self.low > SAME

    @property
    def sentence(self) -> str:
        """Which beats which by how much, or that the data cannot tell."""
        if max(abs(self.low), abs(self.high)) < SAME:
            return f"{self.better} and {self.worse} predict the same"
        by = f"{self.apart:.4f} {PLUS_MINUS} {0.5 * (self.high - self.low):.4f}"
        if max(abs(self.low), abs(self.high)) < SHOWN:
            by = f"less than {SHOWN}"
        if not self.parted:
            return f"the data cannot tell {self.better} from {self.worse}: {by} apart"
        return f"{self.better} beats {self.worse} by {by}"


def order_of(table: Resampled) -> list[int]:
    """Give the columns in the order of their means, the least first."""
    means = table.mean()
    return sorted(range(len(means)), key=lambda column: float(means[column]))


def pair_of(table: Resampled, labels: Sequence[str], one: int, other: int) -> Pair:
    """Weigh two columns against each other; the one with the smaller mean is the better."""
    if table.mean()[other] < table.mean()[one]:
        one, other = other, one
    apart, low, high = table.difference(other, one, LEVEL)
    return Pair(labels[one], labels[other], apart, low, high)


def groups_of(table: Resampled, labels: Sequence[str]) -> list[list[int]]:
    """Give the columns in their order, those together that the data cannot tell from the first of them."""
    groups: list[list[int]] = []
    for column in order_of(table):
        if groups and not pair_of(table, labels, groups[-1][0], column).parted:
            groups[-1].append(column)
        else:
            groups.append([column])
    return groups


def sentences(table: Resampled, labels: Sequence[str]) -> list[str]:
    """Say the order, a sentence for each law and the next."""
    return [f"{_capital(pair_of(table, labels, *pair).sentence)}." for pair in pairwise(order_of(table))]


def _capital(words: str) -> str:
    """Capitalise a sentence that begins with a word, not with the name of a law."""
    return f"T{words[1:]}" if words.startswith("the ") else words
