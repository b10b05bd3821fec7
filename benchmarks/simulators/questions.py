"""Contact questions with exact answers, from questions.yaml."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, final

import yaml

FILE: Final = Path(__file__).with_name("questions.yaml")

FUNCTIONS: Final[dict[str, Any]] = {"__builtins__": {"min": min, "max": max}, **vars(math)}


@final
@dataclass(frozen=True)
class Question:
    """A question at one set of numbers.

    Args:
        name: key in the file.
        kind: function of an entrant that answers it: block, impact or bounce.
        numbers: what the function receives.
        exact: exact answers, by name.
        at_most: upper bounds of answers, by name.
    """

    name: str
    kind: str
    numbers: Mapping[str, float]
    exact: Mapping[str, float]
    at_most: Mapping[str, float]


@cache
def questions() -> tuple[Question, ...]:
    """Return every question at each of its numbers, in the order of the file."""
    made = []
    content = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    for name, entry in content["questions"].items():
        ((varied, values),) = entry["over"].items()
        for value in values:
            numbers = {**content["common"], **entry["numbers"], varied: value}
            scope = dict(numbers)
            for key, text in entry.get("where", {}).items():
                scope[key] = eval(text, FUNCTIONS, scope)
            exact, bounds = (
                {key: float(eval(text, FUNCTIONS, scope)) for key, text in entry.get(part, {}).items()}
                for part in ("exact", "at_most")
            )
            made.append(Question(name, entry["kind"], numbers, exact, bounds))
    return tuple(made)
