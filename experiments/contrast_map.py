"""A map of how much a law matters over dimensionless groups, judged on motors that it has not seen.

y = ln |c|, with |c| held between `SMALLEST` and `LARGEST`, which stands for motors that turn. The map is
additive,

    y = b + sum_g f_g(g),

with a cubic spline f_g of the rank of each group and a ridge whose strength is that of least error with one
motor left out.
"""

from typing import Final, NamedTuple

import numpy as np
from sklearn.linear_model import RidgeCV
from sklearn.model_selection import cross_val_predict
from sklearn.pipeline import Pipeline, make_pipeline
from sklearn.preprocessing import QuantileTransformer, SplineTransformer

from contactlab.arrays import Array

SMALLEST, LARGEST = 1e-4, 3.0
"""Bounds of |c|: below the first the laws are one for every user, and a motor that turns has no ratio."""

KNOTS, RANKS, FOLDS = 4, 64, 8
"""Knots of a spline, ranks of a group, and folds that tell the width of a prediction."""

RIDGES: Final = np.logspace(-3.0, 4.0, 29)

Z90: Final = 1.6448536269514722
"""Half-width of a 90 % interval over the standard deviation."""

RESAMPLES, LEVEL, SEED = 2000, 0.95, 0

BAR: Final = 0.25
"""A contrast is predicted where the lower end of its R^2 is above this."""


class Judged(NamedTuple):
    """How well the map predicts motors that it has not seen.

    Args:
        r2: 1 - sum (y - prediction)^2 / sum (y - mean of the motors fitted)^2.
        low, high: its interval by bootstrap over the motors not seen.
        coverage: share of them within their 90 % interval.
        motors: their number.
    """

    r2: float
    low: float
    high: float
    coverage: float
    motors: int


def mapped(groups: Array, size: Array, fitted: int) -> Judged:
    """Fit the map to the first motors and judge it on the others.

    Args:
        groups: shape (motor, group).
        size: |c|, shape (motor,), infinite where the motor turns, NaN where there is no contrast.
        fitted: motors fitted, counted with those that have no contrast.
    """
    known = ~np.isnan(size)
    y = np.log(np.clip(size, SMALLEST, LARGEST))
    seen, unseen = (
        np.flatnonzero(known & part) for part in (np.arange(y.size) < fitted, np.arange(y.size) >= fitted)
    )
    model = additive().fit(groups[seen], y[seen])
    width = Z90 * float(np.std(y[seen] - cross_val_predict(additive(), groups[seen], y[seen], cv=FOLDS)))
    error = y[unseen] - model.predict(groups[unseen])
    spread = y[unseen] - y[seen].mean()
    rng = np.random.default_rng(SEED)
    drawn = rng.integers(unseen.size, size=(RESAMPLES, unseen.size))
    r2 = 1.0 - (error[drawn] ** 2).sum(axis=1) / (spread[drawn] ** 2).sum(axis=1)
    low, high = np.quantile(r2, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL])
    whole = 1.0 - float(error @ error) / float(spread @ spread)
    return Judged(whole, float(low), float(high), float((np.abs(error) <= width).mean()), unseen.size)


def additive() -> Pipeline:
    """Return the map before it is fitted."""
    return make_pipeline(
        QuantileTransformer(n_quantiles=RANKS), SplineTransformer(n_knots=KNOTS), RidgeCV(alphas=RIDGES)
    )
