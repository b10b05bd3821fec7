"""What is uncertain of a motor and its laws: priors of any key, and draws that serve all laws alike.

One draw of parameters, basis and start serves every law: common random numbers. Draws are points of a
scrambled Sobol' sequence, whose first 16, 32, 64 points are designs of their own. They have the configured
step; what that changes is computed for the motor as configured.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import isfinite, log
from pathlib import Path
from typing import Any, Final, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.checks import check_declared
from contactlab.config import Setup, build
from contactlab.config.nesting import flat, nested
from contactlab.config.resonators import MODAL
from contactlab.config.schema import declared_in
from contactlab.inference.free_parameters import WIDE
from contactlab.metrics import Run
from contactlab.metrics.convergence import FINER, control_of
from contactlab.parameter import Parameter
from contactlab.quantity import UnitError, to_si
from contactlab.steady_state.basins import reach
from contactlab.studies.compare.runs import ComparisonError

SEED: Final = 0

SPREAD: Final[dict[str, tuple[tuple[str, ...], float]]] = {
    "friction coefficient": (("contact.friction_coefficient",), 0.33),
    "stiffness": (("law.stiffness", "law.normal.stiffness"), 0.3),
    "clearance": (("contact.clearance",), 0.2),
}
"""What is uncertain by default, by name: its keys, of which a scale applies to those that a law has, and half
of its range over the value. Dry steel has 0.2 to 0.4; a tip whose radius is half as large, or 1.7 times, has
0.7 or 1.3 of the stiffness; lapped surfaces are 0.2 um and 1 um apart."""

BASIS, START, POSTERIOR = "basis", "start", "posterior"
FREQUENCY: Final = "drive.frequency"
LEVELS: Final = 2, 3
"""Numbers of bases and of steps."""


CONVERGED: Final = "finite_element"
"""Option of the group `resonator` with the converged basis."""

MORE_MODES: Final = 4
"""Modes that are added to a converged basis."""


@final
@dataclass(frozen=True)
class Factor:
    """What is drawn: a number of a motor or a law by its prior, or one of some levels.

    Args:
        name: of the factor.
        keys: of the configuration; those that a law lacks are left out.
        prior: 'scale' from 1 - b to 1 + b of the value, 'uniform' or 'log' from a to b, 'normal' of mean a
            and deviation b, 'level' of b levels, 'share' from 0 to 1.
        a, b: of the prior.
    """

    name: str
    keys: tuple[str, ...] = ()
    prior: str = "share"
    a: float = 0.0
    b: float = 1.0

    def at(self, uniform: Array) -> Array:
        """Return values of the prior at numbers distributed evenly from 0 to 1."""
        match self.prior:
            case "level":
                return np.floor(self.b * uniform)
            case "normal":
                # Imported here: no other study needs scipy.stats.
                from scipy.stats import norm

                return np.asarray(norm.ppf(np.clip(uniform, 1e-9, 1.0 - 1e-9), self.a, self.b))
            case "log":
                return np.asarray(self.a * np.exp(uniform * log(self.b / self.a)))
            case "scale":
                return 1.0 + self.b * (2.0 * uniform - 1.0)
        return self.a + (self.b - self.a) * uniform

    @property
    def text(self) -> str:
        """The prior as in a sentence."""
        match self.prior:
            case "scale":
                return f"{self.name} +-{100.0 * self.b:.3g} %"
            case "normal":
                return f"{self.name} {self.a:g} +- {self.b:g}"
            case "level":
                return f"{self.name} ({self.b:g})"
        return self.name if self.prior == "share" else f"{self.name} {self.a:g} to {self.b:g}"


def factors_of(runs: Sequence[Run], priors: Mapping[str, str]) -> tuple[Factor, ...]:
    """Return what is drawn for laws: what is uncertain by default, what a prior states, and levels.

    Uncertain by default are those of `SPREAD`, what a law declares by `Parameter.spread`, the basis, and the
    rotor velocity at the start.

    Args:
        runs: with their configurations.
        priors: texts by full key: LOW..HIGH, MEAN+-DEVIATION, +-SHARE of the value; +-0 is exact.

    Raises:
        ComparisonError: a prior out of bounds, or of a key that is no number.
    """
    every = {keys: Factor(name, keys, "scale", b=spread) for name, (keys, spread) in SPREAD.items()}
    declared: dict[str, Parameter] = {}
    for run in runs:
        declared |= declared_in(dict(run.configuration))
    for key, parameter in declared.items():
        if parameter.spread > 0.0 and not any(key in keys for keys in every):
            every[key,] = Factor(key, (key,), "scale", b=parameter.spread)
    faults = []
    for key, text in priors.items():
        keys = next((keys for keys in every if key in keys), (key,))
        if key not in declared:
            faults.append(f"vary has {key}; it must be the full key of a number, as contact.clearance.")
        elif factor := _prior(key, keys, text, declared[key]):
            every[keys] = factor
            if factor.prior == "scale" and factor.b > 0.0 and not _scalable(runs, keys):
                faults.append(f"vary has {key}={text}, a share of nothing; it must be LOW..HIGH.")
        else:
            faults.append(
                f"vary has {key}={text}; it must be LOW..HIGH, MEAN+-DEVIATION or +-SHARE below 1, "
                f"{declared[key].range}."
            )
    if faults:
        raise ComparisonError(faults)
    parameters = [
        factor
        # A frequency relative to the resonance follows from the rest.
        for factor in sorted(every.values(), key=lambda each: each.keys == (FREQUENCY,))
        if not (factor.prior == "scale" and (factor.b == 0.0 or not _scalable(runs, factor.keys)))
    ]
    start = () if "rotor.initial_velocity" in priors else (Factor(START, a=-1.0),)
    return (*parameters, Factor(BASIS, prior="level", b=LEVELS[0]), *start)


def _prior(key: str, keys: tuple[str, ...], text: str, declared: Parameter) -> Factor | None:
    """Return the factor of LOW..HIGH, +-SHARE or MEAN+-DEVIATION; None of another text."""
    sign = ".." if ".." in text else "+-"
    first, split, second = (part.strip() for part in text.partition(sign))
    try:
        a = to_si(first, declared.unit) if first else 0.0
        b = to_si(second, declared.unit if first else "1")
    except (UnitError, OverflowError):
        return None
    if not split or not isfinite(a + b) or (sign == ".." and not first):
        return None
    if not first:
        name = next((name for name, (usual, _) in SPREAD.items() if usual == keys), key)
        return Factor(name, keys, "scale", b=b) if 0.0 <= b < 1.0 else None
    if sign == "+-":
        return Factor(key, (key,), "normal", a, b) if declared.admits(a) and b > 0.0 else None
    if not (a < b and declared.admits(a) and declared.admits(b)):
        return None
    return Factor(key, (key,), "log" if a > 0.0 and b / a >= WIDE else "uniform", a, b)


def _scalable(runs: Sequence[Run], keys: Sequence[str]) -> bool:
    return any(is_scalable(run, key) for run in runs for key in keys)


def is_scalable(run: Run, key: str) -> bool:
    """Return whether a run has a number under this key that a scale changes."""
    value = run.settings.get(key)
    return isinstance(value, float) and value != 0.0


def left_fixed(run: Run, factors: Sequence[Factor], priors: Mapping[str, str]) -> list[str]:
    """Return the law's own numbers, and the damping of the resonator, that nothing varies."""
    usual = {key for keys, _ in SPREAD.values() for key in keys}
    treated = usual | {key for factor in factors for key in factor.keys} | set(priors)
    if "resonator.damping_ratio" in treated or run.settings.get("resonator.damping_ratio") is not None:
        treated |= {"resonator.mass_damping", "resonator.stiffness_damping"}
    return [
        key.removeprefix("law.")
        for key in run.settings
        if (key.startswith("law.") or ("resonator." in key and "damping" in key))
        and key not in treated
        and is_scalable(run, key)
    ]


