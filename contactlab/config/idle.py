"""A key that is set and changes nothing."""

from collections.abc import Iterable, Mapping
from typing import Any

from contactlab.config.faults import ConfigurationError
from contactlab.laws.declaration import SHARED
from contactlab.laws.registry import law_class, takes_shared

FRICTION = f"contact.{SHARED}"
"""The key that laws share, and some law of another package may not have."""


def idle_friction(laws: Iterable[Mapping[str, Any]]) -> str:
    """What is to be said where the shared friction coefficient is set or swept.

    Args:
        laws: the sections `law` of all configurations that are to run.

    Returns:
        A sentence that names the laws without it; empty where every law has it.

    Raises:
        ConfigurationError: none has it, so that nothing depends on what was set.
    """
    takes: dict[str, bool] = {}
    for law in laws:
        name = str(law["name"])
        takes[name] = takes.get(name, True) and takes_shared(law_class(name), law)
    idle = ", ".join(name for name, taken in takes.items() if not taken)
    if not idle:
        return ""
    words = f"{FRICTION} is set, but law={idle} has no friction coefficient of that name"
    if not any(takes.values()):
        raise ConfigurationError(
            [f"{words}; it must be left out. Set the keys of the law, or choose another one."]
        )
    return f"{words}: what it gives does not depend on it."
