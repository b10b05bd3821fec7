"""What can be done next, in a line that can be pasted, where something useful follows."""

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from contactlab.cli.idle_words import KEPT, acting
from contactlab.cli.terminal import tell

LONGEST: Final = 120
"""Characters of a command that is spelled in full."""


def after_a_run(directory: Path, overrides: Sequence[str], here: Path) -> str:
    """Say what can be done after a run in a folder, seen from here: watch it, and settle its motor."""
    folder = directory.relative_to(here) if directory.is_relative_to(here) else directory
    of_motor = acting(overrides, *KEPT, "solver.until", "solver.precision")
    watch = command("animate", str(folder))
    return f"Next: {watch} shows it in slow motion, {command('steady', *of_motor)} finds the settled motor."


def command(verb: str, *words: str) -> str:
    """Give a command as a shell takes it, in backquotes; one that is long without what was typed already."""
    line = shlex.join(["contactlab", verb, *words])
    return f"`{line}`" if len(line) <= LONGEST else f"`contactlab {verb}` with these arguments"


def tell_next(verb: str, words: Sequence[str], what: str) -> None:
    """Print the line of one command."""
    tell(f"Next: {command(verb, *words)} {what}.", sys.stdout)
