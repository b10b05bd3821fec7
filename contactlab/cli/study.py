"""A study from the command line: its verb, written as arguments that Hydra reads, its help, and its work.

contactlab steady law=newton brake="2 mN m"     is     contactlab study=steady law=newton study.brake="2 mN m"
"""

import re
import sys
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import MISSING
from itertools import product
from pathlib import Path
from types import NoneType
from typing import Final

from contactlab.cli import terminal
from contactlab.cli.arguments import FLAGS, quoted
from contactlab.cli.jobs import unwritable
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, REFUSED, RefusalError, tell
from contactlab.config import Setup, build
from contactlab.config.studies import study_class
from contactlab.parameter import DeclaredField, declared_fields
from contactlab.studies.study import Setups, Study
from contactlab.sweeps.values import listed

LISTED: Final = re.compile(r"[\w/.]+=[^'\"\[{(]*,")
"""An override with several values."""

PLAIN: Final = re.compile(r"(?!-)[^=]+")
"""A word that is neither an option nor an override."""

FOLDER = "hydra.run.dir", "hydra.sweep.dir"
"""Keys that name the folder of the files, of a single study and of a sweep."""


def as_overrides(verb: str, words: Sequence[str]) -> list[str]:
    """Return the arguments of a verb as Hydra reads them.

    An option of the study may be written NAME=VALUE, --NAME VALUE or --NAME=VALUE, one that is true or
    false --NAME or --no-NAME, and the folder of the files --output DIR.

    Raises:
        RefusalError: an option lacks its value.
    """
    study = study_class(verb)
    options = declared_fields(study)
    sweeps = not {"-m", "--multirun"}.isdisjoint(words)
    lines, rest, several = [f"study={verb}"], list(words), list[str]()
    given: dict[str, list[str]] = defaultdict(list)
    place = FOLDER[sweeps]
    while rest:
        word = rest.pop(0)
        name, sign, value = word.partition("=")
        if word.startswith("--") and name not in FLAGS:
            name, values = _option(word, rest, options)
            given[name] += values
        elif sign and name in (*options, "output"):
            given[name] += _split(options.get(name), value)
        elif taken := next((key for key, form in study.words.items() if form.fullmatch(word)), ""):
            given[taken].append(word)
        else:
            (several if study.several and not sweeps and LISTED.match(word) else lines).append(word)
    lines += [_line(study, name, values, place) for name, values in given.items()]
    if several:
        lines.append(f"sweep.over=[{','.join(map(quoted, several))}]")
    if sweeps:
        return lines
    # What a user sets comes later and prevails.
    return [f"{place}={verb}", "hydra.output_subdir=null", *lines]


def _option(word: str, rest: list[str], options: Mapping[str, DeclaredField]) -> tuple[str, list[str]]:
    """Return name and values of an option with dashes; several values may be the next of the other words."""
    key, sign, value = word.removeprefix("--").partition("=")
    name = key.replace("-", "_")
    if name.removeprefix("no_") in options and bool in options[name.removeprefix("no_")].kinds and not sign:
        return name.removeprefix("no_"), [str(not name.startswith("no_")).lower()]
    if name not in (*options, "output"):
        raise RefusalError(f"{word} is no option; it must be one of {', '.join([*options, 'output'])}.")
    if not sign and not rest:
        raise RefusalError(f"{word} has no value; one must follow it.")
    value = value if sign else rest.pop(0)
    values = _split(options.get(name), value)
    if _takes_several(options.get(name)) and not sign and PLAIN.fullmatch(value):
        while rest and PLAIN.fullmatch(rest[0]):
            values.append(rest.pop(0))
    return name, values


def _takes_several(field: DeclaredField | None) -> bool:
    return field is not None and list[str] in field.kinds


def _split(field: DeclaredField | None, value: str) -> list[str]:
    """Return the values of an option that takes several, separated by commas."""
    several = _takes_several(field) and not value.startswith("[")
    return [each.strip() for each in value.split(",")] if several else [value]


