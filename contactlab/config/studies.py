"""Every study by name, for the group `study` of a configuration: the package's own and those of others.

A study is imported when it is chosen; see `contactlab.studies.study`.
"""

import ast
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from contactlab.studies.study import Study

GROUP: Final = "contactlab.studies"

RUN: Final = "simulate"
"""The study that a command without a verb does."""

OWN: Final = {
    RUN: "contactlab.studies.simulate:Simulate",
    "basins": "contactlab.studies.basins:Basins",
    "branch": "contactlab.studies.branch:Branch",
    "characterise": "contactlab.studies.characterise.study:Characterise",
    "compare": "contactlab.studies.compare.study:Compare",
    "fit": "contactlab.studies.fit:Fit",
    "steady": "contactlab.studies.steady:Steady",
    "synthetic": "contactlab.studies.synthetic:Synthetic",
    "validate": "contactlab.studies.validate:Validate",
}
"""The package's own studies."""


@cache
def studies() -> dict[str, EntryPoint]:
    """Return the entry points of all studies by name; a name of the package's own cannot be taken."""
    others = {point.name: point for point in entry_points(group=GROUP) if point.name.isidentifier()}
    return others | {name: EntryPoint(name, value, GROUP) for name, value in OWN.items()}


def register(name: str, value: str) -> None:
    """Add a study to those of this process.

    Args:
        name: of the study.
        value: its module and class, as of an entry point: "their_module:Stroke".
    """
    studies().setdefault(name, EntryPoint(name, value, GROUP))


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


def study_of(values: Mapping[str, Any]) -> "Study":
    """Return the study that the section `study` of a checked configuration describes."""
    options = {name: value for name, value in values.items() if name != "name"}
    return study_class(values["name"])(**options)


def study_names() -> Iterator[str]:
    """Return the names of all studies."""
    return iter(sorted(studies()))


def question_of(name: str) -> str:
    """Return the question of a study: the first paragraph of its docstring on one line.

    That of the package's own is read from its source, so that no list of studies imports them all.
    """
    if name in OWN:
        module, _, owner = OWN[name].partition(":")
        source = Path(__file__).parents[2].joinpath(*module.split(".")).with_suffix(".py")
        parts = ast.parse(source.read_text(encoding="utf-8")).body
        text = next(ast.get_docstring(c) for c in parts if isinstance(c, ast.ClassDef) and c.name == owner)
    else:
        text = study_class(name).__doc__
    return " ".join((text or "").split("\n\n")[0].split())
