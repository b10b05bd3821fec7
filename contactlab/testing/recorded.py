"""The claims that any recorded run must keep, from its numbers alone."""

from collections.abc import Iterator

import xarray

from contactlab.metrics import INVARIANTS, NOT_APPLICABLE, assess
from contactlab.testing.claim import Claim, at_most


def invariants_of(run: xarray.DataTree) -> Iterator[Claim]:
    """Hold a run to what no law can excuse: closed books, no contact without length, none missed.

    Args:
        run: in the layout of a run.nc, see `contactlab.metrics.read_run`.

    Yields:
        A claim for every one of `contactlab.metrics.INVARIANTS` that the run has the numbers for.
    """
    for key, value in assess(run, INVARIANTS).items():
        metric = INVARIANTS[key]
        if metric.verdict(value) != NOT_APPLICABLE:
            statement = f"{key}: {metric.meaning}"
            yield at_most(statement, value, metric.bound, metric.units)
