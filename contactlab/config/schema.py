"""Check of a configuration against the declarations of its keys and the relations of several keys."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from types import NoneType
from typing import Any, Final, NamedTuple, get_args, get_origin

from contactlab.checks import MOST_RECORDS, RECORD_SIZE, SMALLEST_STEP, is_kind, size_of
from contactlab.config.groups import ADDED, DURATION, GROUPS, LAW, MOTOR, OF_MOTOR, PLANTS, Keys, Section
from contactlab.config.nesting import flat
from contactlab.config.options import full_keys, known_keys, unknown_key
from contactlab.laws.base import PenaltyLaw
from contactlab.laws.declaration import SHARED
from contactlab.laws.registry import law_class
from contactlab.motor.drive import samples_of_chirp
from contactlab.motor.waveform import MOST_SAMPLES
from contactlab.parameter import DeclaredField, Parameter
from contactlab.quantity import MISSING, UnitError, describe, number_of
from contactlab.settling.criterion import LONGEST, PRECISION, STEADY

FRICTION = f"contact.{SHARED}"
"""Key of the friction coefficient that laws share."""

Values = Mapping[str, Any]


class Rule(NamedTuple):
    """Relation of several keys: the keys, whether their values satisfy it, and the fault for `str.format`."""

    keys: tuple[str, ...]
    holds: Callable[..., bool]
    fault: str


RULES: Final = (
    Rule(
        ("placement.start", "placement.end", "resonator.length"),
        lambda start, end, length: start < end <= 0.5 * length,
        "placement.start is {0:.12g} m and placement.end is {1:.12g} m; they must satisfy 0 m <= start < end "
        "<= half of resonator.length, {2:.12g} m, to lie on the beam and clear of their mirror image.",
    ),
    Rule(
        ("piezoceramic.c11", "piezoceramic.c12", "piezoceramic.c13", "piezoceramic.c33"),
        lambda c11, c12, c13, c33: c11 > abs(c12) and (c11 + c12) * c33 > 2.0 * c13**2,
        "piezoceramic has c11 = {0:g}, c12 = {1:g}, c13 = {2:g}, c33 = {3:g} Pa, a tensor of negative "
        "energy; it must satisfy c11 > |c12| and (c11 + c12) c33 > 2 c13^2.",
    ),
    Rule(
        ("contact.clearance", "resonator.beam_thickness"),
        lambda clearance, thickness: clearance <= thickness,
        "contact.clearance is {0:.12g} m; it must be at most {1:.12g} m, the resonator.beam_thickness, "
        "since the beam is linear. 1e-06 m is usual.",
    ),
    Rule(
        ("resonator.rod_length", "contact.tip_length"),
        lambda rod, tip: rod is None or rod == tip,
        "resonator.rod_length is {0:.12g} m; it must be contact.tip_length, {1:.12g} m, that of the tip.",
    ),
    Rule(
        ("drive.first_frequency", "drive.last_frequency", "drive.duration"),
        lambda *chirp: samples_of_chirp(*chirp) <= MOST_SAMPLES,
        "drive.duration is {2:.12g} s; it must be shorter, or drive.first_frequency, {0:.12g} Hz, and "
        "drive.last_frequency, {1:.12g} Hz, lower: a chirp takes 21 samples a turn, and at most "
        f"{MOST_SAMPLES}.",
    ),
    Rule(
        ("solver.contact_step", "solver.duration"),
        lambda step, duration: step is None or SMALLEST_STEP * duration <= step <= duration,
        "solver.contact_step is {0:.12g} s; it must be at least 1e-12 of the solver.duration, {1:.12g} s, "
        "and at most that. Leave it out for the law's own default.",
    ),
    Rule(
        ("solver.precision", "solver.until"),
        lambda precision, until: precision == PRECISION or until == STEADY,
        "solver.precision is {0:g} and solver.until is {1}; it must come with solver.until=steady.",
    ),
    Rule(
        ("solver.changes", "solver.until"),
        lambda changes, until: not changes or until != STEADY,
        "solver.changes is {0}; it must be null with solver.until=steady.",
    ),
    Rule(
        ("solver.tolerance", "law.name", "solver.contact_step"),
        lambda tolerance, law, step: (
            tolerance is None or step is None or issubclass(law_class(law), PenaltyLaw)
        ),
        "solver.tolerance is {0:g}; it must be null with law={1} and solver.contact_step={2:g}: time "
        "stepping has no tolerance. Leave one of the two out.",
    ),
    Rule(
        ("record.interval", "solver.duration"),
        lambda interval, duration: interval is None or 1.0 <= duration / interval <= MOST_RECORDS,
        "record.interval is {0:.12g} s; it must be at most the solver.duration, {1:.12g} s, and give at most "
        f"{MOST_RECORDS} records, {size_of(MOST_RECORDS * RECORD_SIZE)}. Records do not change the motion.",
    ),
    *(
        Rule(
            ("contact.preload", f"rotor.{name}"),
            lambda preload, value: preload is not None or not value,
            f"rotor.{name} is {{1}}; it must come with a contact.preload: without one the axle is fixed.",
        )
        for name in ("mass", "bearing_stiffness", "bearing_damping")
    ),
)

_KINDS: Final = {bool: "true or false", str: "a text", list[str]: "a list of texts", NoneType: "null"}

KEYS: Final[Keys] = {"law": LAW, **GROUPS}
"""All that a run's configuration has."""

