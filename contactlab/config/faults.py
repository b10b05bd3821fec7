"""What a configuration gets wrong, in sentences: key, value, what is admitted, the way out."""

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from functools import cache
from typing import get_args

from pydantic_core import ErrorDetails

from contactlab.config.law_section import part_members, section_of
from contactlab.config.quantity import FAULT, describe
from contactlab.config.schema import KINDS, Configuration
from contactlab.config.section import Section
from contactlab.laws.registry import PARTS, law_names


class ConfigurationError(ValueError):
    """A configuration that cannot run.

    Args:
        faults: one sentence each.
    """

    def __init__(self, faults: list[str]) -> None:
        super().__init__("\n".join(faults))
        self.faults = faults


def sentence(fault: ErrorDetails, chosen: Mapping[str, str]) -> str:
    """One of pydantic's findings in a sentence that starts with the key.

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
        case "bool_type":
            value = describe(fault["input"])
            return f"{key} is {value}; it must be true or false. Leave it out for that of the file."
        case _:
            value = describe(fault["input"])
            if not key:
                return f"The configuration is {value}; it must be a mapping of groups of keys."
            return (
                f"{key} is {value}; it must be a group of keys. "
                f"Set a single one by {key}.KEY=VALUE or choose a file by {key.replace('.', '/')}=NAME."
            )


def one_line(error: BaseException) -> str:
    """What composing a configuration raised, its cause included, as a sentence on one line."""
    parts = [part for part in (error, error.__cause__) if part is not None]
    lines = [line.strip() for part in parts for line in str(part).splitlines()]
    inner = ("full_key:", "reference_type=", "object_type=")
    text = " ".join(line for line in lines if line and not line.startswith(inner))
    return text if text.endswith((".", "?", "!")) else f"{text}."


@cache
def known_keys() -> list[str]:
    """Every full key of every choice, in the order of the schema; a law that is broken has none."""
    laws = [key for section in _law_sections() for key in _keys_of(section)]
    return list(dict.fromkeys([*laws, *_keys_with({})]))


def _law_sections() -> Iterator[type[Section]]:
    """The section of every law that is installed, with each of its parts."""
    for name in law_names():
        try:
            yield section_of(name)
            for member in part_members(name):
                for part in PARTS[member.family]:
                    yield section_of(name, ((member.name, part),))
        except ValueError:
            continue


def _keys_with(chosen: Mapping[str, str]) -> list[str]:
    """Every full key where law and parts are chosen; none of the law's where they are not known."""
    keys = [key for key in _keys_of(Configuration) if not key.startswith("law.")]
    parts = tuple((key.removeprefix("law."), part) for key, part in chosen.items() if key != "law")
    try:
        return [*_keys_of(section_of(chosen["law"], parts)), *keys]
    except (KeyError, ValueError):
        return ["law.name", *keys]


def _keys_of(section: type[Section]) -> list[str]:
    keys = []
    for name, field in section.model_fields.items():
        kinds = [k for k in (field.annotation, *get_args(field.annotation)) if isinstance(k, type)]
        below = [kind for kind in kinds if issubclass(kind, Section)]
        keys += [key for kind in below for key in _keys_of(kind)] or [f"{section.path}{name}"]
    return keys


def _unknown(key: str, kind: str, chosen: Mapping[str, str]) -> str:
    """The sentence for a key that does not exist, or not in this kind of section."""
    if kind and any(name == key or name.startswith(f"{key}.") for name in known_keys()):
        group = key.rpartition(".")[0].replace(".", "/")
        return (
            f"{key} does not belong to {kind}; it must be absent with this choice of {group}. "
            f"Leave it out or choose another {group}."
        )
    known = _keys_with(chosen)
    parent, _, leaf = key.rpartition(".")
    # Whoever names the last part alone, or under another group, means the key that ends so.
    endings = get_close_matches(leaf, {name.rpartition(".")[2] for name in known}, 1, 0.8)
    near = (
        get_close_matches(key, known, 1, 0.8)
        or [name for name in known if name.rpartition(".")[2] in endings]
        or get_close_matches(key, known if parent else Configuration.model_fields, 1)
    )
    if near:
        return f"{key} is not a known key. Did you mean {' or '.join(near)}?"
    siblings = [name for name in known if parent and name.startswith(f"{parent}.")]
    return (
        f"{key} is not a known key; it must be one of "
        f"{', '.join(siblings or Configuration.model_fields)}. "
        "See contactlab --cfg job for all keys with their values."
    )
