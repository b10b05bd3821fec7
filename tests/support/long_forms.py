"""Short and long forms of a claim: some cases always, the others where they are asked for."""

from collections.abc import Collection, Iterable
from typing import TypeVar

import pytest

Case = TypeVar("Case")


def cases(every: Iterable[Case], short: Collection[Case]) -> list[object]:
    """Parameters of a test: those in `short` always run, the others are of its long form."""
    return [case if case in short else pytest.param(case, marks=pytest.mark.long) for case in every]