def drawn(factors: Sequence[Factor], count: int) -> Array:
    """Return the draws, shape (draw, factor)."""
    # Imported here: no other study needs scipy.stats.
    from scipy.stats import qmc

    if not factors:
        return np.empty((count, 0))
    uniform = qmc.Sobol(len(factors), seed=SEED).random(count)
    return np.column_stack([factor.at(uniform[:, i]) for i, factor in enumerate(factors)])


def as_configured(factors: Sequence[Factor], basis: int) -> Array:
    """Return the draw of the motor as configured, on a basis, shape (factor,)."""
    return np.array([basis if factor.name == BASIS else np.nan for factor in factors])


def configuration_of(
    setup: Setup, factors: Sequence[Factor], draw: Array, posterior: "Posteriors | None" = None, step: int = 0
) -> dict[str, Any]:
    """Return the configuration of a law's motor in a draw and at a step; NaN leaves a parameter."""
    other = any(factor.name == BASIS and x for factor, x in zip(factors, draw, strict=True))
    settings = flat(on_other_basis(setup)[0] if other else setup.configuration)
    settings |= {FREQUENCY: None} if is_tuned(setup) else {}
    for factor, x in zip(factors, draw.tolist(), strict=True):
        if factor.name == START and not np.isnan(x):
            settings["rotor.initial_velocity"] = x * reach(setup)
        elif factor.name == POSTERIOR and posterior and not np.isnan(x):
            settings |= posterior.values(setup, x)
        elif not np.isnan(x):
            settings |= _changed(settings, factor, x)
    control = control_of(setup)
    settings[f"solver.{control}"] /= FINER[control][step]
    return nested(settings)


