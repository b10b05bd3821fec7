"""What a configuration gets wrong, in sentences: key, value, what is admitted, the way out."""

from collections.abc import Sequence
from difflib import get_close_matches

from pydantic_core import ErrorDetails

from contactlab.config.groups import GROUPS, keys_of_law, known_keys, told_by
from contactlab.config.quantity import FAULT, describe
from contactlab.laws.registry import law_class, law_names


class ConfigurationError(ValueError):
    """A configuration that cannot run.

    Args:
        faults: one sentence each.
    """

    def __init__(self, faults: list[str]) -> None:
        super().__init__("\n".join(faults))
        self.faults = faults


_PLAIN = {"bool_type": "true or false", "string_type": "a text"}


def sentence(fault: ErrorDetails, law: str) -> str:
    """Tell one of the findings of pydantic in a sentence that starts with the key.

    Args:
        fault: as pydantic has it.
        law: the name of the law that is chosen.
    """
    key, kind = _place(fault)
    group, value, context = key.replace(".", "/"), describe(fault["input"]), fault.get("ctx", {})
    match fault["type"]:
        case str(found) if found == FAULT:
            return f"{key} {context['sentence']}"
        case "extra_forbidden":
            return unknown_key(key, kind, known_keys(law))
        case "missing":
            return f"{key} is missing; it must be given. Add it to the configuration."
        case "union_tag_not_found":
            return f"{key}.{told_by(key)} is missing; it must be given. Choose one by {group}=NAME."
        case "union_tag_invalid":
            return _unknown_option(key, context["tag"], context["expected_tags"])
        case "literal_error":
            return f"{key} is {value}; it must be one of {context['expected']}."
        case str(found) if found in _PLAIN:
            return f"{key} is {value}; it must be {_PLAIN[found]}. Leave it out for the default."
        case _:
            if not key:
                return f"The configuration is {value}; it must be a mapping of groups of keys."
            return (
                f"{key} is {value}; it must be a group of keys. "
                f"Set a single one by {key}.KEY=VALUE or choose a file by {group}=NAME."
            )


def one_line(error: BaseException) -> str:
    """Tell what composing a configuration raised, its cause included, in a sentence on one line."""
    parts = [part for part in (error, error.__cause__) if part is not None]
    lines = [line.strip() for part in parts for line in str(part).splitlines()]
    inner = ("full_key:", "reference_type=", "object_type=")
    text = " ".join(line for line in lines if line and not line.startswith(inner))
    return text if text.endswith((".", "?", "!")) else f"{text}."


def _place(fault: ErrorDetails) -> tuple[str, str]:
    """The key, and which option its section is: pydantic has that in the key, behind each choice."""
    key = kind = option = ""
    for step in map(str, fault["loc"]):
        if told_by(key) and not option:
            option = step
        else:
            key, kind, option = f"{key}.{step}" if key else step, option, ""
    return key, kind


def _unknown_option(key: str, name: object, expected: str) -> str:
    """The sentence for a choice that there is not, or that is broken."""
    if key == "law":
        expected = ", ".join(map(repr, law_names()))
        try:
            if name in law_names():
                keys_of_law(law_class(str(name)))
        except ValueError as error:
            return f"law.name is '{name}', which cannot run. {error}"
    return (
        f"{key}.{told_by(key)} is {describe(name)}; it must be one of {expected}. "
        f"Choose one by {key.replace('.', '/')}=NAME."
    )


def unknown_key(key: str, kind: str, known: Sequence[str]) -> str:
    """Say that a key does not exist, or not in this kind of section.

    Args:
        key: the key.
        kind: what is chosen of the key's group; empty where it is no group.
        known: the keys that there are with what is chosen.
    """
    if kind and any(f"{name}.".startswith(f"{key}.") for name in known_keys()):
        group = key.rpartition(".")[0].replace(".", "/")
        return (
            f"{key} does not belong to {kind}; it must be absent with this choice of {group}. "
            f"Leave it out or choose another {group}."
        )
    top = ("law", *GROUPS)
    parent, _, leaf = key.rpartition(".")
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
