"""`contactlab validate DATA [law=A,B]`: laws against measured impacts that they were not fitted to."""

import sys
from argparse import Namespace
from functools import partial
from pathlib import Path

from contactlab.cli import terminal
from contactlab.cli.arguments import Parser
from contactlab.cli.jobs import check_output, unwritable
from contactlab.cli.next_step import tell_next
from contactlab.cli.terminal import COMPLETE, RefusalError, tell

FOLDS = 5


def main(arguments: list[str]) -> int:
    """Judge the laws, write the files and print the table.

    Returns:
        The exit status.

    Raises:
        RefusalError: data or laws cannot be used, or the folder cannot be written to.
        KeyboardInterrupt: with a sentence; the laws that have ended are kept.
    """
    given = _given(arguments)
    output: Path = given.output
    check_output(output)
    # Imported here: they bring the compiler, which --help does not need.
    from contactlab.cli.law_words import models_of
    from contactlab.inference.study import KEPT, ValidationError, study
    from contactlab.laws import LawError
    from contactlab.measured.faults import MeasurementError
    from contactlab.measured.files import read_impacts
    from contactlab.processes import WorkerError
    from contactlab.studies import validate_tables as tables
    from contactlab.studies.validate_page import write

    models = models_of(given.words)
    try:
        impacts = read_impacts(given.data)
        announce = partial(tell, stream=sys.stderr)
        with terminal.progress(100.0, "%", "The study") as show, terminal.raising():
            data = study(
                impacts,
                models,
                folds=given.folds,
                seed=given.seed,
                workers=given.workers,
                keep=output,
                progress=lambda share: show(100.0 * share),
                announce=announce,
            )
    except (ValidationError, MeasurementError, WorkerError, LawError) as error:
        raise RefusalError(str(error)) from error
    except OSError as error:
        if error.filename == str(given.data):
            raise RefusalError(f"'{given.data}' cannot be read ({error.strerror}). Name a file.") from error
        raise unwritable(output, error) from error
    except KeyboardInterrupt:
        words = f"Interrupted; laws that had ended are kept in {output / KEPT}, and the same command goes on."
        raise KeyboardInterrupt(words) from None
    try:
        write(data, output)
    except OSError as error:
        raise unwritable(output, error) from error
    said = [tables.headline(data), *tables.order(data), "", tables.as_text(data), "", *tables.warnings(data)]
    print(*said, tables.unexplained(data), sep="\n")
    print(f"\nWritten to {output}: validation.html, validation.nc and figures.")
    tell_next(
        "fit", [str(given.data), *given.words], "gives their numbers with a posterior, and the evidence"
    )
    return COMPLETE


def _given(arguments: list[str]) -> Namespace:
    """Read the arguments."""
    parser = Parser(
        "validate",
        ": every impact is held out once, laws are fitted to the others and predict it. Their errors have "
        "bootstrap intervals, and so have their differences, beside the frictionless law, the best constant "
        "impulse and the floors that no law can be better than. Without law=NAME these are all rigid laws "
        "and some compliant ones. All numbers of a law are free but those that are given a value. "
        "A study that is stopped goes on when it is asked for again.",
    )
    parser.add_argument(
        "data",
        type=Path,
        metavar="DATA",
        help="the measured impacts: CSV, netCDF or the published MATLAB file",
    )
    parser.add_argument(
        "words",
        nargs="*",
        # Else argparse says that words must be given where the data are missing.
        default=[],
        metavar="law=A,B | law/PART=A,B | law.KEY=VALUE | law.KEY=LOW..HIGH",
        help="the laws; lists of parts make every combination. A number with a value is held, "
        "law.restitution=0.6, one with a range is free in it, contact.friction_coefficient=0.05..0.5",
    )
    parser.add_argument(
        "--folds", type=int, default=FOLDS, metavar="N", help="parts that are held out: %(default)s"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of all that is drawn: %(default)s")
    parser.add_argument("--workers", type=int, metavar="N", help="processes; default: one a processor")
    parser.add_output("validation", "validation.html, validation.nc and figures")
    given = parser.read(arguments)
    for name, least in (("folds", 2), ("seed", 0), ("workers", 1)):
        number = getattr(given, name)
        if number is not None and number < least:
            parser.error(f"--{name} is {number}; it must be at least {least}")
    return given
