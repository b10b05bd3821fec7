"""`contactlab laws [NAME]`: every law and part that is installed, with all that it declares."""

from collections.abc import Iterator
from dataclasses import MISSING
from textwrap import fill
from typing import Any

from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE, RefusalError
from contactlab.laws.base import EVEN, ODD, ContactLaw, Friction, Part, PenaltyLaw
from contactlab.laws.declaration import SHARED, family_of, members_of
from contactlab.laws.registry import PARTS, Origin, law_class, origins
from contactlab.parameter import DeclaredField
from contactlab.suggestion import suggestion

WIDTH = 100
INDENT = "  "
FAMILIES = {
    "normal": "Normal forces",
    "damping": "Dampings",
    "friction": "Frictions",
}


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
    known = _names()
    if wanted is not None and wanted not in known:
        hint = suggestion(wanted, known, f"It must be one of {', '.join(known)}.")
        raise RefusalError(f"There is no law or part '{wanted}'. {hint}")
    print("\n\n".join(_listing(wanted)))
    return COMPLETE


def _names() -> list[str]:
    """List what can be asked for; a part goes by its own name and by that with its family."""
    parts = [
        each
        for family, table in PARTS.items()
        for name in table
        for each in (name, f"{family}/{name}")
    ]
    return [*(origin.name for origin in origins()), *parts]


def _listing(wanted: str | None) -> Iterator[str]:
    """The paragraphs."""
    if wanted is None:
        yield "Laws: choose one by law=NAME"
    for origin in origins():
        if wanted in (None, origin.name):
            yield _law(origin)
    for family, table in PARTS.items():
        if wanted is None:
            yield f"{FAMILIES[family]} of a composed law: law=composed law/{family}=NAME"
        for name in table:
            if wanted in (None, name, f"{family}/{name}"):
                yield _described(table[name], f"{family}/{name}", "")


def _law(origin: Origin) -> str:
    if origin.fault:
        return _broken(origin, origin.fault)
    try:
        return _described(law_class(origin.name), origin.name, f"{origin} ({origin.entry})")
    except ValueError as error:
        return _broken(origin, str(error))
    # What a law of another package declares may be anything.
    except Exception as error:
        return _broken(
            origin,
            f"What {origin.entry} of {origin} declares cannot be read ({type(error).__name__}: {error}). "
            "Mend that package.",
        )


def _broken(origin: Origin, fault: str) -> str:
    return "\n".join([f"{origin.name}: not usable", _wrapped(fault)])


def _described(owner: type[ContactLaw | Part], title: str, origin: str) -> str:
    """All that a law or a part says of itself."""
    rows = {
        "equation": owner.equation,
        **{f"parameter {n}": described_parameter(n, m) for n, m in members_of(owner).items()},
        **declared_rows(owner),
        "source": owner.source,
        "package": origin,
    }
    lines = [_wrapped(f"{word}: {text}", 2 * INDENT) for word, text in rows.items() if text]
    first = (owner.__doc__ or "").strip().partition("\n")[0]
    return "\n".join([title, *([_wrapped(first)] if first else []), *lines])


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
        rows["stick"] = _of_parts(
            owner.exact_stick, {True: "exact", False: "not exact: it gives, creeps or chatters"}
        )
        word = "internal variable"
        rows[word] = _of_parts(getattr(owner, "internal_variables", ()))
        if rows[word] and not isinstance(owner.internal_variables, property):
            even = getattr(owner, "internal_parity", ODD) == EVEN
            rows[word] += f", {'even' if even else 'odd'} in a mirror"
        violations = owner.violations
        if isinstance(violations, property):
            rows["breaks"] = _of_parts(violations)
        else:
            rows |= {f"breaks {name}": reason for name, reason in violations.items()}
    return rows


def _of_parts(value: Any, words: dict[Any, str] | None = None) -> str:
    """A declaration in words; one that follows from the parts says so."""
    if isinstance(value, property):
        return "that of its parts"
    if words is not None:
        return words[value]
    return f"{value:g}" if isinstance(value, float) else ", ".join(value)


def _wrapped(text: str, indent: str = INDENT) -> str:
    return fill(
        text,
        WIDTH,
        initial_indent=indent,
        subsequent_indent=indent + INDENT,
        break_on_hyphens=False,
        break_long_words=False,
    )
