"""A configuration held against what is declared of its keys: values in SI, and a sentence for each fault."""

from collections.abc import Mapping
from types import NoneType
from typing import Any, get_args

from contactlab.checks import is_kind
from contactlab.config.faults import unknown_key
from contactlab.config.groups import (
    GROUPS,
    NOT_OF_A_RUN,
    Keys,
    Section,
    keys_of_law,
    known_keys,
    laws,
)
from contactlab.config.quantity import UnitError, describe, number_of
from contactlab.laws.registry import LAWS, law_class, law_names
from contactlab.parameter import DeclaredField, Parameter

_WORDS = {bool: "true or false", str: "a text", list[str]: "a list of texts", NoneType: "null"}


class Examination:
    """What is found in a configuration.

    Attributes:
        values: of every section that there is, as they run.
        sound, declared: those that are sound in themselves, by full key, and what is declared of them.
        faults: a sentence each.
    """

    def __init__(self, configuration: Any) -> None:
        self.values: dict[str, Any] = {}
        self.sound: dict[str, Any] = {}
        self.declared: dict[str, DeclaredField] = {}
        self.faults: list[str] = []
        if not isinstance(configuration, Mapping):
            said = f"The configuration is {describe(configuration)}"
            self.faults.append(f"{said}; it must be a mapping of groups of keys.")
            return
        law = configuration.get("law")
        self._law = str(law.get("name") if isinstance(law, Mapping) else None)
        others = [self._law] if self._law in law_names() and self._law not in LAWS else []
        self.values = self._values({"law": laws(*others), **GROUPS}, configuration)

    def _values(
        self, keys: Keys, given: Mapping[str, Any], before: str = "", option: str = ""
    ) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for name, below in keys.items():
            key = f"{before}{name}"
            try:
                if name not in given:
                    if key not in NOT_OF_A_RUN:
                        raise UnitError(
                            f"{key} is missing; it must be given. Add it to the configuration."
                        )
                elif isinstance(below, Section):
                    values[name] = {}
                    chosen = _chosen(below, given[name], key)
                    values[name] = self._values(
                        below.options[chosen], given[name], f"{key}.", chosen
                    )
                else:
                    values[name] = self.sound[key] = _value_of(below, given[name], key)
                    self.declared[key] = below
            except UnitError as fault:
                self.faults.append(str(fault))
        unknown = [f"{before}{name}" for name in given if name not in keys]
        self.faults += [unknown_key(key, option, known_keys(self._law)) for key in unknown]
        return values


def _chosen(section: Section, given: Any, path: str) -> str:
    """Give the option that a section is, or say by a UnitError why it is none."""
    group = path.replace(".", "/")
    if not isinstance(given, Mapping):
        raise UnitError(
            f"{path} is {describe(given)}; it must be a group of keys. "
            f"Set a single one by {path}.KEY=VALUE or choose a file by {group}=NAME."
        )
    told_by = section.told_by
    if not told_by:
        return next(iter(section.options))
    key, way_out = f"{path}.{told_by}", f"Choose one by {group}=NAME."
    if told_by not in given:
        raise UnitError(f"{key} is missing; it must be given. {way_out}")
    word = given[told_by]
    words = {
        told.default: option
        for option, keys in section.options.items()
        if isinstance(told := keys[told_by], DeclaredField)
    }
    if isinstance(word, str) and word in words:
        return words[word]
    known = law_names() if path == "law" else [*words]
    if path == "law" and word in known:
        try:
            keys_of_law(law_class(word))
        except ValueError as error:
            raise UnitError(f"{key} is '{word}', which cannot run. {error}") from error
    expected = ", ".join(map(repr, known))
    raise UnitError(f"{key} is {describe(word)}; it must be one of {expected}. {way_out}")


def declared_in(configuration: Mapping[str, Any]) -> dict[str, Parameter]:
    """Give what is declared of every key that holds a number, by full key."""
    found = Examination(configuration).declared.items()
    return {key: field.parameter for key, field in found if field.parameter and field.is_number}


def _value_of(field: DeclaredField, value: Any, key: str) -> Any:
    """Give a value as it runs, or say by a UnitError what is wrong with it."""
    if field.is_number:
        try:
            return value if field.is_sound_float(value) else number_of(field, value)
        except UnitError as fault:
            raise UnitError(f"{key} {fault}") from fault
    if any(is_kind(value, kind) for kind in field.kinds):
        return value
    words = [_WORDS.get(k) or " or ".join(map(repr, get_args(k))) for k in field.kinds]
    way_out = " Leave it out for the default." if bool in field.kinds or str in field.kinds else ""
    raise UnitError(f"{key} is {describe(value)}; it must be {' or '.join(words)}.{way_out}")
