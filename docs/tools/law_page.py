"""Make docs/laws.md and the pages below docs/laws/ from what the laws declare, with a picture of each.

    python docs/tools/law_page.py [--output DIR]

A test makes the text again and compares, so that the pages cannot go stale.
"""

import argparse
import inspect
import sys
from collections.abc import Iterator, Sequence
from dataclasses import MISSING, replace
from pathlib import Path
from textwrap import fill
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from standard_cycle import curves_of, draw

import contactlab as cl
from contactlab.cli.verbs.laws import declared_rows
from contactlab.laws import ContactLaw, MultiplierLaw
from contactlab.laws.composed import Composed
from contactlab.laws.declaration import SHARED, Declared, members_of
from contactlab.laws.memory import ODD
from contactlab.parameter import DeclaredField
from contactlab.plot.style import STYLE

DOCS = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(DOCS / "extensions"))

import equations  # noqa: E402
from law_families import FAMILIES, Family  # noqa: E402
from page_tables import powers_of_ten, raised, symbol, table, unit  # noqa: E402

PAGE = "laws.md"
FOLDER = "laws"
MADE = "<!-- Made by docs/tools/law_page.py from the declarations of the laws. Do not edit. -->\n"

GUIDE = Path(__file__).with_name("law_guide.txt")
"""What stands before the tables, with marks for numbers."""

END = """\
## The columns

* *Contact*: *rigid*, with impulses and a gap held at zero, or *compliant*, with a force over the penetration.
* *Normal loss*: how much of the energy of the approach a contact does not give back.
* *Stick*: tangentially *rigid*; *elastic*, so that it yields before it slides; *creep* under any load; or
  *none*.
* *Rate*: the same path, or impact, at another speed has other forces.
* *Memory*: the internal variables.
* *Adhesion*: the contact bears tension, or has friction under it.
* *Needs*: what has to be measured or known besides the friction coefficient; numbers have defaults.
* *Valid for*: as the source of the law says, where it does.

Loss and rate are those of the standard cycle, with default parameters. How far laws are apart in a motor is
another question: [When does the law matter?](when_laws_matter.md)

## The pictures

A compliant law is taken along a standard cycle, a prescribed path that presses by 1 µm for 50 µs and slides
twice to and fro by 1 µm. One that pulls is pressed in less, to ten times its pull at the touch-down. A rigid
law answers impacts of a body with the Delassus matrix [[600, 250], [250, 800]] 1/kg: normal impulses over the
approach at a slip of 0.05 m/s, friction impulses over the slip at an approach of 0.1 m/s.

The reference is grey: Hertz without damping and with Coulomb friction for compliant laws, the plastic impact
`lagrange_stick` for rigid ones. A curve that is the reference's is left out.

Internal variables are drawn over time, each over its largest value. Where a rigid law remembers, or the cycle
does not change what a compliant one does, the friction is that of stick-slip: a block of 2 g on a spring of 1
N/µm, pressed by 10 N onto a belt of 20 mm/s.

## Further

* [Contracts and publications](law_table.md): what each law is held to, and what is published of it
* [Writing a contact law](writing_laws.md): examples, from ten lines to a plastic dent
* [The laws' keys](reference/law_keys.md): what each can be given
* `contactlab laws` prints the same on the terminal, with the laws that other packages bring
"""

USUAL = {("tension", "none"), ("contact step", "none"), ("convergence order", "1")}
"""What is declared of most laws, and left out."""

HEADS = ("contact", "normal loss", "stick", "rate", "memory", "adhesion")


def law_of(owner: type[Declared]) -> ContactLaw:
    """Return the law that a page draws: a part stands in an otherwise plain composition."""
    made: Any = owner()
    return made if isinstance(made, ContactLaw) else Composed(**{made.family: made})


def pages() -> Iterator[tuple[str, str]]:
    """Yield the path and text of every page."""
    parts = [entry(), *(choice(family) for family in FAMILIES), END, "```{toctree}\n:hidden:\n"]
    parts[-1] += "".join(f"\n{FOLDER}/{family.page}.md" for family in FAMILIES)
    parts[-1] += "\nContracts and publications <law_table.md>\nwriting_laws.md\n```\n"
    yield PAGE, "\n".join(parts)
    for family in FAMILIES:
        sections = (section(name, owner) for name, owner in family.owners.items())
        composed = "" if family.choice == "law" else "law=composed "
        chosen = f"Chosen by `{composed}{family.choice}=NAME`. [Which law do I need?](../laws.md)\n"
        opening = f"# {family.title}\n\n{MADE}\n{chosen}"
        yield f"{FOLDER}/{family.page}.md", "\n".join([opening, *sections])


