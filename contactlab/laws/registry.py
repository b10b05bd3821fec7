"""Every law and part by name: the package's own, and those that other packages bring.

Another package brings a law, or a part of a composed one, by an entry point in its pyproject.toml, no line of
this one changed. Its group is "contactlab.laws", and that of a part has the family besides, "normal",
"damping" or "friction":

    [project.entry-points."contactlab.laws"]
    power_law = "their_module:PowerLaw"

    [project.entry-points."contactlab.laws.friction"]
    sticky = "their_module:Sticky"

It alone is imported when it is chosen, so that a broken package harms no other law.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING
from functools import cache
from importlib.metadata import EntryPoint, distributions, entry_points
from typing import Any, Final, NamedTuple, cast

from contactlab.checks import checked_arguments
from contactlab.laws.archard import Archard
from contactlab.laws.bare import law_of
from contactlab.laws.base import ContactLaw, Damping, Friction, MultiplierLaw, NormalForce, Part, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.damping import DAMPINGS
from contactlab.laws.declaration import SHARED, Declared, family_of, fault_of, members_of
from contactlab.laws.friction import FRICTIONS
from contactlab.laws.hertz_penalty import HertzPenalty
from contactlab.laws.impact import Brach, ChatterjeeRuina, Johnson, MoreauJean, Newton, Poisson, Stronge
from contactlab.laws.lagrange import LagrangeSlip, LagrangeStick
from contactlab.laws.lagrange_ageing import LagrangeAgeing
from contactlab.laws.normal import NORMAL_FORCES
from contactlab.suggestion import suggestion

GROUP: Final = "contactlab.laws"

LAWS: Mapping[str, type[ContactLaw]] = {
    law.name: law
    for law in (
        Archard,
        Brach,
        ChatterjeeRuina,
        Composed,
        HertzPenalty,
        Johnson,
        LagrangeAgeing,
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


def own(family: str = "") -> Mapping[str, type[Declared]]:
    """Return the package's own of a family, the laws where it is empty."""
    return PARTS[family] if family else LAWS


_KINDS: Final[Mapping[str, tuple[str, tuple[type[Declared], ...]]]] = {
    "": ("law", (PenaltyLaw, MultiplierLaw)),
    "normal": ("normal force", (NormalForce,)),
    "damping": ("damping", (Damping,)),
    "friction": ("friction", (Friction,)),
}
"""What one of each family is called, and what it is a subclass of."""


class Origin(NamedTuple):
    """Where a law or part comes from: name, entry "module:Class", and the distribution that brings it."""

    name: str
    entry: str
    package: str
    version: str
    fault: str = ""
    """A sentence where the entry cannot be a law or part, whatever it names."""

    def __str__(self) -> str:
        return f"{self.package} {self.version}"


@cache
def origins(family: str = "") -> tuple[Origin, ...]:
    """Return every entry of a family: the package's own, then others by name, with their faults."""
    version = next((result.version for result in distributions(name="contactlab")), "unknown")
    ours = [Origin(name, _entry(owner), "contactlab", version) for name, owner in own(family).items()]
    arguments = sorted(
        Origin(point.name, f"{point.module}:{point.attr}", point.dist.name, point.dist.version)
        for point in entry_points(group=_group(family))
        if point.dist is not None
    )
    count = Counter(origin.name for origin in arguments)
    return *ours, *(each._replace(fault=_clash(each, family, count[each.name])) for each in arguments)


@checked_arguments()
def law_names(family: str = "") -> list[str]:
    """Return the names by which a law, or a part of a family, can be chosen, in their order.

    >>> import contactlab as cl
    >>> cl.law_names("damping")
    ['flores', 'hunt_crossley', 'kuwabara_kono', 'lankarani_nikravesh', 'linear', 'none', 'tsuji']
    """
    if family not in _KINDS:
        raise ValueError(f"family is {family!r}; it must be one of {', '.join(map(repr, _KINDS))}.")
    return sorted({origin.name for origin in origins(family) if not origin.fault})


