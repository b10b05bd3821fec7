"""Make docs/laws.md from what the laws declare, with a picture of each.

    python docs/tools/law_page.py [--output DIR]

A test makes the text again and compares, so that the page cannot go stale.
"""

import argparse
import inspect
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import matplotlib.pyplot as plt
from standard_cycle import curves_of, draw

from contactlab.cli.laws import declared_rows, described_parameter
from contactlab.laws import LAWS, PARTS, ContactLaw, law_class
from contactlab.laws.base import Part
from contactlab.laws.composed import Composed
from contactlab.laws.declaration import members_of
from contactlab.plot.style import STYLE

DOCS = Path(__file__).resolve().parents[1]
PAGE = "laws.md"
PICTURES = "laws"

OPENING = """\
# Contact laws

<!-- Made by docs/tools/law_page.py from the declarations of the laws. Do not edit. -->

Every law and every part of a composed law that comes with contactlab. `contactlab laws` prints the same
on the terminal, with the laws that other packages bring. Friction coefficients are
`contact.friction_coefficient`, the same for every law.

The pictures show a standard cycle. A compliant law is taken along a prescribed path, which
presses by 1 µm for 50 µs and slides twice to and fro by 1 µm. One that pulls is pressed in less, to ten
times its pull at the touch. A rigid law answers impacts of a body with the Delassus matrix [[600, 250],
[250, 800]] 1/kg: left over the approach at a slip of 0.05 m/s, right over the slip at an approach of 0.1 m/s.

What a law remembers is drawn over time, each internal variable over its largest value. Where a rigid law
remembers, or the cycle does not stir what a compliant one does, the friction is that of stick-slip: a block
of 2 g on a spring of 1 N/µm, pressed by 10 N onto a belt of 20 mm/s.
"""

FAMILIES = {
    "normal": "Normal forces (`law=composed law/normal=NAME`)",
    "damping": "Dampings (`law=composed law/damping=NAME`)",
    "friction": "Frictions (`law=composed law/friction=NAME`)",
}


def entries() -> Iterator[tuple[str, str, type[ContactLaw] | type[Part], ContactLaw]]:
    """Heading above, name, class, and the law that the picture is of."""
    for name in LAWS:
        law = law_class(name)
        yield "Laws (`law=NAME`)", name, law, law()
    for family, table in PARTS.items():
        for name, part in table.items():
            yield FAMILIES[family], f"{family}/{name}", part, Composed(**{family: part()})


def page() -> str:
    """The text of the page."""
    parts = [OPENING]
    above = ""
    for heading, name, owner, law in entries():
        if heading != above:
            parts.append(f"## {heading}\n")
            above = heading
        parts.append(section(name, owner, curves_of(law).numbers))
    return "\n".join(parts)


def section(name: str, owner: type[ContactLaw] | type[Part], numbers: str) -> str:
    """What the page says of one law or part."""
    label = inspect.getdoc(owner) or ""
    label = label.partition("\nArgs:")[0].partition("\nSource:")[0].strip()
    rows = [f"| `{n}` | {described_parameter(n, m, own=True)} |" for n, m in members_of(owner).items()]
    table = ["| parameter | symbol, unit, meaning, default, range |", "|---|---|", *rows, ""]
    declared = [f"* {word}: {text}" for word, text in declared_rows(owner).items() if text]
    # Where the words have equations of their own, it is one of their kind, and not the first.
    derived = "\n    " in label
    return "\n".join(
        [
            f"### {name.rpartition('/')[2]}",
            "",
            label,
            "",
            *([] if derived else [f"    {owner.equation}", ""]),
            *(table if rows else []),
            *([f"* equation: `{owner.equation}`"] if derived else []),
            *declared,
            f"* source: {owner.source}",
            "",
            numbers,
            "",
            f"![{name}]({picture(name)})",
            "",
        ]
    )


def picture(name: str) -> str:
    """Path of a picture beside the page."""
    return f"{PICTURES}/{name.replace('/', '_')}.png"


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page and its pictures; returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--output", type=Path, default=DOCS)
    folder: Path = parser.parse_args(arguments).output
    (folder / PICTURES).mkdir(parents=True, exist_ok=True)
    (folder / PAGE).write_text(page(), encoding="utf-8")
    with plt.style.context(STYLE):
        for _, name, _, law in entries():
            draw(curves_of(law)).savefig(folder / picture(name), dpi=110, metadata={"Software": None})
    return 0


if __name__ == "__main__":
    sys.exit(main())
