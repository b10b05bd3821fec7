"""Settled motors whose law, parameters, basis and step are drawn together, and what each has its share in.

The design is that of Saltelli et al. (2010), Computer Physics Communications 181, 259: two matrices A and B
of a scrambled Sobol' sequence, and A with one column of B for every factor. Parameters are spread evenly
over their ranges; laws, bases and steps are levels that are equally likely, which the inverse of a discrete
distribution makes of the same sequence: the indices know nothing of where a factor's values are from.
"""

import json
import multiprocessing
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from typing import Any, Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.comparison.reruns import Refined, control_of, on_other_basis
from contactlab.comparison.runs import ComparisonError
from contactlab.comparison.settled import QUANTITIES, means_of, settled
from contactlab.config import Setup, build
from contactlab.config.groups import Uncertainty
from contactlab.config.nesting import flat, nested
from contactlab.config.schema import declared_in
from contactlab.metrics import Run
from contactlab.metrics.convergence import FINER
from contactlab.processes import START_METHOD, begin_worker, processors

SEED: Final = 0
RESAMPLES: Final = 999
PIECE: Final = 4  # motors that a worker is given at once

SPREAD: Final[dict[str, tuple[str, ...]]] = {
    "friction coefficient": ("contact.friction_coefficient",),
    "stiffness": ("law.stiffness", "law.normal.stiffness"),
    "clearance": ("contact.clearance",),
}
"""Parameters by name, in the order of `Uncertainty`: every law has its own value of the key that it has."""

LAW, BASIS, STEP = "law", "basis", "step"


@final
@dataclass(frozen=True)
class Factor:
    """What is drawn: the scale of a parameter, from 1 - spread to 1 + spread, or one of some levels."""

    name: str
    keys: tuple[str, ...] = ()
    spread: float = 0.0
    levels: int = 0

    def at(self, even: Array) -> Array:
        """Give scales or levels of numbers spread evenly from 0 to 1."""
        return np.floor(self.levels * even) if self.levels else 1.0 + self.spread * (2.0 * even - 1.0)


@final
@dataclass(frozen=True)
class Samples:
    """Settled motors of a design.

    Args:
        factors: what was drawn.
        count: of rows of either matrix; A, B, and A with each column of B follow each other in `drawn`.
        drawn: scales and levels, shape (motor, factor).
        values: by `QUANTITIES`, SI, shape (motor, quantity); NaN where there is none.
        reasons: why a motor has no steady state; empty where it has one.
    """

    factors: tuple[Factor, ...]
    count: int
    drawn: Array
    values: Array
    reasons: tuple[str, ...]

    def of_law(self, law: int, basis: int) -> Array:
        """Give the values of one law on one basis, shape (motor, quantity), each motor once."""
        asked, chosen = {LAW: law, BASIS: basis}, np.ones(len(self.drawn), dtype=bool)
        for column, factor in enumerate(self.factors):
            if factor.name in asked:
                chosen &= self.drawn[:, column] == asked[factor.name]
        return np.unique(self.values[chosen], axis=0)

    def shares(self) -> tuple[Array, Array]:
        """Give the shares of the factors in the variance of every quantity, with 95 % intervals.

        First-order indices, and total ones that count what a factor does together with others; NaN where
        nothing varies or too few motors have a steady state.

        Returns:
            First and total, each of shape (quantity, factor, 3): share, lower and upper end.
        """
        # A, B and the mixed ones, row by row.
        rows = self.values.reshape(len(self.factors) + 2, self.count, len(QUANTITIES))
        both = np.array([_indices(rows[:, :, q]) for q in range(len(QUANTITIES))])
        return both[:, 0], both[:, 1]