_OF_PLANTS: Final[Keys] = {
    **{name: section for name, section in KEYS.items() if name not in OF_MOTOR},
    "contact": Section({"default": {SHARED: GROUPS["contact"].options["default"][SHARED]}}),
}
"""All that the configuration of a run of a small plant has."""


def of_plant(configuration: Values) -> tuple[Keys, Values, dict[str, Any]]:
    """Return the keys of a motor or of a small plant, and its configuration without what the other has.

    Of a plant there are also the numbers of a motor that are not the usual ones, by full key.
    """
    plant = configuration.get("plant", {"name": MOTOR})
    if plant == {"name": MOTOR}:
        keys = {name: section for name, section in KEYS.items() if name != "plant"}
        return keys, {name: section for name, section in configuration.items() if name != "plant"}, {}
    if not isinstance(plant, Mapping) or plant.get("name") not in PLANTS:
        return KEYS, configuration, {}
    usual = {
        f"{group}.{key}": field.default
        for group in OF_MOTOR
        for key, field in full_keys(next(iter(GROUPS[group].options.values())))
    }
    numbers = flat({group: configuration[group] for group in OF_MOTOR if group in configuration})
    friction = {SHARED: numbers.pop(FRICTION)} if FRICTION in numbers else {}
    others = {name: section for name, section in configuration.items() if name not in OF_MOTOR}
    unusual = {key: value for key, value in numbers.items() if key not in usual or value != usual[key]}
    return _OF_PLANTS, {**others, "contact": friction}, unusual


class Examination:
    """Result of the check of a configuration.

    Args:
        configuration: nested values.
        keys: all that it may have.
        rules: relations of its keys.

    Attributes:
        values: those that are sound in themselves, in SI.
        faults: key, value and bound, a sentence each.
        follows: of a small plant, numbers of a motor that must be those that follow from it, by full key.
    """

    def __init__(self, configuration: Any, keys: Keys = KEYS, rules: Sequence[Rule] = RULES) -> None:
        self.values: dict[str, Any] = {}
        self.faults: list[str] = []
        if not isinstance(configuration, Mapping):
            self.faults.append(f"The configuration is {describe(configuration)}; it must be a mapping.")
            return
        self.follows: Mapping[str, Any] = {}
        if keys is KEYS:
            keys, configuration, self.follows = of_plant(configuration)
        law = configuration.get("law")
        self._law = str(law.get("name") if isinstance(law, Mapping) else None)
        self.values = self._values(keys, configuration)
        solver = self.values.get("solver", {})
        if "duration" in solver and solver["duration"] is None:
            solver["duration"] = LONGEST if solver.get("until") == STEADY else DURATION
        sound = flat(self.values)
        for rule in rules:
            values = [sound[key] for key in rule.keys if key in sound]
            # A rule with a faulty key is not checked.
            if len(values) == len(rule.keys) and not rule.holds(*values):
                self.faults.append(rule.fault.format(*values))

    def _values(
        self, keys: Keys, section: Mapping[str, Any], before: str = "", option: str = ""
    ) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for name, below in keys.items():
            key = f"{before}{name}"
            try:
                if name not in section:
                    if key in ADDED and isinstance(below, DeclaredField):
                        values[name] = below.default
                    else:
                        raise UnitError(f"{key} is missing; it must be in the configuration.")
                elif isinstance(below, Section):
                    values[name] = {}
                    chosen, own = _chosen(below, section[name], key)
                    values[name] = self._values(own, section[name], f"{key}.", chosen)
                else:
                    values[name] = value_of(below, section[name], key)
            except UnitError as fault:
                self.faults.append(str(fault))
        unknown = [f"{before}{name}" for name in section if name not in keys]
        self.faults += [unknown_key(key, option, known_keys(self._law)) for key in unknown]
        return values


