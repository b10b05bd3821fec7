"""The entry point: a verb, or without one a run or a sweep by Hydra."""

import atexit
import gc
import os
import signal
import sys
from importlib import import_module
from io import TextIOWrapper
from typing import Final

from contactlab.cli import terminal, verbs
from contactlab.cli.arguments import HELP, refuse_repeated
from contactlab.cli.terminal import INCOMPLETE, INTERRUPTED, MESSAGE, RefusalError, refuse
from contactlab.packages import bringing
from contactlab.studies.registry import SIMULATE, studies, study_class
from contactlab.suggestion import suggestion

LISTING: Final = """\
contactlab [KEY=VALUE ...] simulates a motor; contactlab -m KEY=A,B ... simulates all combinations.
contactlab VERB ...:
  {}
contactlab help VERB lists the options of a verb, contactlab --help all groups and keys of a run."""


def main() -> int:
    """Run the command and return its exit status."""
    # What imports make stays: to look through it for garbage again and again takes a tenth of their time.
    gc.set_threshold(100_000, 20, 20)
    terminal.open_closed()
    # As UTF-8 in every locale.
    sys.argv[1:] = [os.fsencode(text).decode("utf-8", "surrogateescape") for text in sys.argv[1:]]
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            # A terminal that cannot show a character shows its code.
            stream.reconfigure(errors="backslashreplace")
    # What has ended has its status: a late Ctrl-C does not change it.
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
    with terminal.ending_stuck(), terminal.ending_at_once():
        try:
            status = _perform(*sys.argv[1:])
        except SystemExit as stop:
            status = int(stop.code or 0)
        except RefusalError as refusal:
            status = refuse([str(refusal)], refusal.status)
        except KeyboardInterrupt as interrupt:
            status = refuse([str(interrupt) or MESSAGE], INTERRUPTED)
        except BrokenPipeError:
            terminal.silence(sys.stdout)
            status = INCOMPLETE
        try:
            sys.stdout.flush()
        except OSError:
            terminal.silence(sys.stdout)
            status = status or INCOMPLETE
    return status


def _perform(*line: str) -> int:
    """Do the work of a verb, of a study, or of a run, which has no verb."""
    if line[:1] in (("-m",), ("--multirun",)):
        line = (*line[1:], line[0])
    verb, arguments = line[0] if line else "", line[1:]
    if verb == "help":
        if not arguments:
            print(LISTING.format(verbs.lines()))
            return 0
        verb, arguments = arguments[0], ("--help",)
    if verb in verbs.modules():
        return int(import_module(verbs.modules()[verb]).main(list(arguments)))
    if verb in studies() and verb != SIMULATE:
        # Imported here: it brings the engine, which may take seconds.
        with terminal.progress(1.0, "tasks"):
            from contactlab.cli.study import as_overrides, help_on

        try:
            study_class(verb)
        except ValueError as error:
            raise RefusalError(str(error)) from error
        if not HELP.isdisjoint(arguments):
            print(help_on(verb))
            return 0
        arguments = tuple(as_overrides(verb, arguments))
    elif verb.isidentifier() and verb != SIMULATE:
        # Imported here: it brings the laws.
        from contactlab.laws.registry import ways_to_choose

        known = verbs.names()
        way = ways_to_choose(verb) or f"It must be one of {', '.join(known)}."
        hint = bringing(verb) or suggestion(verb, known, way)
        raise RefusalError(f"There is no verb '{verb}'. {hint}")
    else:
        arguments = line if verb != SIMULATE else arguments
        refuse_repeated(arguments)
    # Imported here: it brings Hydra, which other verbs do not need, and where something runs all of it.
    with terminal.progress(1.0, "tasks"):
        from contactlab.cli import start

        if not any(argument.startswith("-") for argument in arguments):
            import_module("contactlab.cli.app")
    return start.main(list(arguments))
