"""The arguments of a verb, refused in sentences."""

import argparse
from collections.abc import Sequence
from typing import Any, NoReturn

from contactlab.cli.verbs import VERBS
from contactlab.suggestion import suggestion

REFUSED = 2
"""Exit status."""


class Parser(argparse.ArgumentParser):
    """A parser of one verb's arguments.

    Args:
        verb: a key of `VERBS`.
        description: what the verb does.
        options: of `argparse.ArgumentParser`.
    """

    def __init__(self, verb: str, description: str = "", **options: Any) -> None:
        self._options: list[str] = []
        about = description or f"{VERBS[verb].capitalize()}."
        super().__init__(
            prog=f"contactlab {verb}", description=about, allow_abbrev=False, **options
        )

    def add_argument(self, *names: str, **options: Any) -> argparse.Action:
        """See `argparse.ArgumentParser.add_argument`; remembers the names of options."""
        self._options += [name for name in names if name.startswith("--")]
        return super().add_argument(*names, **options)

    def read(self, arguments: Sequence[str]) -> argparse.Namespace:
        """The arguments, options among them wherever they stand.

        Raises:
            SystemExit: something is wrong with them, or only help was asked for.
        """
        if "" in arguments:
            self.error("an argument is empty, as of a shell variable that is not set")
        found, unknown = self.parse_known_intermixed_args(arguments)
        if unknown:
            options = [one.partition("=")[0] for one in unknown if one.startswith("-")]
            hint = suggestion(options[0], self._options) if options else ""
            self.error(f"{' '.join(unknown)} is not understood", hint)
        return found

    def error(self, message: str, hint: str = "") -> NoReturn:
        """Refuse the arguments in a sentence."""
        way_out = hint or f"{self.prog} --help tells what it takes."
        self.exit(REFUSED, f"{self.prog}: {message}. {way_out}\n")
