"""The paired comparison as a dataset: differences of laws over operating points and draws."""

from collections.abc import Sequence
from typing import Any, Final, NamedTuple, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.inference.paired import EQUAL, INCONCLUSIVE, VERDICTS, classes, log_bayes_factors, orders
from contactlab.metrics.convergence import FINER, richardson
from contactlab.studies.compare.draws import BASIS, LEVELS, Factor
from contactlab.studies.compare.observables import OBSERVABLES

BASES: Final = ("as configured", "other basis")

CLEAR: Final = 3.0
"""Numerical errors of a difference within which it is none."""

MARGIN: Final = 1e-3
"""Difference of two laws, over the size of their quantity, below which they count as equal: a measurement of
such a motor hardly repeats to a tenth of a per cent."""

MEASUREMENT_ERRORS: Final = (0.01, 0.03, 0.1)
"""Standard deviations of a measurement over the median size of its quantity."""

RANGE: Final = (0.05, 0.95)
"""Quantiles of a distribution over draws that are shown."""

PAIR: Final = ("law", "other_law", "cell", "quantity")


@final
class Settled(NamedTuple):
    """Quantities of settled motors.

    Args:
        nominal: as configured, on both bases and at three steps, shape (law, cell, basis, step, quantity).
        drawn: of the draws, shape (law, cell, draw, quantity).
        errors: of the draws, statistical, the same shape.
        orders: of convergence of the laws in the step.
    """

    nominal: Array
    drawn: Array
    errors: Array
    orders: Sequence[float]


def step_errors(settled: Settled) -> Array:
    """Return numerical errors of the differences, shape (law, law, cell, basis, step, quantity).

    That of the finest step is Richardson's of the difference itself, in which common errors cancel; those of
    coarser steps add the distance from it.
    """
    difference = settled.nominal[:, None] - settled.nominal[None]
    laws = len(difference)
    error = np.full_like(difference, np.nan)
    for a in range(laws):
        for b in range(laws):
            steps = np.moveaxis(difference[a, b], 2, 0)
            for place in np.ndindex(steps.shape[1:]):
                values, order = steps[:, *place], min(settled.orders[a], settled.orders[b])
                finest = float(richardson(values, FINER["contact_step"][1], order))
                error[a, b, place[0], place[1], :, place[2]] = np.abs(values - values[-1]) + finest
    return error


def signs_of(settled: Settled, factors: Sequence[Factor], draws: Array) -> Array:
    """Return the signs of differences, shape (law, law, cell, quantity, draw).

    Zero is a difference within `CLEAR` numerical errors on the draw's basis, or within
    `MARGIN`, with statistical errors of aperiodic motions added; NaN where a motor has no steady state or its
    error is not known.
    """
    if not len(draws):
        return np.empty((len(settled.nominal),) * 2 + (*settled.drawn.shape[1::2], 0))
    basis = draws[:, [factor.name for factor in factors].index(BASIS)].astype(int)
    numerical = np.moveaxis(step_errors(settled)[:, :, :, basis, 0], 3, 4)
    values, statistical = (np.moveaxis(each, 2, 3) for each in (settled.drawn, settled.errors))
    difference = values[:, None] - values[None]
    size = np.maximum(np.abs(values[:, None]), np.abs(values[None]))
    threshold = np.maximum(CLEAR * numerical, MARGIN * size)
    threshold += np.hypot(statistical[:, None], statistical[None])
    signs = np.where(np.abs(difference) <= threshold, 0.0, np.sign(difference))
    return np.where(np.isfinite(difference) & np.isfinite(threshold), signs, np.nan)


