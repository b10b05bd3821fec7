"""What the law that ran declares of itself, as far as it and its parts are installed here."""

from typing import Any

from contactlab.laws.base import ELASTOPLASTIC
from contactlab.laws.registry import PARTS, law_class
from contactlab.metrics.record import Record
from contactlab.parameter import parameters_of


def parameter_units(record: Record) -> dict[str, str]:
    """Units of the law's parameters by name; empty for a law that is not installed."""
    try:
        declared = parameters_of(law_class(record.law))
    except ValueError:
        return {}
    units = {name: parameter.units for name, parameter in declared.items()}
    for family, part in _parts(record).items():
        units |= {f"{family}.{name}": p.units for name, p in parameters_of(part).items()}
    return units


def has_tangential_spring(record: Record) -> bool:
    """Whether the law's friction is a spring and a slider; of one that is not installed, no."""
    try:
        owners = [law_class(record.law), *_parts(record).values()]
    except ValueError:
        return False
    return any(getattr(owner, "friction_kind", None) == ELASTOPLASTIC for owner in owners)


def corrects_displacements(record: Record) -> bool:
    """Whether the law's steps put displacements back onto the gap; of one that is not installed, no."""
    try:
        return bool(getattr(law_class(record.law), "projects", False))
    except ValueError:
        return False


def _parts(record: Record) -> dict[str, Any]:
    """Classes of the law's parts by family."""
    section = record.configuration.get("law")
    chosen: dict[str, Any] = {}
    for family, parts in PARTS.items():
        below = section.get(family) if isinstance(section, dict) else None
        name = str(below.get("name")) if isinstance(below, dict) else ""
        if name in parts:
            chosen[family] = parts[name]
    return chosen
