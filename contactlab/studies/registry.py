"""Every study by name, with its entry: the package's own and those of other packages.

A study is imported when it is chosen; see `contactlab.studies.study`.
"""

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Final

from contactlab.studies.docstrings import docstring_of, question_in

if TYPE_CHECKING:
    from contactlab.studies.study import Study

GROUP: Final = "contactlab.studies"

SIMULATE: Final = "simulate"
"""The study that a command without a verb does."""

OWN: Final = {
    SIMULATE: "contactlab.studies.simulate:Simulate",
    "basins": "contactlab.studies.basins:Basins",
    "branch": "contactlab.studies.branch:Branch",
    "characterise": "contactlab.studies.characterise.study:Characterise",
    "compare": "contactlab.studies.compare.study:Compare",
    "drive": "contactlab.studies.drive:Driven",
    "response": "contactlab.studies.response:Response",
    "steady": "contactlab.studies.steady:Steady",
}
"""Entries of the package's own studies by name."""


@cache
def studies() -> dict[str, EntryPoint]:
    """Return the entry points of all studies by name; a name of the package's own cannot be taken."""
    others = {point.name: point for point in entry_points(group=GROUP) if point.name.isidentifier()}
    return others | {name: EntryPoint(name, entry, GROUP) for name, entry in OWN.items()}


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
        ValueError: there is none of this name, its package cannot be imported, or an option is not declared.
    """
    if name not in studies():
        raise ValueError(f"study is '{name}'; it must be one of {', '.join(sorted(studies()))}.")
    try:
        study: type[Study] = studies()[name].load()
    # A module of another package may fail in any way.
    except Exception as error:
        raise ValueError(f"The study {name} cannot be imported: {type(error).__name__}: {error}") from error
    # Imported here: the list of studies needs none.
    from contactlab.studies.study import check_options

    try:
        check_options(study)
    except TypeError as error:
        raise ValueError(str(error)) from error
    return study


def question_of(name: str) -> str:
    """Return the question of a study on one line: the first paragraph of its docstring, read from its source.

    A study without one there is imported; the sentence on its failure stands for the question of one that
    cannot be.
    """
    entry = studies()[name]
    try:
        docstring = docstring_of(entry.module, entry.attr) or study_class(name).__doc__
    except ValueError as error:
        return str(error)
    return question_in(docstring)
