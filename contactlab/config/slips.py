"""What somebody means who writes an argument in another form: `--law newton`, `newton`, `drive.phase:0`."""

import re
import shlex
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Final

from contactlab.config.faults import keys_near
from contactlab.config.options import conf_directory, groups, known_keys
from contactlab.suggestion import nearest

NOTHING: Final[Mapping[str, Iterable[str]]] = MappingProxyType({})

OUTPUT: Final = "hydra.run.dir"
"""Where a run goes; others call it by the names below."""

_OF_OUTPUT: Final = frozenset({"output", "out", "output_dir", "outdir", "dir"})

MOST: Final = 3
"""Arguments that are offered."""


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
    keys = [key for key in known_keys() if plain and f".{key}".endswith(f".{plain}")]
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
