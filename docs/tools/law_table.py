"""Make docs/law_table.md: every law and part, its size, contract, and what is published of it beside ours.

    python docs/tools/law_table.py [--output DIR]

The contracts run in full, which takes minutes. A test makes sure that no law is without its row.
"""

import argparse
import inspect
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path

from law_page import FAMILIES, law_of, powers_of_ten, table, unit
from tqdm import tqdm

from contactlab.laws import ContactLaw
from contactlab.laws.declaration import Declared
from contactlab.testing.claim import Claim
from contactlab.testing.contract import PROPERTIES, check
from contactlab.testing.plants import Bench

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
PAGE = "law_table.md"

OPENING = """\
# Laws, their contracts and what is published of them

<!-- Made by docs/tools/law_table.py. Do not edit. -->

One row a law; a part is tested in a law that otherwise is a Hertz contact with Coulomb friction. *Breaks*:
which properties of the contract, `contactlab.testing.LawContract`, the law declares to break, with the reason
on its page; all others hold. *Published*: a number or a closed form of the source, and what the law answers
or does in the engine where that is another number; *apart*: the difference over the published one.
"""

HEADS = ("law", "breaks", "published", "value", "apart")
UNPUBLISHED = "no closed form"


@dataclass(frozen=True)
class Entry:
    """A row: heading of its table, label, class, its law, and its first published claim."""

    title: str
    label: str
    owner: type[Declared]
    law: ContactLaw
    number: Callable[[], Claim | None]
    heading: str


def entries() -> Iterator[Entry]:
    """Yield every law and part of contactlab."""
    # The published results are tests.
    if str(TESTS) not in sys.path:
        sys.path.insert(0, str(TESTS))
    published = import_module("support.published")
    for family in FAMILIES:
        for name, owner in family.owners.items():
            proofs = published.published_of(name, owner.family)
            heading = _first_line(proofs[0]) if proofs else ""
            number = partial(published.headline, name, owner.family)
            label = f"[{name}]({family.address(name)})"
            yield Entry(family.title, label, owner, law_of(owner), number, heading)


def _first_line(proof: object) -> str:
    return (inspect.getdoc(proof) or "").partition("\n")[0]


def row(entry: Entry) -> list[str]:
    """Return the cells of a law, its contract run in full."""
    bench = Bench(entry.law)
    verdicts = {name: check(bench, name) for name in PROPERTIES}
    broken = [name for name, claims in verdicts.items() if any(claim.excuse for claim in claims)]
    failed = [name for name, claims in verdicts.items() if not all(claim.holds for claim in claims)]
    breaks = ", ".join([*broken, *(f"**fails {name}**" for name in failed)])
    return [entry.label, breaks, *_number(entry)]


def _number(entry: Entry) -> tuple[str, str, str]:
    claim = entry.number()
    if claim is None:
        return UNPUBLISHED, "", ""
    relation = "" if claim.relation == "=" else f"{claim.relation} "
    size = abs(claim.expected)
    distance = abs(claim.value - claim.expected)
    apart = "0" if not distance else f"{distance / size:.1e}" if size and not relation else ""
    ours = f"{claim.value:.6g}"
    ours = ours if claim.true else f"**{ours}**"
    value = f"{relation}{claim.expected:.6g}"
    value = " ".join(filter(None, [value if value == ours else f"{value}; here {ours}", unit(claim.units)]))
    published = f"{entry.heading} {claim.statement}".replace("|", "\\|")
    return published, powers_of_ten(value), powers_of_ten(apart)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page; returns the exit status, 1 where a law fails in what it claims."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--output", type=Path, default=ROOT / "docs")
    folder: Path = parser.parse_args(arguments).output
    tables: dict[str, list[list[str]]] = {}
    for entry in tqdm(list(entries()), unit=" laws", disable=None):
        tables.setdefault(entry.title, []).append(row(entry))
    text = page(tables)
    (folder / PAGE).write_text(text, encoding="utf-8")
    return int("**" in text)


def page(tables: Mapping[str, Iterable[Sequence[str]]]) -> str:
    """Return the text of the page from the rows of each table."""
    return OPENING + "".join(
        f"\n## {title}\n\n" + "\n".join(table(HEADS, rows)) for title, rows in tables.items()
    )


if __name__ == "__main__":
    sys.exit(main())
