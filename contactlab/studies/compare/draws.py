"""The population of motors: what is uncertain of them and their laws, draws for all laws, and quantities.

One draw of parameters and start serves every law: common random numbers. The draws up to each look are one
or several Latin hypercubes. They have the configured basis and step; what those change is computed for the
motor as configured.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from math import isfinite, log
from pathlib import Path
from typing import Any, ClassVar, Final, NamedTuple, Self, final

import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.checks import check_declared
from contactlab.config import Setup, build
from contactlab.config.faults import failure_of
from contactlab.config.groups import MODAL
from contactlab.config.nesting import flat, nested
from contactlab.config.schema import declared_in
from contactlab.estimate import Estimate
from contactlab.metrics import Run
from contactlab.parameter import Parameter
from contactlab.quantity import UnitError, to_si
from contactlab.results.files import digest_of_file
from contactlab.steady_state import steady
from contactlab.steady_state.basins import reach
from contactlab.steady_state.means import LONGEST, motion_of, settled
from contactlab.studies.characterise.transients import start_time
from contactlab.studies.compare.laws import ComparisonError
from contactlab.studies.compare.paired import looks_up_to
from contactlab.studies.study import Part
from contactlab.variables import Variable

SEED: Final = 0

WIDE: Final = 100.0
"""Ratio of the ends of a positive range from which on its logarithm is uniform."""
"""Seed of the draws by default."""

CONFIGURED_NUMBERS: Final = {
    "load": "rotor.load_torque",
    "preload": "contact.preload",
    "tip": "contact.tip_length",
    "radius of the rotor": "rotor.radius",
    "inertia": "rotor.inertia",
    "length of the beam": "resonator.length",
}
"""Numbers that are as configured where nothing draws them."""

START, POSTERIOR = "initial velocity", "posterior"
START_KEY: Final = "rotor.initial_velocity"
FREQUENCY: Final = "drive.frequency"
DAMPING: Final = "resonator.damping_ratio"
"""Key of the damping ratio of the first mode, with which all others are scaled."""

STEPS: Final = 3

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
    ("normal_impulse", "N s", "P_n", "normal impulse of the contact in a period of the drive"),
)}  # fmt: skip
"""Quantities of a settled motor; the first one decides when sampling ends."""

OBSERVED: Final = tuple(name for name in OBSERVABLES if name not in ("start_time", "normal_impulse"))
"""Those that are compared by default: a start takes as long as three steady states."""

ORBIT: Final = {"tip_normal_amplitude", "tip_tangential_amplitude", "rms_current"}

Distribution = float | str | Estimate | tuple[float | str, float | str]
"""What a number may be: within a share of its value, of which 0 is exact; normal, by mean and deviation; or
uniform between two ends, in SI or texts with units, or in the logarithm: 'log(2e-6..2e-5)'."""

LOG: Final = re.compile(r"log\((.+)\.\.(.+)\)")

FORMS: Final = "LOW..HIGH", "log(LOW..HIGH)", "MEAN+-DEVIATION", "+-SHARE"
"""A distribution as it is written in a command."""


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
        r"(?!(?:law|law/\w+)=)(?P<name>[\w.]+)="
        rf"(?:(?P<log>{LOG.pattern})"
        r"|(?P<first>(?:\s*[-+]?\.?\d[^,\[(]*?)?)(?P<sign>(?<!/)\.\.|\+-)(?P<second>\s*[-+]?\.?\d.*))"
    )
    """Words of a command that are one: KEY= and one of `FORMS`, of numbers, which no path has: a=b/../c."""

    name: str
    value: Distribution

    @classmethod
    def of_text(cls, text: str) -> Self:
        """Read a word; a ValueError if it is something else."""
        if not (word := cls.PATTERN.fullmatch(text)):
            raise ValueError(f"it must be KEY={' or KEY='.join(FORMS)}")
        if word["log"]:
            return cls(word["name"], word["log"])
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
            case str(text) if LOG.fullmatch(text):
                return f"{self.name}={text}"
        return f"{self.name}=+-{self.value}"


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text.strip()


@final
@dataclass(frozen=True)
class Factor:
    """What is drawn: a number of a motor or a law, or several that are scaled together.

    Args:
        name: of the factor.
        kind: 'share' and 'shift' change the value by a factor and by a sum; 'uniform', 'log' and 'normal'
            are distributions in its place.
        a, b: share or shift at most; ends, or mean and deviation, in SI.
        keys: of the configuration; those that a law lacks are left out.
        unit: as it is read, with a space before it.
    """

    name: str
    kind: str
    a: float
    b: float = 0.0
    keys: tuple[str, ...] = ()
    unit: str = ""

    def at(self, uniform: Array) -> Array:
        """Return values at numbers distributed evenly from 0 to 1; of a share, factors of the value."""
        if self.kind == "normal":
            # Imported here: no other study needs scipy.stats.
            from scipy.stats import norm

            return np.asarray(norm.ppf(np.clip(uniform, 1e-9, 1.0 - 1e-9), self.a, self.b))
        if self.kind == "log":
            return np.asarray(self.a * np.exp(uniform * log(self.b / self.a)))
        if self.kind == "uniform":
            return self.a + (self.b - self.a) * uniform
        return float(self.kind == "share") + self.a * (2.0 * uniform - 1.0)

    @property
    def text(self) -> str:
        """The factor as in a sentence."""
        match self.kind:
            case "share":
                return f"{self.name} +-{100.0 * self.a:.3g} %"
            case "shift":
                return f"{self.name} +-{self.a:g}{self.unit}"
            case "normal":
                return f"{self.name} {self.a:g} +- {self.b:g}{self.unit}"
        ends = f"{self.name} {self.a:g} to {self.b:g}{self.unit}{' (log)' if self.kind == 'log' else ''}"
        return ends if self.keys else self.name


USUAL: Final = (
    Factor("friction coefficient", "share", 0.33, keys=("contact.friction_coefficient",)),
    Factor("contact stiffness", "share", 0.3, keys=("law.stiffness", "law.normal.stiffness")),
    Factor("clearance", "share", 0.2, keys=("contact.clearance",)),
    Factor("preload", "share", 0.2, keys=("contact.preload",)),
    Factor(
        "damping ratio", "log", 0.002, 0.2, (DAMPING, "resonator.mass_damping", "resonator.stiffness_damping")
    ),
    Factor("drive frequency", "share", 0.02, keys=(FREQUENCY,)),
    Factor("phase", "shift", 0.3, keys=("drive.phase",), unit=" rad"),
    Factor("voltage", "share", 0.2, keys=("drive.voltage_1", "drive.voltage_2")),
)
"""What is uncertain by default. Dry steel has a friction of 0.2 to 0.4; a tip whose radius is half as large,
or 1.7 times, has 0.7 or 1.3 of the stiffness; lapped surfaces are 0.2 um and 1 um apart; steel has a damping
ratio of 0.002, the paper's motor 0.13; a frequency drifts with the temperature."""


