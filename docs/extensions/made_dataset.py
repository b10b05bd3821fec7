"""The reference of what a run leaves: every variable with dimensions, unit and meaning."""

from collections.abc import Iterable

from contactlab.variables import CONTACT_MODE, CONTACTS, RESONATOR, SERIES, TIME, Variable

HEAD = "| variable | dimensions | unit | symbol | meaning |\n|---|---|---|---|---|"


def variables() -> str:
    """Give a table for the root of a dataset and one for the group of its contacts."""
    parts = ["## The root\n", HEAD, *_rows([TIME, *SERIES, CONTACT_MODE, *RESONATOR]), ""]
    parts += ["## The group `contacts`\n", HEAD, *_rows(CONTACTS), ""]
    return "\n".join(parts)


def _rows(found: Iterable[Variable]) -> Iterable[str]:
    for one in found:
        words = [one.long_name]
        if one.flags:
            words.append(", ".join(f"{number} {word}" for number, word in enumerate(one.flags)))
        if one.comment:
            words.append(one.comment)
        dims = ", ".join(one.dims)
        yield f"| `{one.name}` | {dims} | {one.units} | `{one.symbol}` | {'; '.join(words)} |"
