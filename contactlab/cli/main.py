"""The entry point: a verb, or without one a run or a sweep by Hydra."""

import os
import sys
from importlib import import_module
from io import TextIOWrapper

from contactlab.cli import terminal
from contactlab.cli.arguments import VERBS
from contactlab.cli.terminal import INCOMPLETE, INTERRUPTED, MESSAGE, RefusalError, refuse
from contactlab.suggestion import suggestion


def main() -> int:
    """Run the command and give its exit status."""
    terminal.open_closed()
    # As UTF-8, whatever the locale takes them for.
    sys.argv[1:] = [os.fsencode(text).decode("utf-8", "surrogateescape") for text in sys.argv[1:]]
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            # A terminal that cannot show a character shows its code.
            stream.reconfigure(errors="backslashreplace")
    status = _status(*sys.argv[1:])
    try:
        sys.stdout.flush()
    except OSError:
        terminal.silence(sys.stdout)
        status = status or INCOMPLETE
    return status


def _status(verb: str = "", *arguments: str) -> int:
    """Do what is asked for, and give its exit status however it ends."""
    try:
        with terminal.ending_at_once():
            if verb in VERBS:
                return int(import_module(f"contactlab.cli.{verb}").main(list(arguments)))
            _refuse_what_is_no_verb(verb)
            # Imported here: it brings Hydra, which no verb needs.
            from contactlab.cli import app

            return app.main()
    except SystemExit as stop:
        return int(stop.code or 0)
    except RefusalError as refusal:
        return refuse([str(refusal)])
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


def _refuse_what_is_no_verb(word: str) -> None:
    if word == "map":
        raise RefusalError(
            "There is no verb 'map' any more; sweeps run without it: contactlab -m KEY=VALUES ... "
            "sweep.keep=metrics keeps numbers alone."
        )
    if word.isalpha() and (hint := suggestion(word, VERBS)):
        raise RefusalError(f"There is no verb '{word}'; it must be one of {', '.join(VERBS)}. {hint}")
