"""The entry point: a verb, or without one a run."""

import os
import re
import sys
from importlib import import_module
from io import TextIOWrapper

from contactlab.cli import interrupts, streams
from contactlab.cli.verbs import VERBS

REFUSED = 2
"""Exit status."""


def main() -> int:
    """Entry point of the command; gives the exit status."""
    streams.open_closed()
    sys.argv[1:] = map(_decoded, sys.argv[1:])
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            # A terminal that cannot show a character shows its code.
            stream.reconfigure(errors="backslashreplace")
    try:
        return _dispatch(sys.argv[1:])
    except UnicodeEncodeError as error:
        return _refuse(
            f"'{error.object}' cannot be spelled in {error.encoding}, the encoding of this locale; it must "
            "be without special characters here. Set LC_ALL=C.UTF-8 or leave them out."
        )


def _dispatch(arguments: list[str]) -> int:
    verb = arguments[0] if arguments else ""
    if verb in VERBS:
        return streams.flushed(_do(verb, arguments[1:]))
    if verb.isalpha() and (hint := _near(verb)):
        return _refuse(f"There is no verb '{verb}'; it must be one of {', '.join(VERBS)}. {hint}")
    if odd := [argument for argument in arguments if re.search("[\\0\ud800-\udfff]", argument)]:
        return _refuse(f"{odd[0]!r} has bytes that are no text; it must be UTF-8. Leave them out.")
    # Imported here: it brings Hydra, which no verb needs.
    from contactlab.cli import app

    return streams.flushed(app.main())


def _decoded(argument: str) -> str:
    """An argument as UTF-8, whatever the locale takes it for."""
    return os.fsencode(argument).decode("utf-8", "surrogateescape")


def _near(verb: str) -> str:
    # Imported here: its package brings the whole configuration.
    from contactlab.suggestion import suggestion

    return suggestion(verb, VERBS)


def _refuse(fault: str) -> int:
    print(fault, file=sys.stderr)
    return REFUSED


def _do(verb: str, arguments: list[str]) -> int:
    try:
        with interrupts.ending_at_once():
            return int(import_module(f"contactlab.cli.{verb}").main(arguments))
    except BrokenPipeError:
        # Whoever read the output has had enough of it.
        streams.silence(sys.stdout)
        return 1
