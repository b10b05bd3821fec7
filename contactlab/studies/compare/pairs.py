"""The paired comparison: motors as configured and drawn, and outcomes of pairs of laws over the draws."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from typing import Any, Final, NamedTuple, final

import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.laws import MultiplierLaw
from contactlab.refinement import LEVELS, Refinement
from contactlab.studies.compare.factors import POSTERIOR, START, Factor, factors_of
from contactlab.studies.compare.hypercube import SEED, drawn
from contactlab.studies.compare.laws import ComparisonError, Grid, delassus_at_rest, run_of_setup
from contactlab.studies.compare.motors import Drawn, is_changed, on_other_basis
from contactlab.studies.compare.observables import OBSERVABLES, do_draw
from contactlab.studies.compare.paired import (
    EQUAL,
    GREATER,
    INCONCLUSIVE,
    LESS,
    NONE,
    OUTCOMES,
    ROLES,
    UNTESTED,
    VARIES,
    VERDICTS,
    Orders,
    factor_shares,
    looks_up_to,
    orders,
)
from contactlab.studies.compare.posteriors import Posteriors
from contactlab.studies.compare.priors import Distribution
from contactlab.studies.compare.repeats import NEGLIGIBLE, REPEATS, repeated, spread_of
from contactlab.studies.compare.scorecard import OBSERVED_IN, observation_in, task_key
from contactlab.studies.study import Task

CLEAR: Final = 3.0
"""Numerical errors within which the difference of two laws may lie anywhere."""

SIGNED: Final = {"rotor_velocity", "stall_torque"}
"""Quantities that count in the sense in which the motor turns."""

ROUND_OFF: Final = 1e-9
"""Relative difference below which two values are one: nine digits, of which an orbit has as many."""

WITHOUT_EFFECT: Final = 1e-6
"""Relative change of all quantities below which a factor has no effect on them."""

FAR: Final = 0.9
"""Place in its range to which a factor is set by itself, from 0 to 1."""

RANGE: Final = (0.05, 0.5, 0.95)
"""Quantiles of a distribution over draws that are shown."""

PAIR: Final = ("law", "other_law", "cell", "quantity")


@final
class Settled(NamedTuple):
    """Quantities of settled motors.

    Args:
        nominal: as configured, at three steps, shape (law, cell, step, quantity).
        other: on the other basis, shape (law, cell, quantity).
        repeats: of the motors of `REPEATS`, shape (law, cell, repeat, quantity).
        moved: with one factor at `FAR` of its range each, shape (law, cell, factor, quantity).
        drawn: of the draws, shape (law, cell, quantity, draw).
        errors: of the draws, statistical, the same shape.
        orders: of convergence of the laws in the step.
    """

    nominal: Array
    other: Array
    repeats: Array
    moved: Array
    drawn: Array
    errors: Array
    orders: Sequence[float]


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
        seed: of the draws.
    """

    grid: Grid
    factors: tuple[Factor, ...]
    samples: int
    names: tuple[str, ...]
    posterior: Posteriors | None = None
    seed: int = SEED

    @classmethod
    def of(
        cls,
        grid: Grid,
        priors: Mapping[str, Distribution],
        samples: int,
        names: Sequence[str],
        posterior: Posteriors | None,
        seed: int = SEED,
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
                    f"posterior is a fit of {', '.join(posterior.samples)}; it must be one of a number "
                    "of the laws that are compared."
                )
            factors = (*factors, Factor(POSTERIOR, "uniform", 0.0, 1.0))
        return cls(grid, factors, samples, tuple(names), posterior, seed)

    @property
    def looks(self) -> list[int]:
        """Numbers of draws after which orders are tested."""
        return looks_up_to(self.samples)

    @cached_property
    def draws(self) -> Array:
        """All draws, shape (draw, factor)."""
        return drawn(self.factors, self.samples, self.seed)

    @property
    def moved(self) -> Sequence[Factor]:
        """Factors whose effect is computed one by one; `REPEATS` has that of the start."""
        return [factor for factor in self.factors if factor.name != START] if self.samples else []

    def nominal(self) -> dict[str, Drawn]:
        """Return the motors as configured by key: at each step, on the other basis, and `REPEATS`.

        Those of which motors are drawn are also computed with one factor at `FAR` of its range, under the
        laws that it changes. Motors made in Python have the steps alone.
        """
        works: dict[str, Callable[[Setup], Any]] = {
            f"step {step}": partial(_refined, step=step) for step in range(LEVELS)
        }
        if self.grid.whole:
            works |= {"basis": lambda setup: on_other_basis(setup)[0]}
            works |= {name: partial(repeated, repeat=name) for name in REPEATS}
        digest = self.posterior.digest if self.posterior else ""
        configured = {
            _configured(cell, name): Drawn({law: work(self.grid.setups[law, cell]) for law in self.grid.laws})
            for name, work in works.items()
            for cell in self.grid.cells
        }
        return configured | {
            _configured(cell, f"with {factor.name} {digest}"): Drawn(
                {
                    law: setup
                    for law in self.grid.laws
                    if is_changed(setup := self.grid.setups[law, cell], factor, self.posterior)
                },
                (factor,),
                factor.at(np.array([FAR])),
                self.posterior,
                _configured(cell, "step 0"),
            )
            for factor in self.moved
            for cell in self.grid.cells
        }

    def drawn(self, since: int, count: int) -> dict[str, Drawn]:
        """Return the motors of draws from a first to a number of them, those of a point together."""
        digest = self.posterior.digest if self.posterior else ""
        motors = {
            cell: {law: self.grid.setups[law, cell] for law in self.grid.laws} for cell in self.grid.cells
        }
        return {
            f"draw {number} {cell} {digest}": Drawn(
                motors[cell], self.factors, self.draws[number], self.posterior
            )
            for cell, number in product(self.grid.cells, range(since, count))
        }

    @property
    def reruns(self) -> dict[str, list[str]]:
        """Keys of the scorecard's reruns, one of each law, that observe motors as configured."""
        return {
            _configured(self.grid.cells[0], name): [task_key(law, name) for law in self.grid.laws]
            for name in OBSERVED_IN
        }

    def tasks(self, motors: Mapping[str, Drawn]) -> Iterator[Task]:
        """Yield the tasks of motors by key, without those that `reruns` observe."""
        for key, motor in motors.items():
            if key not in self.reruns:
                yield Task(key, do_draw, (motor, self.names))

    def _observed(
        self, parts: Mapping[str, xarray.DataTree], motors: Mapping[str, Drawn]
    ) -> Iterator[xarray.Dataset]:
        """Yield the quantities of each motor under every law."""
        for key, motor in motors.items():
            if key in self.reruns and key not in parts:
                reruns = [parts[rerun] for rerun in self.reruns[key]]
                yield xarray.concat([observation_in(rerun, self.names) for rerun in reruns], "law")
                continue
            data, laws = parts[key].to_dataset(), [*motor.laws]
            if motor.others and len(laws) < len(self.grid.laws):
                # The factor is a number of other laws: these have the motor as configured.
                (others,) = self._observed(parts, {motor.others: motors[motor.others]})
                rows = [
                    data.isel(law=laws.index(law)) if law in laws else others.isel(law=place)
                    for place, law in enumerate(self.grid.laws)
                ]
                data = xarray.concat(rows, "law")
            yield data

    def spent(self, parts: Mapping[str, xarray.DataTree]) -> int:
        """Return the number of draws that are finished: a look's, or none."""
        return max((look for look in self.looks if {*self.drawn(0, look)} <= {*parts}), default=0)

    def settled(self, parts: Mapping[str, xarray.DataTree], count: int) -> Settled:
        """Return the settled motors of a number of draws."""
        laws, cells, quantities = len(self.grid.laws), len(self.grid.cells), len(self.names)

        def every(name: str, motors: Mapping[str, Drawn], number: int) -> Array:
            values = np.array([data[name].values for data in self._observed(parts, motors)])
            return np.moveaxis(values.reshape(number, cells, laws, quantities), 2, 0)

        def by_draw(name: str) -> Array:
            motors = {key: motor for n in range(count) for key, motor in self.drawn(n, n + 1).items()}
            return np.moveaxis(every(name, motors, count), 1, 3)

        configured = every("value", nominal := self.nominal(), len(nominal) // cells)
        places = [LEVELS, LEVELS + 1, LEVELS + 1 + len(REPEATS)]
        known = np.full((laws, places[-1] + len(self.moved), cells, quantities), np.nan)
        known[:, : configured.shape[1]] = configured
        steps, other, repeats, moved = np.split(np.moveaxis(known, 1, 2), places, axis=2)
        orders = [setup.law.convergence_order for setup in self.grid.first.values()]
        return Settled(steps, other[:, :, 0], repeats, moved, by_draw("value"), by_draw("error"), orders)

    def failures(self, parts: Mapping[str, xarray.DataTree], count: int) -> str:
        """Return a sentence on the motors without a steady state; empty where there are none."""
        motors = self.nominal() | self.drawn(0, count)
        reasons = np.array([data["failure"].values for data in self._observed(parts, motors)], str)
        failed = reasons != ""
        if not failed.any():
            return ""
        laws = zip(self.grid.laws, failed.sum(axis=0).tolist(), strict=True)
        numbers = ", ".join(f"{law} {number}" for law, number in laws if number)
        reason = reasons[failed][0].partition(". ")[0].removesuffix(".")
        return f"{failed.sum()} of {failed.size} motors have no steady state ({numbers}): {reason}."


def _configured(cell: str, name: str) -> str:
    """Return the key of a motor as configured at an operating point, or changed as the name states."""
    return f"as configured {cell} {name}"


def _refined(setup: Setup, step: int) -> Setup:
    """Return a setup at one of three steps or tolerances."""
    return Refinement.of(setup).setups(setup)[step]


def step_errors(nominal: Array, orders: Sequence[float]) -> Array:
    """Return numerical errors of the differences, shape (law, law, cell, step, quantity).

    That of the finest step is Richardson's of the difference itself, in which common errors cancel; those of
    coarser steps add the distance from it.

    Args:
        nominal: shape (law, cell, step, quantity).
        orders: of convergence of the laws.
    """
    difference = nominal[:, None] - nominal[None]
    error = np.full_like(difference, np.nan)
    for a, b, cell, quantity in np.ndindex(*difference.shape[:3], difference.shape[4]):
        refinement = Refinement.of_difference([orders[a], orders[b]])
        error[a, b, cell, :, quantity] = refinement.errors(difference[a, b, cell, :, quantity])
    return error


def spreads(settled: Settled) -> Array:
    """Return the range of each quantity over a motor and its `REPEATS`, over its size.

    Infinite where some of them have no steady state; shape (law, cell, quantity).
    """
    alike = np.concatenate([settled.nominal[:, :, :1], settled.repeats], axis=2)
    # Nothing is known of motors that were made in Python, or have no steady state at all.
    known = np.isfinite(settled.repeats).any(axis=2)
    return np.where(known, spread_of(alike, axis=2), np.nan)


def effects(settled: Settled) -> Array:
    """Return the largest relative change of any quantity by a factor at `FAR`, shape (law, factor).

    Infinite where one of both motors has no steady state.
    """
    both = np.stack(np.broadcast_arrays(settled.nominal[:, :, :1], settled.moved), axis=-1)
    # What no motor has is no quantity.
    known = np.isfinite(both).any(axis=(0, 1, 2, 4))
    return np.asarray(spread_of(both[:, :, :, known]).max(axis=(1, 3), initial=0.0))


def differences(values: Array, names: Sequence[str]) -> tuple[Array, Array, Array]:
    """Return differences of laws, the sizes that they are held to, and the differences over these.

    Of `SIGNED` they are in the sense in which the motor turns under the median law. The size is the larger of
    both, and of `NEGLIGIBLE` of the largest there is. A difference below `ROUND_OFF` of it is none.

    Args:
        values: of the quantities, shape (law, cell, quantity, motor).
        names: of the quantities, the velocity first.

    Returns:
        Shapes (law, law, cell, quantity, motor).
    """
    middle = quantiles(np.moveaxis(values[:, :, 0], 0, -1), 0.5)
    signed = np.array([name in SIGNED for name in names])[:, None]
    values = np.where(signed & (middle < 0.0)[:, None], -1.0, 1.0) * values
    difference = values[:, None] - values[None]
    largest = np.abs(values).max(axis=(0, 3), initial=0.0, where=np.isfinite(values))
    size = np.maximum(np.abs(values[:, None]), np.abs(values[None]))
    size = np.maximum(size, NEGLIGIBLE * largest[..., None])
    difference[np.abs(difference) <= ROUND_OFF * size] = 0.0
    return difference, size, np.divide(difference, size, out=np.zeros_like(difference), where=size != 0.0)


@final
class Population(NamedTuple):
    """Pairs of laws in the motors drawn; shapes (law, law, cell, quantity, ...).

    Args:
        difference, relative: of `differences`, (..., draw).
        outcome: place in `OUTCOMES`, (..., draw).
        orders: of all pairs.
    """

    difference: Array
    relative: Array
    outcome: Array
    orders: Orders


def population_of(settled: Settled, names: Sequence[str], margin: float, looks: int) -> Population:
    """Return the pairs of laws in the motors drawn.

    An outcome counts if it holds anywhere within the error of the difference, which is `CLEAR` numerical
    errors of the motor as configured and the statistical errors of irregular motions. No order is stated of a
    law whose response is no function of its inputs: of one with `spreads` beyond the margin.

    Args:
        settled: with draws.
        names: of the quantities.
        margin: relative difference within which two laws are practically equal.
        looks: number of looks that are planned.
    """
    difference, size, relative = differences(settled.drawn, names)
    numerical = step_errors(settled.nominal, settled.orders)[:, :, :, 0]
    error = CLEAR * numerical[..., None] + np.hypot(settled.errors[:, None], settled.errors[None])
    outcome: Array = np.full(difference.shape, NONE)
    outcome[difference - error > margin * size] = GREATER
    outcome[difference + error < -margin * size] = LESS
    outcome[np.abs(difference) + error <= max(margin, ROUND_OFF) * size] = EQUAL
    # What no law has is no quantity of this motor, as the current of a resonator without capacitance.
    absent = ~np.isfinite(settled.drawn[:, :, 1:]).any(axis=(0, 1, 3))
    outcome[:, :, :, np.flatnonzero(absent) + 1] = UNTESTED
    # A law with itself is no pair.
    itself = np.eye(len(difference), dtype=bool)
    outcome[itself] = UNTESTED
    every = _orders_of(outcome, looks)
    unsure = _unsure(settled, margin)
    verdict = np.where(unsure, INCONCLUSIVE, np.nan_to_num(every.verdict))
    verdict[itself] = EQUAL
    return Population(difference, relative, outcome, every._replace(verdict=verdict))


def _unsure(settled: Settled, margin: float) -> NDArray[np.bool_]:
    """Return whether a law of a pair has a response that is no function, shape (law, law, cell, quantity)."""
    wide = spreads(settled) > margin
    return np.asarray(wide[:, None] | wide[None])


def undecided(settled: Settled, pairs: Population, margin: float) -> bool:
    """Return whether more draws may tell the order of two laws in the settled velocity, or what turns it."""
    open_pairs = (pairs.orders.verdict >= VARIES) & ~_unsure(settled, margin)
    return bool(open_pairs[..., 0].any())


def _orders_of(outcome: Array, looks: int) -> Orders:
    """Return `Orders` of all pairs, mirrored for the other sense, of outcomes (law, law, ..., draw)."""
    first, second = np.triu_indices(len(outcome), 1)
    every = orders(outcome[first, second], looks)
    swapped = [LESS, GREATER, EQUAL, NONE]
    mirrored = every._replace(
        share=every.share[..., swapped],
        low=every.low[..., swapped],
        high=every.high[..., swapped],
        verdict=np.where(every.verdict < EQUAL, GREATER + LESS - every.verdict, every.verdict),
    )
    return Orders(*(_of_all(x, y, len(outcome)) for x, y in zip(every, mirrored, strict=True)))


def _of_all(upper: Array, lower: Array, laws: int) -> Array:
    """Return what is known of pairs of different laws over (law, law, ...), NaN of a law with itself.

    Args:
        upper: of each pair once, in the order of `triu_indices`, shape (pair, ...).
        lower: of the pairs in the other sense.
        laws: number of laws.
    """
    first, second = np.triu_indices(laws, 1)
    whole = np.full((laws, laws, *upper.shape[1:]), np.nan)
    whole[first, second], whole[second, first] = upper, lower
    return whole


def _existing(names: Sequence[str], settled: Settled) -> tuple[Sequence[str], Settled, list[str]]:
    """Return the quantities that a motor has, and what it lacks, as the current without capacitance.

    Of a velocity that no motor has that is known.
    """
    drawn = np.isfinite(settled.drawn).any(axis=(0, 1, 3))
    values = np.asarray(drawn | np.isfinite(settled.nominal).any(axis=(0, 1, 2)))
    values[0] = True
    arrays = ("nominal", "other", "repeats", "moved")
    kept = {name: getattr(settled, name)[..., values] for name in arrays}
    kept |= {name: getattr(settled, name)[:, :, values] for name in ("drawn", "errors")}
    existing = [name for name, known in zip(names, values, strict=True) if known]
    return existing, settled._replace(**kept), [name for name in names if name not in existing]


def with_pairs(
    data: xarray.Dataset, design: Design, parts: Mapping[str, xarray.DataTree], margin: float
) -> xarray.Dataset:
    """Add the paired comparison to a scorecard.

    Args:
        data: the scorecard.
        design: of the motors.
        parts: of its tasks.
        margin: relative difference within which two laws are practically equal.

    Returns:
        The dataset with `nominal` values as configured at three steps, those on the `other_basis` and
        `repeated`, with their `spread`; `drawn` factors and `drawn_value` quantities of all laws; over (law,
        other_law, cell, quantity) the `outcome` of each draw, `difference` and `relative_difference` (their
        medians over the draws where both have a steady state, without draws that as configured; `_low` and
        `_high` are 5 and 95 %), `relative_size` (the median without signs), `difference_error` (numerical),
        `outcome_share`, `outcome_low` and `outcome_high`, `p_value`, `order` (flags); of `factor_shares` in
        the outcome `factor_share`, `total_share`, `joint_share`, `factor_role` (flags), and the bounds of
        chance; `effect` of each factor by itself; `normal_tangential_coupling` of the motor at rest.
    """
    count, factors = design.spent(parts), design.factors
    settled, draws = design.settled(parts, count), design.draws[:count]
    names, settled, absent = _existing(design.names, settled)
    quantities = [OBSERVABLES[name] for name in names]
    pairs = population_of(settled, names, margin, len(design.looks))
    # As configured at the finest step, and on the other basis at the configured one.
    configured, size, relative = differences(
        np.stack([settled.nominal[:, :, -1], settled.other], axis=-1), names
    )
    # Values that are none on the other basis are not equal there.
    none = np.maximum(np.abs(settled.other[:, None]), np.abs(settled.other[None])) < size[..., 1]
    relative[..., 1] = np.where(none, np.nan, relative[..., 1])

    def pure(long_name: str, **attributes: Any) -> dict[str, Any]:
        return {"units": "1", "long_name": long_name, **attributes}

    def in_units(long_name: str) -> dict[str, str]:
        return {"comment": "units differ by quantity, see `quantity_units`", "long_name": long_name}

    def flags(names: Sequence[str], since: int = 0) -> dict[str, Any]:
        values = np.arange(since, since + len(names), dtype=np.int8)
        return {"flag_values": values, "flag_meanings": " ".join(names)}

    shown: dict[str, Any] = {
        "relative_drawn": ((*PAIR, "draw"), pairs.relative, pure("relative difference of each draw")),
        "relative_nominal": (PAIR, relative[..., 0], pure("relative difference as configured")),
        "relative_other": (PAIR, relative[..., 1], pure("relative difference on the other basis")),
    }
    for name, at_rest, values in (
        ("difference", configured[..., 0], pairs.difference),
        ("relative_difference", relative[..., 0], pairs.relative),
    ):
        about = {"long_name": f"{name}, law less other law".replace("_", " ")}
        low, middle, high = quantiles(values, RANGE)
        shown |= {f"{name}_low": (PAIR, low, about), f"{name}_high": (PAIR, high, about)}
        shown[name] = PAIR, middle if count else at_rest, about
    sizes = np.abs(pairs.relative) if count else np.abs(relative[..., :1])
    shown["relative_size"] = PAIR, quantiles(sizes, 0.5), pure("median of the relative difference, unsigned")
    outcome, verdict = pairs.outcome, pairs.orders.verdict
    shares = factor_shares(outcome[np.triu_indices(len(outcome), 1)], draws)

    def of_pairs(values: Array) -> Array:
        return _of_all(values, values, len(outcome))

    role = np.nan_to_num(of_pairs(np.asarray(shares.role, float)))
    of_outcomes, of_law = (*PAIR, "outcome_kind"), ("law", "cell", "quantity")
    matrices = [delassus_at_rest(setup.motor) for setup in design.grid.first.values()]
    coupling = [float(abs(d[0, 1]) / np.sqrt(d[0, 0] * d[1, 1])) for d in matrices]
    rigid = [isinstance(setup.law, MultiplierLaw) for setup in design.grid.first.values()]
    without = f"No motor here has {', '.join(absent)}." if absent else ""
    notes = "\n".join(filter(None, [data.attrs["notes"], design.failures(parts, count), without]))
    spread = pure("range over motors that differ by a millionth of friction, or the start, over its size")
    error = step_errors(settled.nominal, settled.orders)[:, :, :, -1]
    drawn_value = np.moveaxis(settled.drawn, 2, 3)
    return (
        data.assign_attrs(notes=notes, margin=margin, samples=design.samples)
        .assign(shown)
        .assign(
            nominal=(("law", "cell", "step", "quantity"), settled.nominal, in_units("as configured")),
            other_basis=(of_law, settled.other, in_units("as configured, on the other basis")),
            repeated=(("law", "cell", "repeat", "quantity"), settled.repeats, in_units("as configured, but")),
            spread=(of_law, spreads(settled), spread),
            drawn=(("draw", "factor"), draws, {"comment": "scales, shifts and values"}),
            drawn_value=(("law", "cell", "draw", "quantity"), drawn_value, in_units("of the draws")),
            outcome=((*PAIR, "draw"), outcome.astype(np.int8), flags(["untested", *OUTCOMES], UNTESTED)),
            difference_error=(PAIR, error, in_units("numerical error")),
            outcome_share=(of_outcomes, pairs.orders.share, pure("share of all draws")),
            outcome_low=(of_outcomes, pairs.orders.low, pure("lower end of the 95 % interval")),
            outcome_high=(of_outcomes, pairs.orders.high, pure("upper end of the 95 % interval")),
            p_value=(PAIR, pairs.orders.p_value, pure("p-value, corrected by Holm")),
            order=(PAIR, verdict.astype(np.int8), flags(VERDICTS)),
            factor_share=((*PAIR, "factor"), of_pairs(shares.first), pure("share in the outcome")),
            total_share=((*PAIR, "factor"), of_pairs(shares.total), pure("share with interactions")),
            joint_share=((*PAIR, "factor", "other_factor"), of_pairs(shares.joint), pure("share of two")),
            factor_role=((*PAIR, "factor"), role.astype(np.int8), flags(ROLES)),
            chance_share=shares.chance,
            joint_chance_share=shares.joint_chance,
            leading_share=(PAIR, of_pairs(shares.lead), pure("resamples with the same largest share")),
            effect=(
                ("law", "moved_factor"),
                effects(settled),
                pure("largest relative change, as configured"),
            ),
        )
        .assign_coords(
            other_law=data["law"].values,
            cell=list(design.grid.cells),
            repeat=list(REPEATS),
            outcome_kind=list(OUTCOMES),
            quantity=list(names),
            quantity_units=("quantity", [each.units for each in quantities]),
            quantity_name=("quantity", [each.long_name for each in quantities]),
            factor=[factor.name for factor in factors],
            other_factor=[factor.name for factor in factors],
            moved_factor=[factor.name for factor in design.moved],
            prior=("factor", [factor.text for factor in factors]),
            logarithmic=("factor", np.array([factor.kind == "log" for factor in factors], np.int8)),
            normal_tangential_coupling=("law", coupling, pure("D_nt over sqrt(D_nn D_tt) at rest")),
            rigid=("law", np.array(rigid, np.int8)),
        )
    )


def quantiles(values: Array, share: float | Sequence[float]) -> Array:
    """Return quantiles over the last axis, NaN where nothing is known."""
    known = np.asarray(np.isfinite(values).any(axis=-1, keepdims=True))
    values = values if values.shape[-1] else np.full_like(known, np.nan, float)
    every = np.nanquantile(np.where(known, values, 0.0), share, axis=-1)
    return np.where(known[..., 0], every, np.nan)
