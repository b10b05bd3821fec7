"""Contact questions with exact answers, from questions.yaml, and the errors of answers."""

import math
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import yaml
from numpy.typing import ArrayLike

from contactlab.variables import Variable

FUNCTIONS: Final[dict[str, Any]] = {"__builtins__": {"min": min, "max": max}, **vars(math)}

CREATED: Final = Variable("energy_created", (), "1", "dT/T-", "energy created")
"""Largest gain of kinetic energy in an impact, over that before."""


class Case(NamedTuple):
    """A quantity of a question at one set of numbers.

    Args:
        question: key in the file.
        at: the number that varies, "push=0.25".
        kind: what is simulated: block, impact, linkage or bounce.
        numbers: all numbers of the question, those that follow from others too [SI, degrees].
        quantity: name of what is answered.
        exact: its exact value; NaN where there is none.
    """

    question: str
    at: str
    kind: str
    numbers: Mapping[str, float]
    quantity: str
    exact: float


class Score(NamedTuple):
    """The largest error of a quantity of a question, relative to the exact value or absolute."""

    variable: Variable
    question: str
    quantity: str
    relative: bool


@cache
def questions() -> tuple[tuple[Case, ...], tuple[Score, ...]]:
    """Return every quantity of every question at each of its numbers, and the errors that are reported."""
    cases, scores = list[Case](), list[Score]()
    content = yaml.safe_load(Path(__file__).with_name("questions.yaml").read_text(encoding="utf-8"))
    for name, entry in content["questions"].items():
        ((varied, values),) = entry["over"].items()
        for value in values:
            scope = {**content["common"], **entry["numbers"], varied: value}
            for key, text in entry.get("where", {}).items():
                scope[key] = eval(text, FUNCTIONS, scope)
            for key, text in entry["exact"].items():
                exact = float(eval(text, FUNCTIONS, scope))
                cases.append(Case(name, f"{varied}={value}", entry["kind"], scope, key, exact))
        for key, (title, units, *relative) in entry.get("errors", {}).items():
            variable = Variable(re.sub(r"\W", "_", title), (), units, "", title)
            scores.append(Score(variable, name, key, bool(relative)))
    return tuple(cases), tuple(scores)


def errors_of(responses: ArrayLike) -> dict[Variable, float]:
    """Return the largest errors of answers, shape (case,), and the energy created; NaN without an answer."""
    values, (cases, scores), result = np.asarray(responses, np.float64), questions(), dict[Variable, float]()
    exact = np.array([case.exact for case in cases])
    for variable, *place, relative in scores:
        here = np.array([[case.question, case.quantity] == place for case in cases])
        scale = np.abs(exact[here]) if relative else 1.0
        result[variable] = float((np.abs(values - exact)[here] / scale).max())
    energies = values[[case.quantity == "energy" for case in cases]]
    known = energies[np.isfinite(energies)]
    result[CREATED] = float((known - 1.0).max(initial=0.0)) if known.size else math.nan
    return result
