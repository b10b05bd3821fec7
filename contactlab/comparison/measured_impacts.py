"""Laws against measured impacts: error, that over the least admissible one, and where each is the nearest."""

from collections.abc import Sequence
from itertools import permutations
from math import nan
from typing import Final

import numpy as np

from contactlab.arrays import Array
from contactlab.comparison.measurements import ENDS, Judged, Measurement, row
from contactlab.config import Setup
from contactlab.impacts import velocities_after
from contactlab.inference.bootstrap import LEVEL, MeanIntervals, mean_intervals, paired_differences
from contactlab.laws import LawError
from contactlab.measured import floors
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.metrics import CANNOT_TELL, NOT_APPLICABLE, Metric

SEED: Final = 1
"""Of the resamples: the same comparison gives the same bits."""


def by_impacts(
    one: Measurement,
    impacts: MeasuredImpacts,
    labels: Sequence[str],
    setups: Sequence[Setup | None],
    mark: str,
) -> Judged:
    """Give the rows of measured impacts."""
    notes: list[str] = []
    answers = [
        _answers(one, impacts, label, setup, notes) for label, setup in zip(labels, setups, strict=True)
    ]
    errors = np.array([impacts.errors(answer) for answer in answers]).T
    best = impacts.errors(floors.velocities_after(impacts, floors.best_admissible_impulses(impacts)))
    comparable = np.isfinite(errors).all(axis=0)
    known = np.flatnonzero(comparable)
    values, spread = np.full((2, 3, len(labels)), nan)
    nearer = np.full((len(labels), len(labels), len(ENDS)), nan)
    # The best of the others is none where there is one law.
    others = [np.delete(errors[:, known], i, axis=1).min(axis=1, initial=np.inf) for i in range(known.size)]
    nearest = np.array([errors[:, law] < other for law, other in zip(known, others, strict=True)], float)
    columns = np.column_stack([errors[:, known], *nearest, best]) if known.size else best[:, None]
    drawn = mean_intervals(columns, SEED)
    means, half = drawn.mean, drawn.half
    # Where impulses can make every measured velocity, what they leave is rounding alone.
    told = means[-1] > floors.ROUND_OFF
    if not told:
        notes.append(
            f"impact_error_over_floor does not apply to {one.title}: admissible impulses give its "
            f"velocities to {means[-1]:.1g} of the approach, which is round-off and no floor."
        )
    for i, law in enumerate(known):
        j = known.size + i
        values[0, law], spread[0, law] = means[i], half[i]
        if told:
            values[1, law], spread[1, law] = means[i] / means[-1], _half_of_ratio(drawn, i)
        if known.size > 1:
            values[2, law], spread[2, law] = means[j], half[j]
    apart, intervals = paired_differences(errors[:, known], SEED)
    for i, j in permutations(range(known.size), 2):
        nearer[known[i], known[j]] = apart[j, i], *intervals[j, i]
    return Judged(
        one,
        _impact_rows(one, mark, CANNOT_TELL if told else NOT_APPLICABLE),
        values,
        spread,
        nearer,
        tuple(notes),
    )


def _impact_rows(one: Measurement, mark: str, without_floor: str) -> tuple[Metric, ...]:
    """Give the rows; the words are of the one over the floor, where it has no value."""
    source = "; ".join(filter(None, (one.title, one.source)))
    return (
        row(
            f"impact_error{mark}",
            "mean of ||v+ - v+_law||_M / ||v-||_M",
            f"error of predicted impacts, less is better ({one.title}): of the velocities after, in the norm "
            "of the kinetic energy before, parameters as run",
            "1",
            source,
        ),
        row(
            f"impact_error_over_floor{mark}",
            "mean error / mean error of the best admissible impulse",
            f"error over the least that is admissible, less is better ({one.title}): that of the "
            "impulses which do not pull, close or gain energy, and 1 the best",
            "1",
            source,
            without_floor,
        ),
        row(
            f"nearest_impacts{mark}",
            "share of impacts with error < least error of the other laws",
            f"share of impacts that no other law predicts as well, more is better ({one.title}): of the laws "
            "compared here",
            "1",
            source,
        ),
    )


def _answers(
    one: Measurement, impacts: MeasuredImpacts, label: str, setup: Setup | None, notes: list[str]
) -> Array:
    """Give the velocities after the impacts under a law, shape (impact, 2); NaN with a note without."""
    nothing = np.full_like(impacts.velocity_before, nan)
    if setup is None:
        notes.append(f"{label} is not held against {one.title}: its run has no configuration that builds.")
        return nothing
    try:
        found = velocities_after(setup.law, impacts.delassus, impacts.velocity_before)
    # A law of another package may fail in ways of its own.
    except (LawError, TypeError, ValueError) as error:
        notes.append(f"{label} does not answer to the impacts of {one.title}: {error}")
        return nothing
    lost = int((~np.isfinite(found)).any(axis=1).sum())
    if lost:
        notes.append(
            f"{label} gives no number for {lost} of the {len(impacts)} impacts of {one.title}, so its "
            "error cannot be told."
        )
    return found


def _half_of_ratio(drawn: MeanIntervals, column: int) -> float:
    """Return half the interval of a mean over that of the last column, by percentiles."""
    tail = 0.5 * (1.0 - LEVEL)
    low, high = np.quantile(drawn.resampled[column] / drawn.resampled[-1], [tail, 1.0 - tail])
    return 0.5 * float(high - low)
