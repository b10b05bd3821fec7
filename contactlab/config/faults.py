"""What a configuration gets wrong, in sentences: key, value, what is admitted, the way out."""

from collections.abc import Sequence
from difflib import get_close_matches

from contactlab.config.groups import GROUPS
from contactlab.config.options import known_keys


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
    parent, _, leaf = key.rpartition(".")
    if kind and any(f"{name}.".startswith(f"{key}.") for name in known_keys()):
        group = parent.replace(".", "/")
        return (
            f"{key} does not belong to {kind}; it must be absent with this choice of {group}. "
            f"Leave it out or choose another {group}."
        )
    top = ("law", *GROUPS)
    # Whoever names the last part alone, or under another group, means the key that ends so.
    endings = get_close_matches(leaf, {name.rpartition(".")[2] for name in known}, 1, 0.8)
    near = (
        get_close_matches(key, known, 1, 0.8)
        or [name for name in known if name.rpartition(".")[2] in endings]
        or get_close_matches(key, known if parent else top, 1)
    )
    if near:
        return f"{key} is not a known key. Did you mean {' or '.join(near)}?"
    siblings = [name for name in known if parent and name.startswith(f"{parent}.")]
    return (
        f"{key} is not a known key; it must be one of {', '.join(siblings or top)}. "
        "See contactlab --cfg job for all keys with their values."
    )