def verdicts_of(signs: Array, looks: int) -> Any:
    """Return `Orders` of all pairs, mirrored for the other sense, of signs (law, law, ..., draw)."""
    first, second = np.triu_indices(len(signs), 1)
    every = orders(signs[first, second], looks)
    swapped = [1, 0, 2]
    mirrored = every._replace(
        share=every.share[..., swapped],
        low=every.low[..., swapped],
        high=every.high[..., swapped],
        verdict=np.where(every.verdict < EQUAL, 1 - every.verdict, every.verdict),
    )
    result = []
    for upper, lower in zip(every, mirrored, strict=True):
        whole = np.full((len(signs), *signs.shape[1:-1], *upper.shape[len(signs.shape) - 2 :]), np.nan)
        whole[first, second], whole[second, first] = upper, lower
        result.append(whole)
    return type(every)(*result)


def with_pairs(
    data: xarray.Dataset,
    settled: Settled,
    factors: Sequence[Factor],
    draws: Array,
    looks: int,
    cells: Sequence[str],
    names: Sequence[str],
) -> xarray.Dataset:
    """Add the paired comparison to a scorecard.

    Args:
        data: the scorecard, over `law`.
        settled: the motors.
        factors: what is drawn.
        draws: shape (draw, factor).
        looks: number of looks at growing draws that are planned.
        cells: operating points.
        names: quantities.

    Returns:
        With `nominal` and `drawn_value` of the laws; over (law, other_law, cell, quantity) `difference` (its
        median over the draws, without draws that as configured), `difference_low` and `difference_high` (5
        and 95 %), `difference_error` (numerical, the largest of both bases at the finest step), `sign_share`,
        `sign_low` and `sign_high` of the signs (+, -, 0), `p_value`, `order` (flags) and
        `rank_correlation` with each factor; `basis_mean` and `basis_deviation` by basis;
        `log_bayes_factor` by error of the measurement; `class` of the laws by quantity.
    """
    laws, quantities = len(settled.nominal), [OBSERVABLES[name] for name in names]
    error = step_errors(settled)[:, :, :, :, -1]
    nominal = settled.nominal[:, None, :, :, -1] - settled.nominal[None, :, :, :, -1]
    values = np.moveaxis(settled.drawn, 2, 3)
    difference = values[:, None] - values[None]
    middle, (low, high) = nominal[:, :, :, 0], np.full((2, *nominal[:, :, :, 0].shape), np.nan)
    known = np.isfinite(difference).any(axis=-1)
    if known.any():
        middle = np.where(known, _quantile(difference, 0.5), middle)
        low, high = (_quantile(difference, share) for share in RANGE)
    outcome = verdicts_of(signs_of(settled, factors, draws), looks)
    itself = np.eye(laws, dtype=bool)
    verdict = np.where(itself[:, :, None, None], EQUAL, np.nan_to_num(outcome.verdict, nan=INCONCLUSIVE))
    units = {"comment": "units differ by quantity, see `quantity_units`"}
    meaning = {"flag_values": np.arange(len(VERDICTS), dtype=np.int8), "flag_meanings": " ".join(VERDICTS)}
    basis = draws[:, [factor.name for factor in factors].index(BASIS)] if factors else np.empty(0)
    by_basis = [difference[..., basis == level] for level in range(LEVELS[0])]
    sizes = np.nanmedian(np.abs(values), axis=(0, 3)) if values.size else np.empty((len(cells), len(names)))
    factor_of_bayes = np.full((len(MEASUREMENT_ERRORS), laws, laws, len(cells), len(names)), np.nan)
    for cell, quantity in np.ndindex(sizes.shape if values.size else (0, 0)):
        deviations = [float(share * sizes[cell, quantity]) for share in MEASUREMENT_ERRORS]
        factor_of_bayes[..., cell, quantity] = log_bayes_factors(values[:, cell, quantity], deviations)
    same = (verdict == EQUAL).all(axis=2)
    sign = (*PAIR, "sign")
    members = np.array([classes(same[..., number]) for number in range(len(names))])
    about = {"long_name": "laws that are equal at every operating point"}
    return (
        data.assign({"class": (("quantity", "law"), members, about)})
        .assign(
            nominal=(("law", "cell", "basis", "step", "quantity"), settled.nominal, units),
            drawn=(("draw", "factor"), draws, {"comment": "NaN: as configured; scales, values and levels"}),
            drawn_value=(("law", "cell", "draw", "quantity"), settled.drawn, units),
            difference=(PAIR, middle, {"long_name": "law less other law, median over the draws", **units}),
            difference_low=(PAIR, low, {"long_name": "5 % of the draws", **units}),
            difference_high=(PAIR, high, {"long_name": "95 % of the draws", **units}),
            difference_error=(
                PAIR,
                np.fmax(error[:, :, :, 0], error[:, :, :, 1]),
                {"long_name": "numerical error, finest step", **units},
            ),
            basis_mean=(
                (*PAIR, "basis"),
                _by(np.mean, by_basis),
                {"long_name": "mean of the draws", **units},
            ),
            basis_deviation=((*PAIR, "basis"), _by(np.std, by_basis), {"long_name": "deviation", **units}),
            sign_share=(sign, outcome.share, {"units": "1"}),
            sign_low=(sign, outcome.low, {"units": "1", "long_name": "lower end of the 95 % interval"}),
            sign_high=(sign, outcome.high, {"units": "1", "long_name": "upper end of the 95 % interval"}),
            p_value=(PAIR, outcome.p_value, {"units": "1", "long_name": "p-value, corrected by Holm"}),
            order=(PAIR, verdict.astype(np.int8), meaning),
            rank_correlation=((*PAIR, "factor"), _correlations(difference, draws), {"units": "1"}),
            log_bayes_factor=(
                ("measurement_error", *PAIR),
                factor_of_bayes,
                {"units": "1", "long_name": "expected natural log Bayes factor of one measurement"},
            ),
        )
        .assign_coords(
            other_law=data["law"].values,
            cell=list(cells),
            basis=list(BASES),
            sign=["+", "-", "0"],
            quantity=list(names),
            quantity_units=("quantity", [each.units for each in quantities]),
            quantity_name=("quantity", [each.long_name for each in quantities]),
            factor=[factor.name for factor in factors],
            prior=("factor", [factor.text for factor in factors]),
            measurement_error=list(MEASUREMENT_ERRORS),
        )
    )


