"""Laws and free numbers chosen by overrides: law=A,B, law/PART=A,B, KEY=VALUE and KEY=LOW..HIGH.

A number with a value is fixed, one with a range is free in it. `setups_of` and `free_keys` choose them for a
motor, `law_predictors` for laws alone.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final, Self, final

from contactlab.config import ConfigurationError, Setup, build, compose
from contactlab.config.composition import options_of
from contactlab.config.nesting import flat, nested
from contactlab.config.schema import FRICTION, declared_in
from contactlab.inference.free_parameters import FreeParameter, chosen_range, free_parameters, label_of
from contactlab.inference.impact_problem import LawPredictor, Ranges
from contactlab.laws import (
    Composed,
    ContactLaw,
    Flores,
    HertzPoint,
    HuntCrossley,
    LuGre,
    Microslip,
    Mindlin,
    MultiplierLaw,
    Regularised,
    Stribeck,
    Thornton,
    WaltonBraun,
    registry,
)
from contactlab.laws.declaration import SHARED
from contactlab.measured.bodies import CORRECTIONS
from contactlab.quantity import UnitError, to_si
from contactlab.suggestion import suggestion

LAW: Final = "law."
PART: Final = "law/"
DATA: Final = "data."
FORMS: Final = "law=NAME,NAME, law/PART=NAME, law.NAME=VALUE or law.NAME=LOW..HIGH"

NOT_OF_A_PROBLEM: Final = ("hydra", "sweep", "record")
LASTING: Final = ("solver.duration", "solver.until", "solver.precision")
"""Groups and keys on which no prediction depends: times are those of the measurements."""

FREE_OF: Final[dict[str, tuple[str, ...]]] = {"johnson": ("friction_coefficient", "yield_strength")}
"""Free numbers of laws whose other numbers act through a product with these."""

_RANGE: Final = re.compile(r"(?P<key>[\w.]+)=(?P<low>[^=]+?)\.\.(?P<high>[^=]+)")


@final
@dataclass(frozen=True)
class LawChoice:
    """Overrides, sorted.

    Args:
        laws: names; none for the law of the data, or for the usual ones.
        parts: names of a composed law's parts by key, "law/normal".
        ranges: both ends as typed, by full key.
        overrides: all others.
    """

    laws: tuple[str, ...]
    parts: Mapping[str, tuple[str, ...]]
    ranges: Mapping[str, tuple[str, str]]
    overrides: tuple[str, ...]

    @classmethod
    def of(cls, texts: Sequence[str]) -> Self:
        """Sort overrides.

        Raises:
            ConfigurationError: a law, part or range occurs twice.
        """
        laws, others = list[str](), list[str]()
        parts, ranges = dict[str, list[str]](), dict[str, tuple[str, str]]()
        faults = []
        for text in texts:
            key, _, value = text.partition("=")
            if limits := _RANGE.fullmatch(text):
                if key in ranges:
                    faults.append(f"{key} has two ranges; it must have one. Leave one out.")
                ranges[key] = limits["low"].strip(), limits["high"].strip()
            elif key == "law":
                laws += [name.strip() for name in value.split(",")]
            elif key.startswith(PART):
                parts.setdefault(key, []).extend(name.strip() for name in value.split(","))
            else:
                others.append(text)
        for key, names in {"law": laws, **parts}.items():
            twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
            faults += [f"{key}={name} occurs twice; it must occur once. Leave one out." for name in twice]
        if faults:
            raise ConfigurationError(faults)
        return cls(tuple(laws), {key: tuple(names) for key, names in parts.items()}, ranges, tuple(others))

    @property
    def keys(self) -> list[str]:
        """All keys with a range or a value."""
        return list(dict.fromkeys([*self.ranges, *(text.partition("=")[0] for text in self.overrides)]))

    def check(self, *, of_law: bool) -> None:
        """Raise a ConfigurationError for overrides that have no effect on a problem.

        Args:
            of_law: whether the measurements are impacts, which depend on the law alone.
        """
        kind = "the law alone" if of_law else "the motor; times are those of the data"
        unused = [
            f"{key} must be left out: the measurements are of {kind}."
            for key in self.keys
            if (of_law and not key.startswith(LAW) and key != FRICTION)
            or key in LASTING
            or key.partition(".")[0].lstrip("+~") in NOT_OF_A_PROBLEM
        ]
        if unused:
            raise ConfigurationError(unused)

    def combinations(self) -> list[tuple[str, ...]]:
        """Return the overrides that choose each law; a composed law in every combination of its parts."""
        lists = [[f"{key}={name}" for name in names] for key, names in self.parts.items()]
        result: list[tuple[str, ...]] = []
        for name in self.laws:
            result += [
                (f"law={name}", *chosen) for chosen in product(*lists if name == Composed.name else ())
            ]
        return result or [()]


def setups_of(choice: LawChoice, configuration: Mapping[str, Any]) -> list[Setup]:
    """Build the setup of each law, with all that is not free.

    Among several laws, numbers `law.NAME` apply to those that have them.

    Args:
        choice: of laws, which takes precedence over the configuration.
        configuration: of the data, may be empty.

    Raises:
        ConfigurationError: with every fault.
    """
    lines = choice.combinations()
    overrides = list(choice.overrides)
    if Composed.name not in choice.laws:
        overrides += [f"{key}={','.join(names)}" for key, names in choice.parts.items()]
    applied = [[*overrides] for _ in lines]
    if len(lines) > 1:
        known = [flat(compose([*law])) for law in lines]
        applied = [[text for text in overrides if _applies(text, keys)] for keys in known]
        # The first law reports an override that applies to none.
        applied[0] += [text for text in overrides if not any(text in own for own in applied)]
    setups, faults = [], []
    for law, own in zip(lines, applied, strict=True):
        try:
            setups.append(build(_configuration([*law, *own], configuration)))
        except ConfigurationError as error:
            faults += error.faults
    if faults:
        raise ConfigurationError(list(dict.fromkeys(faults)))
    every = sorted({key for setup in setups for key in declared_in(setup.configuration)})
    unknown = [key for key in choice.ranges if key not in every] if len(setups) > 1 else []
    if unknown:
        hints = {key: suggestion(key, every, "Leave it out.") for key in unknown}
        raise ConfigurationError([f"No law here has a number {key}. {hint}" for key, hint in hints.items()])
    return setups


def _applies(text: str, known: Mapping[str, Any]) -> bool:
    key = text.partition("=")[0]
    return not key.startswith(PART) and (not key.startswith(LAW) or key in known)


def _configuration(lines: Sequence[str], configuration: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a configuration with overrides."""
    composed = compose(lines)
    if not configuration:
        return composed
    merged, fresh = dict(configuration), flat(composed)
    for line in lines:
        key = line.partition("=")[0].lstrip("+~")
        top = key.replace("/", ".").partition(".")[0]
        if options_of(key):
            # The choice of a part replaces the whole law.
            merged[top] = composed[top]
    keys = flat(merged)
    keys |= {key: fresh[key] for line in lines if (key := line.partition("=")[0].lstrip("+")) in fresh}
    return nested(keys)


