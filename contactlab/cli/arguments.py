"""Arguments of the command: parsers of the verbs that are no studies, and arguments as Hydra reads them."""

import re
import sys
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from inspect import cleandoc
from itertools import pairwise
from pathlib import Path
from shlex import quote
from textwrap import fill
from typing import Final, final

from contactlab.cli.terminal import RefusalError
from contactlab.config.nesting import quoted
from contactlab.suggestion import suggestion

HELP: Final = frozenset({"--help", "-h"})

HELP_WIDTH: Final = 100
"""Of the lines of a help's list."""

VALUED: Final = frozenset(
    {
        *("--cfg", "-c", "--info", "-i", "--package", "-p", "--config-path", "-cp", "--config-name", "-cn"),
        *("--config-dir", "-cd", "--experimental-rerun"),
    }
)
"""Flags of Hydra that take a value."""

_SPREAD: Final = re.compile(r"(?P<key>[^=]+)=\s*'?(?P<value>(?P<name>linspace|geomspace|range)\(.*\))'?\s*")
_NUMBER_WITH_UNIT: Final = re.compile(r"[\d.]\s*(?:(?![eE][-+\d])[^\W\d_]|[°%]|\s1\s*/)")


@final
class Parser:
    """Arguments of a verb that is no study: operands, such as files, and options NAME=VALUE.

    Args:
        module: of the verb, its `__name__`.
        about: docstring of the module.
        operand: what an operand is, as the usage shows it: FILE is one, [FILE] one at most, [FILE ...] any
            number.
        meaning: of the operands.
    """

    def __init__(self, module: str, about: str | None, operand: str = "", meaning: str = "") -> None:
        self._verb, self._about = module.rpartition(".")[2].replace("_", "-"), about
        self._operand, self._meaning = operand, meaning
        self._options: dict[str, tuple[str, str]] = {}

    def option(self, name: str, value: str, meaning: str) -> None:
        """Declare an option; `value` is what its value is, as the help shows it."""
        self._options[name] = value, meaning

    def read(self, arguments: Sequence[str]) -> tuple[list[str], dict[str, str]]:
        """Return the operands, and the options by name that have a value.

        Raises:
            SystemExit: help was printed.
            RefusalError: an argument is no option, or there are too few or too many operands.
        """
        if not HELP.isdisjoint(arguments):
            print(self.help())
            sys.exit(0)
        refuse_dashed(arguments, self._options)
        operands, options = list[str](), list[str]()
        for text in arguments:
            name, sign, _ = text.partition("=")
            # What is there is a file, or the folder of a sweep's run, law=newton.
            is_option = (text.startswith("-") or (sign and name.isidentifier())) and not Path(text).exists()
            (options if is_option or (sign and name in self._options) else operands).append(text)
        for name in (text.partition("=")[0] for text in options):
            if name not in self._options:
                hint = suggestion(
                    name, self._options, f"It must be {', '.join(self._options) or 'left out'}."
                )
                raise RefusalError(f"{name} is no option. {hint}")
        refuse_repeated(options)
        most = (len(operands) if "..." in self._operand else 1) if self._operand else 0
        if len(operands) > most:
            raise RefusalError(f"{operands[most]} is one argument too many: {self._usage}.")
        if not operands and self._operand and "[" not in self._operand:
            raise RefusalError(f"{self._operand} is missing: {self._usage}.")
        pairs = (text.partition("=") for text in options)
        return operands, {name: value for name, _, value in pairs}

    @property
    def _usage(self) -> str:
        options = (f"[{name}={value}]" for name, (value, _) in self._options.items())
        return " ".join(filter(None, ["contactlab", self._verb, self._operand, *options]))

    def help(self) -> str:
        """Return the help of the verb."""
        rows = {self._operand.strip("[] ."): self._meaning} if self._operand else {}
        rows |= {f"{name}={value}": meaning for name, (value, meaning) in self._options.items()}
        return "\n".join(
            [f"usage: {self._usage}", "", cleandoc(self._about or ""), "", *table_of(rows)]
        ).rstrip()


def table_of(rows: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines of a help's list: names, and what each is."""
    width = max(map(len, rows), default=0) + 2
    for name, meaning in rows.items():
        yield fill(
            f"  {name:<{width}}{meaning}",
            HELP_WIDTH,
            subsequent_indent=" " * (width + 2),
            break_long_words=False,
            break_on_hyphens=False,
        )


def refuse_dashed(arguments: Sequence[str], names: Container[str]) -> None:
    """Refuse --NAME of an option, or of a group of keys, by a RefusalError that says how it is written."""
    for word, follower in pairwise([*arguments, ""]):
        if not word.startswith("--"):
            continue
        key, sign, value = word.partition("=")
        name = key.removeprefix("--").replace("-", "_")
        if not sign:
            value = "" if "=" in follower or re.match("-+[a-z]", follower) else follower
        # As --no-refine.
        if name.partition(".")[0] not in names and name.startswith("no_"):
            name, value = name.removeprefix("no_"), "false"
        if name.partition(".")[0] in names:
            written = quote(f"{name}={value or 'VALUE'}")
            raise RefusalError(f"{word} is no option; write {written}.")


def refuse_repeated(lines: Iterable[str]) -> None:
    """Refuse a key with two values, of which Hydra would take the last in silence, by a RefusalError."""
    values: dict[str, list[str]] = {}
    for key, sign, value in (line.partition("=") for line in lines):
        if sign and re.fullmatch(r"[\w./]+", key):
            values.setdefault(key, []).append(value)
    for key, every in values.items():
        if len({*every}) > 1:
            raise RefusalError(f"{key} is {' and '.join(every)}; it must have one value. Leave one out.")


def for_hydra(arguments: Sequence[str]) -> list[str]:
    """Return arguments as Hydra reads them: flags last, as it loses what follows, special values quoted."""
    # Imported here: it brings Hydra, which no verb's --help needs.
    from contactlab.config.composition import readable

    overrides: list[str] = []
    flags: list[str] = []
    for argument in arguments:
        is_value = bool(flags) and flags[-1] in VALUED and "=" not in argument
        (flags if argument.startswith("-") or is_value else overrides).append(argument)
    return [*(_spread_quoted(readable(override)) for override in overrides), *flags]


def _spread_quoted(override: str) -> str:
    """Quote values by a function that Hydra lacks, or with units, which it does not read."""
    match = _SPREAD.fullmatch(override)
    if not match or (match["name"] == "range" and not _NUMBER_WITH_UNIT.search(match["value"])):
        return override
    return f"{match['key']}={quoted(match['value'])}"
