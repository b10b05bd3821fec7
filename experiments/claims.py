"""Sentences of the pages that state a result; they stand in claims.yaml.

A claim has a population, a predicate and what the page says if it holds, if it does not, and if that is open.
A predicate is an expression over the files of results with the names of recorded_numbers.py,
recorded_contrasts.py, recorded_practice.py and verdicts.py.
It is true, false, or None where the uncertainty of the numbers leaves it open. `{expression:format}` in a
sentence is a number. What was measured or follows in closed form, and claims nothing, is stated without a
predicate. `results_pages.py` writes the sentence that holds on its page.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import recorded_contrasts
import recorded_numbers
import recorded_practice
import verdicts
import yaml
from dependencies import ROOT

GENERATED: Final = (
    "docs/claims.md",
    "docs/judged_motors.md",
    "docs/law_table.md",
    "docs/laws.md",
    "docs/laws/",
    "docs/plausibility.md",
    "docs/random_runs.md",
    "docs/simulators.md",
)
"""Pages whose numbers other scripts write, from runs or declarations of their own."""

PAPERS: Final = ("paper/paper.md", "paper/laws/laws.md")
"""Pages of which the conclusions are their authors': a script writes their numbers, and no other sentence."""

PAGES: Final = tuple(
    name
    for path in (
        ROOT / "README.md",
        *(ROOT / each for each in PAPERS),
        *sorted((ROOT / "docs").rglob("*.md")),
    )
    if not (name := path.relative_to(ROOT).as_posix()).startswith((*GENERATED, "docs/build/"))
)
"""Pages that state no result without a claim."""


def evaluated(expression: str) -> Any:
    """Return the value of an expression over the recorded numbers and verdicts."""
    modules = verdicts, recorded_numbers, recorded_contrasts, recorded_practice
    return eval(expression, {name: each for module in modules for name, each in vars(module).items()})


@dataclass(frozen=True)
class Statement:
    """A sentence of a page on what was measured or follows in closed form.

    Args:
        page: where it stands.
        population: what it is about.
        sentence: what the page says.
    """

    page: str
    population: str
    sentence: str

    @property
    def templates(self) -> list[str]:
        """Every sentence that may stand on the page, the longest first."""
        return [self.sentence]

    @property
    def template(self) -> str:
        """The sentence that the page states."""
        return self.sentence

    @property
    def reason(self) -> str:
        """Why the page states it."""
        return "Stated as it was measured or follows in closed form."


HOLDS, DOES_NOT_HOLD, OPEN = "holds", "does not hold", "open"
"""Verdicts on a claim."""


@dataclass(frozen=True)
class Claim(Statement):
    """A sentence of a page, chosen by a predicate.

    Args:
        holds: the predicate, an expression; `sentence` is what the page says if it holds.
        otherwise, open: the sentence if it does not hold, and if that is open.
    """

    holds: str
    otherwise: str
    open: str

    @property
    def templates(self) -> list[str]:
        """Every sentence that may stand on the page, the longest first."""
        return sorted({self.sentence, self.otherwise, self.open}, key=len, reverse=True)

    @property
    def verdict(self) -> str:
        """Whether the claim holds."""
        return {True: HOLDS, False: DOES_NOT_HOLD, None: OPEN}[evaluated(self.holds)]

    @property
    def template(self) -> str:
        """The sentence that the page states."""
        return {HOLDS: self.sentence, DOES_NOT_HOLD: self.otherwise, OPEN: self.open}[self.verdict]

    @property
    def reason(self) -> str:
        """Why the page states it."""
        return {
            HOLDS: f"Stated as this is true: `{self.holds}`",
            DOES_NOT_HOLD: f"Stated as this is false: `{self.holds}`",
            OPEN: f"Stated as the results leave open whether this is true: `{self.holds}`",
        }[self.verdict]


_WRITTEN: Final = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))


def on_pages(written: Iterable[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield what is written of statements once for each of their pages."""
    for each in written:
        pages = each["page"] if isinstance(each["page"], list) else [each["page"]]
        yield from (each | {"page": page} for page in pages)


CLAIMS: Final = tuple(Claim(**each) for each in on_pages(_WRITTEN["claims"]))
STATEMENTS: Final = (*CLAIMS, *(Statement(**each) for each in on_pages(_WRITTEN["measured"])))