def free_keys(setup: Setup, choice: LawChoice, *, several: bool) -> tuple[FreeParameter, ...]:
    """Return the free numbers of law and motor, named by full keys; those of the law with their field.

    Without ranges every number of the law without a value is free, in its declared range; among several laws
    those are free besides the ranges too.

    Args:
        setup: of the law.
        choice: ranges and values.
        several: whether several laws are compared.

    Raises:
        ConfigurationError: an unknown key, or a range that is not admitted.
    """
    known = declared_in(setup.configuration)
    every = {key_of(item.name): item for item in free_parameters(setup.law)}
    fields = {key: item.name for key, item in every.items()}
    usual = [replace(x, name=key, field=x.name) for key, x in every.items() if key not in choice.keys]
    faults, result = list[str](), list[FreeParameter]()
    for key, ends in choice.ranges.items():
        if key not in known:
            if not (key.startswith(LAW) and several):
                hint = suggestion(key, known, "contactlab --help lists the keys.")
                faults.append(f"There is no free number {key} under law={setup.law.name}. {hint}")
            continue
        declared = known[key]
        try:
            span = [to_si(end, declared.unit) for end in ends]
            result.append(replace(chosen_range(key, span, declared), field=fields.get(key, "")))
        except UnitError as error:
            faults.append(f"{key}={'..'.join(ends)} has an end {error}.")
        except ValueError as error:
            faults.append(str(error))
    if faults:
        raise ConfigurationError(faults)
    return tuple(result if choice.ranges and not several else [*result, *usual])