def factors_of(runs: Sequence[Run], priors: Mapping[str, Distribution]) -> tuple[Factor, ...]:
    """Return what is drawn for laws: what is uncertain by default and what a prior states.

    Uncertain by default are `USUAL`, what a law declares by `Parameter.spread`, and the rotor velocity at the
    start; not a damping that differs between operating points.

    Args:
        runs: with their configurations.
        priors: by full key.

    Raises:
        ComparisonError: a prior out of bounds, or of a key that is no number.
    """
    apart = [key for x in USUAL for key in x.keys if len({run.settings.get(key) for run in runs}) > 1]
    every = {x.keys: x for x in USUAL if DAMPING not in x.keys or {*apart}.isdisjoint(x.keys)}
    declared: dict[str, Parameter] = {}
    for run in runs:
        declared |= declared_in(dict(run.configuration))
    # Every resonator has damping, if no key of it.
    declared[DAMPING] = Parameter("zeta", "1", "damping ratio", above=0.0, below=1.0)
    for key, parameter in declared.items():
        if parameter.spread > 0.0 and not any(key in keys for keys in every):
            every[key,] = Factor(key, "share", parameter.spread, keys=(key,))
    faults = []
    for key, prior in priors.items():
        usual = next((x for keys, x in every.items() if key in keys), Factor(key, "share", 0.0, keys=(key,)))
        if key not in declared:
            faults.append(f"vary has {key}; it must be the full key of a number, as contact.clearance.")
        elif not (factor := _factor(usual, key, prior, declared[key])):
            faults.append(
                f"vary has {Prior(key, prior)}; it must be {' or '.join(FORMS)}, a share below 1, "
                f"{declared[key].range}."
            )
        elif factor.kind == "share" and factor.a > 0.0 and not _applies(factor, runs):
            faults.append(f"vary has {Prior(key, prior)}, a share of nothing; it must have two ends.")
        else:
            every.pop(usual.keys, None)
            every[factor.keys] = factor
    if faults:
        raise ComparisonError(faults)
    # A frequency relative to the resonance follows from the rest.
    ordered = sorted(every.values(), key=lambda factor: factor.keys == (FREQUENCY,))
    start = () if START_KEY in priors else (Factor(START, "uniform", -1.0, 1.0),)
    some = (x for x in ordered if _applies(x, runs) and not (x.kind == "share" and x.a == 0.0))
    return (*some, *start)


