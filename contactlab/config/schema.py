"""A configuration held against what is declared of its keys, and what binds several of them.

What comes out is its values in SI, and a sentence for each fault.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import NoneType
from typing import Any, get_args

from contactlab.checks import SMALLEST_STEP, is_kind
from contactlab.config.faults import unknown_key
from contactlab.config.groups import ADDED, GROUPS, LAW, NO_NUMBERS, Keys, Section, duration_for
from contactlab.config.nesting import flat
from contactlab.config.options import known_keys
from contactlab.config.quantity import UnitError, describe, number_of
from contactlab.laws.base import PenaltyLaw
from contactlab.laws.declaration import SHARED
from contactlab.laws.registry import law_class
from contactlab.parameter import DeclaredField, Parameter
from contactlab.settling.until import PRECISION, STEADY

MOST_RECORDS = 10_000_000
"""Records of one run; they take 3.5 GB of memory."""

FRICTION = f"contact.{SHARED}"
"""The key that laws share, and some law of another package may not have."""

Values = Mapping[str, Any]
Rule = Callable[..., Iterator[str]]

_RULES: dict[tuple[str, ...], Rule] = {}
_WORDS = {bool: "true or false", str: "a text", list[str]: "a list of texts", NoneType: "null"}


class Examination:
    """What is found in a configuration.

    Attributes:
        values: those that are sound in themselves, as they run.
        declared: what is declared of them, by full key.
        faults: a sentence each.
    """

    def __init__(self, configuration: Any) -> None:
        self.values: dict[str, Any] = {}
        self.declared: dict[str, DeclaredField] = {}
        self.faults: list[str] = []
        if not isinstance(configuration, Mapping):
            said = f"The configuration is {describe(configuration)}"
            self.faults.append(f"{said}; it must be a mapping of groups of keys.")
            return
        law = configuration.get("law")
        self._law = str(law.get("name") if isinstance(law, Mapping) else None)
        self.values = self._values({"law": LAW, **GROUPS}, configuration)
        solver = self.values.get("solver", {})
        if "duration" in solver and solver["duration"] is None:
            solver["duration"] = duration_for(solver.get("until"))
        sound = flat(self.values)
        for keys, rule in _RULES.items():
            if sound.keys() >= {*keys}:
                self.faults += rule(*(sound[key] for key in keys))

    def _values(
        self, keys: Keys, given: Mapping[str, Any], before: str = "", option: str = ""
    ) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for name, below in keys.items():
            key = f"{before}{name}"
            try:
                if name not in given:
                    if key in ADDED and isinstance(below, DeclaredField):
                        values[name] = below.default
                    elif key not in NO_NUMBERS:
                        raise UnitError(f"{key} is missing; it must be given. Add it to the configuration.")
                elif isinstance(below, Section):
                    values[name] = {}
                    chosen, own = _chosen(below, given[name], key)
                    values[name] = self._values(own, given[name], f"{key}.", chosen)
                else:
                    values[name] = _value_of(below, given[name], key)
                    self.declared[key] = below
            except UnitError as fault:
                self.faults.append(str(fault))
        unknown = [f"{before}{name}" for name in given if name not in keys]
        self.faults += [unknown_key(key, option, known_keys(self._law)) for key in unknown]
        return values


def _chosen(section: Section, given: Any, path: str) -> tuple[str, Keys]:
    """Give the option that a section is and its keys, or say by a UnitError why it is none."""
    group = path.replace(".", "/")
    if not isinstance(given, Mapping):
        raise UnitError(
            f"{path} is {describe(given)}; it must be a group of keys. "
            f"Set a single one by {path}.KEY=VALUE or choose a file by {group}=NAME."
        )
    told_by = section.told_by
    if not told_by:
        return next(iter(section.options.items()))
    key, way_out = f"{path}.{told_by}", f"Choose one by {group}=NAME."
    if told_by not in given:
        raise UnitError(f"{key} is missing; it must be given. {way_out}")
    word, words = given[told_by], section.told
    if isinstance(word, str) and word in words:
        try:
            return words[word], section.options[words[word]]
        except ValueError as error:
            raise UnitError(f"{key} is '{word}', which cannot run. {error}") from error
    expected = ", ".join(map(repr, words))
    raise UnitError(f"{key} is {describe(word)}; it must be one of {expected}. {way_out}")


def declared_in(configuration: Mapping[str, Any]) -> dict[str, Parameter]:
    """Give what is declared of every key that holds a number, by full key."""
    found = Examination(configuration).declared.items()
    return {key: field.parameter for key, field in found if field.parameter and field.is_number}


def _value_of(field: DeclaredField, value: Any, key: str) -> Any:
    """Give a value as it runs, or say by a UnitError what is wrong with it."""
    if field.is_number:
        try:
            return number_of(field, value)
        except UnitError as fault:
            raise UnitError(f"{key} {fault}") from fault
    if any(is_kind(value, kind) for kind in field.kinds):
        return value
    words = [_WORDS.get(k) or " or ".join(map(repr, get_args(k))) for k in field.kinds]
    way_out = " Leave it out for the default." if bool in field.kinds or str in field.kinds else ""
    raise UnitError(f"{key} is {describe(value)}; it must be {' or '.join(words)}.{way_out}")


def _binds(*keys: str) -> Callable[[Rule], Rule]:
    """Register a rule: it gets the values of the keys where all are sound, and gives sentences."""
    return partial(_RULES.setdefault, keys)


@_binds("placement.start", "placement.end", "resonator.length")
def _patches_fit(start: float, end: float, length: float) -> Iterator[str]:
    if not start < end <= 0.5 * length:
        yield (
            f"placement.start is {start:.12g} m and placement.end is {end:.12g} m; they must "
            f"satisfy 0 m <= start < end <= {0.5 * length:.12g} m, half of resonator.length, to "
            "lie on the beam and clear of their mirror image. Shift or shorten them."
        )


@_binds(*(f"piezoceramic.{key}" for key in ("c11", "c12", "c13", "c33")))
def _elastic_tensor_is_stable(c11: float, c12: float, c13: float, c33: float) -> Iterator[str]:
    if not (c11 > abs(c12) and (c11 + c12) * c33 > 2.0 * c13**2):
        yield (
            f"piezoceramic has c11 = {c11:g}, c12 = {c12:g}, c13 = {c13:g}, c33 = {c33:g} Pa, a tensor "
            "that stores negative energy; it must satisfy c11 > |c12| and (c11 + c12) c33 > 2 c13^2. "
            "Check the constants against the datasheet."
        )


@_binds("contact.clearance", "resonator.beam_thickness")
def _clearance_can_be_bridged(clearance: float, thickness: float) -> Iterator[str]:
    if clearance > thickness:
        yield (
            f"contact.clearance is {clearance:.12g} m; it must be at most {thickness:.12g} m, the "
            "resonator.beam_thickness: the beam's theory is linear and knows no larger motion of the tip. "
            "Bring them closer; 1e-06 m is usual."
        )


@_binds("solver.contact_step", "solver.duration")
def _step_fits(step: float | None, duration: float) -> Iterator[str]:
    if step is not None and not SMALLEST_STEP * duration <= step <= duration:
        yield (
            f"solver.contact_step is {step:.12g} s; it must be at least "
            f"{SMALLEST_STEP * duration:.3g} s and at most {duration:.12g} s, the solver.duration. "
            "Leave it out for the law's own default."
        )


@_binds("solver.precision", "solver.until")
def _precision_is_for_steady_runs(precision: float, until: str) -> Iterator[str]:
    if precision != PRECISION and until != STEADY:
        yield (
            f"solver.precision is {precision:g} and solver.until is {until}; it must come with "
            "solver.until=steady, whose runs it ends. Leave it out."
        )


@_binds("solver.tolerance", "law.name")
def _tolerance_is_for_compliant_laws(tolerance: float | None, law: str) -> Iterator[str]:
    if tolerance is not None and not issubclass(law_class(law), PenaltyLaw):
        yield (
            f"solver.tolerance is {tolerance:g}; it must be null with law={law}, which takes steps "
            "of solver.contact_step without a tolerance. Refine solver.contact_step instead."
        )


@_binds("record.interval", "solver.duration")
def _records_fit(interval: float, duration: float) -> Iterator[str]:
    said = f"record.interval is {interval:.12g} s"
    if interval > duration:
        yield (
            f"{said}; it must be at most {duration:.12g} s, the solver.duration. Record more often or run "
            "longer."
        )
    elif duration / interval > MOST_RECORDS:
        yield (
            f"{said}, which makes {duration / interval:.3g} records; it must be at least "
            f"{duration / MOST_RECORDS:.3g} s, for {MOST_RECORDS} records that fit into memory. Record less "
            "often; the records do not change the motion."
        )


@_binds("sweep.keep", "sweep.chunk", "sweep.workers")
def _processes_are_for_metrics(keep: str, chunk: int | None, workers: int | None) -> Iterator[str]:
    for name, given in {"chunk": chunk, "workers": workers}.items():
        if keep == "runs" and given is not None:
            yield (
                f"sweep.{name} is {given} and every run leaves its folder; it must come with "
                "sweep.keep=metrics. Leave it out; hydra/launcher=joblib runs folders side by side."
            )
