"""Every study by name, with its entry and its question: the package's own and those of other packages.

A study is imported when it is chosen; see `contactlab.studies.study`.
"""

import ast
import sys
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from contactlab.studies.study import Study

GROUP: Final = "contactlab.studies"

SIMULATE: Final = "simulate"
"""The study that a command without a verb does."""

OWN: Final = {
    SIMULATE: (
        "contactlab.studies.simulate:Simulate",
        "What does the motor do from its start to the end of the configured duration?",
    ),
    "basins": (
        "contactlab.studies.basins:Basins",
        "To which of its steady states does the motor come from where it starts?",
    ),
    "branch": (
        "contactlab.studies.branch:Branch",
        "Which periodic orbits has the motor over one number, KEY=START..END, stable and unstable?",
    ),
    "characterise": (
        "contactlab.studies.characterise.study:Characterise",
        "What is the motor's data sheet: speed-torque curve, power, efficiencies, start and stop?",
    ),
    "compare": (
        "contactlab.studies.compare.study:Compare",
        "Does the difference of contact laws survive where the motor is not exactly known?",
    ),
    "drive": (
        "contactlab.studies.drive:Driven",
        "What forces does a law bring on a prescribed path, without a motor, and what does it lose?",
    ),
    "steady": (
        "contactlab.studies.steady:Steady",
        "What does the motor do once it has settled: velocity, torque, power, stability?",
    ),
}
"""The package's own studies: entry, and question, which is the first paragraph of the study's docstring."""


@cache
def studies() -> dict[str, EntryPoint]:
    """Return the entry points of all studies by name; a name of the package's own cannot be taken."""
    others = {point.name: point for point in entry_points(group=GROUP) if point.name.isidentifier()}
    return others | {name: EntryPoint(name, entry, GROUP) for name, (entry, _) in OWN.items()}


def register(name: str, entry: str) -> None:
    """Add a study to those of this process.

    Args:
        name: of the study.
        entry: its module and class, as of an entry point: "their_module:Stroke".
    """
    studies().setdefault(name, EntryPoint(name, entry, GROUP))


@cache
def study_class(name: str) -> "type[Study]":
    """Return the class of a study.

    Raises:
        ValueError: there is none of this name, or its package cannot be imported.
    """
    if name not in studies():
        raise ValueError(f"study is '{name}'; it must be one of {', '.join(sorted(studies()))}.")
    try:
        study: type[Study] = studies()[name].load()
    # A module of another package may fail in any way.
    except Exception as error:
        raise ValueError(f"The study {name} cannot be imported: {type(error).__name__}: {error}") from error
    return study


def question_of(name: str) -> str:
    """Return the question of a study on one line, of another package's from its source."""
    if name in OWN:
        return OWN[name][1]
    text = _docstring_in_source(studies()[name]) or study_class(name).__doc__ or ""
    return " ".join(text.split("\n\n")[0].split())


def _docstring_in_source(entry: EntryPoint) -> str:
    """Return the docstring of a class that is not imported yet; empty if its module does not define it."""
    try:
        spec = None if entry.module in sys.modules else find_spec(entry.module)
        tree = ast.parse(Path(str(spec.origin)).read_bytes() if spec else b"")
    # A module of another package may fail in any way, and is refused once it is imported.
    except Exception:
        return ""
    classes = (each for each in tree.body if isinstance(each, ast.ClassDef) and each.name == entry.attr)
    return next((ast.get_docstring(each) or "" for each in classes), "")
