"""Every resonator by name: beams in two bases, that of a file, and those that other packages bring.

Another package brings a resonator by an entry point in its pyproject.toml:

    [project.entry-points."contactlab.resonators"]
    ring = "their_module:Ring"

It is a dataclass whose fields are declared numbers, as those of a law, with a property `modes`, the
`contactlab.NormalModes`. It is imported when it is chosen.
"""

from collections.abc import Mapping
from dataclasses import is_dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Final

from contactlab.motor import FiniteElementResonator, RitzResonator
from contactlab.motor.modal import ModalFile

GROUP: Final = "contactlab.resonators"

BASES: Final = {"ritz": RitzResonator, "finite_element": FiniteElementResonator}
"""The bases of the beam."""

MODAL: Final = "modal"
"""The basis of a file."""

OF_BEAMS: Final = ("piezoceramic", "placement")
"""Groups of the beam, of which no other resonator has anything."""

_OWN: Final[Mapping[str, type]] = {**BASES, MODAL: ModalFile}


@cache
def others() -> dict[str, EntryPoint]:
    """Return the entries of other packages by name."""
    return {point.name: point for point in entry_points(group=GROUP) if point.name not in _OWN}


def resonator_names() -> list[str]:
    """Return the names by which a resonator can be chosen; nothing of another package is imported."""
    return [*_OWN, *others()]


def resonator_class(name: str) -> type:
    """Return the class of a resonator; a ValueError where another package's cannot be one."""
    if name in _OWN:
        return _OWN[name]
    try:
        owner: Any = others()[name].load()
    # Whatever a module of somebody else's does while it is imported, it is that resonator's fault alone.
    except (Exception, SystemExit) as error:
        raise ValueError(f"It cannot be imported ({type(error).__name__}: {error}).") from error
    if not (isinstance(owner, type) and is_dataclass(owner) and hasattr(owner, "modes")):
        raise ValueError("It must be a dataclass with a property `modes`.")
    return owner
