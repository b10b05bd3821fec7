"""Write the numbers of the pages from docs/results: sentences with a result, tables, and docs/claims.md.

    python experiments/results_pages.py [--check]

A sentence of `claims.CLAIMS` stands on its page as its template, with the numbers of the store and in the
form that its predicate decides; a table stands between `<!-- table NAME -->` and `<!-- end of the table -->`.
A page whose results are not of the present code says so at its end. Every other number with a unit is listed
in numbers.yaml with its origin, which is checked (listed_numbers.py). A paper of which a sentence has fallen
is left as it is, and the sentence is named: what it concludes is its authors' to write. Without an option the
pages are written anew; `--check` says what differs. The exit status is 1 where something differs, where a
number stands on a page without a claim and unlisted or is not what its origin has, where a section was
changed by hand, and where its short form has other digits under the present code. remake.py makes sections.
"""

import argparse
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from difflib import unified_diff
from functools import cache
from itertools import zip_longest
from string import Formatter
from textwrap import fill

import accuracy_tables
import claims
import listed_numbers
import result_tables
from claims import PAPERS, STATEMENTS, Claim, Statement
from dependencies import ROOT
from recorded_numbers import FILES, USED
from results_store import CHECKED, DIFFERENT, EDITED, OLDER, PRESENT, changed, read, state_of

LIST = "docs/claims.md"
TABLES = result_tables.TABLES | accuracy_tables.TABLES

TABLE = re.compile(r"(<!-- table ([\w ]+) -->\n\n)(.*?)(\n\n<!-- end of the table -->)", re.DOTALL)
CODE = re.compile(r"^```.*?^```|^\$\$.*?^\$\$|`[^`\n]+`|<!--.*?-->|\]\([^)\n]*\)", re.DOTALL | re.MULTILINE)
UNIT = (
    r"%|rad/s|[mkM]?Hz|[munp]?s|[mun]?N(?:/m|\s+m\b|\s+s\b)?|[kMG]?Pa|[mukn]?m(?:/s)?|[mu]?[WAJ]|k?V|[mk]?g|rpm"
    r"|[kMG]B|bytes|deg(?:rees?)?|errors?|times"
)
RESULT = re.compile(
    rf"(?<![\w.])[-+]?\d(?:[\d.,]*\d)?(?:e[-+]?\d+)?\s+(?:(?:{UNIT})(?![\w/-])|of\s+(?:\d|all|the|them)[\d,]*)"
    r"|\d%|Q\s+(?:=|of)\s+\d[\d.]*"
    r"|\b(?:half|two\s+thirds|three\s+quarters|a\s+third|a\s+quarter|one\s+in\s+\w+)"
    r"\s+of\s+(?:all|the\s+(?:motors|laws)|them)\b"
    r"|\bevery\s+(?:second|third)\s+(?:motor|law)"
    r"|(?<=\|\s)[-+]?\d+\.\d+(?:e[-+]?\d+)?(?=\s(?:\||±|\+-))"
)
"""A number with a unit, a share or a count of some, a decimal number as a cell of a table."""

AGE = re.compile(r"\n+<!-- age of the results -->.*?<!-- end of the age -->", re.DOTALL)
OTHER = {
    CHECKED: "Made by an earlier code; a short form has the same digits under the present one:",
    OLDER: "Made by an earlier code, and not checked:",
    DIFFERENT: "Made by an earlier code; a short form has other digits under the present one:",
}
"""What a page says of results that are not of the present code."""

OPENING = """\
# What is claimed

<!-- Made by experiments/results_pages.py. Do not edit. -->

Every sentence that states a result on the pages below, with the population that it is about and the predicate
that chose it. A predicate is true, false, or open: where the intervals of two numbers have a value in common,
where a share of so many motors may lie on either side of a bound, where repetitions differ. What was measured
or follows in closed form, and claims nothing, has no predicate. The values are those of `docs/results/`, the
predicates are evaluated by `experiments/results_pages.py`.
"""


