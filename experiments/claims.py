"""Sentences and tables of the pages that state a result; the sentences stand in claims.yaml.

A claim has a population, a predicate and what the page says if it holds, if not, and if it is inconclusive.
A predicate is an expression over the files of results with the functions of this module. It is true, false,
or None where errors leave it open. `{expression:format}` in a sentence is a number. A claim without a
predicate states numbers. `results_pages.py` writes the sentence that holds on its page.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from math import floor, log10
from pathlib import Path
from typing import Any, Final, Self

import motor_findings
import yaml
from results_store import OLDER, read, state_of

FILES: Final = ("motor", "experiments")
PAGES: Final = ("README.md", "docs/index.md", "docs/steady.md", "docs/paper.md", "paper/paper.md")

CHEAP: Final[Mapping[str, Mapping[str, Callable[[], Any]]]] = {
    "motor": {name: motor_findings.SECTIONS[name][0] for name in motor_findings.CHEAP}
}
"""Sections that are made anew when the code has changed; the others are checked by them, or say their age."""

INPUTS: Final = re.compile(r"95\s%|within\s20\s%\sof\sthe\sdistance")
"""Numbers with the unit of a result that are none: levels of intervals, a bound of the search."""

USED: Final[set[tuple[str, str]]] = set()
"""Files and sections that were read."""


class Number(float):
    """A number of the store with its error."""

    error: float

    def __new__(cls, value: float, error: float = 0.0) -> Self:
        """Return a number with an error."""
        number = super().__new__(cls, value)
        number.error = error
        return number

    def __abs__(self) -> "Number":
        return Number(float(self) if self > 0.0 else -float(self), self.error)

    def __str__(self) -> str:
        """Return the number with the digits that its error leaves, and the error where it shows in four."""
        if self.error < 5e-5:
            return f"{float(self):.4f}"
        digits = max(-floor(log10(self.error)), 0)
        error = f"{self.error:.{digits}f}" if digits < 3 else f"{self.error:.0e}".replace("e-0", "e-")
        return f"{float(self):.{digits}f} +- {error}"


@cache
def results(file: str) -> dict[str, Any]:
    """Return the sections of a file of results."""
    return {name: section["results"] for name, section in read(file)["sections"].items()}


def value(key: str, file: str = "motor") -> Any:
    """Return a value of the store by its key, "SECTION/.../NAME", a number with its error."""
    *way, name = key.split("/")
    USED.add((file, way[0]))
    here: Any = results(file)
    for part in way:
        here = here[int(part)] if isinstance(here, list) else here[part]
    stored = here[int(name)] if isinstance(here, list) else here.get(name)
    if not isinstance(stored, float):
        return stored
    return Number(stored, here.get(f"{name}_error", 0.0) if isinstance(here, dict) else 0.0)


def less(a: float, b: float) -> bool | None:
    """Return whether a number is less than another; None where they are nearer than their errors."""
    blur = sum(getattr(each, "error", 0.0) for each in (a, b))
    return None if abs(float(b) - float(a)) < blur else a < b


def every(verdicts: Iterable[bool | None]) -> bool | None:
    """Return whether all verdicts are true; None if some are open and none is false."""
    known = [*verdicts]
    return False if False in known else None if None in known else True


def velocity(section: str, law: str) -> Any:
    """Return the settled velocity under a law [rad/s]; None where there is none."""
    return value(f"{section}/{law}/rotor_velocity")


def ratio(basis: str, mode: int) -> float:
    """Return a damping ratio of the default motor [1]."""
    return float(value(f"modes/{basis}/damping_ratio/{mode}"))


def speeds(section: str, laws: Iterable[str]) -> dict[str, Number]:
    """Return settled speeds by law [rad/s], without laws that have none."""
    return {law: abs(v) for law in laws if (v := velocity(section, law)) is not None}


def apart(section: str, laws: Iterable[str]) -> Number:
    """Return the range of speeds over their mean [1]."""
    least, *others, most = sorted(speeds(section, laws).values())
    mean = (least + sum(others) + most) / (2 + len(others))
    return Number((most - least) / mean, (most.error + least.error) / mean)


def fastest(section: str, law: str, laws: Iterable[str]) -> bool | None:
    """Return whether a law has the greatest speed of some laws."""
    here = speeds(section, laws)
    return every(less(speed, here[law]) for name, speed in here.items() if name != law)


def slowest(section: str, law: str, laws: Iterable[str]) -> bool | None:
    """Return whether a law has the least speed of some laws."""
    here = speeds(section, laws)
    return every(less(here[law], speed) for name, speed in here.items() if name != law)


NAMES: Final = {
    "hertz": "`hertz_penalty`",
    "stick": "`lagrange_stick`",
    "newton": "`newton`",
    "poisson": "`poisson`",
    "mindlin": "composed, `mindlin`",
    "slip": "`lagrange_slip`",
}
THREE, FOUR = ("stick", "newton", "hertz"), ("hertz", "stick", "newton", "mindlin")
FIVE, PICTURED = (*THREE, "poisson", "mindlin"), tuple(motor_findings.PICTURED)
PHASE: Final = "converged, by phase"
DAMPING: Final = "converged, by damping ratio at equal free amplitude"
PAPER, *LOWER = (f"{DAMPING}/{damping}" for damping in motor_findings.DAMPING)
ROD: Final = "converged, with a rod"


def evaluated(expression: str) -> Any:
    """Return the value of an expression over the store."""
    return eval(expression, globals())


@dataclass(frozen=True)
class Claim:
    """A sentence of a page, chosen by a predicate.

    Args:
        page: where it stands.
        population: what the predicate is about.
        sentence: what the page says if the predicate holds.
        holds: the predicate, an expression; empty for numbers that are stated as they are.
        otherwise, open: the sentence if the predicate does not hold, and if it is inconclusive.
    """

    page: str
    population: str
    sentence: str
    holds: str = ""
    otherwise: str = ""
    open: str = ""

    @property
    def templates(self) -> list[str]:
        """Every sentence that may stand on the page, the longest first."""
        return sorted(filter(None, (self.sentence, self.otherwise, self.open)), key=len, reverse=True)

    @property
    def verdict(self) -> str:
        """Whether the claim holds."""
        if not self.holds:
            return "stated"
        return {True: "holds", False: "does not hold", None: "inconclusive"}[evaluated(self.holds)]

    @property
    def template(self) -> str:
        """The sentence that the page states."""
        return {"does not hold": self.otherwise, "inconclusive": self.open}.get(self.verdict, self.sentence)


CLAIMS: Final = tuple(
    Claim(**claim)
    for claim in yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))
)


def markdown(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Return a table in Markdown."""
    lines = [[*head], *([*map(str, row)] for row in rows)]
    head, *body = [f"| {' | '.join(line)} |".replace("|  |", "| |") for line in lines]
    return "\n".join([head, "|---" * len(lines[0]) + "|", *body])