def entry() -> str:
    """Return what stands before the tables."""
    text = GUIDE.read_text(encoding="utf-8")
    for mark, made in (("steel", steel()), ("stick", stick_of_the_motor())):
        text = text.replace(f"MADE: {mark}", fill(made, 110))
    return text


def steel() -> str:
    """Return what a steel tip at 0.1 m/s does on steel, by Hertz's closed forms."""
    setup, speed, radius, modulus = cl.build(), 0.1, 5e-3, 210e9 / (2.0 * (1.0 - 0.3**2))
    mass = float(setup.configuration["resonator"]["tip_mass"])
    stiffness = 4.0 / 3.0 * modulus * radius**0.5
    depth = (1.25 * mass * speed**2 / stiffness) ** 0.4
    force, time = stiffness * depth**1.5, 2.94 * depth / speed
    pressure = (6.0 * force * modulus**2 / (np.pi**3 * radius**2)) ** (1.0 / 3.0)
    share = time * float(setup.motor.drive.frequency[0])
    return (
        f"**A steel tip at {speed:g} m/s**, of {1e3 * radius:g} mm radius and {1e3 * mass:.2g} g, against "
        f"steel: it presses with {force:.2g} N over {1e6 * time:.2g} µs, {1e6 * depth:.2g} µm deep, at "
        f"{1e-9 * pressure:.2g} GPa. Both bodies stay elastic if they yield above "
        f"{1e-6 * pressure / 1.6:.0f} MPa, as hardened steel does, and a Hertz contact is the law; softer "
        "steel yields, which takes "
        "`thornton` or a restitution that is measured at this speed. The contact lasts "
        f"{100 * share:.0f} % of a period of the default motor, in which the tip goes on along its path: a "
        "rigid law is an approximation to be compared."
    )


def stick_of_the_motor() -> str:
    """Return up to which slip a plastic impact of the default motor sticks."""
    setup = cl.build()
    modes, geometry, rotor = setup.motor.modes, setup.motor.geometry, setup.motor.rotor
    normal = float(np.sum(modes.tip_displacement**2))
    tangential = float(np.sum((geometry.tip_length * modes.tip_slope) ** 2))
    ratio = (tangential + geometry.rotor_radius**2 / rotor.inertia) / normal
    friction = float(setup.configuration["contact"]["friction_coefficient"])
    return (
        f"In the default motor $D_{{tt}}/D_{{nn}}$ is {ratio:.2g}: a plastic impact sticks up to a slip of "
        f"{friction * ratio:.2g} times the speed of the approach."
    )


def choice(family: Family) -> str:
    """Return the table of a family: what all have alike is a sentence below it."""
    owners = {name: owner for name, owner in family.owners.items() if owner is not Composed}
    rows = [properties(owner) for owner in owners.values()]
    columns = {head: [*cells] for head, cells in zip(HEADS, zip(*rows, strict=True), strict=True)}
    alike = {head: cells[0] for head, cells in columns.items() if len({*cells}) == 1 < len(cells)}
    columns = {
        "law" if family.choice == "law" else family.page: [f"[{n}]({family.address(n)})" for n in owners],
        **{head: cells for head, cells in columns.items() if head not in alike},
        "needs": [needs(owner) for owner in owners.values()],
        "valid for": [owner.validity for owner in owners.values()],
    }
    lines = table([*columns], zip(*columns.values(), strict=True))
    common = ", ".join(f"{head} {cell}" for head, cell in alike.items())
    return "\n".join([f"## {family.title}\n", *lines, *([f"All of them: {common}.\n"] if common else [])])


def properties(owner: type[Declared]) -> tuple[str, ...]:
    """Return what the columns of `HEADS` say of a law or part."""
    law = law_of(owner)
    curves, _ = curves_of(law)
    variables = law.internal_variables
    lasting = any(variable.units == "s" for variable in variables)
    names = dict.fromkeys(variable.name.rstrip("_0123456789").replace("_", " ") for variable in variables)
    return (
        "rigid" if isinstance(law, MultiplierLaw) else "compliant",
        curves.loss,
        stick(law),
        "yes" if curves.rate or lasting else "no",
        ", ".join(names) or "none",
        "yes" if law.allows_tension or law.friction_offset else "no",
    )