def _applies(factor: Factor, runs: Sequence[Run]) -> bool:
    """Return whether a run has what a factor changes."""
    if factor.kind not in ("share", "shift") or DAMPING in factor.keys:
        return True
    return any(
        is_scalable(run, key, factor.kind) and _counts(run, key) for run in runs for key in factor.keys
    )


def _counts(run: Run, key: str) -> bool:
    """Return whether a motor depends on a number: on the clearance it does not if a preload closes it."""
    closed = run.settings.get("contact.preload") and not run.settings.get("rotor.bearing_stiffness")
    return key != "contact.clearance" or not closed


def _factor(usual: Factor, key: str, prior: Distribution, declared: Parameter) -> Factor | None:
    """Return the factor of a prior, None of a faulty one; a share applies to all keys of the usual one."""
    word = LOG.fullmatch(prior) if isinstance(prior, str) else None
    try:
        if not (word or isinstance(prior, tuple | list)):
            share = to_si(prior, "1") if isinstance(prior, str) else float(prior)
            return Factor(usual.name, "share", share, keys=usual.keys) if 0.0 <= share < 1.0 else None
        both: Any = [_number(x) for x in word.groups()] if word else prior
        a, b = (to_si(x, declared.unit) if isinstance(x, str) else float(x) for x in both)
    except (UnitError, OverflowError, TypeError, ValueError):
        return None
    normal = isinstance(prior, Estimate)
    if not (isfinite(a) and isfinite(b) and declared.admits(a)) or (word and a <= 0.0):
        return None
    if (normal and b <= 0.0) or not (normal or (a < b and declared.admits(b))):
        return None
    kind = "normal" if normal else "log" if word or (a > 0.0 and b / a >= WIDE) else "uniform"
    # The damping ratio is that of the first mode; other keys of damping are set by themselves.
    name, keys = (usual.name, usual.keys) if key == DAMPING else (key, (key,))
    return Factor(name, kind, a, b, keys, declared.label)


def is_scalable(run: Run, key: str, kind: str = "share") -> bool:
    """Return whether a run has a number under this key that a scale, or a shift, changes."""
    value = run.settings.get(key)
    return isinstance(value, float) and (value != 0.0 or kind == "shift")


def left_fixed(run: Run, factors: Sequence[Factor], priors: Mapping[str, Distribution]) -> list[str]:
    """Return the law's own numbers that nothing varies."""
    treated = {key for factor in (*USUAL, *factors) for key in factor.keys} | set(priors)
    return [
        key.removeprefix("law.")
        for key in run.settings
        if key.startswith("law.") and key not in treated and is_scalable(run, key)
    ]


def as_configured(runs: Sequence[Run], factors: Sequence[Factor]) -> list[str]:
    """Return what the motor has as configured in all draws, beside the laws' own numbers."""
    varied = {key for factor in factors for key in factor.keys}
    numbers = {
        name: key for name, key in CONFIGURED_NUMBERS.items() if isinstance(runs[0].settings.get(key), float)
    }
    return [name for name, key in numbers.items() if key not in varied] if runs else []


def drawn(factors: Sequence[Factor], count: int, seed: int = SEED) -> Array:
    """Return the draws, shape (draw, factor); those up to a look are the first ones of any greater number.

    Each block between two looks is a Latin hypercube, sliced by the sense of the rotor at the start (Qian
    2012, J. Am. Stat. Assoc. 107, 393): the halves that start backwards and forwards are Latin hypercubes
    themselves, so that every other factor has as many starts of either sense in each part of its range. The
    places are independent otherwise. Points of a sequence of low discrepancy are not: of a Sobol' sequence
    some quarters of one factor are halves of another.

    Args:
        factors: what is drawn.
        count: of the draws.
        seed: of the places.
    """
    starts = [factor.name == START or START_KEY in factor.keys for factor in factors]
    looks = [0, *looks_up_to(count)]
    blocks = [_hypercube(until - since, np.array(starts), [seed, since]) for since, until in pairwise(looks)]
    uniform = np.concatenate(blocks)
    every = [factor.at(uniform[:, n]) for n, factor in enumerate(factors)]
    return np.reshape(every, (len(factors), count)).T


