"""What stands behind the name of the command: the arguments of a verb, and those that Hydra reads."""

import re
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from contactlab.cli.terminal import REFUSED, RefusalError
from contactlab.suggestion import suggestion

VERBS = {
    "animate": "show tip, rotor and contact force of a run in slow motion, as GIF or MP4",
    "collect": "put the runs of a sweep into one dataset over their parameters",
    "example": "copy a script, measured impacts or the package of a law to begin from",
    "laws": "list every installed law and part, with all that it declares",
    "verify": "print what is claimed of the engine and the laws, and what is found",
    "warm-up": "compile the engine ahead, for laws of every kind, so that no run has to wait for it",
}
"""What each verb does. Its work is `main(arguments)` in the module beside this one of its name, - as _."""

FLAGS = {
    *(
        "--help",
        "-h",
        "--hydra-help",
        "--version",
        "--cfg",
        "-c",
        "--resolve",
        "--package",
        "-p",
        "--run",
        "-r",
    ),
    *("--multirun", "-m", "--shell-completion", "-sc", "--config-path", "-cp", "--config-name", "-cn", "--"),
    *("--config-dir", "-cd", "--experimental-rerun", "--info", "-i"),
}
"""Flags of Hydra."""

VALUED = {
    *("--cfg", "-c", "--info", "-i", "--package", "-p", "--config-path", "-cp", "--config-name", "-cn"),
    *("--config-dir", "-cd", "--experimental-rerun"),
}
"""Those of them that take a value."""

NO_TEXT = re.compile("[\0\ud800-\udfff]")
"""What the bytes of an argument become that are no UTF-8."""

_LISTED = re.compile(r"(?P<key>[^=]+)=\s*'?(?P<value>(?P<name>linspace|geomspace|range)\(.*\))'?\s*")
_NUMBER_WITH_UNIT = re.compile(r"[\d.]\s*(?:(?![eE][-+\d])[^\W\d_]|[°%]|\s1\s*/)")


class Parser(ArgumentParser):
    """Reads the arguments of one verb, a key of `VERBS`, and refuses them in sentences.

    Args:
        verb: whose arguments.
        about: what follows on the sentence that says what the verb does.
    """

    def __init__(self, verb: str, about: str) -> None:
        described = f"{VERBS[verb].capitalize()}{about}"
        super().__init__(prog=f"contactlab {verb}", description=described, allow_abbrev=False)

    def add_output(self, folder: str, files: str) -> None:
        """Take the folder for what the verb leaves, the default, and name its files in the help."""
        said = f"where {files} go; default: %(default)s"
        self.add_argument("--output", type=Path, default=Path(folder), metavar="DIR", help=said)

    def read(self, arguments: Sequence[str]) -> Namespace:
        """Give the arguments, options among them wherever they stand.

        Raises:
            SystemExit: something is wrong with them, or only help was asked for.
        """
        # Argparse takes -1e-3 for an option.
        joined = re.sub(r"(?<![^\0])(--[a-z]+)\0(?=-[\d.])", r"\1=", "\0".join(arguments))
        found, unknown = self.parse_known_intermixed_args(joined.split("\0") if arguments else [])
        if unknown:
            hint = suggestion(unknown[0].partition("=")[0], re.findall(r"--[\w-]+", self.format_usage()))
            self.error(f"{' '.join(unknown)} is not understood", hint)
        return found

    def error(self, message: str, hint: str = "") -> NoReturn:
        """Refuse the arguments in a sentence."""
        way_out = hint or f"{self.prog} --help tells what it takes."
        self.exit(REFUSED, f"{self.prog}: {message}. {way_out}\n")


def number_in(unit: str, text: str, name: str) -> float:
    """Give a number in an SI unit, "1" for none, that stands in an option or in a part of one.

    Raises:
        RefusalError: it is none, or its unit is of another dimension; the sentence begins with the name.
    """
    # Imported here: it brings Hydra, which --help does not need.
    from contactlab.config.quantity import UnitError, example_in, to_si

    try:
        return to_si(text.strip(), unit)
    except UnitError as error:
        expected = f"in {unit}, or a text with a unit such as {example_in(unit)}" if unit != "1" else "alone"
        raise RefusalError(f"{name} is '{text}', {error}; it must be a number {expected}.") from error


def for_hydra(arguments: Sequence[str]) -> list[str]:
    """Return the arguments as Hydra reads them: flags last, values that are not of its grammar quoted.

    Hydra loses arguments that stand behind a flag.

    Raises:
        RefusalError: an argument is no text, empty, or a verb that does not stand first.
    """
    # Imported here: it brings Hydra, which no verb's --help needs.
    from contactlab.config.composition import readable

    overrides: list[str] = []
    flags: list[str] = []
    for argument in arguments:
        if NO_TEXT.search(argument) or not argument.strip() or argument.startswith("="):
            raise RefusalError(f"{argument!r} is no argument; it must be KEY=VALUE in UTF-8. Leave it out.")
        is_value = bool(flags) and flags[-1] in VALUED and "=" not in argument
        if argument in VERBS and not is_value:
            raise RefusalError(f"{argument} is a verb; it must stand first.")
        (flags if argument.startswith("-") or is_value else overrides).append(argument)
    for flag in flags:
        name = flag.partition("=")[0]
        if name.startswith("-") and name not in FLAGS:
            known = [each for each in FLAGS if each.startswith("--")]
            raise RefusalError(f"{flag} is no option. {suggestion(name, known, 'Keys have no dashes.')}")
    return [*(_quoted(readable(override)) for override in overrides), *flags]


def gives_several(override: str) -> bool:
    """Tell whether an override lists values by a function that is not of Hydra's grammar."""
    return _LISTED.fullmatch(override) is not None


def _quoted(override: str) -> str:
    """Quote values that only our sweeper understands, as Hydra has no such function or no units."""
    found = _LISTED.fullmatch(override)
    if not found or (found["name"] == "range" and not _NUMBER_WITH_UNIT.search(found["value"])):
        return override
    return f"{found['key']}={quoted(found['value'])}"


def quoted(text: str) -> str:
    """Give a text as the value of an override."""
    return "'" + re.sub(r"(\\*)'", r"\1\1\\'", text) + "'"
