"""Make docs/law_table.md: every law and part, its size, contract, and what is published of it beside ours.

    python docs/tools/law_table.py [--output DIR]

The contracts run in full, which takes minutes. A test makes sure that no law is without its row.
"""

import argparse
import inspect
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from tqdm import tqdm

from contactlab.laws import LAWS, PARTS, ContactLaw, MultiplierLaw
from contactlab.laws.base import Part
from contactlab.laws.composed import Composed
from contactlab.testing.claim import Claim, proofs_of
from contactlab.testing.contract import PROPERTIES, check
from contactlab.testing.plants import Bench

ROOT = Path(__file__).resolve().parents[2]
PAGE = "law_table.md"

OUTSIDE = ROOT / "tests" / "fourteen_laws"
"""A package of its own, with laws that are in the literature and not in contactlab."""

OPENING = """\
# Laws, their contracts and what is published of them

<!-- Made by docs/tools/law_table.py. Do not edit. -->

One row a law, or a part in a law that is a Hertz contact with Coulomb friction but for it. *Lines* are those
of its class, words and blank lines included. *Remembers* counts the internal variables with the default
parameters. The contract is `contactlab.testing.LawContract`: how many of its properties hold, and which
the law declares to break, with the reason at its class. What is published is a number or a closed form of the
source, ours is what the law answers or does in the engine.

| law | lines | remembers | contract | published | | ours | apart |
|---|---|---|---|---|---|---|---|
"""

UNPUBLISHED = "no closed form of it is held to"


@dataclass(frozen=True)
class Entry:
    """A law or part of the table: family, class, the law that contains it, and its first published claim."""

    family: str
    owner: type[ContactLaw] | type[Part]
    law: ContactLaw
    number: Callable[[], Claim | None]
    heading: str

    @property
    def name(self) -> str:
        """As configurations choose it."""
        return f"{self.family}={self.owner.name}"


def entries() -> Iterator[Entry]:
    """Return every law and part of contactlab, then those of the package outside of it."""
    for name, owner in LAWS.items():
        yield _own("law", owner, owner(), "", name)
    for family, table in PARTS.items():
        for name, part in table.items():
            yield _own(f"law/{family}", part, Composed(**{family: part()}), family, name)
    yield from outside()


def _own(group: str, owner: type, law: ContactLaw, family: str, name: str) -> Entry:
    published = _module("support.published", ROOT / "tests")
    proofs = published.published_of(name, family)
    heading = _first_line(proofs[0]) if proofs else ""
    return Entry(group, owner, law, partial(published.headline, name, family), heading)


def _module(name: str, folder: Path) -> Any:
    """Return a module of the tests."""
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    return import_module(name)


def outside() -> Iterator[Entry]:
    """Return the laws of the package outside of contactlab, each with its own published number."""
    numbers = _module("published_numbers", OUTSIDE)
    proofs = proofs_of(numbers)
    for owner in vars(numbers).values():
        if isinstance(owner, type) and getattr(owner, "name", "") in proofs:
            proof = proofs[owner.name]
            law = owner() if issubclass(owner, ContactLaw) else Composed(**{owner.family: owner()})
            group = "law" if law.__class__ is owner else f"law/{owner.family}"
            yield Entry(group, owner, law, partial(_first_claim, proof), _first_line(proof))


def _first_claim(proof: Callable[[], Iterator[Claim]]) -> Claim | None:
    return next(proof(), None)


def _first_line(proof: object) -> str:
    return (inspect.getdoc(proof) or "").partition("\n")[0]


def row(entry: Entry) -> str:
    """Return the row of a law, its contract run in full."""
    bench = Bench(entry.law)
    verdicts = {name: check(bench, name) for name in PROPERTIES}
    broken = [n for n, claims in verdicts.items() if any(claim.excuse for claim in claims)]
    failed = [n for n, claims in verdicts.items() if not all(claim.holds for claim in claims)]
    fixed = len(verdicts) - len({*broken, *failed})
    contract = f"{fixed} hold"
    contract += f"; declared broken: {', '.join(broken)}" if broken else ""
    contract += f"; **fails**: {', '.join(failed)}" if failed else ""
    lines = len(inspect.getsourcelines(entry.owner)[0])
    kind = "rigid" if isinstance(entry.law, MultiplierLaw) else "compliant"
    variables = entry.law.internal_variables
    remembers = f"{len(variables)}" if variables else ""
    number = _number(entry)
    return f"| `{entry.name}` ({kind}) | {lines} | {remembers} | {contract} | {number} |"


def _number(entry: Entry) -> str:
    claim = entry.number()
    if claim is None:
        return f"{UNPUBLISHED} | | | "
    unit = "" if claim.units == "1" else f" {claim.units}"
    relation = "" if claim.relation == "=" else f"{claim.relation} "
    size = abs(claim.expected)
    apart = f"{abs(claim.value - claim.expected) / size:.1e}" if size and not relation else ""
    wrong = "" if claim.true else "**"
    text = f"{entry.heading} {claim.statement}".replace("|", "\\|")
    return f"{text} | {relation}{claim.expected:.6g}{unit} | {wrong}{claim.value:.6g}{unit}{wrong} | {apart}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page; returns the exit status, 1 where a law fails in what it claims."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--output", type=Path, default=ROOT / "docs")
    folder: Path = parser.parse_args(arguments).output
    rows = [row(entry) for entry in tqdm(list(entries()), unit=" laws", disable=None)]
    (folder / PAGE).write_text(OPENING + "\n".join(rows) + "\n", encoding="utf-8")
    return int("**" in "".join(rows))


if __name__ == "__main__":
    sys.exit(main())