def _quantile(values: Array, share: float) -> Array:
    """Return quantiles over the last axis, NaN where nothing is known."""
    known: Array = np.asarray(np.isfinite(values).any(axis=-1, keepdims=True))
    return np.asarray(
        np.where(known[..., 0], np.nanquantile(np.where(known, values, 0.0), share, axis=-1), np.nan)
    )


def _by(function: Any, parts: Sequence[Array]) -> Array:
    """Return a statistic of the known numbers of every part, shape (..., part)."""
    result = []
    for part in parts:
        known = np.isfinite(part)
        some = known.any(axis=-1)
        value = np.full(part.shape[:-1], np.nan)
        if some.any():
            value[some] = function(part[some], axis=-1, where=known[some])
        result.append(value)
    return np.stack(result, axis=-1)


def _correlations(difference: Array, draws: Array) -> Array:
    """Return Spearman's rank correlations of differences with factors, shape (..., factor)."""
    # Imported here: a run needs no scipy.stats.
    from scipy.stats import rankdata

    result = np.full((*difference.shape[:-1], draws.shape[1]), np.nan)
    for place in np.ndindex(difference.shape[:-1]):
        known = np.isfinite(difference[place])
        if known.sum() < 3 or np.ptp(difference[place][known]) == 0.0:
            continue
        ranks = rankdata(np.column_stack([difference[place][known], draws[known]]), axis=0)
        moving = np.ptp(ranks, axis=0) > 0.0
        result[place][moving[1:]] = np.corrcoef(ranks[:, moving], rowvar=False)[0, 1:]
    return result
