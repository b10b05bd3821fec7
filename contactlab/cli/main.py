"""The entry point: a verb, or without one a run or a sweep by Hydra."""

import os
import sys
from importlib import import_module
from io import TextIOWrapper

from contactlab.cli import terminal
from contactlab.cli.arguments import NO_TEXT, VERBS
from contactlab.cli.terminal import INCOMPLETE, INTERRUPTED, MESSAGE, RefusalError, refuse
from contactlab.config.studies import RUN, question_of, studies
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
            return _perform(verb, *arguments)
    except SystemExit as stop:
        return int(stop.code or 0)
    except RefusalError as refusal:
        return refuse([str(refusal)], refusal.status)
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


def _perform(verb: str, *arguments: str) -> int:
    """Do the work of a verb, of a study, or of a run, which has no verb."""
    if verb in ("-m", "--multirun") and arguments:
        (verb, *rest), flag = arguments, verb
        arguments = (*rest, flag)
    if verb == "help":
        if not arguments:
            print(*_verbs(), sep="\n")
            return 0
        verb, arguments = arguments[0], ("--help",)
        sys.argv[1:] = [verb, *arguments]
    if verb == RUN:
        sys.argv[1:] = arguments
    elif verb in studies():
        # Imported here: it brings the engine.
        from contactlab.cli.study import as_overrides, help_on

        if {"--help", "-h"} & {*arguments}:
            print(help_on(verb))
            return 0
        sys.argv[1:] = as_overrides(verb, arguments)
    elif verb in VERBS:
        module = verb.replace("-", "_")
        return int(import_module(f"contactlab.cli.{module}").main(list(arguments)))
    else:
        _refuse_what_is_no_verb(verb)
    # Imported here: it brings Hydra, which other verbs do not need.
    from contactlab.cli import app

    return app.main()


def _verbs() -> list[str]:
    """Return the lines that list every verb with what it does."""
    every = dict(sorted({**VERBS, **{name: question_of(name) for name in studies() if name != RUN}}.items()))
    width = max(map(len, every))
    return [
        "contactlab [KEY=VALUE ...] simulates a motor; contactlab -m KEY=A,B ... simulates all combinations.",
        "contactlab VERB ...:",
        *(f"  {verb:{width}}  {words}" for verb, words in every.items()),
        "contactlab help VERB lists the options of a verb, contactlab --help all groups and keys of a run.",
    ]


def _refuse_what_is_no_verb(word: str) -> None:
    """Refuse a first word that is neither a verb nor an argument of a run."""
    if not word or "=" in word or word.startswith(("-", "~")) or NO_TEXT.search(word):
        return
    known = sorted({*VERBS, *studies()})
    raise RefusalError(
        f"There is no verb '{word}'; it must be one of {', '.join(known)}. {suggestion(word, known)}".rstrip()
    )
