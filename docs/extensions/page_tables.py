"""Tables of the pages that are made, and the units in them."""

import re
from collections.abc import Iterable, Sequence

import equations

from contactlab.parameter import from_cf


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Return the lines of a Markdown table, with an empty one behind it."""
    cells = [heads, ["---"] * len(heads), *rows]
    return [*(f"| {' | '.join(row)} |" for row in cells), ""]


def unit(units: str) -> str:
    """Return a unit of the CF conventions with its powers raised; empty for a pure number."""
    return "" if units == "1" else raised(from_cf(units))


def raised(text: str) -> str:
    """Return a text with the powers of its units raised: "N/m^1.5"."""
    return re.sub(r"\^(-?[\d.]+)", r"<sup>\1</sup>", text)


def powers_of_ten(text: str) -> str:
    """Return a text with its numbers as they are printed: "1.5e-05" as 1.5 times a power of ten."""
    text = re.sub(r"(\d)e([-+]\d+)", lambda part: f"{part[1]}\u00b710<sup>{int(part[2])}</sup>", text)
    text = re.sub(r"(?<![\d.])1\u00b710", "10", text)
    return re.sub(r"(?<=<sup>)-", "\N{MINUS SIGN}", text)


def symbol(text: str) -> str:
    """Return a symbol as a formula in a line; empty for none."""
    return f"${equations.formula(text)}$" if text else ""
