"""The paired comparison: motors as configured and drawn, and differences of laws over points and draws."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any, Final, NamedTuple, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.inference.paired import (
    EQUAL,
    INCONCLUSIVE,
    VERDICTS,
    classes,
    log_bayes_factors,
    looks_up_to,
    orders,
)
from contactlab.laws import MultiplierLaw
from contactlab.metrics.convergence import FINER, control_of, richardson
from contactlab.studies.compare.draws import (
    BASES,
    BASIS,
    LEVELS,
    OBSERVABLES,
    POSTERIOR,
    STEPS,
    Distribution,
    Factor,
    Posteriors,
    as_configured,
    configuration_of,
    do_draw,
    drawn,
    factors_of,
)
from contactlab.studies.compare.laws import ComparisonError, Grid, delassus_at_rest, run_of_setup
from contactlab.studies.study import Task

NAMES_OF_BASES: Final = ("as configured", "other basis")

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


_Place = tuple[str, Array, int]
"""Operating point, draw and step of a motor."""


@final
@dataclass(frozen=True)
class Design:
    """The motors that are compared in pairs, as configured and drawn; each task is one motor, all laws.

    Args:
        grid: laws and operating points.
        factors: what is drawn; nothing for setups that were made in Python.
        samples: draws at most.
        names: of the quantities.
        posterior: samples of the laws' numbers.
    """

    grid: Grid
    factors: tuple[Factor, ...]
    samples: int
    names: tuple[str, ...]
    posterior: Posteriors | None = None

    @classmethod
    def of(
        cls,
        grid: Grid,
        priors: Mapping[str, Distribution],
        samples: int,
        names: Sequence[str],
        posterior: Posteriors | None,
    ) -> "Design":
        """Return the design for priors by full key.

        Raises:
            ComparisonError: a prior is faulty, or the posterior is that of no law here.
        """
        if not grid.whole:
            return cls(grid, (), 0, tuple(names))
        factors = factors_of([run_of_setup(law, each) for (law, _), each in grid.setups.items()], priors)
        if posterior:
            if not any(posterior.values(setup, 0.0) for setup in grid.setups.values()):
                raise ComparisonError(
                    [
                        f"posterior is a fit of {', '.join(posterior.samples)}; it must be one of a number "
                        "of the laws that are compared."
                    ]
                )
            factors = (*factors, Factor(POSTERIOR, (0.0, 1.0)))
        return cls(grid, factors, samples, tuple(names), posterior)

    @property
    def looks(self) -> list[int]:
        """Numbers of draws after which orders are tested."""
        return looks_up_to(self.samples)

    @cached_property
    def draws(self) -> Array:
        """All draws, shape (draw, factor)."""
        return drawn(self.factors, self.samples)

    def nominal(self) -> dict[str, _Place]:
        """Return the motors as configured, on each basis and at each step; made in Python, on one basis."""
        bases = range(BASES if self.factors else 1)
        return {
            f"as configured {cell} {basis} {step}": (cell, as_configured(self.factors, basis), step)
            for cell, basis, step in product(self.grid.cells, bases, range(STEPS))
        }

    def drawn(self, since: int, count: int) -> dict[str, _Place]:
        """Return the motors of draws from a first to a number of them, those of a point together."""
        digest = self.posterior.digest if self.posterior else ""
        return {
            f"draw {number} {cell} {digest}": (cell, self.draws[number], 0)
            for cell, number in product(self.grid.cells, range(since, count))
        }

    def tasks(self, motors: Mapping[str, _Place]) -> Iterator[Task]:
        """Yield the tasks of motors by key: each is one motor under every law."""
        for key, (cell, draw, step) in motors.items():
            laws: dict[str, Any] = {law: self.grid.setups[law, cell] for law in self.grid.laws}
            for law, setup in laws.items():
                if self.factors:
                    laws[law] = configuration_of(setup, self.factors, draw, self.posterior, step)
                else:
                    control = control_of(setup)
                    laws[law] = replace(setup, **{control: getattr(setup, control) / FINER[control][step]})
            yield Task(key, do_draw, (laws, self.names))

    def spent(self, parts: Mapping[str, xarray.DataTree]) -> int:
        """Return the number of draws that are finished: a look's, or none."""
        return max((look for look in self.looks if {*self.drawn(0, look)} <= {*parts}), default=0)

    def settled(self, parts: Mapping[str, xarray.DataTree], count: int) -> Settled:
        """Return the settled motors of a number of draws."""
        laws, cells, quantities = len(self.grid.laws), len(self.grid.cells), len(self.names)

        def every(name: str, motors: Iterable[str], *shape: int) -> Array:
            values = np.reshape(
                [parts[key][name].values for key in motors], (cells, *shape, laws, quantities)
            )
            return np.moveaxis(values, -2, 0)

        nominal = np.full((laws, cells, *LEVELS, quantities), np.nan)
        known = every("value", self.nominal(), -1, STEPS)
        nominal[:, :, : known.shape[2]] = known
        values, errors = (every(name, self.drawn(0, count), count) for name in ("value", "error"))
        orders = [setup.law.convergence_order for setup in self.grid.first.values()]
        return Settled(nominal, values, errors, orders)

    def failures(self, parts: Mapping[str, xarray.DataTree], count: int) -> str:
        """Return a sentence on the motors without a steady state; empty where there are none."""
        motors = self.nominal() | self.drawn(0, count)
        reasons = np.array([parts[key]["failure"].values for key in motors], str)
        failed = reasons != ""
        if not failed.any():
            return ""
        laws = zip(self.grid.laws, failed.sum(axis=0).tolist(), strict=True)
        numbers = ", ".join(f"{law} {number}" for law, number in laws if number)
        return (
            f"{failed.sum()} of {failed.size} motors have no steady state ({numbers}): {reasons[failed][0]}"
        )


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


