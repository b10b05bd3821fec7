"""Objects of dataclasses from the JSON that they were written as, by their annotations."""

import json
from collections.abc import Mapping
from dataclasses import is_dataclass
from types import UnionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from contactlab.checks import is_kind, shown

Kind = TypeVar("Kind")


def read_json(kind: type[Kind], text: str | bytes) -> Kind:
    """Read an object of a dataclass; a ValueError tells that the text is something else.

    What the dataclass does not name is left out, and what it has a default for may be missing.
    """
    try:
        found: Kind = _made(kind, json.loads(text))
    except (TypeError, RecursionError) as fault:
        raise ValueError(str(fault)) from fault
    return found


def _made(kind: Any, value: Any) -> Any:
    """Make what is annotated of what JSON says, which has lists for tuples, and objects for dataclasses."""
    form, inner = get_origin(kind) or kind, get_args(kind)
    if isinstance(form, type) and is_dataclass(form) and isinstance(value, dict):
        hints = get_type_hints(form)
        return form(**{name: _made(hints[name], one) for name, one in value.items() if name in hints})
    if form is tuple and isinstance(value, list):
        return tuple(_made(inner[0], one) for one in value)
    if form is Mapping and isinstance(value, dict):
        return {name: _made(inner[1], one) for name, one in value.items()}
    if kind is Any or any(is_kind(value, one) for one in (inner if form is UnionType else (kind,))):
        return value
    raise ValueError(f"{shown(value)} stands where {kind} was written.")
