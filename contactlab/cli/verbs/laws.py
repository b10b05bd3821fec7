"""List every installed law and part, with all that it declares.

These are equation, parameters with symbol, unit, default and range, its declarations, source and package. A
law that cannot be loaded is listed with the reason.
"""

from collections.abc import Iterable, Iterator, Mapping
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
from contactlab.laws.registry import PARTS, Origin, class_of, law_names, origins, ways_to_choose
from contactlab.parameter import DeclaredField, from_cf
from contactlab.suggestion import suggestion

STICK = {True: "tangentially rigid", False: "not rigid: it yields, creeps or chatters"}

KERNELS = {"limits": "a contact begins and ends at the gaps that it says, not at zero"}
"""What kernels that most have not say of a law or part."""

HEADINGS = {
    "": "Laws: choose one by law=NAME",
    "normal": "Normal forces of a composed law: law=composed law/normal=NAME",
    "damping": "Dampings of a composed law: law=composed law/damping=NAME",
    "friction": "Frictions of a composed law: law=composed law/friction=NAME",
}

_wrapped = partial(
    fill,
    width=100,
    initial_indent="  ",
    subsequent_indent="    ",
    break_on_hyphens=False,
    break_long_words=False,
)


def main(arguments: list[str]) -> int:
    """Print the listing, of everything or of some names, and return the exit status.

    Raises:
        RefusalError: no law or part has the name.
    """
    parser = Parser(__name__, __doc__, "[NAME ...]", "of laws, or of parts (friction/coulomb)")
    wanted, _ = parser.read(arguments)
    listing = _listing()
    titles, known = [title for entries in listing.values() for title, _ in entries], names()
    for name in {*wanted} - {*known}:
        hint = suggestion(name, known, ways_to_choose(name) or f"It must be one of {', '.join(titles)}.")
        raise RefusalError(f"There is no law or part '{name}'. {hint}")
    blocks = []
    for family, entries in listing.items():
        if not wanted:
            blocks.append(HEADINGS[family])
        for title, origin in entries:
            if not wanted or not {*wanted}.isdisjoint((title, title.rpartition("/")[2])):
                blocks.append(_paragraph(title, origin, family))
    print("\n\n".join(blocks))
    return COMPLETE


def _listing() -> dict[str, list[tuple[str, Origin]]]:
    """Return the titles and origins of laws and parts by family; two packages may bring one name."""
    return {
        family: [(f"{family}/{each.name}".lstrip("/"), each) for each in origins(family)]
        for family in HEADINGS
    }


def names() -> list[str]:
    """Return the names by which a law or part can be listed, those of parts with and without their family."""
    titles = [title for entries in _listing().values() for title, _ in entries]
    return sorted({name for title in titles for name in (title, title.rpartition("/")[2])})


def _paragraph(title: str, origin: Origin, family: str) -> str:
    """Return all that a law or a part says of itself, or why it cannot be used."""
    fault = origin.fault
    try:
        if not fault:
            return _described(class_of(origin.name, family), title, f"{origin} ({origin.entry})")
    except ValueError as error:
        fault = str(error)
    # Declarations of another package may fail in any way.
    except Exception as error:
        fault = f"The declarations of {origin.entry} of {origin} raise {type(error).__name__}: {error}."
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


def described_parameter(name: str, member: DeclaredField) -> str:
    """Return symbol, unit, meaning, default and range of a number, or the options of a part."""
    declared, default = member.parameter, member.default
    if declared is None:
        family = family_of(member)
        options = dict.fromkeys([*PARTS[family], *law_names(family)])
        shown = "" if default is MISSING else f", default {default.name}"
        return f"a part, law/{family}={', '.join(options)}{shown}"
    unit = "" if declared.units == "1" else f" [{declared.unit}]"
    shown = "must be given" if default is MISSING else "default none" if default is None else ""
    shown = shown or f"default {default if isinstance(default, str) else f'{default:g}'}"
    shown = "contact.friction_coefficient" if name == SHARED else shown
    named = ", ".join(filter(None, (declared.symbol + unit, declared.meaning, shown)))
    return f"{named}, {declared.range or 'finite'}" if member.is_number else named