class Page:
    """A page of the repository, and the spans of it that come from the store."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.old = self.text = (ROOT / name).read_text(encoding="utf-8") if (ROOT / name).is_file() else ""

    def fill(self) -> Iterator[str]:
        """Write sentences and tables, and of what code they are; yields what is missing."""
        USED.clear()
        self.text = TABLE.sub(lambda each: each[1] + TABLES[each[2]]() + each[4], self.text)
        for claim in of_page(self.name):
            # A sentence may begin as another does: the longest one counts, and comes first.
            places: dict[int, re.Match[str]] = {}
            for each in (each for text in claim.templates for each in pattern(text).finditer(self.text)):
                places.setdefault(each.start(), each)
            if len(places) == 1:
                (place,) = places.values()
                line = self.text[self.text.rfind("\n", 0, place.start()) + 1 : place.start()]
                new = in_place(place[0], rendered(claim), line)
                self.text = self.text[: place.start()] + new + self.text[place.end() :]
            else:
                yield f"{self.name}: {len(places) or 'none'} of: {claim.sentence}"
        own = AGE.sub("", self.text).rstrip("\n")
        self.text = f"{own}\n{age_of(USED)}" if own else ""

    def fallen(self) -> Iterator[str]:
        """Yield sentences of a paper that do not hold, each with the one that does."""
        if self.name not in PAPERS:
            return
        for claim in (each for each in of_page(self.name) if isinstance(each, Claim)):
            standing = [each for text in claim.templates if (each := pattern(text).search(self.old))]
            if standing and not pattern(claim.template).search(self.old):
                fallen = " ".join(standing[0][0].split())
                yield f"{self.name}: '{fallen}' has fallen by `{claim.holds}`. It is '{rendered(claim)}'."

    def numbers(self) -> Counter[str]:
        """Count the numbers that no claim and no table states."""
        text = AGE.sub("", TABLE.sub("", self.text))
        for claim in of_page(self.name):
            for sentence in claim.templates:
                text = pattern(sentence).sub("", text)
        return Counter(" ".join(each[0].split()) for each in RESULT.finditer(CODE.sub("", text)))

    def bare(self) -> Iterator[str]:
        """Yield numbers that are not listed either, are there no more, or are listed wrong."""
        here, known = self.numbers(), Counter(listed_numbers.of_page(self.name))
        yield from (f"{self.name}: '{each}' has no claim" for each in (here - known).elements())
        yield from (f"{self.name}: '{each}' stands there no more" for each in (known - here).elements())
        yield from listed_numbers.faults(self.name, self.text)


@cache
def states() -> dict[tuple[str, str], str]:
    """Return the states of all sections by file and name."""
    every = ((file, name, own) for file in FILES for name, own in read(file)["sections"].items())
    return {(file, name): state_of(own) for file, name, own in every}


def age_of(used: Iterable[tuple[str, str]]) -> str:
    """Return the paragraph on results of a page that are not of the present code; empty if there are none."""
    here = {state: sorted(key[1] for key in used if states()[key] == state) for state in OTHER}
    lines = [
        f"{text} {', '.join(f'`{name}`' for name in here[state])}."
        for state, text in OTHER.items()
        if here[state]
    ]
    if not lines:
        return ""
    return "\n\n".join(("\n<!-- age of the results -->", *lines, "<!-- end of the age -->\n"))


def of_page(name: str) -> list[Statement]:
    """Return the statements of a page."""
    return [each for each in STATEMENTS if each.page == name]


WORD = r"\S+?"
FEW_WORDS, MANY_WORDS = (rf"{WORD}(?:(?: +| *\n *){WORD}){{0,{most}}}?" for most in (5, 60))
"""A number, and one with its error or the name of a factor; and a list of names."""


def pattern(template: str) -> re.Pattern[str]:
    """Return what a template matches, whatever its numbers and its line breaks."""
    parts: list[str] = []
    for literal, field, _, _ in Formatter().parse(template):
        parts.append(re.sub(r"(?:\\?\s)+", r"\\s+", re.escape(literal)))
        if field is not None:
            # Where a sentence begins with a number, what stands before it is not its own.
            several = MANY_WORDS if "join(" in field else FEW_WORDS
            parts.append(several if "".join(parts) else WORD)
    return re.compile("".join(parts) + r"(?!\d)")


def rendered(claim: Statement) -> str:
    """Return the sentence of a claim that holds, with its numbers."""

    class Evaluated(Formatter):
        def get_field(self, field_name: str, args: object, kwargs: object) -> tuple[object, str]:
            return claims.evaluated(field_name), field_name

    return Evaluated().format(claim.template)


def in_place(old: str, new: str, line: str) -> str:
    """Return a new sentence with the line breaks of the old one, or with new ones where they do not fit.

    Args:
        old, new: sentences.
        line: what stands before the old one on its line.
    """
    tokens, breaks = new.split(), re.findall(r"\s+", old)
    if len(tokens) == len(old.split()):
        kept = "".join(a + b for a, b in zip_longest(tokens, breaks, fillvalue=""))
        # Markdown with directives takes a line that begins with a percent sign for a comment.
        if not re.search(r"^\s*%", kept, re.MULTILINE):
            return kept
    # A number stays with its unit.
    whole = re.sub(r"(\d) (?=%|rad/s|mm/s|m[NW] )", "\\1\N{NO-BREAK SPACE}", new)
    listed_or_not = re.match(r"\s*(?:[*-]\s+)?", line)
    indent = " " * (len(listed_or_not[0]) if listed_or_not else 0)
    text = fill(
        whole,
        120,
        initial_indent=" " * len(line),
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return text.replace("\N{NO-BREAK SPACE}", " ").lstrip()


def listed() -> str:
    """Return the page of all claims, and of the code that made their numbers."""
    lines = [OPENING]
    for page in dict.fromkeys(each.page for each in STATEMENTS):
        lines.append(f"## {page}\n")
        lines += [f"* {rendered(x)}\n  ({x.population})\n  {x.reason}" for x in of_page(page)]
        lines.append("")
    lines += ["## The code that made the numbers\n", "| results | section | code |", "|---|---|---|"]
    for (file, name), state in states().items():
        about = {
            PRESENT: "made by the present code",
            CHECKED: "made by an earlier code; its short form has the same digits under the present one",
            OLDER: "made by an earlier code",
            DIFFERENT: "made by an earlier code; its short form has other digits under the present one",
            EDITED: "changed by hand",
        }[state]
        lines.append(f"| {file} | {name} | {about} |")
    return "\n".join(lines) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Write or check the pages and return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing, and say what differs")
    chosen = parser.parse_args(arguments)
    pages = [Page(name) for name in claims.PAGES]
    faults = [fault for page in pages for fault in page.fill()]
    faults += [fault for page in pages for fault in page.bare()]
    fallen = {page.name: [*page.fallen()] for page in pages}
    faults += [fault for own in fallen.values() for fault in own]
    pages.append(Page(LIST))
    pages[-1].text = listed() if not faults else pages[-1].old
    by_hand = [f"{file}: {name} was changed by hand." for (file, name), x in states().items() if x == EDITED]
    faults += by_hand
    for (file, name), state in states().items():
        if state == DIFFERENT:
            names = ", ".join(sorted(changed(read(file)["sections"][name])))
            faults.append(
                f"{file}: {name} has other digits in its short form: make it anew. Changed: {names}."
            )
    for page in pages:
        if page.text != page.old and chosen.check:
            faults += unified_diff(
                page.old.splitlines(), page.text.splitlines(), page.name, "store", n=0, lineterm=""
            )
        elif page.text != page.old and not by_hand and not fallen.get(page.name):
            (ROOT / page.name).write_text(page.text, encoding="utf-8")
    print(*faults, sep="\n", end="\n" if faults else "")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
