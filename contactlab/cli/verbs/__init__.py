"""The verbs of the command: every module of this package, - in its name as _, of others, and every study.

What a verb does is the first paragraph of the docstring of its module, or of the study's class.
"""

from functools import cache
from importlib.metadata import entry_points
from pkgutil import iter_modules
from typing import Final

from contactlab.studies.docstrings import docstring_of, question_in
from contactlab.studies.registry import SIMULATE, question_of, studies

GROUP: Final = "contactlab.verbs"
"""Entry points by which a package adds a verb that is no study: a module with `main`, as here."""


@cache
def modules() -> dict[str, str]:
    """Return the modules of the verbs that are no studies, by name; those of the package cannot be taken."""
    others = {point.name: point.value for point in entry_points(group=GROUP)}
    return others | {
        each.name.replace("_", "-"): f"{__name__}.{each.name}" for each in iter_modules(__path__)
    }


def names() -> list[str]:
    """Return the names of all verbs, those of studies of other packages included."""
    return sorted({*modules(), *studies()} - {SIMULATE})


def purpose_of(verb: str) -> str:
    """Return what a verb does, on one line."""
    return question_in(docstring_of(modules()[verb])) if verb in modules() else question_of(verb)


def lines(indent: str = "  ") -> str:
    """Return a line for each verb: its name, and what it does."""
    width = max(map(len, names()))
    return f"\n{indent}".join(f"{verb:{width}}  {purpose_of(verb)}" for verb in names())
