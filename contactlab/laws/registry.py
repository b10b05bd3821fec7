"""Every law and part by name: the package's own, and laws that other packages bring.

Another package brings a law by an entry point in its pyproject.toml, no line of this one changed:

    [project.entry-points."contactlab.laws"]
    power_law = "their_module:PowerLaw"

It is imported when that law is asked for, and no other, so that a package that is broken harms no other law.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import MISSING
from functools import cache
from importlib.metadata import EntryPoint, distributions, entry_points
from typing import Any, NamedTuple

from contactlab.laws.archard import Archard
from contactlab.laws.base import ContactLaw, MultiplierLaw, Part, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.damping import DAMPINGS
from contactlab.laws.declaration import SHARED, Declared, family_of, fault_of, members_of
from contactlab.laws.friction import FRICTIONS
from contactlab.laws.hertz_penalty import HertzPenalty
from contactlab.laws.impact import MoreauJean, Newton, Poisson, Stronge
from contactlab.laws.lagrange import LagrangeSlip, LagrangeStick
from contactlab.laws.normal import NORMAL_FORCES
from contactlab.suggestion import suggestion

GROUP = "contactlab.laws"

LAWS: Mapping[str, type[ContactLaw]] = {
    law.name: law
    for law in (
        Archard,
        Composed,
        HertzPenalty,
        LagrangeSlip,
        LagrangeStick,
        MoreauJean,
        Newton,
        Poisson,
        Stronge,
    )
}
"""The package's own laws."""

PARTS: Mapping[str, Mapping[str, type[Part]]] = {
    "normal": NORMAL_FORCES,
    "damping": DAMPINGS,
    "friction": FRICTIONS,
}
"""The parts of a composed law by family."""


class Origin(NamedTuple):
    """Where a law comes from: its name and entry "module:Class", and the distribution that brings it."""

    name: str
    entry: str
    package: str
    version: str
    fault: str = ""
    """A sentence where the entry cannot be a law, whatever it names."""

    def __str__(self) -> str:
        return f"{self.package} {self.version}"


@cache
def origins() -> tuple[Origin, ...]:
    """Give every entry: the package's own, then the others by name; those that are no law say why."""
    version = next((found.version for found in distributions(name="contactlab")), "unknown")
    own = [Origin(name, _entry(law), "contactlab", version) for name, law in LAWS.items()]
    given = sorted(
        Origin(point.name, f"{point.module}:{point.attr}", point.dist.name, point.dist.version)
        for point in entry_points(group=GROUP)
        if point.dist is not None
    )
    count = Counter(origin.name for origin in given)
    return *own, *(each._replace(fault=_clash(each, count[each.name])) for each in given)


def law_names() -> list[str]:
    """Give the names by which a law can be chosen, in their order."""
    return sorted({origin.name for origin in origins() if not origin.fault})


def origin_of(name: str) -> Origin:
    """Tell where a law comes from, or say in a ValueError that no law alone has the name."""
    found = [origin for origin in origins() if origin.name == name]
    for origin in found:
        if not origin.fault:
            return origin
    raise ValueError(found[0].fault if found else _unknown("law", name, law_names()))


@cache
def law_class(name: str) -> type[ContactLaw]:
    """Give a law's class, importing that law alone, or say in a ValueError what is wrong with it."""
    origin, cause = origin_of(name), None
    try:
        found: Any = EntryPoint(name, origin.entry, GROUP).load()
    # Whatever a module of somebody else's does while it is imported, it is that law's fault alone.
    except (Exception, SystemExit) as error:
        cause, fault = error, f"cannot be imported ({type(error).__name__}: {error})"
    else:
        if not isinstance(found, type) or not issubclass(found, PenaltyLaw | MultiplierLaw):
            fault = "is no subclass of contactlab.laws.PenaltyLaw or MultiplierLaw"
        elif not (fault := fault_of(found)) and found.name != name:
            fault = f"calls itself {found.name!r}, which must be the name of its entry too"
    if fault:
        raise ValueError(
            f"The law {name!r} of {origin} is not usable: {origin.entry} {fault}. Mend that package or "
            f"remove it by pip uninstall {origin.package}; other laws run."
        ) from cause
    return found  # type: ignore[no-any-return]


def law(name: str, /, **parameters: Any) -> ContactLaw:
    """Make a law from its name: `law("newton", restitution=0.4)`.

    The parts of a composed law are given as they are, or by name where their defaults are wanted:
    `law("composed", normal="linear", friction=LuGre(0.2))`.

    Raises:
        TypeError: the name is no text, or a parameter is one that the law has not, or is no number.
        ValueError: there is no such law or part, or a parameter is out of its range.
    """
    if not isinstance(name, str):
        raise TypeError(f"The name of the law is {name!r}; it must be a text like 'newton'.")
    owner = law_class(name)
    members = members_of(owner)
    for given, value in parameters.items():
        if given not in members:
            hint = suggestion(given, members, f"It has {', '.join(members) or 'none'}.")
            raise TypeError(f"The law {name} has no parameter {given!r}. {hint}")
        if (family := family_of(members[given])) and isinstance(value, str):
            if value not in PARTS[family]:
                raise ValueError(_unknown(family, value, PARTS[family]))
            parameters[given] = PARTS[family][value]()
    needed = [own for own, member in members.items() if member.default is MISSING]
    if lacking := ", ".join(own for own in needed if own not in parameters):
        raise TypeError(f"The law {name} lacks {lacking}; without default it must be given.")
    return owner(**parameters)


def build_law(owner: type[Declared], values: Mapping[str, Any], friction_coefficient: float) -> Any:
    """Make a law or a part from its section of a configuration, or raise what the law refuses it with."""
    given: dict[str, Any] = {}
    for name, member in members_of(owner).items():
        value: Any = friction_coefficient if name == SHARED else values[name]
        if family := family_of(member):
            value = build_law(PARTS[family][value["name"]], value, friction_coefficient)
        elif int in member.kinds and value is not None and value == value // 1:
            # One that is not whole the law refuses.
            value = int(value)
        given[name] = value
    return owner(**given)


def takes_shared(owner: type[Declared], values: Mapping[str, Any]) -> bool:
    """Tell whether a law, or one of its parts as they are chosen, has the parameter that is the contact's."""
    return any(
        takes_shared(PARTS[family][values[name]["name"]], values[name])
        if (family := family_of(member))
        else name == SHARED
        for name, member in members_of(owner).items()
    )


def provenance(law: type) -> str:
    """Give the package and version that a law comes from; of one that no package brings, its module."""
    entries = {origin.entry: str(origin) for origin in reversed(origins()) if not origin.fault}
    return entries.get(_entry(law), law.__module__)


def _entry(law: type) -> str:
    return f"{law.__module__}:{law.__qualname__}"


def _unknown(kind: str, name: str, known: Iterable[str]) -> str:
    hint = suggestion(name, known)
    return f"There is no {kind} {name!r}; it must be one of {', '.join(known)}. {hint}".rstrip()


def _clash(origin: Origin, count: int) -> str:
    """Say why an entry of another package cannot be a law, whatever it names; empty if it can."""
    if origin.name in LAWS:
        fault = "takes the name of one of contactlab's own, which stays what it is"
    elif count > 1:
        fault = "has the name of a law of another package, so that neither can be told by it"
    elif not origin.name.isidentifier():
        fault = "has a name that is no option"
    else:
        return ""
    return (
        f"The law {origin.name!r} of {origin.package} {fault}; it must be one word of letters, digits and "
        "underscores, and no other law's. Rename it, or remove the package by pip uninstall "
        f"{origin.package}."
    )
