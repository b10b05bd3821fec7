"""YAML of files, written and read; a text whose aliases multiply is refused before it is expanded."""

from typing import Any, Final

import yaml

from contactlab.immutable import Frozen

MOST_VALUES: Final = 1_000_000
"""Values of a text with those that its aliases repeat."""

# libyaml, where PyYAML has it, reads and writes the same eight times as fast.
_LOADER: Final[Any] = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_DUMPER: Final[Any] = getattr(yaml, "CSafeDumper", yaml.SafeDumper)

# Whoever writes a configuration by YAML's own functions can do so too.
for _each in {_DUMPER, yaml.SafeDumper, yaml.Dumper}:
    _each.add_representer(Frozen, _each.represent_dict)


def write_yaml(value: Any) -> str:
    """Return plain numbers, texts, lists and mappings as a text of YAML, in their order."""
    return str(yaml.dump(value, Dumper=_DUMPER, sort_keys=False, allow_unicode=True))


def read_yaml(text: str) -> Any:
    """Return what a text of YAML contains.

    Raises:
        yaml.YAMLError: it is none.
        ValueError: an impossible date, or more values than `MOST_VALUES`.
    """
    check_expansion(text)
    return yaml.load(text, _LOADER)


def check_expansion(text: str) -> None:
    """Refuse a text of more values than `MOST_VALUES`, those that aliases repeat included, by a ValueError.

    Raises:
        yaml.YAMLError: the text is no YAML.
    """
    # Without an alias it has no more values than characters.
    if "*" in text and (count := _expanded(yaml.compose(text, _LOADER), {})) > MOST_VALUES:
        raise ValueError(f"its aliases repeat {count:.3g} values; {MOST_VALUES:.0e} are the most")


def _expanded(node: Any, known: dict[int, float]) -> float:
    """Return the number of values of a node; infinite where it contains itself."""
    if id(node) not in known:
        known[id(node)] = float("inf")
        parts: Any = node.value if isinstance(node, yaml.CollectionNode) else ()
        below = (each for part in parts for each in (part if isinstance(part, tuple) else (part,)))
        known[id(node)] = 1.0 + sum(_expanded(each, known) for each in below)
    return known[id(node)]
