"""Every study by name, with its entry and its question: the package's own and those of other packages.

A study is imported when it is chosen; see `contactlab.studies.study`.
"""

from functools import cache
from importlib.metadata import EntryPoint, entry_points
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
    "bench": (
        "contactlab.studies.bench.study:Bench",
        "Does a law stick, does it keep its energy, does it rebound as its numbers say?",
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
    "fit": (
        "contactlab.studies.fit:Fit",
        "Which numbers of a law or a motor do measurements support, and which law?",
    ),
    "steady": (
        "contactlab.studies.steady:Steady",
        "What does the motor do once it has settled: velocity, torque, power, stability?",
    ),
    "synthetic": (
        "contactlab.studies.synthetic:Synthetic",
        "What would be measured of a motor, or of impacts, under a known law?",
    ),
    "validate": (
        "contactlab.studies.validate:Validate",
        "How well do contact laws predict measured impacts to which they were not fitted?",
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
    """Return the question of a study on one line; that of another package's imports it."""
    if name in OWN:
        return OWN[name][1]
    return " ".join((study_class(name).__doc__ or "").split("\n\n")[0].split())
