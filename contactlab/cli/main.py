"""The entry point: a verb, or without one a run or a sweep by Hydra."""

import os
import sys
from collections.abc import Callable
from importlib import import_module
from io import TextIOWrapper

from contactlab.cli import terminal
from contactlab.cli.arguments import VERBS
from contactlab.cli.terminal import INCOMPLETE, INTERRUPTED, MESSAGE, RefusalError, refuse
from contactlab.suggestion import suggestion

GONE = {
    "map": "sweeps run without it: contactlab -m KEY=VALUES ... sweep.keep=metrics keeps numbers alone",
}
"""Verbs of earlier versions, and what took their place."""


def main() -> int:
    """Run the command and give its exit status."""
    terminal.open_closed()
    # As UTF-8, whatever the locale takes them for.
    sys.argv[1:] = [os.fsencode(text).decode("utf-8", "surrogateescape") for text in sys.argv[1:]]
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            # A terminal that cannot show a character shows its code.
            stream.reconfigure(errors="backslashreplace")
    status = _status(_dispatch)
    try:
        sys.stdout.flush()
    except OSError:
        terminal.silence(sys.stdout)
        status = status or INCOMPLETE
    return status


def _status(work: Callable[[], int]) -> int:
    """Give the exit status of some work, however it ends."""
    try:
        with terminal.ending_at_once():
            return work()
    except SystemExit as stop:
        return int(stop.code or 0)
    except KeyboardInterrupt as interrupt:
        print(str(interrupt) or MESSAGE, file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # Whoever read the output has had enough of it.
        terminal.silence(sys.stdout)
        return INCOMPLETE
    except UnicodeEncodeError as error:
        return refuse(
            [
                f"'{error.object}' cannot be spelled in {error.encoding}, the encoding of this locale; it "
                "must be without special characters here. Set LC_ALL=C.UTF-8 or leave them out."
            ]
        )


def _dispatch() -> int:
    verb, *arguments = sys.argv[1:] or [""]
    if verb in VERBS:
        try:
            return int(import_module(f"contactlab.cli.{verb}").main(arguments))
        except RefusalError as refusal:
            return refuse([str(refusal)])
    if verb in GONE:
        return refuse([f"There is no verb '{verb}' any more; {GONE[verb]}."])
    if verb.isalpha() and (hint := suggestion(verb, VERBS)):
        return refuse([f"There is no verb '{verb}'; it must be one of {', '.join(VERBS)}. {hint}"])
    # Imported here: it brings Hydra, which no verb needs.
    from contactlab.cli import app

    return app.main()
