"""The keys of a checked configuration, each with its unit."""

from collections.abc import Iterator

from contactlab.config.quantity import Quantity
from contactlab.config.section import Section
from contactlab.config.units import to_cf


def units_of(checked: Section) -> dict[str, str]:
    """The unit of every key that holds a number, in the words of the CF conventions.

    Args:
        checked: a configuration as `contactlab.config.validate` gives it, or a section of one.

    Returns:
        Units by full key: {"contact.clearance": "m", ...}.
    """
    return dict(_units(checked))


def _units(section: Section) -> Iterator[tuple[str, str]]:
    for name, field in type(section).model_fields.items():
        value = getattr(section, name)
        if isinstance(value, Section):
            yield from _units(value)
        for said in field.metadata:
            if isinstance(said, Quantity):
                yield f"{section.path}{name}", to_cf(said.unit)
