"""A nested configuration by full keys, 'contact.clearance', and back."""

import re
from collections.abc import Mapping
from typing import Any

from contactlab.immutable import PLAIN

Value = float | int | bool | str
"""Type of a value of a configuration."""


def flat(configuration: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """Return the values of a nested configuration by full key."""
    values: dict[str, Any] = {}
    for key, value in configuration.items():
        if type(value) not in PLAIN and isinstance(value, Mapping):
            values |= flat(value, f"{path}{key}.")
        else:
            values[f"{path}{key}"] = value
    return values


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a nested configuration from values by full key."""
    configuration: dict[str, Any] = {}
    for key, value in values.items():
        *sections, last = key.split(".")
        section = configuration
        for name in sections:
            section = section.setdefault(name, {})
        section[last] = value
    return configuration


def with_key(configuration: Mapping[str, Any], key: str, value: Any) -> dict[str, Any]:
    """Return a configuration with another value of a key; sections without the key are shared."""
    first, _, rest = key.partition(".")
    below = configuration.get(first)
    inner = below if isinstance(below, Mapping) else {}
    return {**configuration, first: with_key(inner, rest, value) if rest else value}


def quoted(text: str) -> str:
    """Return a text as the value of an override."""
    return "'" + re.sub(r"(\\*)'", r"\1\1\\'", text) + "'"
