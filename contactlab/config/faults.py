"""What a configuration gets wrong, in sentences: key, value, what is admitted, the way out."""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches

from pydantic_core import ErrorDetails

from contactlab.config.groups import GROUPS, KINDS, LAW, known_keys, law_keys
from contactlab.config.nesting import flat
from contactlab.config.quantity import FAULT, describe
from contactlab.config.schema import parts_of


class ConfigurationError(ValueError):
    """A configuration that cannot run.

    Args:
        faults: one sentence each.
    """

    def __init__(self, faults: list[str]) -> None:
        super().__init__("\n".join(faults))
        self.faults = faults


_PLAIN = {"bool_type": "true or false", "string_type": "a text"}


def sentence(fault: ErrorDetails, chosen: Mapping[str, str]) -> str:
    """Tell one of the findings of pydantic in a sentence that starts with the key.

    Args:
        fault: as pydantic has it.
        chosen: the names of law and parts by the keys of their sections.
    """
    steps = [str(step) for step in fault["loc"]]
    kind = chosen.get(".".join(steps[:-1]), "")
    # A section of several kinds is entered by the kind's name, which is no part of the key.
    if len(steps) > 2 and steps[0] in KINDS:
        kind = steps.pop(1)
    key = ".".join(steps)
    value = describe(fault["input"])
    match fault["type"]:
        case str(found) if found == FAULT:
            return f"{key} {fault['ctx']['sentence']}"
        case "extra_forbidden":
            return _unknown(key, kind, chosen)
        case "missing":
            return f"{key} is missing; it must be given. Add it to the configuration."
        case "union_tag_not_found":
            return f"{key}.{KINDS[key]} is missing; it must be given. Choose one by {key}=NAME."
        case "union_tag_invalid":
            return (
                f"{key}.{KINDS[key]} is {describe(fault['ctx']['tag'])}; it must be one of "
                f"{fault['ctx']['expected_tags']}. Choose one by {key}=NAME."
            )
        case "literal_error":
            return f"{key} is {value}; it must be one of {fault['ctx']['expected']}."
        case str(found) if found in _PLAIN:
            return f"{key} is {value}; it must be {_PLAIN[found]}. Leave it out for the default."
        case _:
            if not key:
                return f"The configuration is {value}; it must be a mapping of groups of keys."
            return (
                f"{key} is {value}; it must be a group of keys. "
                f"Set a single one by {key}.KEY=VALUE or choose a file by {key.replace('.', '/')}=NAME."
            )


def one_line(error: BaseException) -> str:
    """Tell what composing a configuration raised, its cause included, in a sentence on one line."""
    parts = [part for part in (error, error.__cause__) if part is not None]
    lines = [line.strip() for part in parts for line in str(part).splitlines()]
    inner = ("full_key:", "reference_type=", "object_type=")
    text = " ".join(line for line in lines if line and not line.startswith(inner))
    return text if text.endswith((".", "?", "!")) else f"{text}."


def _unknown(key: str, kind: str, chosen: Mapping[str, str]) -> str:
    own = flat({LAW: law_keys(chosen[LAW], parts_of(chosen))}) if LAW in chosen else ["law.name"]
    others = (name for name in known_keys() if not name.startswith(f"{LAW}."))
    return unknown_key(key, kind, [*own, *others])


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
    parent, _, leaf = key.rpartition(".")
    # Whoever names the last part alone, or under another group, means the key that ends so.
    endings = get_close_matches(leaf, {name.rpartition(".")[2] for name in known}, 1, 0.8)
    near = (
        get_close_matches(key, known, 1, 0.8)
        or [name for name in known if name.rpartition(".")[2] in endings]
        or get_close_matches(key, known if parent else (LAW, *GROUPS), 1)
    )
    if near:
        return f"{key} is not a known key. Did you mean {' or '.join(near)}?"
    siblings = [name for name in known if parent and name.startswith(f"{parent}.")]
    return (
        f"{key} is not a known key; it must be one of {', '.join(siblings or (LAW, *GROUPS))}. "
        "See contactlab --cfg job for all keys with their values."
    )
