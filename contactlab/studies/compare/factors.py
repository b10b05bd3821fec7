"""What is drawn of motors and laws: what is uncertain by default, and what priors state."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, log
from typing import Any, Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config.schema import declared_in
from contactlab.estimate import Estimate
from contactlab.metrics import Run
from contactlab.parameter import Parameter
from contactlab.quantity import UnitError, to_si
from contactlab.studies.compare.laws import ComparisonError
from contactlab.studies.compare.priors import FORMS, LOG, Distribution, Prior, number_in

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
WIDE: Final = 100.0
"""Ratio of the ends of a positive range from which on its logarithm is uniform."""

DAMPING: Final = "resonator.damping_ratio"
"""Key of the damping ratio of the first mode, with which all others are scaled."""


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
    for run in runs:
        # A preload that closes the clearance leaves nothing of it, but where a bearing yields.
        closed = run.settings.get("contact.preload") and not run.settings.get("rotor.bearing_stiffness")
        keys = [key for key in factor.keys if is_scalable(run, key, factor.kind)]
        if any(key != "contact.clearance" or not closed for key in keys):
            return True
    return False


def _factor(usual: Factor, key: str, prior: Distribution, declared: Parameter) -> Factor | None:
    """Return the factor of a prior, None of a faulty one; a share applies to all keys of the usual one."""
    word = LOG.fullmatch(prior) if isinstance(prior, str) else None
    try:
        if not (word or isinstance(prior, tuple | list)):
            share = to_si(prior, "1") if isinstance(prior, str) else float(prior)
            return Factor(usual.name, "share", share, keys=usual.keys) if 0.0 <= share < 1.0 else None
        both: Any = [number_in(x) for x in word.groups()] if word else prior
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
