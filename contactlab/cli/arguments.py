"""What stands behind the name of the command: the arguments of a verb, and those that Hydra reads."""

import re
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from contactlab.cli.terminal import REFUSED
from contactlab.suggestion import suggestion

VERBS = {
    "animate": "show tip, rotor and contact force of a run in slow motion, as GIF or MP4",
    "basins": "map which of its steady states a motor comes to from where it starts",
    "branch": "follow the periodic orbits of a motor over one number, stable and unstable",
    "characterise": "make the data sheet of a motor: speed-torque curve, power, efficiencies, start and stop",
    "collect": "put the runs of a sweep into one dataset over their parameters",
    "compare": "set the contact laws of several runs side by side, judged, drawn and reported",
    "fit": "find numbers of law and motor from measurements, with posterior and evidence",
    "laws": "list every installed law and part, with all that it declares",
    "steady": "find what the motor does once it has settled: velocity, torque, stability",
    "validate": "judge contact laws by measured impacts that they were not fitted to",
    "verify": "print what is claimed of the engine and the laws, and what is found",
}
"""What each verb does. Its work is `main(arguments)` in the module of its name beside this one."""

_VALUED = {
    "--cfg",
    "-c",
    "--package",
    "-p",
    "--config-path",
    "-cp",
    "--config-name",
    "-cn",
    "--config-dir",
    "-cd",
    "--experimental-rerun",
    "--info",
    "-i",
}
"""Hydra's flags that take a value; that of `--info` may be left out."""

_LONG_FLAGS = {
    *(flag for flag in _VALUED if flag.startswith("--")),
    "--help",
    "--hydra-help",
    "--version",
    "--resolve",
    "--run",
    "--multirun",
    "--shell-completion",
}

_LISTED = re.compile(r"(?P<key>[^=]+)=\s*'?(?P<value>(?P<name>linspace|geomspace|range)\(.*\))'?\s*")
_NUMBER_WITH_UNIT = re.compile(r"[\d.]\s*(?![eE][-+\d])[^\W\d_]")


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
        if "" in arguments:
            self.error("an argument is empty, as of a shell variable that is not set")
        found, unknown = self.parse_known_intermixed_args(arguments)
        if unknown:
            options = [one.partition("=")[0] for one in unknown if one.startswith("-")]
            known = re.findall(r"--[\w-]+", self.format_usage())
            hint = suggestion(options[0], known) if options else ""
            self.error(f"{' '.join(unknown)} is not understood", hint)
        return found

    def error(self, message: str, hint: str = "") -> NoReturn:
        """Refuse the arguments in a sentence."""
        way_out = hint or f"{self.prog} --help tells what it takes."
        self.exit(REFUSED, f"{self.prog}: {message}. {way_out}\n")


def for_hydra(arguments: Sequence[str]) -> list[str]:
    """Give the arguments as Hydra reads them: flags last, and quoted what is not of its grammar.

    Hydra loses arguments that stand behind a flag.

    Raises:
        ValueError: with a sentence on what can be no argument.
    """
    overrides: list[str] = []
    flags: list[str] = []
    for argument in arguments:
        if re.search("[\0\ud800-\udfff]", argument):
            raise ValueError(f"{argument!r} has bytes that are no text; it must be UTF-8. Leave them out.")
        if argument.startswith("--") and argument.partition("=")[0] not in _LONG_FLAGS:
            hint = suggestion(argument, sorted(_LONG_FLAGS), "contactlab --help lists what there is.")
            raise ValueError(f"unrecognized arguments: {argument}. {hint}")
        if argument.startswith("="):
            raise ValueError(f"{argument} has no key; it must have the form KEY=VALUE. Name one.")
        is_value = bool(flags) and flags[-1] in _VALUED and "=" not in argument
        (flags if argument.startswith("-") or is_value else overrides).append(argument)
    return [*map(_quoted, overrides), *flags]


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