def origin_of(name: str, family: str = "") -> Origin:
    """Return where a law or part comes from; a ValueError where none, or more than one, has the name."""
    result = [origin for origin in origins(family) if origin.name == name]
    for origin in result:
        if not origin.fault:
            return origin
    if result:
        raise ValueError(result[0].fault)
    known = law_names(family)
    text = f"There is no {_KINDS[family][0]} {name!r}; it must be one of {', '.join(known)}."
    raise ValueError(f"{text} {suggestion(name, known)}".rstrip())


def ways_to_choose(*texts: str) -> str:
    """Return how laws and parts of these names are chosen, a sentence; empty where a text is no such name.

    Where no law and no part has a name, those that have the text in theirs are meant.

    >>> ways_to_choose("newton", "poisson"), ways_to_choose("newtonian")
    ('newton and poisson are chosen by law=newton,poisson.', '')
    """
    keys = {"": "law", **{family: f"law=composed law/{family}" for family in PARTS}}
    ways = [f"{key}={','.join(texts)}" for each, key in keys.items() if {*texts} <= {*law_names(each)}]
    if not ways and len(texts) == 1:
        every = ((key, name) for each, key in keys.items() for name in law_names(each))
        ways = [f"{key}={name}" for key, name in every if texts[0] in name.split("_")]
    *others, last = ways or [""]
    listed = f"{', '.join(others)} or {last}" if others else last
    verb = "is" if len(texts) == 1 else "are"
    return f"{' and '.join(texts)} {verb} chosen by {listed}." if ways else ""


@cache
def class_of(name: str, family: str = "") -> type[Declared]:
    """Return the class of a law or part, importing it alone, or say in a ValueError what is wrong with it."""
    origin, (kind, bases), cause = origin_of(name, family), _KINDS[family], None
    try:
        result: Any = EntryPoint(name, origin.entry, _group(family)).load()
    # Whatever a module of somebody else's does while it is imported, it is that law's fault alone.
    except (Exception, SystemExit) as error:
        cause, fault = error, f"cannot be imported ({type(error).__name__}: {error})"
    else:
        if not isinstance(result, type) or not issubclass(result, bases):
            fault = f"is no subclass of contactlab.laws.{' or '.join(base.__name__ for base in bases)}"
        elif not (fault := fault_of(result)) and result.name != name:
            fault = f"calls itself {result.name!r}, which must be the name of its entry too"
    if fault:
        raise ValueError(
            f"The {kind} {name!r} of {origin} is not usable: {origin.entry} {fault}. Mend that package or "
            f"remove it by pip uninstall {origin.package}; other laws run."
        ) from cause
    owner: type[Declared] = result
    return owner


def law_class(name: str) -> type[ContactLaw]:
    """Return a law's class, importing that law alone, or say in a ValueError what is wrong with it."""
    return cast("type[ContactLaw]", class_of(name))


@checked_arguments()
def law(name: str | Callable[..., float], /, **parameters: Any) -> ContactLaw:
    """Make a law from its name, `law("newton", restitution=0.4)`, or of a bare function, for a first try.

    The parts of a composed law are given as they are, or by name where their defaults are wanted:
    `law("composed", normal="linear", friction=LuGre(0.2))`. A function is the normal force [N] of a composed
    law; its arguments are quantities of the contact, by the names that kernels have, and with a default
    parameters. See `contactlab.friction` too.

        >>> import contactlab as cl
        >>> cl.law("newton", restitution=0.4)
        Newton(friction_coefficient=0.3, restitution=0.4)
        >>> law = cl.law(lambda depth, stiffness=1e10: stiffness * depth**1.5, friction=cl.Coulomb(0.2))
        >>> law.describe()["normal.stiffness"]
        10000000000.0

    Raises:
        TypeError: the name is neither text nor function, or a parameter is one that the law has not, or is no
            number.
        ValueError: there is no such law or part, a parameter is out of its range, or the function names or
            does what only a class can.
    """
    if isinstance(name, str):
        named: ContactLaw = _made("", name, parameters)
        return named
    parts = {k: _made(k, x, {}) if k in PARTS and isinstance(x, str) else x for k, x in parameters.items()}
    made: ContactLaw = law_of(name, parts)
    return made


