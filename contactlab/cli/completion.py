"""Tab completion: verbs, options of studies, groups and keys, as the shell's script asks for them.

Hydra's scripts for bash, zsh and fish, which `contactlab -sc install=SHELL` prints, call `contactlab -sc
query=SHELL` with the line in the environment. Hydra completes groups and keys; what stands before them is
completed here.
"""

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from importlib import import_module
from types import NoneType
from typing import Final, get_args

from hydra.plugins.completion_plugin import CompletionPlugin, DefaultCompletionPlugin

from contactlab.cli import verbs
from contactlab.cli.arguments import for_hydra
from contactlab.config.composition import COMMAND, RUN, started
from contactlab.parameter import DeclaredField, declared_fields
from contactlab.studies.registry import studies, study_class

_FLAG: Final = "query="
_BETWEEN: Final = {"fish": "\n"}
"""What the script of a shell reads between candidates, where it is no space."""


def queried_shell(arguments: list[str]) -> str:
    """Return the shell whose script asks for candidates; empty where none does."""
    asks = arguments[:1] in (["-sc"], ["--shell-completion"])
    return arguments[-1].removeprefix(_FLAG) if asks and arguments[-1].startswith(_FLAG) else ""


def print_candidates(shell: str) -> None:
    """Print what may complete the last word of the line: nothing where that fails."""
    matches: list[str] = []
    # Whatever it raises would be written into the prompt.
    with suppress(Exception):
        line = CompletionPlugin.strip_python_or_app_name(os.environ["COMP_LINE"])
        matches = candidates(line)
    print(_BETWEEN.get(shell, " ").join(matches))


def candidates(line: str) -> list[str]:
    """Return the words that the last word of a line may become, in their order.

    Args:
        line: of a command, without the name of the program.
    """
    arguments = line.split()
    word = "" if not line or line[-1].isspace() else arguments.pop()
    if not arguments:
        return _beginning(sorted([*verbs.names(), "help"]), word) + _of_configuration(
            COMMAND, arguments, word
        )
    if arguments == ["help"]:
        return _beginning(verbs.names(), word)
    if arguments[0] in verbs.modules():
        # Of a verb that takes files there are none: the shell completes them.
        module = import_module(verbs.modules()[arguments[0]])
        return _beginning(module.names() if hasattr(module, "names") else (), word)
    if arguments[0] not in studies():
        return [] if arguments[0].isidentifier() else _of_configuration(COMMAND, arguments, word)
    study = study_class(arguments[0])
    options = declared_fields(study)
    key, sign, _ = word.partition("=")
    if sign and key in options:
        return _beginning((f"{key}={value}" for value in _values(options[key])), word)
    named = _beginning((f"{name}=" for name in (*options, "output")), word)
    others = [each for each in arguments[1:] if each.partition("=")[0] not in (*options, "output")]
    # Imported here: it brings the engine. What the study refuses is not offered.
    from contactlab.cli.study import without_effect

    return named + [x for x in _of_configuration(RUN, others, word) if not any(without_effect(study, [x]))]


def _beginning(candidates: Iterable[str], start: str) -> list[str]:
    return [each for each in candidates if each.startswith(start)]


def _values(field: DeclaredField) -> Iterator[str]:
    """Yield the values of an option that can be listed."""
    for kind in field.kinds:
        yield from ("true", "false") if kind is bool else ("null",) if kind is NoneType else ()
        yield from (each for each in get_args(kind) if isinstance(each, str))


def _of_configuration(name: str, arguments: Iterable[str], word: str) -> list[str]:
    """Return the groups, options, keys and values that Hydra completes a word to.

    Of several values, law=newton,h, the last one is completed, and those before count as the first.
    """
    key, sign, value = word.partition("=")
    before, comma, last = value.rpartition(",")
    chosen = [each.split(",")[0] for each in arguments if "=" in each and not {*"'\"[({"} & {*each}]
    with started() as application:
        plugin = DefaultCompletionPlugin(application.config_loader)
        line = " ".join([*for_hydra(chosen), f"{key}{sign}{last}"])
        matches: list[str] = plugin._query(name, line)
    if matches == [word] and sign:
        # A text without a default: a file.
        return [f"{word}{file}" for file in plugin.complete_files("./")]
    return [f"{key}={before}{comma}{each.partition('=')[2]}" for each in matches] if comma else matches
