"""Draws of law, parameters, basis and step, and their shares in the variance of the settled motors.

The design is that of Saltelli et al. (2010), Computer Physics Communications 181, 259: two matrices A and B
of a scrambled Sobol' sequence, and A with one column of B for each factor. Parameters are distributed evenly
over their ranges; laws, bases and steps are levels of equal probability.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup, build
from contactlab.config.groups import Uncertainty
from contactlab.config.nesting import flat, nested
from contactlab.config.schema import declared_in
from contactlab.metrics import Run
from contactlab.metrics.convergence import FINER, control_of
from contactlab.studies.compare_runs import ComparisonError

SEED: Final = 0
RESAMPLES: Final = 999

SPREAD: Final[dict[str, tuple[str, ...]]] = {
    "friction coefficient": ("contact.friction_coefficient",),
    "stiffness": ("law.stiffness", "law.normal.stiffness"),
    "clearance": ("contact.clearance",),
}
"""Parameters by name, in the order of `Uncertainty`: a scale applies to the keys that a law has."""

LAW, BASIS, STEP = "law", "basis", "step"

CONVERGED: Final = "finite_element"
"""Option of the group `resonator` with the converged basis."""

MORE_MODES: Final = 4
"""Modes that are added to a converged basis."""


@final
@dataclass(frozen=True)
class Factor:
    """What is drawn: the scale of a parameter, from 1 - spread to 1 + spread, or one of some levels."""

    name: str
    keys: tuple[str, ...] = ()
    spread: float = 0.0
    levels: int = 0

    def at(self, uniform: Array) -> Array:
        """Return scales or levels of numbers distributed evenly from 0 to 1."""
        return np.floor(self.levels * uniform) if self.levels else 1.0 + self.spread * (2.0 * uniform - 1.0)


def factors_of(runs: Sequence[Run], ranges: Mapping[str, float]) -> tuple[Factor, ...]:
    """Return what is drawn for laws: parameters that one of them has and that are not exactly known.

    Args:
        runs: with their configurations.
        ranges: half of the range of a parameter over its value, by full key, beside or in place of what the
            section `uncertainty` of the runs states and what laws declare by `Parameter.spread`.

    Raises:
        ComparisonError: a range out of bounds, or of a key that is no number.
    """
    stated = next((run.configuration.get("uncertainty") for run in runs), None) or {}
    usual = Uncertainty(**stated)
    spreads = {
        keys: getattr(usual, field.name)
        for keys, field in zip(SPREAD.values(), fields(Uncertainty), strict=True)
    }
    for run in runs:
        for key, parameter in declared_in(dict(run.configuration)).items():
            if parameter.spread > 0.0 and not any(key in keys for keys in spreads):
                spreads[key,] = parameter.spread
    faults = []
    for key, spread in ranges.items():
        keys = next((keys for keys in spreads if key in keys), (key,))
        if not any(is_scalable(run, key) for run in runs):
            faults.append(f"range has {key}; it must be the full key of a number, as contact.clearance.")
        elif not 0.0 <= spread < 1.0:
            faults.append(f"range of {key} is {spread:g}; it must be at least 0 and less than 1.")
        spreads[keys] = spread
    if faults:
        raise ComparisonError(faults)
    names = {keys: name for name, keys in SPREAD.items()}
    parameters = (
        Factor(names.get(keys, keys[0]), keys, spread)
        for keys, spread in spreads.items()
        if spread > 0.0 and any(is_scalable(run, key) for run in runs for key in keys)
    )
    laws = (Factor(LAW, levels=len(runs)),) if len(runs) > 1 else ()
    return (*laws, *parameters, Factor(BASIS, levels=2), Factor(STEP, levels=3))


def left_fixed(run: Run, factors: Sequence[Factor], ranges: Collection[str]) -> list[str]:
    """Return the law's own parameters that no factor varies and that no range declares exactly known."""
    usual = {key for keys in SPREAD.values() for key in keys}
    treated = usual | {key for factor in factors for key in factor.keys} | set(ranges)
    own = (key for key in run.settings if key.startswith("law.") and key not in treated)
    return [key.removeprefix("law.") for key in own if is_scalable(run, key)]


def is_scalable(run: Run, key: str) -> bool:
    """Return whether a run has a number under this key that a scale changes."""
    value = run.settings.get(key)
    return isinstance(value, float) and value != 0.0


