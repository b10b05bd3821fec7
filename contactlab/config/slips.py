"""What somebody means who writes an argument in another form: `--law newton`, `newton`, `drive.phase:0`."""

import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

from contactlab.config.faults import OURS, keys_near
from contactlab.config.options import conf_directory, groups, known_keys
from contactlab.config.quantity import is_unit
from contactlab.suggestion import nearest

NOTHING: Final[Mapping[str, Iterable[str]]] = MappingProxyType({})

OUTPUT: Final = "hydra.run.dir"
"""Where a run goes; others call it by the names below."""

_OF_OUTPUT: Final = frozenset({"output", "out", "o", "output_dir", "outdir", "dir"})

MOST: Final = 3
"""Arguments that are offered."""

_QUANTITY: Final = re.compile(
    r".*(?:=|,|\.\.)\s*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?P<unit>(?:\s.*)?)"
)
"""What ends in a number, or in one with a unit behind a space."""


def argument_for(
    word: str, value: str = "", *, near: bool = False, names: Mapping[str, Iterable[str]] = NOTHING
) -> str:
    """Give the argument that a word stands for, as a shell takes it, or a few with "or"; empty for none.

    Args:
        word: an option with dashes, a group, one of its options, a key or the last part of one, each with
            or without a value behind "=" or ":".
        value: what follows the word.
        near: whether a key that is only near the word will do.
        names: what the values of some keys are the names of.
    """
    name, *own = re.split("[=:]", word.lstrip("-"), maxsplit=1)
    given, plain = "".join(own) or value, name.replace("-", "_")
    options = _options()
    holders = [group for group, names in options.items() if plain in names]
    keys = _keys_that_end_so(plain)
    if plain in _OF_OUTPUT:
        found = [f"{OUTPUT}={given or 'DIR'}"]
    elif plain in options:
        found = [f"{plain}={_nearest(given, options[plain]) or 'NAME'}"]
    elif holders and not given:
        found = [f"{group}={plain}" for group in holders]
    else:
        keys = keys or (keys_near(plain, known_keys()) if near and plain else [])
        found = [f"{key}={_nearest(given, names.get(key, ())) or 'VALUE'}" for key in keys]
    return " or ".join(map(shlex.quote, found)) if len(found) <= MOST else ""


def joined(words: Sequence[str]) -> list[list[str]]:
    """Give words in groups, each of those that make one argument: `law = newton`, `contact.clearance=1 um`.

    A word alone is a group of its own.
    """
    found: list[list[str]] = []
    for word in words:
        if found and _belongs(word, "".join(found[-1][:1]) if len(found[-1]) == 1 else spelled(found[-1])):
            found[-1].append(word)
        else:
            found.append([word])
    return found


def spelled(group: Sequence[str]) -> str:
    """Give the argument that a group of words makes."""
    text = " ".join(group)
    name, sign, value = re.sub(r"\s*=\s*", "=", text, count=1).partition("=")
    return f"{name}={value}" if sign else text.replace(" ", "=", 1)


def line_for(words: Sequence[str], names: Mapping[str, Iterable[str]] = NOTHING) -> str:
    """Give the arguments that words stand for, each as a run takes it where that can be told, for a shell."""
    found = []
    for argument in map(spelled, joined(words)):
        meant = argument_for(argument, names=names)
        found.append(meant if meant and " or " not in meant else shlex.quote(argument))
    return " ".join(found)


def _belongs(word: str, before: str) -> bool:
    """Tell whether a word is the rest of the argument before it: its value, or the unit of that."""
    if re.match(r"-+[^\W\d]", word):
        return False
    if word.startswith("=") or before.endswith("="):
        return True
    if "=" not in before:
        name = before.lstrip("-").replace("-", "_")
        is_name = name in _options() or bool(_keys_that_end_so(name))
        return is_name and "=" not in word
    number = _QUANTITY.fullmatch(before)
    units = re.split(r",|\.\.", word)
    return number is not None and is_unit(f"{number['unit']} {units[0]}")


def _keys_that_end_so(name: str) -> list[str]:
    """Give the keys whose last parts are a name, or what others call by it."""
    found = [key for key in known_keys() if name and f".{key}".endswith(f".{name}")]
    return found or (keys_near(name, known_keys()) if name.lower() in OURS else [])


def _nearest(words: str, names: Iterable[str]) -> str:
    """Give the names that words with commas between them are or are near, or the words."""
    known = sorted(names)
    near = (
        word if word in known or not word else (*nearest(word, known), word)[0] for word in words.split(",")
    )
    return ",".join(near)


def _options() -> dict[str, set[str]]:
    """Give the names of the options of every group, files included."""
    found = {group: set(options) for group, options in groups().items()}
    for path in conf_directory().glob("*/**/*.yaml"):
        group = path.parent.relative_to(conf_directory()).as_posix()
        found.setdefault(group, set()).add(path.stem)
    return found
