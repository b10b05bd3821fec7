"""`contactlab laws [NAME]`: every law and part that is installed, with all that it declares."""

from collections.abc import Iterator
from dataclasses import MISSING
from functools import partial
from textwrap import fill
from typing import Any

from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE, RefusalError
from contactlab.laws.base import ContactLaw, Friction, Part, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.declaration import SHARED, family_of, members_of
from contactlab.laws.memory import EVEN, ODD
from contactlab.laws.registry import PARTS, Origin, law_class, origins
from contactlab.parameter import DeclaredField
from contactlab.suggestion import suggestion

FAMILIES = {"normal": "Normal forces", "damping": "Dampings", "friction": "Frictions"}

Sections = dict[str, list[tuple[str, partial[str]]]]
"""Names and what prints their paragraphs, by heading."""

_wrapped = partial(
    fill,
    width=100,
    initial_indent="  ",
    subsequent_indent="    ",
    break_on_hyphens=False,
    break_long_words=False,
)


def main(arguments: list[str]) -> int:
    """Print the listing, of everything or of one name, and give the exit status.

    Raises:
        RefusalError: no law or part has the name.
    """
    parser = Parser(
        "laws",
        ": equation, parameters with symbol, unit, default and range, what it declares of itself, source "
        "and the package it comes from. A law that cannot be loaded is listed with the reason.",
    )
    parser.add_argument("name", nargs="?", help="of a law, or of a part (friction/coulomb)")
    wanted = parser.read(arguments).name
    # Two packages may bring a law of one name.
    sections: Sections = {"Laws: choose one by law=NAME": [(o.name, partial(_law, o)) for o in origins()]}
    for family, table in PARTS.items():
        heading = f"{FAMILIES[family]} of a composed law: law=composed law/{family}=NAME"
        parts = [(f"{family}/{name}", part) for name, part in table.items()]
        sections[heading] = [(name, partial(_described, part, name)) for name, part in parts]
    print("\n\n".join(_chosen(sections, wanted)))
    return COMPLETE


def _chosen(sections: Sections, wanted: str | None) -> Iterator[str]:
    """Give the paragraphs; a part goes by its own name and by that with its family."""
    names = [name for entries in sections.values() for name, _ in entries]
    known = dict.fromkeys(each for name in names for each in (name.rpartition("/")[2], name))
    if wanted is not None and wanted not in known:
        hint = suggestion(wanted, known, f"It must be one of {', '.join(known)}.")
        raise RefusalError(f"There is no law or part '{wanted}'. {hint}")
    for heading, entries in sections.items():
        if wanted is None:
            yield heading
        for name, paragraph in entries:
            if wanted in (None, name, name.rpartition("/")[2]):
                yield paragraph()


def _law(origin: Origin) -> str:
    fault = origin.fault
    try:
        if not fault:
            return _described(law_class(origin.name), origin.name, f"{origin} ({origin.entry})")
    except ValueError as error:
        fault = str(error)
    # What a law of another package declares may be anything.
    except Exception as error:
        fault = (
            f"What {origin.entry} of {origin} declares cannot be read ({type(error).__name__}: {error}). "
            "Mend that package."
        )
    return f"{origin.name}: not usable\n{_wrapped(fault)}"


def _described(owner: type[ContactLaw | Part], title: str, origin: str = "") -> str:
    """All that a law or a part says of itself."""
    rows = {
        "equation": owner.equation,
        **{f"parameter {n}": described_parameter(n, m) for n, m in members_of(owner).items()},
        **declared_rows(owner),
        "source": owner.source,
        "package": origin,
    }
    first = (owner.__doc__ or "").strip().partition("\n")[0]
    lines = [_wrapped(first)] if first else []
    lines += [
        _wrapped(f"{word}: {text}", initial_indent="    ", subsequent_indent="      ")
        for word, text in rows.items()
        if text
    ]
    return "\n".join([title, *lines])


def described_parameter(name: str, member: DeclaredField) -> str:
    """Symbol, unit, meaning, default and range of a number; the options of a part."""
    said, given = member.parameter, member.default
    if said is None:
        family = family_of(member)
        default = "" if given is MISSING else f", default {given.name}"
        return f"a part, law/{family}={', '.join(PARTS[family])}{default}"
    unit = "" if said.units == "1" else f" [{said.units}]"
    default = "must be given"
    if name == SHARED:
        default = "contact.friction_coefficient"
    elif given is not MISSING:
        default = "default none" if given is None else f"default {given:g}"
    return f"{said.symbol}{unit}, {said.meaning}, {default}, {said.range or 'finite'}"


def declared_rows(owner: Any) -> dict[str, str]:
    """What a law or part claims of itself where it says anything: a composed law leaves it to its parts."""
    rows: dict[str, str] = {}
    if issubclass(owner, ContactLaw):
        rows["family"] = "compliant" if issubclass(owner, PenaltyLaw) else "rigid"
        rows["tension"] = "allowed" if owner.allows_tension else "none"
        rows["convergence order"] = _of_parts(owner.convergence_order)
        at_most = "at most " if getattr(owner, "projects", False) else ""
        rows["default contact step"] = f"{at_most}{owner.default_contact_step:g} s"
    if issubclass(owner, ContactLaw | Friction):
        stick = {True: "exact", False: "not exact: it gives, creeps or chatters"}
        rows["stick"] = stick.get(owner.exact_stick) or _of_parts(owner.exact_stick)
        violations = owner.violations
        if isinstance(violations, property):
            rows["breaks"] = _of_parts(violations)
        else:
            rows |= {f"breaks {name}": reason for name, reason in violations.items()}
    rows["internal variable"] = remembered_rows(owner)
    return rows


def remembered_rows(owner: Any) -> str:
    """What a law or part remembers, in words; empty where that is nothing."""
    internal = getattr(owner, "internal_variables", ())
    if isinstance(internal, property):
        if owner is Composed:
            return "that of its parts"
        internal = owner().internal_variables
    parities = {ODD: ", odd in a mirror", EVEN: ""}
    lives = {"run": ", for the run", "contact": ""}
    return "; ".join(f"{one}{parities[one.parity]}{lives[one.life]}" for one in internal)


def _of_parts(value: Any) -> str:
    """A declaration in words; one that follows from the parts says so."""
    if isinstance(value, property):
        return "that of its parts"
    return f"{value:g}"
