"""The help of every verb of the command, as the command prints it."""

from contextlib import redirect_stdout, suppress
from importlib import import_module
from io import StringIO

from contactlab.cli.study import help_on
from contactlab.cli.verbs import modules, names, purpose_of
from contactlab.packages import bringing
from contactlab.studies.registry import OWN

OURS = [verb for verb in names() if verb in {*modules(), *OWN} or bringing(verb)]
"""Verbs of this project's packages."""


def verbs() -> str:
    """Return a chapter for every study and every other verb."""
    return "\n".join(
        f"## `contactlab {verb}`\n\n{purpose_of(verb)}\n\n```text\n{help_of(verb)}\n```\n" for verb in OURS
    )


def help_of(verb: str) -> str:
    """Return what `contactlab VERB --help` prints."""
    if verb not in modules():
        return help_on(verb)
    printed = StringIO()
    with redirect_stdout(printed), suppress(SystemExit):
        import_module(modules()[verb]).main(["--help"])
    return printed.getvalue().strip()
