"""The reference of what a run leaves: every variable with dimensions, unit and meaning."""

from collections.abc import Iterable

from contactlab.variables import BEARING, CONTACT_MODE, CONTACTS, RESONATOR, SERIES, TIME, Variable

HEAD = "| variable | dimensions | unit | symbol | meaning |\n|---|---|---|---|---|"


def variables() -> str:
    """Return a table for the root of a dataset and one for the group of its contacts."""
    parts = ["## The root\n", HEAD, *_rows([TIME, *SERIES, BEARING, CONTACT_MODE, *RESONATOR]), ""]
    parts += ["## The group `contacts`\n", HEAD, *_rows(CONTACTS), ""]
    return "\n".join(parts)


def _rows(result: Iterable[Variable]) -> Iterable[str]:
    for item in result:
        text = [item.long_name]
        if item.flags:
            text.append(", ".join(f"{number} {word}" for number, word in enumerate(item.flags)))
        if item.comment:
            text.append(item.comment)
        dims = ", ".join(item.dims)
        yield f"| `{item.name}` | {dims} | {item.units} | `{item.symbol}` | {'; '.join(text)} |"
