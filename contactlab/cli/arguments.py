"""What stands behind the name of the command: the arguments of a verb, and those that Hydra reads."""

import re
import shlex
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from contactlab.cli.terminal import REFUSED, RefusalError
from contactlab.suggestion import suggestion

VERBS = {
    "animate": "show tip, rotor and contact force of a run in slow motion, as GIF or MP4",
    "collect": "put the runs of a sweep into one dataset over their parameters",
    "compare": "set the contact laws of several runs side by side, judged, drawn and reported",
    "example": "copy a script, measured impacts or the package of a law to begin from",
    "laws": "list every installed law and part, with all that it declares",
    "verify": "print what is claimed of the engine and the laws, and what is found",
    "warm-up": "compile the engine ahead, for laws of every kind, so that no run has to wait for it",
}
"""What each verb does. Its work is `main(arguments)` in the module beside this one of its name, - as _."""

INSTEAD = {
    "compile": "warm-up",
    "config": "--cfg job",
    "datasheet": "characterise",
    "demo": "example",
    "examples": "example",
    "gallery": "example",
    "list": "laws",
    "ls": "laws",
    "multirun": "-m",
    "plot": "animate",
    "run": "",
    "show": "animate",
    "simulate": "",
    "start": "",
    "sweep": "-m",
    "version": "--version",
}
"""What others call a verb, and what stands behind `contactlab` for it: a run has no verb."""

_CHOICES = {
    **dict.fromkeys(("--cfg", "-c"), ("job", "hydra", "all")),
    **dict.fromkeys(
        ("--info", "-i"), ("all", "config", "defaults", "defaults-tree", "plugins", "searchpath")
    ),
}
"""What Hydra's flags may be followed by that take a word of some; that of `--info` may be left out."""

_VALUED = {
    *_CHOICES,
    "--package",
    "-p",
    "--config-path",
    "-cp",
    "--config-name",
    "-cn",
    "--config-dir",
    "-cd",
    "--experimental-rerun",
}
"""Hydra's flags that take a value."""

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

FLAGS = {*_LONG_FLAGS, *_VALUED, "-h", "-r", "-m", "-sc", "--"}
"""All of Hydra's flags."""

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
        if any(not word.strip() or re.fullmatch("--[a-z-]+=", word) for word in arguments):
            self.error("an argument is empty, as of a shell variable that is not set")
        self._check_units(arguments)
        if "KEY=VALUE" in self.format_usage():
            self._check_whole(arguments)
        # Argparse takes -1e-3 for an option.
        joined = re.sub(r"(?<![^\0])(--[a-z]+)\0(?=-[\d.])", r"\1=", "\0".join(arguments))
        found, unknown = self.parse_known_intermixed_args(joined.split("\0") if arguments else [])
        if unknown:
            options = [one for one in unknown if one.startswith("-")]
            hint = self._meant(options[0], arguments) if options else ""
            self.error(f"{' '.join(unknown)} is not understood", hint)
        return found

    def _check_units(self, arguments: Sequence[str]) -> None:
        """Refuse the value of an option that a space has split from its unit."""
        for option, value, unit in zip(arguments, arguments[1:], arguments[2:], strict=False):
            if not (option.startswith("--") and re.fullmatch(r"-?[\d.]+", value)) or unit.startswith("-"):
                continue
            # Imported here: it brings Hydra, which --help does not need.
            from contactlab.config.quantity import is_unit

            if is_unit(unit) and not Path(unit).exists():
                meant = f"{option} '{value} {unit}'"
                self.error(f"{option} {value} {unit} has a space before the unit", f"Did you mean {meant}?")

    def _check_whole(self, arguments: Sequence[str]) -> None:
        """Refuse an argument that spaces have split, with the one that was meant."""
        # Imported here: it brings Hydra, which --help does not need.
        if all("=" in word or word.startswith("-") for word in arguments):
            return
        from contactlab.config.slips import joined, spelled

        for group in joined(arguments):
            if len(group) > 1 and not group[0].startswith("-"):
                meant = shlex.quote(spelled(group))
                self.error(
                    f"{' '.join(group)} is {len(group)} words; an argument must be one",
                    f"Did you mean {meant}?",
                )

    def _meant(self, option: str, arguments: Sequence[str]) -> str:
        """Ask what an unknown option may stand for: an argument of a run, where the verb takes any."""
        usage = self.format_usage()
        if "KEY=VALUE" in usage and (meant := _argument_for(option, arguments)):
            return f"Did you mean {meant}, without dashes?"
        return suggestion(option.partition("=")[0], re.findall(r"--[\w-]+", usage))

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
    """Give the arguments as Hydra reads them: flags last, and quoted what is not of its grammar.

    Hydra loses arguments that stand behind a flag.

    Raises:
        RefusalError: with a sentence on what can be no argument.
    """
    # Imported here: it brings Hydra, which no verb's --help needs.
    from contactlab.config.composition import readable

    overrides: list[str] = []
    flags: list[str] = []
    for argument in arguments:
        if NO_TEXT.search(argument):
            raise RefusalError(f"{argument!r} has bytes that are no text; it must be UTF-8. Leave them out.")
        if (name := argument.partition("=")[0]) not in FLAGS and re.match("-.", name):
            _refuse_flag(argument, arguments)
        if not argument.strip():
            raise RefusalError("An argument is empty, as of a shell variable that is not set. Leave it out.")
        if argument.startswith("="):
            raise RefusalError(f"{argument} has no key; it must have the form KEY=VALUE. Name one.")
        if argument in VERBS and not (flags and flags[-1] in _VALUED):
            rest = shlex.join(each for each in arguments if each != argument)
            raise RefusalError(f"{argument} is a verb; it stands first: contactlab {argument} {rest}")
        is_value = bool(flags) and flags[-1] in _VALUED and "=" not in argument
        (flags if argument.startswith("-") or is_value else overrides).append(argument)
    _check_values(flags)
    return [*(_quoted(readable(override)) for override in overrides), *flags]