def _indices(rows: Array) -> Array:
    """Give first and total indices of one quantity, shape (2, factor, 3), of rows (matrix, row)."""
    sound = rows[:, np.isfinite(rows).all(axis=0)]
    nothing = np.full((2, len(rows) - 2, 3), np.nan)
    if sound.shape[1] < 2:
        return nothing
    # A power of two is what the estimate wants of its rows.
    sound = sound[:, : 1 << (sound.shape[1].bit_length() - 1)]
    scale = float(np.abs(sound).max())
    if np.ptp(sound) <= 1e-12 * scale:
        return nothing

    # It takes a third of a second, of which a run shall know nothing.
    from scipy.stats import sobol_indices

    def found(a: Array) -> Array:
        made = {"f_A": a[:1], "f_B": a[1:2], "f_AB": a[2:, np.newaxis]}
        each = sobol_indices(func=made, n=a.shape[1])
        return np.array([each.first_order, each.total_order]).reshape(2, -1)

    rng = np.random.default_rng(SEED)
    drawn = rng.integers(sound.shape[1], size=(RESAMPLES, sound.shape[1]))
    ends = np.quantile([found(sound[:, which]) for which in drawn], (0.025, 0.975), axis=0)
    return np.stack([found(sound), *ends], axis=-1)


def factors_of(laws: Sequence[Refined], ranges: Mapping[str, float]) -> tuple[Factor, ...]:
    """Give what can be drawn for these laws: parameters that one of them has and that are not exactly known.

    Args:
        laws: settled.
        ranges: half of the range of a parameter over its value, by full key, beside or in place of what the
            section `uncertainty` of the runs states and what laws declare by `Parameter.spread`.

    Raises:
        ComparisonError: a range that is none, or of what is no number; a sentence each.
    """
    stated = next((law.run.configuration.get("uncertainty") for law in laws), None) or {}
    usual = Uncertainty(**stated)
    spreads = {
        keys: getattr(usual, field.name)
        for keys, field in zip(SPREAD.values(), fields(Uncertainty), strict=True)
    }
    spreads |= {
        keys: x for keys, x in _declared_ranges(laws).items() if not any(keys[0] in k for k in spreads)
    }
    faults = []
    for key, spread in ranges.items():
        keys = next((keys for keys in spreads if key in keys), (key,))
        if not any(holds_number(law.run, key) for law in laws):
            faults.append(
                f"The range of {key} is given, which is no number of any run compared; it must be the full "
                "key of one, such as contact.clearance."
            )
        elif not 0.0 <= spread < 1.0:
            faults.append(
                f"The range of {key} is {spread:g}; it must be at least 0 and less than 1. It is half of the "
                "range over the value."
            )
        spreads[keys] = spread
    if faults:
        raise ComparisonError(faults)
    names = {keys: name for name, keys in SPREAD.items()}
    parameters = (
        Factor(names.get(keys, keys[0]), keys, spread)
        for keys, spread in spreads.items()
        if spread > 0.0 and any(holds_number(law.run, key) for law in laws for key in keys)
    )
    kinds = (Factor(LAW, levels=len(laws)),) if len(laws) > 1 else ()
    bases = (Factor(BASIS, levels=2),) if all(law.elsewhere for law in laws) else ()
    return (*kinds, *parameters, *bases, Factor(STEP, levels=3))


def left_fixed(run: Run, factors: Sequence[Factor], ranges: Collection[str]) -> list[str]:
    """Return the law's own parameters that no factor varies and no range calls exactly known.

    Args:
        run: of the law.
        factors: what is drawn.
        ranges: keys whose range was given, zero among them.
    """
    usual = {key for keys in SPREAD.values() for key in keys}
    treated = usual | {key for factor in factors for key in factor.keys} | set(ranges)
    own = (key for key in run.settings if key.startswith("law.") and key not in treated)
    return [key.removeprefix("law.") for key in own if holds_number(run, key)]


def _declared_ranges(laws: Sequence[Refined]) -> dict[tuple[str, ...], float]:
    """Return the ranges that laws declare of their own parameters, `Parameter.spread`, by full key."""
    return {
        (key,): parameter.spread
        for law in laws
        for key, parameter in declared_in(dict(law.run.configuration)).items()
        if parameter.spread > 0.0
    }


