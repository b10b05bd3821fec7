"""The help of every verb of the command, as it prints it."""

import os
from contextlib import redirect_stdout, suppress
from importlib import import_module
from io import StringIO
from unittest.mock import patch

from contactlab.cli.arguments import VERBS

WIDTH = 92


def verbs() -> str:
    """Give a chapter for every verb."""
    parts = []
    for verb, said in VERBS.items():
        parts += [f"## `contactlab {verb}`\n", f"{said[0].upper()}{said[1:]}.\n"]
        parts += ["```text", help_of(verb), "```\n"]
    return "\n".join(parts)


def help_of(verb: str) -> str:
    """Give what `contactlab VERB --help` prints."""
    printed = StringIO()
    # Colours are for terminals.
    told = patch.dict(os.environ, {"COLUMNS": str(WIDTH), "NO_COLOR": "1"})
    with told, redirect_stdout(printed), suppress(SystemExit):
        import_module(f"contactlab.cli.{verb.replace('-', '_')}").main(["--help"])
    return printed.getvalue().strip()