def with_age(file: str, sections: Iterable[str], table: str) -> str:
    """Return a table with a sentence below it where its numbers are older than the code."""
    old = [name for name in sections if state_of(read(file)["sections"][name]) == OLDER]
    return f"{table}\n\nMade by an earlier code: {', '.join(f'`{name}`' for name in old)}." if old else table


def front_page() -> str:
    """Return what the example of README prints."""
    bases = {"ritz": "four shapes", "finite_element": "converged"}
    lines = [
        f"{basis:15} {law:15} {float(number):8.4f} +- {number.error:.1g} rad/s"
        for basis, section in bases.items()
        for law in ("lagrange_stick", "newton", "hertz_penalty")
        for number in [
            velocity(f"default motor/{section}", law.removeprefix("lagrange_").removesuffix("_penalty"))
        ]
    ]
    return "\n".join(["```text", *lines, "```"])


def default_motor() -> str:
    """Return settled velocities and times of the default motor on both bases."""

    def cell(basis: str, law: str) -> str:
        here = value(f"default motor/{basis}/{law}")
        time, speed = here["settling_time"], velocity(f"default motor/{basis}", law)
        return f"{speed}, {here['kind']}" if time is None else f"{speed} ({1e3 * time:.1f} ms)"

    rows = ([NAMES[law], cell("four shapes", law), cell("converged", law)] for law in PICTURED)
    table = markdown(("", "four shapes of the paper", "converged beam"), rows)
    return with_age("motor", ["default motor"], table)


def by_phase() -> str:
    """Return velocity and stall torque over the phase of the drive."""
    phases = results("motor")[PHASE]

    def cell(phase: str, law: str) -> str:
        return (
            f"{velocity(f'{PHASE}/{phase}', law)}, {1e3 * value(f'{PHASE}/{phase}/{law}/stall_torque'):.3f}"
        )

    head = ("law", *(phase if phase == "configured" else f"phase {float(phase):g}" for phase in phases))
    laws = ("stick", "newton", "poisson", "hertz", "mindlin")
    return with_age(
        "motor", [PHASE], markdown(head, ([NAMES[x], *(cell(p, x) for p in phases)] for x in laws))
    )


def by_damping() -> str:
    """Return velocities over the damping."""

    def row(section: str) -> Iterator[object]:
        damping = section.removeprefix(f"{DAMPING}/")
        yield f"`{damping}`{' (paper)' * (section == PAPER)}"
        yield ", ".join(
            f"{ratio:.2g}" if ratio < 0.1 else f"{ratio:.3f}" for ratio in value(f"{section}/damping_ratio")
        )
        yield from (velocity(section, law) or "none" for law in FOUR)

    head = ("damping", "ratios", *(NAMES[law].removeprefix("composed, ") for law in FOUR))
    return with_age("motor", [DAMPING], markdown(head, map(row, (PAPER, *LOWER))))


def experiments() -> str:
    """Return the finding of each experiment, and whether its claim holds."""
    rows = (
        (f"`{name}`", "yes" if each["holds"] else "no", each["finding"])
        for name, each in results("experiments").items()
    )
    return with_age("experiments", results("experiments"), markdown(("script", "holds", "finding"), rows))


TABLES: Final[dict[str, Callable[[], str]]] = {
    "front page": front_page,
    "default motor": default_motor,
    "by phase": by_phase,
    "by damping": by_damping,
    "experiments": experiments,
}