def stick(law: Any) -> str:
    """Return how a contact that is held behaves."""
    if not getattr(law, "sticks", True):
        return "none"
    if law.exact_stick:
        return "rigid"
    return "elastic" if any(v.parity == ODD and v.units == "m" for v in law.internal_variables) else "creep"


def needs(owner: type[Declared]) -> str:
    """Return the meanings of what is a law's own; how finely it is resolved is none of them."""
    own = {name: each for name, each in members_of(owner).items() if name != SHARED}
    numbers = [
        each for name, each in own.items() if int not in each.kinds and (each.is_number or name == "file")
    ]
    return ", ".join(dict.fromkeys(each.parameter.meaning for each in numbers if each.parameter))


def section(name: str, owner: type[Declared]) -> str:
    """Return what a page says of a law or part."""
    first, _, rest = described(owner).partition("\n\n")
    curves, _ = curves_of(law_of(owner))
    rows = [parameter_row(n, member) for n, member in members_of(owner).items()]
    made = f"cl.{owner.__name__}()"
    if not issubclass(owner, ContactLaw):
        made = f"cl.Composed({owner.family}={made})"
    declared = {**declared_rows(owner), "source": owner.source, "in Python": f"`{made}`"}
    return "\n".join(
        [
            f"## {name}\n",
            f"{first}\n",
            display(owner.equation),
            f"![{name}]({picture(owner)})\n",
            f"{curves.numbers}\n",
            f"{in_formulas(rest)}\n" if rest else "",
            *(table(("parameter", "symbol", "unit", "default", "meaning"), rows) if rows else []),
            *(f"* {w}: {raised(text)}" for w, text in declared.items() if text and (w, text) not in USUAL),
            "",
        ]
    )


def described(owner: type[Declared]) -> str:
    """Return the words of a law or part without its arguments and sources."""
    text = inspect.getdoc(owner) or ""
    return text.partition("\nArgs:")[0].partition("\nSource:")[0].strip()


def formulas_of(owner: type[Declared]) -> list[str]:
    """Return the equations among the words, a line each."""
    return [line.strip() for line in described(owner).splitlines() if line.startswith("    ")]


def in_formulas(text: str) -> str:
    """Return words with their equations set."""
    return "\n".join(display(line.strip()) if line.startswith("    ") else line for line in text.splitlines())


def display(equation: str) -> str:
    """Return an equation as displayed formulas."""
    return "\n".join(f"$$\n{line}\n$$\n" for line in equations.lines(equation))


def parameter_row(name: str, member: DeclaredField) -> list[str]:
    """Return name, symbol, unit, default and meaning of a number, or the default of a part."""
    declared, default = member.parameter, member.default
    if declared is None:
        return [f"`{name}`", "", "", f"`{default.name}`", f"the [{name}]({name}.md)"]
    shown = (
        "none"
        if default is None
        else "must be given"
        if default is MISSING
        else f"`{default}`"
        if isinstance(default, str)
        else powers_of_ten(f"{default:g}")
    )
    shown = "that of the contact" if name == SHARED else shown
    bounds = replace(declared, units="1").range
    meaning = f"{declared.meaning}; {bounds}" if bounds else declared.meaning
    return [f"`{name}`", symbol(declared.symbol), unit(declared.units), shown, meaning]


def picture(owner: type[Declared]) -> str:
    """Return the path of a picture beside the pages."""
    return f"{owner.family}_{owner.name}.png".lstrip("_")


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the pages and their pictures; returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--output", type=Path, default=DOCS)
    folder: Path = parser.parse_args(arguments).output
    (folder / FOLDER).mkdir(parents=True, exist_ok=True)
    for path, text in pages():
        (folder / path).write_text(text, encoding="utf-8")
    with plt.style.context(STYLE):
        for owner in (owner for family in FAMILIES for owner in family.owners.values()):
            figure = draw(*curves_of(law_of(owner)))
            figure.savefig(folder / FOLDER / picture(owner), dpi=110, metadata={"Software": None})
            plt.close(figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
