"""What a configuration gets wrong, in sentences: key, value, what is admitted, the way out."""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Final

from contactlab.config.groups import GROUPS
from contactlab.config.options import known_keys

OURS: Final = {
    "amplitude": "voltage",
    "cor": "restitution",
    "dt": "contact_step",
    "e": "restitution",
    "f": "frequency",
    "gap": "clearance",
    "k": "stiffness",
    "mu": "friction_coefficient",
    "step": "contact_step",
    "t": "duration",
    "t_end": "duration",
    "time": "duration",
    "torque": "load_torque",
}
"""Symbols and words of others, and what the last part of our key begins with."""

MOST: Final = 3
"""Keys that are offered."""

SHORTEST: Final = 3
"""Letters that tell which word begins with them."""

ALIKE: Final = 0.8
"""How near a name must be to be offered, from 0 to 1."""


class ConfigurationError(ValueError):
    """A configuration that cannot run, with a sentence for each of its faults."""

    def __init__(self, faults: list[str]) -> None:
        super().__init__("\n".join(faults))
        self.faults = faults


def one_line(error: BaseException) -> str:
    """Tell what composing a configuration raised, its cause included, in a sentence on one line."""
    parts = [part for part in (error, error.__cause__) if part is not None]
    lines = [line.strip() for part in parts for line in str(part).splitlines()]
    inner = ("full_key:", "reference_type=", "object_type=")
    text = " ".join(line for line in lines if line and not line.startswith(inner))
    return text if text.endswith((".", "?", "!")) else f"{text}."


def unknown_key(key: str, kind: str, known: Sequence[str]) -> str:
    """Say that a key is none of those that there are, or none of the kind that is chosen of its group."""
    parent = key.rpartition(".")[0]
    if kind and any(f"{name}.".startswith(f"{key}.") for name in known_keys()):
        group = parent.replace(".", "/")
        return (
            f"{key} does not belong to {kind}; it must be absent with this choice of {group}. "
            f"Leave it out or choose another {group}."
        )
    top = ("law", *GROUPS)
    if key in top:
        return (
            f"{key} is a group of keys; it must be one of them, {key}.KEY. See contactlab --cfg job for all."
        )
    siblings = [name for name in known if parent and name.startswith(f"{parent}.")]
    near = keys_near(key, known) or get_close_matches(key.lower(), top, 1, ALIKE)
    if near or (parent and not siblings and (near := get_close_matches(key, known, 1))):
        return f"{key} is not a known key. Did you mean {' or '.join(near)}?"
    return (
        f"{key} is not a known key; it must be one of {', '.join(siblings or top)}. "
        "See contactlab --cfg job for all keys with their values."
    )


def keys_near(key: str, known: Sequence[str]) -> list[str]:
    """Give the known keys that a key is, begins or is near, by all of it or by its last part."""
    typed = key.lower()
    parent, _, last = typed.rpartition(".")
    endings = {name: name.rpartition(".")[2] for name in known}
    own = {name: end for name, end in endings.items() if name.rpartition(".")[0] == parent}
    # Whoever names the last part alone, or under another group, means the key that ends so.
    if last in OURS:
        near = _begun(OURS[last], own) or _begun(OURS[last], endings)
    else:
        near = _begun(last, own if parent else endings) or get_close_matches(typed, known, 1, ALIKE)
    if not near:
        alike = get_close_matches(last, {*endings.values()}, 1, ALIKE)
        near = [name for name, end in endings.items() if end in alike]
    return near if len(near) <= MOST else []


def _begun(word: str, endings: Mapping[str, str]) -> list[str]:
    """Give the keys whose last part is a word, or begins with it where that tells anything."""
    exact = [name for name, end in endings.items() if end == word]
    return exact or [name for name, end in endings.items() if len(word) >= SHORTEST and end.startswith(word)]
