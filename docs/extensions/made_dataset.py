"""The reference of what a run leaves: every variable with dimensions, unit and meaning."""

from collections.abc import Iterable

from page_tables import table, unit

from contactlab.variables import BEARING, CONTACT_MODE, CONTACTS, RESONATOR, SERIES, TIME, Variable

HEADS = ("variable", "dimensions", "unit", "symbol", "meaning")


def variables() -> str:
    """Return a table for the root of a dataset and one for the group of its contacts."""
    root = [TIME, *SERIES, BEARING, CONTACT_MODE, *RESONATOR]
    parts = ["## The root\n", *table(HEADS, _rows(root))]
    parts += ["## The group `contacts`\n", *table(HEADS, _rows(CONTACTS))]
    return "\n".join(parts)


def _rows(result: Iterable[Variable]) -> Iterable[list[str]]:
    for item in result:
        text = [item.long_name]
        if item.flags:
            text.append(", ".join(f"{number} {word}" for number, word in enumerate(item.flags)))
        if item.comment:
            text.append(item.comment)
        dims = ", ".join(item.dims)
        yield [f"`{item.name}`", dims, unit(item.units), f"`{item.symbol}`", "; ".join(text)]