def _refuse_flag(flag: str, arguments: Sequence[str]) -> NoReturn:
    """Refuse what begins with a dash and is none of Hydra's flags, with what was meant."""
    if meant := _argument_for(flag, arguments):
        words = f"{flag} is no option; arguments of a run have no dashes."
        raise RefusalError(f"{words} Did you mean {meant}?")
    name = f"--{flag.lstrip('-').lower()}"
    # A letter is near many words.
    known = sorted(each for each in _LONG_FLAGS if len(name) > len("--x") or each.startswith(name))
    hint = suggestion(name, known, _near(flag, arguments))
    raise RefusalError(f"unrecognized arguments: {flag}. {hint}")


def _check_values(flags: Sequence[str]) -> None:
    """Refuse flags that take a value and have none, or one that is not for them."""
    for flag, behind in zip(flags, [*flags[1:], ""], strict=False):
        name, sign, own = flag.partition("=")
        value = own if sign else "" if behind.startswith("-") else behind
        if name not in _VALUED or (not value and _CHOICES.get(name) == _CHOICES["--info"]):
            continue
        among = _CHOICES.get(name)
        if among and value not in among:
            words = f"{name} is '{value}'" if value else f"{name} has no value"
            raise RefusalError(f"{words}; it must be one of {', '.join(among)}, as in {name} {among[0]}.")
        if not value:
            raise RefusalError(
                f"{name} has no value; one must follow it. contactlab --hydra-help tells of it."
            )


def _argument_for(option: str, arguments: Sequence[str], *, near: bool = False) -> str:
    """Give the argument of a run that an option stands for, with the value behind it; empty for none."""
    # Imported here: it brings Hydra, which --help does not need.
    from contactlab.config.slips import argument_for
    from contactlab.metrics import METRICS

    names = {"sweep.metrics": METRICS}
    behind = "".join(arguments[arguments.index(option) + 1 :][:1]) if option in arguments else ""
    return argument_for(option, "" if re.match("-|.*=", behind) else behind, near=near, names=names)


def _near(option: str, arguments: Sequence[str]) -> str:
    meant = _argument_for(option, arguments, near=True)
    return f"Did you mean {meant}?" if meant else "contactlab --help lists what there is."


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