def with_pairs(data: xarray.Dataset, design: Design, parts: Mapping[str, xarray.DataTree]) -> xarray.Dataset:
    """Add the paired comparison to a scorecard.

    Args:
        data: the scorecard, over `law`.
        design: of the comparison.
        parts: of its tasks.

    Returns:
        With `nominal` and `drawn_value` of the laws; over (law, other_law, cell, quantity) `difference` (its
        median over the draws, without draws that as configured), `difference_low` and `difference_high` (5
        and 95 %), `difference_error` (numerical, the largest of both bases at the finest step), `sign_share`,
        `sign_low` and `sign_high` of the signs (+, -, 0), `p_value`, `order` (flags) and
        `rank_correlation` with each factor; `basis_mean` and `basis_deviation` by basis;
        `log_bayes_factor` by error of the measurement; `class` of the laws by quantity;
        `normal_tangential_coupling` of the motor at rest.
    """
    count = design.spent(parts)
    settled, draws = design.settled(parts, count), design.draws[:count]
    names, factors = design.names, design.factors
    laws, quantities = len(settled.nominal), [OBSERVABLES[name] for name in names]
    error = step_errors(settled)[:, :, :, :, -1]
    nominal = settled.nominal[:, None, :, :, -1] - settled.nominal[None, :, :, :, -1]
    values = np.moveaxis(settled.drawn, 2, 3)
    difference = values[:, None] - values[None]
    middle, (low, high) = nominal[:, :, :, 0], np.full((2, *nominal[:, :, :, 0].shape), np.nan)
    known = np.isfinite(difference).any(axis=-1)
    if known.any():
        middle = np.where(known, quantiles(difference, 0.5), middle)
        low, high = quantiles(difference, RANGE)
    outcome = verdicts_of(signs_of(settled, factors, draws), len(design.looks))
    itself = np.eye(laws, dtype=bool)[:, :, None, None]
    verdict = np.where(itself, EQUAL, np.nan_to_num(outcome.verdict, nan=INCONCLUSIVE)).astype(np.int8)
    members = np.array([classes((verdict[..., n] == EQUAL).all(axis=2)) for n in range(len(names))])
    basis = draws[:, [factor.name for factor in factors].index(BASIS)] if factors else np.empty(0)
    by_basis = [difference[..., basis == level] for level in range(BASES)]
    bayes = np.full((len(MEASUREMENT_ERRORS), laws, laws, *middle.shape[2:]), np.nan)
    if values.size:
        sizes = np.nanmedian(np.abs(values), axis=(0, 3))
        for place in np.ndindex(sizes.shape):
            deviations = [float(share * sizes[place]) for share in MEASUREMENT_ERRORS]
            bayes[..., *place] = log_bayes_factors(values[:, *place], deviations)

    def pure(long_name: str) -> dict[str, str]:
        return {"units": "1", "long_name": long_name}

    def in_units(long_name: str) -> dict[str, str]:
        return {"comment": "units differ by quantity, see `quantity_units`", "long_name": long_name}

    flags = {"flag_values": np.arange(len(VERDICTS), dtype=np.int8), "flag_meanings": " ".join(VERDICTS)}
    on_bases, of_signs = (*PAIR, "basis"), (*PAIR, "sign")
    motors, drawn_motors = ("law", "cell", "basis", "step", "quantity"), ("law", "cell", "draw", "quantity")
    matrices = [delassus_at_rest(setup.motor) for setup in design.grid.first.values()]
    coupling = [float(abs(d[0, 1]) / np.sqrt(d[0, 0] * d[1, 1])) for d in matrices]
    rigid = [isinstance(setup.law, MultiplierLaw) for setup in design.grid.first.values()]
    notes = [data.attrs["notes"], design.failures(parts, count)]
    data = data.assign_attrs(notes="\n".join(filter(None, notes)))
    equal = {"long_name": "laws that are equal at every operating point"}
    factor_values = {"comment": "NaN: as configured; scales, values and levels"}
    return (
        data.assign({"class": (("quantity", "law"), members, equal)})
        .assign(
            nominal=(motors, settled.nominal, in_units("as configured")),
            drawn=(("draw", "factor"), draws, factor_values),
            drawn_value=(drawn_motors, settled.drawn, in_units("of the draws")),
            difference=(PAIR, middle, in_units("law less other law, median over the draws")),
            difference_low=(PAIR, low, in_units("5 % of the draws")),
            difference_high=(PAIR, high, in_units("95 % of the draws")),
            difference_error=(
                PAIR,
                np.fmax(error[:, :, :, 0], error[:, :, :, 1]),
                in_units("numerical error"),
            ),
            basis_mean=(on_bases, _by(np.mean, by_basis), in_units("mean of the draws")),
            basis_deviation=(on_bases, _by(np.std, by_basis), in_units("deviation of the draws")),
            sign_share=(of_signs, outcome.share, pure("share of the draws")),
            sign_low=(of_signs, outcome.low, pure("lower end of the 95 % interval")),
            sign_high=(of_signs, outcome.high, pure("upper end of the 95 % interval")),
            p_value=(PAIR, outcome.p_value, pure("p-value, corrected by Holm")),
            order=(PAIR, verdict, flags),
            rank_correlation=((*PAIR, "factor"), _correlations(difference, draws), pure("Spearman's")),
            log_bayes_factor=(
                ("measurement_error", *PAIR),
                bayes,
                pure("expected natural log Bayes factor of one measurement"),
            ),
        )
        .assign_coords(
            other_law=data["law"].values,
            cell=list(design.grid.cells),
            basis=list(NAMES_OF_BASES),
            sign=["+", "-", "0"],
            quantity=list(names),
            quantity_units=("quantity", [each.units for each in quantities]),
            quantity_name=("quantity", [each.long_name for each in quantities]),
            factor=[factor.name for factor in factors],
            prior=("factor", [factor.text for factor in factors]),
            measurement_error=list(MEASUREMENT_ERRORS),
            normal_tangential_coupling=("law", coupling, pure("D_nt over sqrt(D_nn D_tt) at rest")),
            rigid=("law", np.array(rigid, np.int8)),
        )
    )


def quantiles(values: Array, share: float | Sequence[float]) -> Array:
    """Return quantiles over the last axis, NaN where nothing is known."""
    known = np.asarray(np.isfinite(values).any(axis=-1, keepdims=True))
    every = np.nanquantile(np.where(known, values, 0.0), share, axis=-1)
    return np.where(known[..., 0], every, np.nan)


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