def _made(family: str, name: str, parameters: dict[str, Any]) -> Any:
    owner, text = class_of(name, family), f"The {_KINDS[family][0]} {name}"
    members = members_of(owner)
    for parameter, value in parameters.items():
        if parameter not in members:
            hint = suggestion(parameter, members, f"It has {', '.join(members) or 'none'}.")
            raise TypeError(f"{text} has no parameter {parameter!r}. {hint}")
        if (below := family_of(members[parameter])) and isinstance(value, str):
            parameters[parameter] = _made(below, value, {})
    needed = [item for item, member in members.items() if member.default is MISSING]
    if lacking := ", ".join(item for item in needed if item not in parameters):
        raise TypeError(f"{text} lacks {lacking}; without default it must be given.")
    return owner(**parameters)


def build_law(owner: type[Declared], values: Mapping[str, Any], friction_coefficient: float) -> Any:
    """Make a law or a part from its section of a configuration, or raise what the law refuses it with."""
    arguments: dict[str, Any] = {}
    for name, member in members_of(owner).items():
        value: Any = friction_coefficient if name == SHARED else values[name]
        if family := family_of(member):
            value = build_law(class_of(value["name"], family), value, friction_coefficient)
        elif int in member.kinds and value is not None and value == value // 1:
            # One that is not whole the law refuses.
            value = int(value)
        arguments[name] = value
    return owner(**arguments)


def classes_in(values: Mapping[str, Any], family: str = "") -> Iterator[type[Declared]]:
    """Yield the classes of a law and of its parts as its section of a configuration chooses them."""
    owner = class_of(values["name"], family)
    yield owner
    for name, member in members_of(owner).items():
        if below := family_of(member):
            yield from classes_in(values[name], below)


def classes_of(law: Declared) -> Iterator[type[Declared]]:
    """Yield the classes of a law and of its parts."""
    yield type(law)
    for value in vars(law).values():
        if isinstance(value, Declared):
            yield from classes_of(value)


def takes_shared(values: Mapping[str, Any]) -> bool:
    """Return whether a law, or one of its chosen parts, has the parameter that is the contact's."""
    return any(SHARED in members_of(owner) for owner in classes_in(values))


def provenance(law: type[Declared], *parts: type[Declared]) -> str:
    """Return package and version that a law comes from, and those of its parts that are from elsewhere.

    Of one that no package brings it is the module.
    """
    first = _provenance(law)
    foreign = [part for part in parts if part not in own(part.family).values()]
    return ", ".join([first, *(f"{part.family} of {_provenance(part)}" for part in foreign)])


def _provenance(owner: type[Declared]) -> str:
    result = origins(owner.family)
    entries = {origin.entry: str(origin) for origin in reversed(result) if not origin.fault}
    # Of a bare function it is its text as well.
    module = ": ".join(filter(None, (owner.__module__, getattr(owner, "text", ""))))
    return entries.get(_entry(owner), module)


def _group(family: str) -> str:
    return f"{GROUP}.{family}" if family else GROUP


def _entry(owner: type) -> str:
    return f"{owner.__module__}:{owner.__qualname__}"


def _clash(origin: Origin, family: str, count: int) -> str:
    """Return why an entry of another package cannot be a law or part, whatever it names; empty if it can."""
    kind = _KINDS[family][0]
    if origin.name in own(family):
        fault = "takes the name of one of contactlab's own, which stays what it is"
    elif count > 1:
        fault = f"has the name of a {kind} of another package, so that the name is ambiguous"
    elif not origin.name.isidentifier():
        fault = "has a name that is no option"
    else:
        return ""
    return (
        f"The {kind} {origin.name!r} of {origin.package} {fault}; it must be one word of letters, digits and "
        f"underscores, and no other {kind}'s. Rename it, or remove the package by pip uninstall "
        f"{origin.package}."
    )
