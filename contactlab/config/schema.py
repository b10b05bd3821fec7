"""A configuration held against what is declared of its keys: values in SI, and a sentence for each fault."""

from collections.abc import Mapping
from types import NoneType
from typing import Any, get_args

from contactlab.checks import is_kind
from contactlab.config.faults import unknown_key
from contactlab.config.groups import (
    GROUPS,
    NOT_OF_A_RUN,
    Choice,
    Keys,
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

    def __init__(self, configuration: object) -> None:
        given = configuration.get("law") if isinstance(configuration, Mapping) else None
        self.law = str(given.get("name") if isinstance(given, Mapping) else None)
        self.sound: dict[str, Any] = {}
        self.declared: dict[str, DeclaredField] = {}
        self.faults: list[str] = []
        others = [self.law] if self.law in law_names() and self.law not in LAWS else []
        self.values = self._section({"law": laws(*others), **GROUPS}, configuration, "")

    def _section(self, found: Keys | Choice, given: Any, path: str) -> dict[str, Any]:
        try:
            option, keys = _chosen(found, given, path)
        except UnitError as fault:
            self.faults.append(str(fault))
            return {}
        values: dict[str, Any] = {}
        before = f"{path}." if path else ""
        for name, below in keys.items():
            key = f"{before}{name}"
            try:
                if name not in given:
                    if key not in NOT_OF_A_RUN:
                        raise UnitError(
                            "is missing; it must be given. Add it to the configuration."
                        )
                elif isinstance(below, DeclaredField):
                    values[name] = self.sound[key] = _value_of(below, given[name])
                    self.declared[key] = below
                else:
                    values[name] = self._section(below, given[name], key)
            except UnitError as fault:
                self.faults.append(f"{key} {fault}")
        unknown = [f"{before}{name}" for name in given if name not in keys]
        self.faults += [unknown_key(key, option, known_keys(self.law)) for key in unknown]
        return values


def _chosen(found: Keys | Choice, given: Any, path: str) -> tuple[str, Keys]:
    """Give the option that a section is, empty where it is no choice, and its keys.

    Raises:
        UnitError: it is no section, or of no option that there is; a whole sentence.
    """
    group = path.replace(".", "/")
    if not isinstance(given, Mapping) and not path:
        said = f"The configuration is {describe(given)}"
        raise UnitError(f"{said}; it must be a mapping of groups of keys.")
    if not isinstance(given, Mapping):
        raise UnitError(
            f"{path} is {describe(given)}; it must be a group of keys. "
            f"Set a single one by {path}.KEY=VALUE or choose a file by {group}=NAME."
        )
    if not isinstance(found, Choice):
        return "", found
    if not found.told_by:
        return next(iter(found.options.items()))
    key, way_out = f"{path}.{found.told_by}", f"Choose one by {group}=NAME."
    if found.told_by not in given:
        raise UnitError(f"{key} is missing; it must be given. {way_out}")
    name, options = given[found.told_by], [*found.told]
    if name in options:
        return found.told[name]
    if path == "law":
        options = law_names()
        try:
            if name in options:
                keys_of_law(law_class(name))
        except ValueError as error:
            raise UnitError(f"{key} is '{name}', which cannot run. {error}") from error
    expected = ", ".join(map(repr, options))
    raise UnitError(f"{key} is {describe(name)}; it must be one of {expected}. {way_out}")


def declared_in(configuration: Mapping[str, Any]) -> dict[str, Parameter]:
    """Give what is declared of every key that holds a number, by full key."""
    found = Examination(configuration).declared.items()
    return {key: field.parameter for key, field in found if field.parameter and field.is_number}


def _value_of(found: DeclaredField, value: Any) -> Any:
    """Give a value as it runs.

    Raises:
        UnitError: what is wrong with it.
    """
    if found.is_number:
        return value if found.is_sound_float(value) else number_of(found, value)
    if any(is_kind(value, kind) for kind in found.kinds):
        return value
    words = [_WORDS.get(k) or " or ".join(map(repr, get_args(k))) for k in found.kinds]
    way_out = " Leave it out for the default." if bool in found.kinds or str in found.kinds else ""
    raise UnitError(f"is {describe(value)}; it must be {' or '.join(words)}.{way_out}")