def drawn(factors: Sequence[Factor], count: int) -> Array:
    """Return the draws, shape (draw, factor): `count` rows of A, of B, and of A with each column of B."""
    # Imported here: no other study needs scipy.stats.
    from scipy.stats import qmc

    size = len(factors)
    uniform = qmc.Sobol(2 * size, seed=SEED).random(count)
    first, second = uniform[:, :size], uniform[:, size:]
    mixed = [np.where(np.arange(size) == column, second, first) for column in range(size)]
    points = np.concatenate([first, second, *mixed])
    return np.column_stack([factor.at(points[:, i]) for i, factor in enumerate(factors)])


def configurations_of(
    setups: Sequence[Setup], factors: Sequence[Factor], draws: Array
) -> list[dict[str, Any]]:
    """Return the configuration of each draw, of the law that it draws."""
    bases = [[flat(setup.configuration), flat(on_other_basis(setup)[0])] for setup in setups]
    controls = [control_of(setup.law) for setup in setups]
    result = []
    for row in draws:
        level = {factor.name: int(x) for factor, x in zip(factors, row, strict=True) if factor.levels}
        law = level.get(LAW, 0)
        settings = dict(bases[law][level[BASIS]])
        for factor, scale in zip(factors, row, strict=True):
            for key in factor.keys:
                if isinstance(settings.get(key), float):
                    settings[key] *= float(scale)
        settings[f"solver.{controls[law]}"] /= FINER[controls[law]][level[STEP]]
        result.append(nested(settings))
    return result


@cache
def _converged_resonator() -> dict[str, Any]:
    return dict(build([f"resonator={CONVERGED}"]).configuration["resonator"])


def on_other_basis(setup: Setup) -> tuple[dict[str, Any], str]:
    """Return the same motor on the converged basis, one on it with more modes, and what differs.

    A drive at the first natural frequency stays there.
    """
    configuration = setup.configuration
    resonator, drive = configuration["resonator"], configuration["drive"]
    if resonator["basis"] == "ritz":
        kept = {key: value for key, value in resonator.items() if key not in ("basis", "shapes")}
        other, change = {**_converged_resonator(), **kept}, f"resonator={CONVERGED}"
    else:
        more = resonator["kept_modes"] + MORE_MODES
        other, change = resonator | {"kept_modes": more}, f"resonator.kept_modes={more}"
    tuned = drive["frequency"] == setup.motor.modes.natural_frequency[0]
    frequency = {"frequency": None} if tuned else {}
    return {**configuration, "resonator": other, "drive": drive | frequency}, change


def shares(values: Array, factors: int) -> tuple[Array, Array]:
    """Return first-order and total Sobol' indices of each quantity with 95 % percentile intervals.

    Args:
        values: of the draws, shape (draw, quantity); a row of the design with a NaN is left out.
        factors: number of factors.

    Returns:
        First-order and total indices, each of shape (quantity, factor, 3): share, lower and upper end; NaN
        where nothing varies or too few motors have a steady state.
    """
    rows = values.reshape(factors + 2, -1, values.shape[1])
    both = np.array([_indices(rows[:, :, quantity]) for quantity in range(values.shape[1])])
    return both[:, 0], both[:, 1]


def _indices(rows: Array) -> Array:
    """Return first-order and total indices of one quantity, shape (2, factor, 3), of rows (matrix, row)."""
    sound = rows[:, np.isfinite(rows).all(axis=0)]
    nothing = np.full((2, len(rows) - 2, 3), np.nan)
    if sound.shape[1] < 2:
        return nothing
    # The estimate requires a power of two of rows.
    sound = sound[:, : 1 << (sound.shape[1].bit_length() - 1)]
    scale = float(np.abs(sound).max())
    if np.ptp(sound) <= 1e-12 * scale:
        return nothing
    # Imported here, as above.
    from scipy.stats import sobol_indices

    def indices(a: Array) -> Array:
        matrices = {"f_A": a[:1], "f_B": a[1:2], "f_AB": a[2:, np.newaxis]}
        result = sobol_indices(func=matrices, n=a.shape[1])
        return np.array([result.first_order, result.total_order]).reshape(2, -1)

    # By percentiles; SobolResult.bootstrap has BCa intervals, which are other numbers.
    rng = np.random.default_rng(SEED)
    resamples = rng.integers(sound.shape[1], size=(RESAMPLES, sound.shape[1]))
    ends = np.quantile([indices(sound[:, which]) for which in resamples], (0.025, 0.975), axis=0)
    return np.stack([indices(sound), *ends], axis=-1)
