"""Why runs cannot be compared."""

from collections.abc import Sequence
from typing import final


@final
class ComparisonError(ValueError):
    """Runs that cannot be compared.

    Args:
        faults: a sentence each.
    """

    def __init__(self, faults: Sequence[str]) -> None:
        super().__init__("\n".join(faults))
        self.faults = tuple(faults)
