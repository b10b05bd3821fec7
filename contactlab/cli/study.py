"""A study from the command line: its verb, written as arguments that Hydra reads, its help, and its work.

contactlab steady law=newton brake="2 mN m"     is     contactlab study=steady law=newton study.brake="2 mN m"
"""

import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import MISSING
from pathlib import Path
from types import NoneType

from contactlab.cli import terminal
from contactlab.cli.arguments import FLAGS, quoted
from contactlab.cli.jobs import unwritable
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, REFUSED, RefusalError, tell
from contactlab.config.studies import study_class
from contactlab.parameter import DeclaredField, declared_fields
from contactlab.studies.study import Setups, Study

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
    lines, rest = [f"study={verb}"], list(words)
    place = FOLDER[sweeps]
    while rest:
        word = rest.pop(0)
        name, sign, value = word.partition("=")
        name = name.removeprefix("--").replace("-", "_")
        if name == "output" or (word.startswith("--") and name in options):
            field = options.get(name)
            if not sign and field is not None and bool in field.kinds:
                value = "true"
            elif not sign and not rest:
                raise RefusalError(f"{word} has no value; one must follow it.")
            elif not sign:
                value = rest.pop(0)
            key = place if name == "output" else f"study.{name}"
            lines.append(f"{key}={quoted(value) if name == 'output' else value}")
        elif word.startswith("--no-") and name.removeprefix("no_") in options:
            lines.append(f"study.{name.removeprefix('no_')}=false")
        elif word.startswith("--") and word.partition("=")[0] not in FLAGS:
            raise RefusalError(f"{word} is no option of {verb}; it must be one of {', '.join(options)}.")
        elif sign and name in options:
            lines.append(f"study.{word}")
        else:
            taken = next((key for key, form in study.words.items() if form.fullmatch(word)), None)
            lines.append(f"study.{taken}={quoted(word)}" if taken else word)
    if sweeps:
        return lines
    # What a user sets comes later and prevails.
    return [f"{place}={verb}", "hydra.output_subdir=null", *lines]


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

    for line in idle(lines, *study_class(verb).ignored):
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
