"""The help of every verb of the command, as the command prints it."""

import os
from contextlib import redirect_stdout, suppress
from importlib import import_module
from io import StringIO
from unittest.mock import patch

from contactlab.cli.arguments import VERBS
from contactlab.cli.study import help_on
from contactlab.packages import bringing
from contactlab.studies.registry import OWN, SIMULATE, question_of, studies

WIDTH = 92

STUDIES = sorted(name for name in studies() if name in OWN or bringing(name))
"""Studies of this project's packages."""


def verbs() -> str:
    """Return a chapter for every study and every other verb."""
    about = {verb: question_of(verb) for verb in STUDIES if verb != SIMULATE}
    about |= {verb: f"{text[0].upper()}{text[1:]}." for verb, text in VERBS.items()}
    return "\n".join(
        f"## `contactlab {verb}`\n\n{text}\n\n```text\n{help_of(verb)}\n```\n" for verb, text in about.items()
    )


def help_of(verb: str) -> str:
    """Return what `contactlab VERB --help` prints."""
    if verb in STUDIES:
        return help_on(verb)
    printed = StringIO()
    # Colours are for terminals.
    terminal = patch.dict(os.environ, {"COLUMNS": str(WIDTH), "NO_COLOR": "1"})
    with terminal, redirect_stdout(printed), suppress(SystemExit):
        import_module(f"contactlab.cli.{verb.replace('-', '_')}").main(["--help"])
    return printed.getvalue().strip()