def declared_rows(owner: type[Declared]) -> dict[str, str]:
    """Return the declarations of a law or part by name, with the defaults of its parameters."""
    is_open = any(member.default is MISSING for member in members_of(owner).values())
    law: Any = owner if owner is Composed or is_open else owner()
    rows = {"valid for": owner.validity}
    if issubclass(owner, ContactLaw):
        rows["family"] = "compliant" if issubclass(owner, PenaltyLaw) else "rigid"
    if issubclass(owner, ContactLaw) or getattr(law, "allows_tension", False):
        rows["tension"] = _shown(law, "allows_tension", {True: "allowed", False: "none"})
    if issubclass(owner, ContactLaw):
        rows["convergence order"] = _shown(law, "convergence_order")
        step = f"{owner.default_contact_step:g} s by default"
        rows["contact step"] = step if issubclass(owner, PenaltyLaw) else "none"
    has_friction = issubclass(owner, ContactLaw | Friction)
    if has_friction:
        rows["stick"] = _shown(law, "exact_stick", STICK)
        offset = law.friction_offset
        rows["cone"] = f"widened by an offset C = {offset:g} N" if not _is_open(offset) and offset else ""
    rows |= _contact_rows(law)
    if has_friction and _is_open(law.violations):
        rows["breaks"] = _shown(law, "violations")
    elif has_friction:
        rows |= {f"breaks {name}": reason for name, reason in law.violations.items()}
    return rows


def _contact_rows(law: Any) -> dict[str, str]:
    """Return internal variables, kernels that most laws have not, and guards."""
    variables, guards = getattr(law, "internal_variables", ()), getattr(law, "guards", 0)
    if _is_open(variables):
        rows = {"internal variables": _shown(law, "internal_variables")}
    else:
        rows = dict(_variables(variables))
    for name, text in KERNELS.items():
        if not _is_open(kernel := getattr(law, name, None)) and kernel is not None:
            rows[name] = text
    if not _is_open(guards) and guards:
        rows["guards"] = f"{guards}: where one falls through zero, a step ends and the reset map is applied"
    return rows


def _variables(variables: Iterable[InternalVariable]) -> Iterator[tuple[str, str]]:
    """Yield title and text of internal variables; those that differ by a number alone have one row."""
    digits = str.maketrans("", "", "0123456789")

    def plain(variable: InternalVariable) -> InternalVariable:
        texts = {key: getattr(variable, key).translate(digits) for key in ("name", "symbol", "meaning")}
        return replace(variable, **texts)

    for _, group in groupby(variables, plain):
        first, *rest = group
        last = rest[-1] if rest else first
        names, symbols, meanings = (
            " to ".join(dict.fromkeys((getattr(first, key), getattr(last, key))))
            for key in ("name", "symbol", "meaning")
        )
        unit = f" [{from_cf(first.units)}]" if first.units != "1" else ""
        symbol = f"{symbols}{unit}, ".lstrip() if symbols or unit else ""
        life = {"contact": "with every contact", "run": "with the run and not with a contact"}[first.life]
        text = f"{symbol}{meanings}, {'begin' if rest else 'begins'} at {first.initial:g} {life}"
        title = f"internal variable{'s' if rest else ''} {names}"
        yield title, f"{text}{', odd in a mirror' if first.parity == ODD else ''}"


def _is_open(value: Any) -> bool:
    """Return whether a declaration depends on parts or parameters that have no value."""
    return isinstance(value, property)


def _shown(law: Any, name: str, texts: Mapping[Any, str] = MappingProxyType({})) -> str:
    """Return a declaration as text; one that follows from the parts says so."""
    value = getattr(law, name)
    if _is_open(value):
        return "that of its parts" if law is Composed else "as its parameters are"
    return texts.get(value) or f"{value:g}"
