"""`contactlab laws [NAME]`: every law and part that is installed, with all that it declares."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, replace
from functools import partial
from itertools import groupby
from textwrap import fill
from types import MappingProxyType
from typing import Any

from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE, RefusalError
from contactlab.laws.base import ContactLaw, Friction, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.declaration import SHARED, Declared, family_of, members_of
from contactlab.laws.memory import ODD, InternalVariable
from contactlab.laws.registry import PARTS, Origin, class_of, law_names, origins
from contactlab.parameter import DeclaredField
from contactlab.suggestion import suggestion

STICK = {True: "exact", False: "not exact: it gives, creeps or chatters"}

KERNELS = {
    "limits": "a contact begins and ends at the gaps that it says, not at zero",
    "moment": "a patch of some extent turns the tip",
}
"""What kernels that most have not say of a law or part."""

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
    headings = {"": "Laws: choose one by law=NAME"} | {
        family: f"{words} of a composed law: law=composed law/{family}=NAME"
        for family, words in FAMILIES.items()
    }
    # Two packages may bring a law of one name.
    sections: Sections = {
        heading: [(_title(one, family), partial(_paragraph, one, family)) for one in origins(family)]
        for family, heading in headings.items()
    }
    print("\n\n".join(_chosen(sections, wanted)))
    return COMPLETE


def _title(origin: Origin, family: str) -> str:
    return f"{family}/{origin.name}" if family else origin.name


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


def _paragraph(origin: Origin, family: str) -> str:
    fault, title = origin.fault, _title(origin, family)
    try:
        if not fault:
            return _described(class_of(origin.name, family), title, f"{origin} ({origin.entry})")
    except ValueError as error:
        fault = str(error)
    # What a law of another package declares may be anything.
    except Exception as error:
        fault = (
            f"What {origin.entry} of {origin} declares cannot be read ({type(error).__name__}: {error}). "
            "Mend that package."
        )
    return f"{title}: not usable\n{_wrapped(fault)}"


def _described(owner: type[Declared], title: str, origin: str) -> str:
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


def described_parameter(name: str, member: DeclaredField, own: bool = False) -> str:
    """Symbol, unit, meaning, default and range of a number; the options of a part, or our `own` alone."""
    said, given = member.parameter, member.default
    if said is None:
        family = family_of(member)
        options = dict.fromkeys([*PARTS[family], *([] if own else law_names(family))])
        default = "" if given is MISSING else f", default {given.name}"
        return f"a part, law/{family}={', '.join(options)}{default}"
    unit = "" if said.units == "1" else f" [{said.units}]"
    default = "must be given"
    if name == SHARED:
        default = "contact.friction_coefficient"
    elif given is not MISSING:
        default = "default none" if given is None else f"default {given:g}"
    return f"{said.symbol}{unit}, {said.meaning}, {default}, {said.range or 'finite'}"


def declared_rows(owner: type[Declared]) -> dict[str, str]:
    """What a law or part claims of itself where it says anything: a composed law leaves it to its parts.

    What hangs on parameters is told as it is with their defaults.
    """
    open_ones = [one for one in members_of(owner).values() if one.default is MISSING]
    said: Any = owner if owner is Composed or open_ones else owner()
    rows: dict[str, str] = {}
    if issubclass(owner, ContactLaw):
        rows["family"] = "compliant" if issubclass(owner, PenaltyLaw) else "rigid"
    if issubclass(owner, ContactLaw) or getattr(said, "allows_tension", False):
        rows["tension"] = _in_words(said, "allows_tension", {True: "allowed", False: "none"})
    if issubclass(owner, ContactLaw):
        rows["convergence order"] = _in_words(said, "convergence_order")
        at_most = "at most " if getattr(owner, "projects", False) else ""
        rows["default contact step"] = f"{at_most}{owner.default_contact_step:g} s"
    if issubclass(owner, ContactLaw | Friction):
        rows["stick"] = _in_words(said, "exact_stick", STICK)
        offset = said.friction_offset
        rows["cone"] = f"widened by an offset C = {offset:g} N" if not _hangs(offset) and offset else ""
    rows |= _memory_rows(said)
    if issubclass(owner, ContactLaw | Friction):
        if _hangs(said.violations):
            rows["breaks"] = _in_words(said, "violations")
        else:
            rows |= {f"breaks {name}": reason for name, reason in said.violations.items()}
    return rows


def _memory_rows(said: Any) -> dict[str, str]:
    """What a law or part remembers, and what it has a hand in: limits, guards, a moment, the step."""
    rows: dict[str, str] = {}
    variables = getattr(said, "internal_variables", ())
    if _hangs(variables):
        rows["internal variables"] = _in_words(said, "internal_variables")
    else:
        for alike in _alike(variables):
            names, words = described_variables(alike)
            rows[f"internal variable{'s' * (len(alike) > 1)} {names}"] = words
    kernels = {name: getattr(said, name, None) for name in ("limits", "moment")}
    for name, words in KERNELS.items():
        if not _hangs(kernels[name]) and kernels[name] is not None:
            rows[name] = words
    guards = getattr(said, "guards", 0)
    if not _hangs(guards) and guards:
        rows["guards"] = f"{guards}: where one falls through zero, a step ends and what it remembers jumps"
    return rows


def _alike(variables: Iterable[InternalVariable]) -> Iterator[list[InternalVariable]]:
    """Give internal variables together that differ by a number alone, one after the other."""
    digits = str.maketrans("", "", "0123456789")

    def plain(one: InternalVariable) -> InternalVariable:
        words = {name: getattr(one, name).translate(digits) for name in ("name", "symbol", "meaning")}
        return replace(one, **words)

    for _, alike in groupby(variables, plain):
        yield list(alike)


def described_variables(alike: Sequence[InternalVariable]) -> tuple[str, str]:
    """Names, and symbols, unit, meaning, how life begins and parity, of variables that are alike."""
    one = alike[0]
    names, symbols, meanings = (
        " to ".join(dict.fromkeys(getattr(each, word) for each in (one, alike[-1])))
        for word in ("name", "symbol", "meaning")
    )
    unit = f" [{one.units}]" if one.units != "1" else ""
    symbol = f"{symbols}{unit}, " if symbols or unit else ""
    begins = "begin" if len(alike) > 1 else "begins"
    life = {"contact": "with every contact", "run": "with the run and not with a contact"}[one.life]
    parity = ", odd in a mirror" if one.parity == ODD else ""
    return names, f"{symbol.lstrip()}{meanings}, {begins} at {one.initial:g} {life}{parity}"


def _hangs(value: Any) -> bool:
    """Tell whether a declaration hangs on parts or parameters that are not given."""
    return isinstance(value, property)


def _in_words(said: Any, name: str, words: Mapping[Any, str] = MappingProxyType({})) -> str:
    """A declaration in words; one that follows from the parts says so."""
    value = getattr(said, name)
    if _hangs(value):
        return "that of its parts" if said is Composed else "as its parameters are"
    return words.get(value) or f"{value:g}"
