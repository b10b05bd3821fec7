"""Write the numbers of the pages from docs/results: sentences with a result, tables, and docs/claims.md.

    python experiments/results_pages.py [--check | --restamp]

A sentence of `claims.CLAIMS` stands on its page as its template, with the numbers of the store and in the
form that its predicate decides; a table stands between `<!-- table NAME -->` and `<!-- end of the table -->`.
Without an option the pages are written anew. `--check` says what differs, which results stand on a page
without a claim, and which cheap sections that are older than the code have other digits under it, and
makes them anew for that; the exit status is then 1. `--restamp` makes all cheap sections anew, and where
their digits are the same puts down that the others were checked by them.
"""

import argparse
import re
import sys
from collections.abc import Iterator, Sequence
from difflib import unified_diff
from itertools import zip_longest
from string import Formatter
from textwrap import fill

import claims
import results_store
from claims import CHEAP, CLAIMS, TABLES, Claim
from results_store import CHECKED, OLDER, PRESENT, ROOT, state_of

LIST = "docs/claims.md"

TABLE = re.compile(r"(<!-- table ([\w ]+) -->\n\n)(.*?)(\n\n<!-- end of the table -->)", re.DOTALL)
CODE = re.compile(r"^```.*?^```|`[^`\n]+`|<!--.*?-->|\]\([^)\n]*\)", re.DOTALL | re.MULTILINE)
INPUT = re.compile(r"<!-- inputs -->.*?<!-- end of the inputs -->", re.DOTALL)
RESULT = re.compile(r"[-+]?\d[\d.,]*(?:e[-+]?\d+)?\s*(?:%|rad/s|mm/s|mN\s+m|mW\b)")
"""A number with a unit of speed, torque or power, or a share."""

OPENING = """\
# What is claimed

<!-- Made by experiments/results_pages.py. Do not edit. -->

Every sentence that states a result on the pages below, with the population that it is about, the predicate
that chose it, and whether that holds. A predicate is inconclusive where two numbers are nearer to each other
than their errors. Numbers without a predicate are stated as they are. The values are those of
`docs/results/`, the predicates are evaluated by `experiments/results_pages.py`.
"""


class Page:
    """A page of the repository, and the spans of it that come from the store."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.old = self.text = (ROOT / name).read_text(encoding="utf-8") if (ROOT / name).is_file() else ""

    def fill(self) -> Iterator[str]:
        """Write sentences and tables; yields what is missing."""
        self.text = TABLE.sub(lambda each: each[1] + TABLES[each[2]]() + each[4], self.text)
        for claim in of_page(self.name):
            # A sentence may begin as another does: the longest one counts, and comes first.
            places: dict[int, re.Match[str]] = {}
            for each in (each for text in claim.templates for each in pattern(text).finditer(self.text)):
                places.setdefault(each.start(), each)
            if len(places) == 1:
                (place,) = places.values()
                new = in_place(
                    place[0], rendered(claim), place.start() - self.text.rfind("\n", 0, place.start())
                )
                self.text = self.text[: place.start()] + new + self.text[place.end() :]
            else:
                yield f"{self.name}: {len(places) or 'none'} of: {claim.sentence}"

    def bare(self) -> Iterator[str]:
        """Yield the results that no claim and no table states."""
        text = INPUT.sub("", TABLE.sub("", self.text))
        for claim in of_page(self.name):
            for sentence in claim.templates:
                text = pattern(sentence).sub("", text)
        text = claims.INPUTS.sub("", CODE.sub("", text))
        yield from (f"{self.name}: '{each[0]}' has no claim" for each in RESULT.finditer(text))


def of_page(name: str) -> list[Claim]:
    """Return the claims of a page."""
    return [claim for claim in CLAIMS if claim.page == name]


def pattern(template: str) -> re.Pattern[str]:
    """Return what a template matches, whatever its numbers and its line breaks."""
    parts = []
    for literal, field, _, _ in Formatter().parse(template):
        parts.append(re.sub(r"(?:\\?\s)+", r"\\s+", re.escape(literal)))
        if field is not None:
            parts.append(r"\S+?")
    return re.compile("".join(parts) + r"(?!\d)")


def rendered(claim: Claim) -> str:
    """Return the sentence of a claim that holds, with its numbers."""

    class Evaluated(Formatter):
        def get_field(self, field_name: str, args: object, kwargs: object) -> tuple[object, str]:
            return claims.evaluated(field_name), field_name

    return Evaluated().format(claim.template)


def in_place(old: str, new: str, column: int) -> str:
    """Return a new sentence with the line breaks of the old one, or with new ones where they do not fit."""
    tokens, breaks = new.split(), re.findall(r"\s+", old)
    if len(tokens) == len(old.split()):
        kept = "".join(a + b for a, b in zip_longest(tokens, breaks, fillvalue=""))
        # Markdown with directives takes a line that begins with a percent sign for a comment.
        if not re.search(r"^\s*%", kept, re.MULTILINE):
            return kept
    # A number stays with its unit.
    whole = re.sub(r"(\d) (?=%|rad/s|mm/s|m[NW] )", "\\1\N{NO-BREAK SPACE}", new)
    indent = " " * (column - 1)
    text = fill(whole, 120, initial_indent=indent, break_long_words=False, break_on_hyphens=False)
    return text.replace("\N{NO-BREAK SPACE}", " ").lstrip()


def listed() -> str:
    """Return the page of all claims, and of the code that made their numbers."""
    lines = [OPENING]
    for page in claims.PAGES:
        lines.append(f"## {page}\n")
        for claim in of_page(page):
            claims.USED.clear()
            lines.append(f"* **{claim.verdict}**: {rendered(claim)}\n  ({claim.population})")
            lines += [f"  `{claim.holds}`"] if claim.holds else []
            old = {
                name
                for file, name in claims.USED
                if state_of(results_store.read(file)["sections"][name]) == OLDER
            }
            lines += [f"  Older than the code: {', '.join(sorted(old))}."] if old else []
        lines.append("")
    lines += [
        "## The code that made the numbers\n",
        "| results | section | code | state |",
        "|---|---|---|---|",
    ]
    for file in claims.FILES:
        for name, section in results_store.read(file)["sections"].items():
            state = {
                PRESENT: "made by the present code",
                CHECKED: "not made anew; the cheap sections have the same digits under the present code",
                OLDER: "older than the present code",
            }[state_of(section)]
            lines.append(f"| {file} | {name} | {section['made']} | {state} |")
    return "\n".join(lines) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Write or check the pages and return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    only = parser.add_mutually_exclusive_group()
    only.add_argument("--check", action="store_true", help="write nothing, and say what differs")
    only.add_argument("--restamp", action="store_true", help="make cheap sections anew, and compare")
    chosen = parser.parse_args(arguments)
    others = results_store.check(CHEAP, claims.FILES) if chosen.restamp else []
    if chosen.check:
        others = results_store.different(CHEAP)
    pages = [Page(name) for name in claims.PAGES]
    faults = [fault for page in pages for fault in (*page.fill(), *page.bare())]
    pages.append(Page(LIST))
    pages[-1].text = listed() if not faults else pages[-1].old
    faults += [f"{name} has other digits under the present code; make its file anew." for name in others]
    for page in pages:
        if page.text != page.old and chosen.check:
            faults += unified_diff(
                page.old.splitlines(), page.text.splitlines(), page.name, "store", n=0, lineterm=""
            )
        elif page.text != page.old:
            (ROOT / page.name).write_text(page.text, encoding="utf-8")
    print(*faults, sep="\n", end="\n" if faults else "")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