def _chosen(section: Section, values: Any, path: str) -> tuple[str, Keys]:
    """Return the option of a section and its keys; a UnitError if it is none."""
    group = path.replace(".", "/")
    if not isinstance(values, Mapping):
        raise UnitError(f"{path} is {describe(values)}; it must be a group of keys, or {group}=NAME.")
    key, options = f"{path}.{section.selector}", section.labelled
    if not section.selector or (section.selector not in values and key in ADDED):
        return next(iter(section.options.items()))
    if section.selector not in values:
        raise UnitError(f"{key} is missing; choose one by {group}=NAME.")
    label = values[section.selector]
    if isinstance(label, str) and label in options:
        try:
            return options[label], section.options[options[label]]
        except ValueError as error:
            raise UnitError(f"{key} is '{label}', which cannot run. {error}") from error
    expected = ", ".join(map(repr, options))
    raise UnitError(f"{key} is {describe(label)}; it must be one of {expected}. Choose by {group}=NAME.")


def declared_in(configuration: Mapping[str, Any], keys: Keys = KEYS) -> dict[str, Parameter]:
    """Return the declarations of the numbers of a sound configuration, by full key."""
    fields = numbers_in(configuration, keys)
    return {key: field.parameter for key, field in fields.items() if field.parameter}


def numbers_in(
    configuration: Mapping[str, Any], keys: Keys = KEYS, before: str = ""
) -> dict[str, DeclaredField]:
    """Return the fields of a sound configuration that are numbers, by full key."""
    numbers: dict[str, DeclaredField] = {}
    for name, below in keys.items():
        key = f"{before}{name}"
        if name not in configuration:
            continue
        if isinstance(below, DeclaredField):
            if below.is_number:
                numbers[key] = below
            continue
        # A law made in Python may be none that is chosen by its name.
        with suppress(UnitError):
            _, own = _chosen(below, configuration[name], key)
            numbers |= numbers_in(configuration[name], own, f"{key}.")
    return numbers


def value_of(field: DeclaredField, value: Any, key: str) -> Any:
    """Return a value in SI; a UnitError with key and bound if it is faulty."""
    if field.is_number:
        try:
            return number_of(field, value)
        except UnitError as fault:
            raise UnitError(f"{key} {fault}") from fault
    if value == MISSING:
        meaning = f", {field.parameter.meaning}," if field.parameter else ""
        raise UnitError(f"{key}{meaning} is missing; write {key}=VALUE.")
    if any(is_kind(value, kind) for kind in field.kinds):
        return value
    try:
        for kind in field.kinds:
            if isinstance(value, str) and hasattr(kind, "of_text"):
                return kind.of_text(value)
            if get_origin(kind) is list and isinstance(value, list) and hasattr(get_args(kind)[0], "of_text"):
                return [get_args(kind)[0].of_text(str(each)) for each in value]
    except ValueError as error:
        raise UnitError(f"{key} is {describe(value)}; {error}.") from error
    kinds = [_KINDS.get(k) or " or ".join(map(repr, get_args(k))) for k in field.kinds]
    raise UnitError(f"{key} is {describe(value)}; it must be {' or '.join(kinds)}.")