def _hypercube(count: int, starts: NDArray[np.bool_], seed: Sequence[int]) -> Array:
    """Return points of a Latin hypercube in two slices in turn, shape (draw, factor), from 0 to 1.

    Args:
        count: of the points; of an odd number the last one is anywhere.
        starts: whether a factor is the start, whose halves are the slices.
        seed: of the places.
    """
    rng, half = np.random.default_rng(seed), -(-count // 2)
    shape = (half, 2, starts.size)
    cells = rng.permuted(np.broadcast_to(np.arange(half)[:, None, None], shape), axis=0)
    # Each of `half` parts of a range has a point of either slice, one in its lower and one in its upper half.
    upper = rng.integers(2, size=(half, starts.size))
    upper = np.take_along_axis(np.stack([upper, 1 - upper], axis=1), cells, axis=0)
    slices = np.arange(2)[:, None]
    places = np.where(starts, cells + half * slices, 2 * cells + upper) + rng.random(shape)
    return np.asarray(places.reshape(2 * half, starts.size)[:count] / (2 * half))


def configuration_of(
    setup: Setup, factors: Sequence[Factor], draw: Array, posterior: "Posteriors | None" = None
) -> dict[str, Any]:
    """Return the configuration of a law's motor in a draw, but for the damping of `damped`."""
    settings = flat(setup.configuration)
    settings |= {FREQUENCY: None} if is_tuned(setup) else {}
    for factor, x in zip(factors, draw.tolist(), strict=True):
        if factor.name == START:
            settings[START_KEY] = x * reach(setup)
        elif factor.name == POSTERIOR and posterior:
            settings |= posterior.values(setup, x)
        elif DAMPING not in factor.keys:
            settings |= _changed(settings, factor, x)
    return nested(settings)


def _changed(settings: Mapping[str, Any], factor: Factor, x: float) -> dict[str, float]:
    """Return the numbers that a factor changes; a law without a key has none."""
    if factor.kind not in ("share", "shift"):
        return {key: x for key in factor.keys if key in settings or not key.startswith("law.")}
    if factor.keys == (FREQUENCY,) and settings[FREQUENCY] is None:
        # Relative to the resonance, which other numbers of the draw may move.
        resonance = build(nested(dict(settings))).motor.modes.natural_frequency[0]
        return {FREQUENCY: x * float(resonance)}
    some = {key: x0 for key in factor.keys if isinstance(x0 := settings.get(key), float)}
    return {key: x0 * x if factor.kind == "share" else x0 + x for key, x0 in some.items()}


def damped(setup: Setup, factors: Sequence[Factor], draw: Array) -> Setup:
    """Return a setup with the damping ratio of a draw in its first mode, and others scaled with it.

    Without damping all modes have that ratio.
    """
    for factor, x in zip(factors, draw.tolist(), strict=True):
        if DAMPING in factor.keys:
            modes = setup.motor.modes
            elastic = modes.stiffness > 0.0
            ratio = modes.damping[elastic][0] / (2.0 * np.sqrt(modes.stiffness[elastic][0]))
            if factor.kind == "share":
                damping = x * modes.damping
            elif ratio > 0.0:
                damping = x / ratio * modes.damping
            else:
                damping = 2.0 * x * np.sqrt(modes.stiffness)
            setup = replace(setup, motor=replace(setup.motor, modes=replace(modes, damping=damping)))
    return setup


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
                f"posterior is '{path}', which is no file of the study fit: {error}"
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


@final
class Drawn(NamedTuple):
    """A motor to be computed under every law.

    Args:
        laws: setups, or their configurations, by law.
        factors, draw: what is changed, and where to; nothing of a motor as configured.
        posterior: of the laws' numbers.
    """

    laws: Mapping[str, Any]
    factors: tuple[Factor, ...] = ()
    draw: Array = np.empty(0)
    posterior: "Posteriors | None" = None

    def under(self, law: str) -> Setup:
        """Return the motor under a law."""
        setup: Setup = each if isinstance(each := self.laws[law], Setup) else build(each)
        if not self.factors:
            return setup
        changed = build(configuration_of(setup, self.factors, self.draw, self.posterior))
        return damped(changed, self.factors, self.draw)


def do_draw(motor: Drawn, names: Sequence[str]) -> Part:
    """Return the quantities of one motor under every law, with statistical errors."""
    values, errors = np.full((2, len(motor.laws), len(names)), np.nan)
    failures: list[str] = []
    for row, law in enumerate(motor.laws):
        failures.append("")
        try:
            _, numbers = observed(motor.under(law), names)
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
    if "normal_impulse" in names:
        force = state.average("normal_force")
        result["normal_impulse"] = Estimate(state.period * force.value, state.period * force.error)
    if "stall_torque" in names:
        result["stall_torque"] = steady(setup, belt=0.0, longest=LONGEST).torque
    if "start_time" in names:
        result["start_time"] = start_time(setup, state.velocity.value)
    return state.kind, result