def numbers_of(setup: Setup, choice: LawChoice, keys: Sequence[FreeParameter]) -> str:
    """Return a sentence on the free and fixed numbers of a law, and on the keys that it does not have."""
    free = {item.name for item in keys}
    fixed = {key_of(name): value for name, value in setup.law.describe().items() if key_of(name) not in free}
    known = {*flat(setup.configuration), *free}
    absent = [key for key in choice.keys if key.startswith(LAW) and key not in known]
    return " ".join(
        [
            f"Free: {'; '.join(map(str, keys)) or 'nothing'}.",
            f"Fixed: {', '.join(f'{key} = {value:.6g}' for key, value in fixed.items()) or 'nothing'}.",
            *([f"Not a number of this law: {', '.join(absent)}."] if absent else []),
        ]
    )


def key_of(field: str) -> str:
    """Return the key of a configuration for a field of a law."""
    return FRICTION if field.rpartition(".")[2] == SHARED else f"{LAW}{field}"


def corrections_in(texts: Sequence[str]) -> tuple[list[str], tuple[FreeParameter, ...]]:
    """Separate the free numbers of measured impacts, data.NAME=LOW..HIGH, from overrides.

    Raises:
        ConfigurationError: an unknown name, no range, or one that is not admitted.
    """
    others, result = list[str](), list[FreeParameter]()
    for text in texts:
        key, _, value = text.partition("=")
        if not key.startswith(DATA):
            others.append(text)
            continue
        name, limits = key.removeprefix(DATA), _RANGE.fullmatch(text)
        if name not in CORRECTIONS:
            every = [f"{DATA}{name}" for name in CORRECTIONS]
            hint = suggestion(key, every, f"There are {', '.join(every)}.")
            raise ConfigurationError([f"There is no number {key} of the data. {hint}"])
        if key in [item.name for item in result]:
            raise ConfigurationError([f"{key} has two ranges; it must have one. Leave one out."])
        if limits is None:
            raise ConfigurationError([f"{key} is {value}; it must be a range, {key}=LOW..HIGH."])
        declared = CORRECTIONS[name]
        try:
            span = [to_si(limits[end].strip(), declared.unit) for end in ("low", "high")]
            result.append(replace(chosen_range(key, span, declared), field=name))
        except UnitError as error:
            raise ConfigurationError([f"{text} has an end {error}."]) from error
        except ValueError as error:
            raise ConfigurationError([str(error)]) from error
    return others, tuple(result)


def law_predictors(texts: Sequence[str]) -> list[LawPredictor]:
    """Return predictors of impacts under the chosen laws, by default the usual ones.

    A number with a value is fixed, one with a range is free in it; all others are free as usual.

    Raises:
        ConfigurationError: an override of another form, or an unknown name.
    """
    _check_forms(texts)
    choice = LawChoice.of(texts)
    if choice.parts and Composed.name not in choice.laws:
        choice = replace(choice, laws=(*choice.laws, Composed.name))
    result = usual_laws()
    if choice.laws:
        result = []
        for law, *parts in choice.combinations():
            named = dict(part.removeprefix(PART).split("=") for part in parts)
            try:
                result.append(usual_law(law.removeprefix("law="), **named))
            except (ValueError, TypeError) as error:
                raise ConfigurationError([str(error)]) from error
    keys = [text.partition("=")[0] for text in choice.overrides]
    if twice := [key for key in keys if keys.count(key) > 1 or key in choice.ranges]:
        raise ConfigurationError([f"{twice[0]} occurs twice; it must occur once. Leave one out."])
    changes = {key: (value,) for key, _, value in (text.partition("=") for text in choice.overrides)}
    for key, ends in {**changes, **choice.ranges}.items():
        changed = [_changed(predictor, key, ends) for predictor in result]
        if all(item is other for item, other in zip(changed, result, strict=True)):
            every = sorted({f"{LAW}{name}" for predictor in result for name in predictor.law.describe()})
            hint = suggestion(key, every, f"They have {', '.join(every) or 'none'}.")
            raise ConfigurationError([f"None of these laws has a number {key}. {hint}"])
        result = changed
    return result


