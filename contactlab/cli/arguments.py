"""Arguments of the command: parsers of the verbs that are no studies, and arguments as Hydra reads them."""

import re
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Final

from contactlab.cli.terminal import RefusalError
from contactlab.config.nesting import quoted
from contactlab.suggestion import suggestion

VERBS: Final = {
    "animate": "show tip, rotor and contact force of a run in slow motion, as GIF or MP4",
    "collect": "put the runs of a sweep into one dataset over their parameters",
    "example": "copy a script, measured impacts, or the package of a law or study, to begin from",
    "laws": "list every installed law and part, with all that it declares",
    "report": "make page, figures and tables of a study anew from its dataset",
    "verify": "print the contract of every law, or check what runs recorded",
    "warm-up": "compile the engine ahead, for laws of every kind, so that no run has to wait for it",
}
"""What each verb does; it is `main(arguments)` in the module beside this one of its name, - as _."""

VALUED: Final = frozenset(
    {
        *("--cfg", "-c", "--info", "-i", "--package", "-p", "--config-path", "-cp", "--config-name", "-cn"),
        *("--config-dir", "-cd", "--experimental-rerun"),
    }
)
"""Flags of Hydra that take a value."""

_SPREAD: Final = re.compile(r"(?P<key>[^=]+)=\s*'?(?P<value>(?P<name>linspace|geomspace|range)\(.*\))'?\s*")
_NUMBER_WITH_UNIT: Final = re.compile(r"[\d.]\s*(?:(?![eE][-+\d])[^\W\d_]|[°%]|\s1\s*/)")


class Parser(ArgumentParser):
    """Parser of one verb, whose options are written NAME=VALUE or, as usual elsewhere, --NAME VALUE.

    Args:
        verb: a key of `VERBS`.
        about: follows on the sentence that says what the verb does.
    """

    def __init__(self, verb: str, about: str) -> None:
        self._options: set[str] = set()
        description = f"{VERBS[verb].capitalize()}{about} An option may be written NAME=VALUE."
        super().__init__(prog=f"contactlab {verb}", description=description, allow_abbrev=False)

    def option(self, name: str, **about: Any) -> None:
        """Declare an option, as `add_argument`."""
        self._options.add(name)
        self.add_argument(f"--{name}", **about)

    def read(self, arguments: Sequence[str]) -> Namespace:
        """Return the arguments, options among them wherever they stand.

        Raises:
            SystemExit: a fault in the arguments, or only help was wanted.
        """
        for text in arguments:
            name, sign, _ = text.partition("=")
            # What is there is a file, or the folder of a sweep's run, law=newton.
            if sign and name.isidentifier() and name not in self._options and not Path(text).exists():
                known = ", ".join(sorted(self._options))
                self.error(f"{name} is no option. {suggestion(name, self._options, f'Options are {known}.')}")
        texts = (f"--{t}" if t.partition("=")[0] in self._options and "=" in t else t for t in arguments)
        return self.parse_intermixed_args([*texts])


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