def _changed(settings: Mapping[str, Any], factor: Factor, x: float) -> dict[str, float]:
    """Return the numbers that a factor changes; a law without a key has none."""
    if factor.prior != "scale":
        return {key: x for key in factor.keys if key in settings or not key.startswith("law.")}
    if factor.keys == (FREQUENCY,) and settings[FREQUENCY] is None:
        # Relative to the resonance, which other numbers of the draw may move.
        resonance = build(nested(dict(settings))).motor.modes.natural_frequency[0]
        return {FREQUENCY: x * float(resonance)}
    return {key: settings[key] * x for key in factor.keys if isinstance(settings.get(key), float)}


@final
@dataclass(frozen=True)
class Posteriors:
    """Samples of the numbers of laws from files of the study `fit`, by name of the law.

    A draw gives every law the sample at the same share of its own posterior: those of different laws are
    independent.
    """

    samples: Mapping[str, Mapping[str, Array]]

    @classmethod
    def read(cls, path: str) -> "Posteriors":
        """Read the groups of a file.

        Raises:
            ComparisonError: it is no file of the study `fit`.
        """
        file = Path(path) / "fit.nc" if Path(path).is_dir() else Path(path)
        try:
            check_declared(file)
            with xarray.open_datatree(file) as tree:
                groups = {label: fit["posterior"].to_dataset().load() for label, fit in tree.children.items()}
                if not any(data.data_vars for data in groups.values()):
                    raise ValueError("it has no posterior of a law")
        except (OSError, KeyError, ValueError) as error:
            raise ComparisonError(
                [f"posterior is '{path}', which is no file of the study fit: {error}"]
            ) from None
        return cls(
            {
                str(label).partition(" ")[0]: {
                    str(name): x.values.ravel() for name, x in data.data_vars.items()
                }
                for label, data in groups.items()
            }
        )

    def values(self, setup: Setup, share: float) -> dict[str, float]:
        """Return the numbers of a law's sample by full key; none where there is no posterior of the law."""
        known = flat(setup.configuration)
        columns = self.samples.get(setup.law.name, {})
        keys = {name if name in known else f"law.{name}": x for name, x in columns.items()}
        return {key: float(x[int(share * x.size)]) for key, x in keys.items() if key in known}


def is_tuned(setup: Setup) -> bool:
    """Return whether the drive is at the first natural frequency, which it then follows."""
    return bool(setup.configuration["drive"].get("frequency") == setup.motor.modes.natural_frequency[0])


@cache
def _converged_resonator() -> dict[str, Any]:
    return dict(build([f"resonator={CONVERGED}"]).configuration["resonator"])


def on_other_basis(setup: Setup) -> tuple[dict[str, Any], str]:
    """Return the same motor on another basis, and what differs.

    That is the converged one, one with more modes if it is that, or with a mode less if it is a file's. The
    drive stays at the first natural frequency if it is there.
    """
    configuration = setup.configuration
    resonator, drive = configuration["resonator"], configuration["drive"]
    if resonator["basis"] == "ritz":
        kept = {key: value for key, value in resonator.items() if key not in ("basis", "shapes")}
        other, change = {**_converged_resonator(), **kept}, f"resonator={CONVERGED}"
    elif resonator["basis"] == MODAL:
        fewer = max(setup.motor.modes.stiffness.size - 1, 1)
        other, change = resonator | {"modes": fewer}, f"resonator.modes={fewer}"
    elif resonator["basis"] == CONVERGED:
        more = resonator["kept_modes"] + MORE_MODES
        other, change = resonator | {"kept_modes": more}, f"resonator.kept_modes={more}"
    else:
        other, change = resonator, "the same resonator"
    frequency = {"frequency": None} if is_tuned(setup) else {}
    return {**configuration, "resonator": other, "drive": drive | frequency}, change
