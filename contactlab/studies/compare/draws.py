"""What is uncertain of a motor and its laws, draws that serve all laws alike, and the quantities of a draw.

One draw of parameters, basis and start serves every law: common random numbers. Draws are points of a
scrambled Sobol' sequence, whose first 16, 32, 64 points are designs of their own. They have the configured
step; what that changes is computed for the motor as configured.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import isfinite, log
from pathlib import Path
from typing import Any, ClassVar, Final, Self, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.checks import check_declared
from contactlab.config import Setup, build
from contactlab.config.faults import failure_of
from contactlab.config.nesting import flat, nested
from contactlab.config.resonators import MODAL
from contactlab.config.schema import declared_in
from contactlab.estimate import Estimate
from contactlab.inference.free_parameters import WIDE
from contactlab.metrics import Run
from contactlab.metrics.convergence import FINER, control_of
from contactlab.parameter import Parameter
from contactlab.quantity import UnitError, to_si
from contactlab.results.files import digest_of_file
from contactlab.steady_state import steady
from contactlab.steady_state.basins import reach
from contactlab.steady_state.means import LONGEST, motion_of, settled
from contactlab.studies.characterise.transients import start_time
from contactlab.studies.compare.laws import ComparisonError
from contactlab.studies.study import Part
from contactlab.variables import Variable

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

BASES, STEPS = LEVELS = 2, 3
"""Numbers of bases and of steps."""

CONVERGED: Final = "finite_element"
"""Option of the group `resonator` with the converged basis."""

MORE_MODES: Final = 4
"""Modes that are added to a converged basis."""

OBSERVABLES: Final = {name: Variable(name, (), *rest) for name, *rest in (
    ("rotor_velocity", "rad s-1", "Omega", "settled rotor velocity"),
    ("stall_torque", "N m", "M_0", "mean torque of the contact on a rotor held at rest"),
    ("start_time", "s", "t_90", "time from the start to 90 % of the settled velocity"),
    ("tip_normal_amplitude", "m", "a_n", "normal amplitude of the tip, half its range"),
    ("tip_tangential_amplitude", "m", "a_t", "tangential amplitude of the tip, half its range"),
    ("rms_current", "A", "I_rms", "current of the electrodes, root mean square over both and time"),
)}  # fmt: skip
"""Quantities of a settled motor; the first one decides when sampling ends."""

USUAL: Final = tuple(name for name in OBSERVABLES if name != "start_time")
"""Those that are compared by default: a start takes as long as three steady states."""

ORBIT: Final = {"tip_normal_amplitude", "tip_tangential_amplitude", "rms_current"}

Distribution = float | str | Estimate | tuple[float | str, float | str]
"""What a number may be: within a share of its value, of which 0 is exact; normal, by mean and deviation; or
uniform between two ends, in SI or texts with units."""


@final
@dataclass(frozen=True)
class Prior:
    """What a number of a motor or a law may be.

    >>> Prior.of_text("rotor.inertia=+-0.1"), str(Prior("drive.phase", Estimate(-0.6, 0.05)))
    (Prior(name='rotor.inertia', value=0.1), 'drive.phase=-0.6+-0.05')

    Args:
        name: of the number, as a full key.
        value: its distribution.
    """

    PATTERN: ClassVar[re.Pattern[str]] = re.compile(
        r"(?!(?:law|law/\w+)=)(?P<name>[\w.]+)=(?P<first>[^,\[(]*?)(?P<sign>\.\.|\+-)(?P<second>.+)"
    )
    """Words of a command that are one: KEY=LOW..HIGH, KEY=MEAN+-DEVIATION, KEY=+-SHARE."""

    name: str
    value: Distribution

    @classmethod
    def of_text(cls, text: str) -> Self:
        """Read a word; a ValueError if it is something else."""
        if not (word := cls.PATTERN.fullmatch(text)):
            raise ValueError("it must be KEY=LOW..HIGH, KEY=MEAN+-DEVIATION or KEY=+-SHARE")
        ends: Any = [_number(word["first"]), _number(word["second"])]
        if word["sign"] == "..":
            return cls(word["name"], tuple(ends))
        return cls(word["name"], Estimate(*ends) if word["first"] else ends[1])

    def __str__(self) -> str:
        match self.value:
            case Estimate(mean, deviation):
                return f"{self.name}={mean}+-{deviation}"
            case (low, high):
                return f"{self.name}={low}..{high}"
        return f"{self.name}=+-{self.value}"


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text.strip()


@final
@dataclass(frozen=True)
class Factor:
    """What is drawn: a number of a motor or a law, or a level.

    Args:
        name: of the factor.
        value: its distribution in SI, of a level the number of them.
        keys: of the configuration; those that a law lacks are left out.
    """

    name: str
    value: float | Estimate | tuple[float, float]
    keys: tuple[str, ...] = ()

    def at(self, uniform: Array) -> Array:
        """Return values at numbers distributed evenly from 0 to 1; of a share, factors of the value."""
        match self.value:
            case Estimate(mean, deviation):
                # Imported here: no other study needs scipy.stats.
                from scipy.stats import norm

                return np.asarray(norm.ppf(np.clip(uniform, 1e-9, 1.0 - 1e-9), mean, deviation))
            case (low, high) if low > 0.0 and high / low >= WIDE:
                return np.asarray(low * np.exp(uniform * log(high / low)))
            case (low, high):
                return low + (high - low) * uniform
            case share if self.keys:
                return 1.0 + share * (2.0 * uniform - 1.0)
        return np.floor(self.value * uniform)

    @property
    def text(self) -> str:
        """The factor as in a sentence."""
        match self.value:
            case Estimate(mean, deviation):
                return f"{self.name} {mean:g} +- {deviation:g}"
            case (low, high):
                return f"{self.name} {low:g} to {high:g}" if self.keys else self.name
            case share if self.keys:
                return f"{self.name} +-{100.0 * share:.3g} %"
        return f"{self.name} ({self.value:g})"


def factors_of(runs: Sequence[Run], priors: Mapping[str, Distribution]) -> tuple[Factor, ...]:
    """Return what is drawn for laws: what is uncertain by default, what a prior states, and levels.

    Uncertain by default are those of `SPREAD`, what a law declares by `Parameter.spread`, the basis, and the
    rotor velocity at the start.

    Args:
        runs: with their configurations.
        priors: by full key.

    Raises:
        ComparisonError: a prior out of bounds, or of a key that is no number.
    """
    every = {keys: Factor(name, spread, keys) for name, (keys, spread) in SPREAD.items()}

    def scalable(factor: Factor) -> bool:
        return any(is_scalable(run, key) for run in runs for key in factor.keys)

    declared: dict[str, Parameter] = {}
    for run in runs:
        declared |= declared_in(dict(run.configuration))
    for key, parameter in declared.items():
        if parameter.spread > 0.0 and not any(key in keys for keys in every):
            every[key,] = Factor(key, parameter.spread, (key,))
    faults = []
    for key, prior in priors.items():
        usual = next((factor for keys, factor in every.items() if key in keys), Factor(key, 0.0, (key,)))
        if key not in declared:
            faults.append(f"vary has {key}; it must be the full key of a number, as contact.clearance.")
        elif factor := _factor(usual, key, prior, declared[key]):
            every[usual.keys] = factor
            if isinstance(factor.value, float) and factor.value > 0.0 and not scalable(factor):
                faults.append(f"vary has {Prior(key, prior)}, a share of nothing; it must have two ends.")
        else:
            faults.append(
                f"vary has {Prior(key, prior)}; it must be LOW..HIGH, MEAN+-DEVIATION or +-SHARE below 1, "
                f"{declared[key].range}."
            )
    if faults:
        raise ComparisonError(faults)
    # A frequency relative to the resonance follows from the rest.
    ordered = sorted(every.values(), key=lambda factor: factor.keys == (FREQUENCY,))
    parameters = [x for x in ordered if not isinstance(x.value, float) or (x.value > 0.0 and scalable(x))]
    start = () if "rotor.initial_velocity" in priors else (Factor(START, (-1.0, 1.0)),)
    return (*parameters, Factor(BASIS, BASES), *start)


def _factor(usual: Factor, key: str, prior: Distribution, declared: Parameter) -> Factor | None:
    """Return the factor of a prior, None of a faulty one; a share applies to all keys of the usual one."""
    try:
        if not isinstance(prior, tuple | list):
            share = to_si(prior, "1") if isinstance(prior, str) else float(prior)
            return Factor(usual.name, share, usual.keys) if 0.0 <= share < 1.0 else None
        a, b = (to_si(x, declared.unit) if isinstance(x, str) else float(x) for x in prior)
    except (UnitError, OverflowError, TypeError, ValueError):
        return None
    normal = isinstance(prior, Estimate)
    if not (isfinite(a) and isfinite(b) and declared.admits(a)):
        return None
    if (normal and b <= 0.0) or not (normal or (a < b and declared.admits(b))):
        return None
    return Factor(key, Estimate(a, b) if normal else (a, b), (key,))


def is_scalable(run: Run, key: str) -> bool:
    """Return whether a run has a number under this key that a scale changes."""
    value = run.settings.get(key)
    return isinstance(value, float) and value != 0.0


def left_fixed(run: Run, factors: Sequence[Factor], priors: Mapping[str, Distribution]) -> list[str]:
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
    if not isinstance(factor.value, float):
        return {key: x for key in factor.keys if key in settings or not key.startswith("law.")}
    if factor.keys == (FREQUENCY,) and settings[FREQUENCY] is None:
        # Relative to the resonance, which other numbers of the draw may move.
        resonance = build(nested(dict(settings))).motor.modes.natural_frequency[0]
        return {FREQUENCY: x * float(resonance)}
    return {key: settings[key] * x for key in factor.keys if isinstance(settings.get(key), float)}


@final
@dataclass(frozen=True)
class Posteriors:
    """Samples of the numbers of laws from a file of the study `fit`, by name of the law.

    A draw gives every law the sample at the same share of its own posterior: those of different laws are
    independent.
    """

    samples: Mapping[str, Mapping[str, Array]]
    digest: str

    @classmethod
    def read(cls, path: str | Path) -> "Posteriors":
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
        samples = {
            str(label).partition(" ")[0]: {str(name): x.values.ravel() for name, x in data.items()}
            for label, data in groups.items()
        }
        return cls(samples, digest_of_file(file))

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


def do_draw(configurations: Mapping[str, Mapping[str, Any] | Setup], names: Sequence[str]) -> Part:
    """Return the quantities of one motor under every law, with statistical errors."""
    values, errors = np.full((2, len(configurations), len(names)), np.nan)
    failures: list[str] = []
    for row, each in enumerate(configurations.values()):
        failures.append("")
        try:
            _, numbers = observed(each if isinstance(each, Setup) else build(each), names)
            values[row], errors[row] = np.transpose([numbers[name] for name in names])
        # A law of another package may fail in any way, and must not stop the others.
        except Exception as error:
            failures[-1] = failure_of(error)
    both = ("law", "quantity")
    data = {"value": (both, values), "error": (both, errors), "failure": ("law", failures)}
    return Part(xarray.DataTree(xarray.Dataset(data)))


def observed(setup: Setup, names: Sequence[str]) -> tuple[str, dict[str, Estimate]]:
    """Return the kind of the steady state and its quantities.

    Raises:
        BrokenOffError, NotSettledError: there is none.
    """
    state = settled(setup)
    result = {"rotor_velocity": state.velocity}
    if ORBIT & set(names):
        run = motion_of(state)
        for name in ("normal", "tangential"):
            values = run.series[f"tip_{name}_displacement"]
            # Of a motion of many periods, the difference of both halves.
            ends = [float(np.ptp(part)) for part in np.array_split(values, 2)]
            error = 0.0 if state.periods > 0 else 0.5 * abs(ends[0] - ends[1])
            result[f"tip_{name}_amplitude"] = Estimate(0.5 * float(np.ptp(values)), error)
        square = float(np.mean(run.currents[:, 1:] ** 2))
        result["rms_current"] = Estimate(float(np.sqrt(square)), 0.0)
    if "stall_torque" in names:
        result["stall_torque"] = steady(setup, belt=0.0, longest=LONGEST).torque
    if "start_time" in names:
        result["start_time"] = start_time(setup, state.velocity.value)
    return state.kind, result
