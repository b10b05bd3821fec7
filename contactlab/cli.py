"""The entry point: a verb, or without one a run."""

import sys
from importlib import import_module

from contactlab.command import interrupts, streams
from contactlab.command.verbs import VERBS


def main() -> int:
    """Entry point of the command; gives the exit status."""
    streams.open_closed()
    verb = sys.argv[1] if len(sys.argv) > 1 else ""
    if verb in VERBS:
        return streams.flushed(_do(verb, sys.argv[2:]))
    # Imported here: it brings Hydra, which no verb needs.
    from contactlab import app

    return streams.flushed(app.main())


def _do(verb: str, arguments: list[str]) -> int:
    try:
        with interrupts.ending_at_once():
            return int(import_module(f"contactlab.command.{verb}").main(arguments))
    except BrokenPipeError:
        # Whoever read the output has had enough of it.
        streams.silence(sys.stdout)
        return 1
