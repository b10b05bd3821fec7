"""Numbers of a page beside those of a file of results."""

import json
from functools import cache
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parents[2] / "docs"


@cache
def results_of(name: str) -> Any:
    """Return the results in docs/results/NAME.json."""
    return json.loads((DOCS / "results" / f"{name}.json").read_text(encoding="utf-8"))


@cache
def text_of(page: str) -> str:
    """Return a page, its path relative to docs/, with single spaces."""
    return " ".join((DOCS / page).read_text(encoding="utf-8").split())


def number(results: Any, key: str) -> float:
    """Return a number of nested results by the keys on its way, "ellipses/laws/poisson/error".

    "A - B" has the difference of two numbers, "A * 1000" a multiple.
    """
    if " - " in key:
        first, _, other = key.partition(" - ")
        return number(results, first) - number(results, other)
    way, _, factor = key.partition(" * ")
    value = results
    for part in way.split("/"):
        value = value[int(part)] if isinstance(value, list) else value[part]
    return float(value) * float(factor or 1.0)


def stated(text: str, results: Any, *keys: str) -> str:
    """Return a sentence with the numbers of these keys in its places, as "{:.4f}"."""
    return " ".join(text.format(*(number(results, key) for key in keys)).split())