def _line(study: type[Study], name: str, values: Sequence[str], place: str) -> str:
    """Return an option as Hydra reads it: a text in quotes, several texts as a list."""
    if name == "output":
        return f"{place}={quoted(values[-1])}"
    field = declared_fields(study)[name]
    if len(values) > 1 and name in study.words and not _takes_several(field):
        raise RefusalError(f"{', '.join(values)} are given; it must be one of them.")
    if _takes_several(field) and not values[0].startswith("["):
        return f"study.{name}=[{','.join(map(quoted, values))}]"
    return f"study.{name}={quoted(values[-1]) if str in field.kinds and values[-1] != 'null' else values[-1]}"


def setups_of(lines: Sequence[str], over: Sequence[str]) -> dict[str, Setup]:
    """Return the setups of a study: of its overrides, and of every combination of the listed values.

    Raises:
        ConfigurationError: an override is faulty.
    """
    rest = [line for line in lines if not re.match(r"\+*(study|sweep|hydra)\b", line)]
    axes = [
        [f"{key}={value}" for value in listed(values)] for key, _, values in (o.partition("=") for o in over)
    ]
    return {", ".join(chosen): build([*rest, *chosen]) for chosen in product(*axes)}


def help_on(verb: str) -> str:
    """Return the help of a study's verb, made from its declaration."""
    study = study_class(verb)
    about = re.sub(r"\n +", "\n", (study.__doc__ or "").strip())
    fields = declared_fields(study)
    width = max(map(len, fields)) + 2
    return "\n".join(
        [
            f"usage: contactlab {verb} [NAME=VALUE | KEY=VALUE | GROUP=OPTION ...] [output=DIR] [-m]",
            "",
            about,
            "",
            "Options:",
            *(f"  {name:<{width}}{_described(field)}" for name, field in fields.items()),
            f"  {'output':<{width}}folder of the files; {verb}",
            "",
            "KEY=VALUE and GROUP=OPTION are those of a run (contactlab --help). With -m every combination of",
            "listed values, KEY=A,B or KEY=linspace(FIRST,LAST,COUNT), leaves its numbers in one dataset.",
        ]
    )


def _described(field: DeclaredField) -> str:
    """Return meaning, unit and default of an option."""
    assert field.parameter is not None
    label = f" [{field.parameter.unit}]" if field.parameter.label else ""
    default = field.default
    given = "" if default in (None, MISSING, ()) or NoneType in field.kinds else f"; {default}".lower()
    return f"{field.parameter.meaning}{label}{given}"


def refusals_of(verb: str, lines: Sequence[str]) -> Iterator[str]:
    """Yield what is wrong with arguments on which a study does not depend."""
    from contactlab.cli.idle_words import idle

    study = study_class(verb)
    effective = "sweep.over=" if study.several else "study="
    for line in idle((line for line in lines if not line.startswith(effective)), *study.ignored):
        yield f"{line} has no effect on the study {verb}; it must be left out."


def perform_study(study: Study, setups: Setups, folder: Path) -> int:
    """Do a study, write its files, print its result and return the exit status.

    Raises:
        KeyboardInterrupt: with a sentence; finished tasks are kept.
        RefusalError: nothing can be written.
    """
    from contactlab.studies.runner import finish, run

    try:
        with terminal.progress(1.0, "of the study", f"The study {study.name}") as show, terminal.raising():
            result = run(study, setups, folder, lambda done, total: show(done / max(total, 1)))
            files = finish(result, folder)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"Interrupted. Finished tasks are kept in '{folder}': the same command continues there."
        ) from None
    except OSError as error:
        raise unwritable(folder, error) from error
    # An argument that is refused, and a result that physics does not have: no steady state, no orbit.
    except (RuntimeError, ValueError) as error:
        with suppress(OSError):
            folder.rmdir()
        raise RefusalError(str(error), REFUSED if isinstance(error, ValueError) else INCOMPLETE) from error
    tell(repr(result), sys.stdout)
    tell(f"Written to {folder}: {', '.join(files)}.", sys.stdout)
    return COMPLETE