def _check_forms(texts: Sequence[str]) -> None:
    """Raise a ConfigurationError if an override does not choose a law or a number of it."""
    parts = [f"{PART}{family}" for family in registry.PARTS]
    for text in texts:
        key, _, value = text.partition("=")
        if not value or not (key in ("law", FRICTION, *parts) or key.startswith(LAW)):
            hint = suggestion(key, ["law", *parts], f"Parts are {', '.join(registry.PARTS)}.")
            raise ConfigurationError([f"{text} does not choose a law; it must have the form {FORMS}. {hint}"])


def _changed(predictor: LawPredictor, key: str, ends: Sequence[str]) -> LawPredictor:
    """Return a predictor with a number fixed at one value or free between two, if its law has it."""
    law = predictor.law
    units = {name: declared.unit for name, _, declared in law.effective() if declared is not None}
    name = next((name for name in units if key in (key_of(name), f"{LAW}{name}")), None)
    if name is None:
        return predictor
    ranges: dict[str, Any] = {item.name: (item.low, item.high) for item in predictor.free}
    shown = f"{key}={'..'.join(ends)}"
    try:
        values = [to_si(end.strip(), units[name]) for end in ends]
        if len(values) == 2:
            ranges[name] = values
        else:
            law = law.changed(name, values[0])
            ranges.pop(name, None)
        return replace(predictor, law=law, free=free_parameters(law, ranges))
    except UnitError as error:
        raise ConfigurationError([f"{shown} has a value {error}; write KEY=0.3 or KEY=0.1..0.5."]) from error
    except ValueError as error:
        raise ConfigurationError([f"{shown}: {error}"]) from error


def usual_laws() -> list[LawPredictor]:
    """Return predictors of every installed rigid law and of compliant ones composed of common parts.

    A law with microslip is not among them: its impacts take 25 times as long as those of `mindlin`.
    """
    compliant = (LawPredictor.of(*item) for item in _compliant_laws())
    rigid = [name for name in registry.law_names() if issubclass(registry.class_of(name), MultiplierLaw)]
    return [
        *(usual_law(name) for name in rigid),
        *(item for item in compliant if "microslip" not in item.label),
    ]


def usual_law(name: str, **parts: str) -> LawPredictor:
    """Return the predictor of a law by its name and those of its parts, with the free numbers as usual.

    All numbers of a law that is not among the usual ones are free.

    Raises:
        ValueError: there is no such law or part.
        TypeError: the law has no such part.
    """
    made = registry.law(name, **parts)
    if not isinstance(made, MultiplierLaw):
        for item, ranges in _compliant_laws():
            if label_of(item) == label_of(made):
                return LawPredictor.of(item, ranges)
    return LawPredictor.of(made, dict.fromkeys(FREE_OF[name]) if name in FREE_OF else None)


def _compliant_laws() -> list[tuple[ContactLaw, Ranges]]:
    """Return compliant laws and what is free of them; the absolute stiffness of a spring has no effect."""
    cone: dict[str, tuple[float, float] | None] = {"friction.friction_coefficient": None}
    lossy = {"damping.restitution": None, **cone}
    # The range of the loss of Hunt and Crossley at this speed.
    slowing = {"damping.restitution": (0.4, 1.0), **cone}
    yielding = {"normal.unloading_stiffness": (1e7, 1e9), **cone}
    elastic, dent = HertzPoint(), WaltonBraun(loading_stiffness=1e7, unloading_stiffness=3e7)
    ratio = {"friction.stiffness_ratio": None}
    return [
        (registry.law("hertz_penalty"), {"friction_coefficient": None}),
        (Composed(elastic, Flores()), lossy),
        (Composed(elastic, HuntCrossley(0.8, impact_speed=1.0)), slowing),
        (Composed(Thornton()), {"normal.yield_pressure": None, **cone}),
        (Composed(dent), yielding),
        (Composed(elastic, Flores(), Mindlin()), lossy | ratio),
        (Composed(elastic, Flores(), Microslip()), lossy | ratio),
        (Composed(elastic, Flores(), Regularised()), lossy | {"friction.creep_velocity": (1e-2, 3.0)}),
        (Composed(elastic, Flores(), LuGre()), lossy | {"friction.bristle_stiffness": (1e3, 1e7)}),
        (
            Composed(elastic, Flores(), Stribeck()),
            lossy | {"friction.static_ratio": (1.0, 4.0), "friction.stribeck_velocity": (3e-2, 3.0)},
        ),
        (Composed(dent, friction=Mindlin()), yielding | ratio),
    ]
