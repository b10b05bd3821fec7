"""The tables of all metrics and what fills them from datasets."""

from collections.abc import Container, Sequence
from typing import Final

import xarray

from contactlab.metrics import (
    admissible,
    balances,
    consistency,
    ladder,
    response,
    variants,
)
from contactlab.metrics.ladder import Ladder
from contactlab.metrics.measure import measured, table
from contactlab.metrics.metric import Metric
from contactlab.metrics.record import Record
from contactlab.metrics.variants import Variants

_INVARIANT: Final = (*balances.MEASURES, *consistency.MEASURES)
_OF_A_RUN: Final = (*_INVARIANT, *admissible.MEASURES, *response.MEASURES)

METRICS: Final[dict[str, Metric]] = table(_OF_A_RUN)
"""Metrics of one run."""

INVARIANTS: Final[dict[str, Metric]] = table(_INVARIANT)
"""Those metrics of one run that hold whatever its law: where one fails, the solver or the file is wrong."""

STEP_METRICS: Final[dict[str, Metric]] = table(ladder.MEASURES)
"""Metrics of a ladder of steps."""

SENSITIVITIES: Final[dict[str, Metric]] = table(variants.MEASURES)
"""Metrics of a run and its variants."""


def assess(run: xarray.DataTree | Record, keys: Container[str] | None = None) -> dict[str, float]:
    """Metrics of one run.

    Args:
        run: in the layout of a run.nc, see `contactlab.metrics.read_run`, or already a record.
        keys: of the metrics that are wanted; None is all.

    Returns:
        A number for every such key of `METRICS`, in SI; NaN where the run lacks what it needs.
    """
    record = run if isinstance(run, Record) else Record.of_tree(run)
    return measured(_OF_A_RUN, record, keys)


def assess_steps(runs: Sequence[tuple[float, xarray.DataTree]]) -> dict[str, float]:
    """Every metric of a ladder of steps.

    Args:
        runs: contact step [s] or tolerance [1] and run, of one law on one motor, coarsest first.

    Returns:
        A number for every key of `STEP_METRICS`; NaN where there are too few steps.

    Raises:
        ValueError: the steps are not positive and falling.
    """
    steps = [float(step) for step, _ in runs]
    if any(step <= 0.0 for step in steps) or sorted(set(steps), reverse=True) != steps:
        raise ValueError(
            f"The steps are {steps}; they must be positive and fall from run to run. Sort the runs, "
            "coarsest first, and give each step once."
        )
    return measured(ladder.MEASURES, Ladder(steps, [Record.of_tree(tree) for _, tree in runs]))


def assess_variants(
    base: xarray.DataTree,
    basis: xarray.DataTree | None = None,
    friction: tuple[float, xarray.DataTree] | None = None,
) -> dict[str, float]:
    """Every sensitivity of a law's answers.

    Args:
        base: the run.
        basis: a run with another basis of the resonator.
        friction: relative change of the friction coefficient [1], and a run with it.

    Returns:
        A number for every key of `SENSITIVITIES`; NaN where the variant is not given.
    """
    change, other = (0.0, None) if friction is None else friction
    return measured(
        variants.MEASURES,
        Variants(
            base=Record.of_tree(base),
            basis=None if basis is None else Record.of_tree(basis),
            friction=None if other is None else Record.of_tree(other),
            friction_change=float(change),
        ),
    )