def holds_number(run: Run, key: str) -> bool:
    """Tell whether a run has a number by this key that a scale changes."""
    value = run.settings.get(key)
    return isinstance(value, float) and value != 0.0


@final
class Design:
    """The motors that are to settle, each once."""

    def __init__(self, laws: Sequence[Refined], factors: tuple[Factor, ...], count: int) -> None:
        # As above.
        from scipy.stats import qmc

        self._laws, self.factors, self.count = laws, factors, count
        size = len(factors)
        even = qmc.Sobol(2 * size, seed=SEED).random(count)
        first, second = even[:, :size], even[:, size:]
        mixed = [np.where(np.arange(size) == column, second, first) for column in range(size)]
        points = np.concatenate([first, second, *mixed])
        self.drawn = np.column_stack([f.at(points[:, i]) for i, f in enumerate(factors)])
        setups = [build(law.run.configuration) for law in laws]
        self._bases = [[setup.configuration, on_other_basis(setup)[0]] for setup in setups]
        self._controls = [control_of(setup) for setup in setups]
        made = [self._configuration(row) for row in self.drawn]
        keys = [json.dumps(one, sort_keys=True) for one in made]
        self._cases = dict(zip(keys, made, strict=True))
        places = {key: place for place, key in enumerate(self._cases)}
        self._place = [places[key] for key in keys]

    @property
    def size(self) -> int:
        """Steady states to be found."""
        return len(self._cases)

    @property
    def workers(self) -> int:
        """Processes that find them."""
        return max(1, min(processors(), self.size // PIECE))

    @property
    def estimate(self) -> float:
        """Time that they take, by what those before took [s]."""
        every = [seconds for law in self._laws for seconds in law.seconds]
        return float(np.mean(every)) * self.size / self.workers

    def _configuration(self, row: Array) -> dict[str, Any]:
        """Give the configuration of a motor of the design."""
        level = {factor.name: int(x) for factor, x in zip(self.factors, row, strict=True) if factor.levels}
        law = level.get(LAW, 0)
        settings = flat(self._bases[law][level.get(BASIS, 0)])
        for factor, scale in zip(self.factors, row, strict=True):
            for key in factor.keys:
                if isinstance(settings.get(key), float):
                    settings[key] *= float(scale)
        control = self._controls[law]
        settings[f"solver.{control}"] /= FINER[control][level[STEP]]
        return nested(settings)

    def run(self) -> Iterator[tuple[Array, str]]:
        """Find the steady states one after the other, the same bits by any number of workers."""
        if self.workers == 1:
            yield from map(_answer, self._cases.values())
            return
        context = multiprocessing.get_context(START_METHOD)
        executor = ProcessPoolExecutor(self.workers, mp_context=context, initializer=begin_worker)
        try:
            # From Python 3.12 on, of threads that a fork does not have: the workers do not ask for them.
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", "This process", DeprecationWarning)
                yield from executor.map(_answer, self._cases.values(), chunksize=PIECE)
        finally:
            executor.shutdown(cancel_futures=True)

    def samples(self, found: Sequence[tuple[Array, str]]) -> Samples:
        """Put what was found where it was drawn."""
        values = np.array([found[place][0] for place in self._place])
        reasons = tuple(found[place][1] for place in self._place)
        return Samples(self.factors, self.count, self.drawn, values, reasons)


def _answer(configuration: Mapping[str, Any]) -> tuple[Array, str]:
    """Give the values of one settled motor, or why it has none."""
    try:
        setup: Setup = build(configuration)
        return means_of(settled(setup)).values, ""
    # The others shall not suffer from what one of a thousand runs into.
    except Exception as error:
        return np.full(len(QUANTITIES), np.nan), str(error) or type(error).__name__
