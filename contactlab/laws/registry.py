"""Every contact law that is installed, by name: the package's own, and those that other packages bring.

Another package brings a law by an entry point in its pyproject.toml, no line of this one changed:

    [project.entry-points."contactlab.laws"]
    power_law = "their_module:PowerLaw"

Nothing is imported before a law is asked for, and then that law alone, so that a package that is
broken harms no other law.
"""

from collections import Counter
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, entry_points, version
from typing import TYPE_CHECKING, final

from contactlab.laws.soundness import fault_of
from contactlab.laws.table import Table

if TYPE_CHECKING:
    from contactlab.laws.base import ContactLaw

GROUP = "contactlab.laws"
"""The group of entry points."""

LAWS: "Table[type[ContactLaw]]" = Table(
    {
        "composed": "contactlab.laws.composed:Composed",
        "hertz_penalty": "contactlab.laws.hertz_penalty:HertzPenalty",
        "lagrange_slip": "contactlab.laws.lagrange_slip:LagrangeSlip",
        "lagrange_stick": "contactlab.laws.lagrange_stick:LagrangeStick",
        "moreau_jean": "contactlab.laws.moreau_jean:MoreauJean",
        "newton": "contactlab.laws.newton:Newton",
        "poisson": "contactlab.laws.poisson:Poisson",
        "stronge": "contactlab.laws.stronge:Stronge",
    }
)
"""The package's own laws."""


@final
@dataclass(frozen=True)
class Origin:
    """Where a law comes from.

    Args:
        name: of the law, as its entry has it.
        entry: "module:Class".
        package, version: the distribution that brings it.
        fault: a sentence where the entry cannot be a law, whatever it names; else empty.
    """

    name: str
    entry: str
    package: str
    version: str
    fault: str = ""

    def __str__(self) -> str:
        return f"{self.package} {self.version}"


@cache
def origins() -> tuple[Origin, ...]:
    """Every entry: the package's own, then the others by name; those that are no law say why."""
    own = [
        Origin(name, entry, "contactlab", _own_version()) for name, entry in LAWS.entries.items()
    ]
    given = sorted(
        (point.name, f"{point.module}:{point.attr}", point.dist.name, str(point.dist.version))
        for point in entry_points(group=GROUP)
        if point.dist is not None
    )
    count = Counter(name for name, *_ in given)
    return *own, *(Origin(*point, _clash(point[0], point[2], count[point[0]])) for point in given)


def law_names() -> list[str]:
    """The names by which a law can be chosen, in their order."""
    return sorted({origin.name for origin in origins() if not origin.fault})


def origin_of(name: str) -> Origin:
    """Where a law comes from.

    Raises:
        ValueError: there is no such law, or the name is not one law's alone.
    """
    found = [origin for origin in origins() if origin.name == name]
    for origin in found:
        if not origin.fault:
            return origin
    if found:
        raise ValueError(found[0].fault)
    raise ValueError(f"There is no law {name!r}; it must be one of {', '.join(law_names())}.")


@cache
def law_class(name: str) -> "type[ContactLaw]":
    """A law's class; imports that law alone.

    Raises:
        ValueError: a sentence on what is wrong with the name, its entry or the class.
    """
    origin = origin_of(name)
    module, _, attribute = origin.entry.partition(":")
    try:
        found: object = import_module(module)
        for step in attribute.split("."):
            found = getattr(found, step)
    # Whatever a module of somebody else's does while it is imported, it is that law's fault alone.
    except (Exception, SystemExit) as error:
        words = f"cannot be imported ({type(error).__name__}: {error})"
        raise ValueError(_sentence(origin, words)) from error
    if fault := _fault_of(found, name):
        raise ValueError(_sentence(origin, fault))
    return found  # type: ignore[return-value]


def provenance(law: type) -> str:
    """The package and version that a law comes from; of one that no package brings, its module."""
    entry = f"{law.__module__}:{law.__qualname__}"
    found = [str(origin) for origin in origins() if origin.entry == entry and not origin.fault]
    return found[0] if found else law.__module__


def _fault_of(found: object, name: str) -> str:
    """What keeps an object from being the law of this name; empty for a law."""
    from contactlab.laws.base import LAW_WORDS, MultiplierLaw, PenaltyLaw

    if not isinstance(found, type) or not issubclass(found, PenaltyLaw | MultiplierLaw):
        return "is no subclass of contactlab.laws.PenaltyLaw or MultiplierLaw"
    if fault := fault_of(found, LAW_WORDS):
        return fault
    if found.name != name:
        return f"calls itself {found.name!r}, which must be the name of its entry too"
    return ""


def _sentence(origin: Origin, fault: str) -> str:
    return (
        f"The law {origin.name!r} of {origin} is not usable: {origin.entry} {fault}. Mend that "
        f"package or remove it by pip uninstall {origin.package}; other laws run."
    )


def _clash(name: str, package: str, count: int) -> str:
    """Why an entry of another package cannot be a law, whatever it names; empty if it can."""
    way_out = f"Rename it, or remove the package by pip uninstall {package}."
    if name in LAWS:
        return (
            f"The law {name!r} of {package} takes the name of one of contactlab's own, which "
            f"stays what it is; it must have a name of its own. {way_out}"
        )
    if count > 1:
        return (
            f"The law {name!r} of {package} has the name of a law of another package, so that neither "
            f"can be told by it; it must have a name of its own. {way_out}"
        )
    if not name.isidentifier():
        return (
            f"The law {name!r} of {package} has a name that is no option; it must be one word of "
            f"letters, digits and underscores. {way_out}"
        )
    return ""


def _own_version() -> str:
    try:
        return version("contactlab")
    except PackageNotFoundError:
        return "unknown"
