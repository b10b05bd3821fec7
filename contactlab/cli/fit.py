"""`contactlab fit DATA [KEY=LOW..HIGH ...]`: what measurements say of the numbers of a law, and of laws."""

import sys
from argparse import Namespace
from functools import partial
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from contactlab.cli import terminal
from contactlab.cli.arguments import Parser
from contactlab.cli.jobs import check_output, unwritable
from contactlab.cli.next_step import tell_next
from contactlab.cli.terminal import COMPLETE, RefusalError, tell

if TYPE_CHECKING:
    from contactlab.inference.fit import Data, Question
    from contactlab.inference.result import Answer

POINTS = 150
STARTS = 16
IMPACTS = 200
"""Of made data, where their number is not given."""

NOISE = 0.01
"""Of made data, where it is not given."""

DATA = "data.nc"


def main(arguments: list[str]) -> int:
    """Fit, write the files and print the tables; or make data to fit.

    Returns:
        The exit status; that nothing can be told is a result.

    Raises:
        RefusalError: the data or the words cannot be fitted, or the folder cannot be written to.
    """
    parser = Parser(
        "fit",
        ". Numbers with a range, KEY=LOW..HIGH, are free; without one all of the law are. Least squares "
        "with many starts, then posterior and evidence by nested sampling. A fit that is stopped goes on "
        "when it is asked for again.",
    )
    parser.add_argument(
        "words",
        nargs="*",
        metavar="DATA | KEY=LOW..HIGH | KEY=VALUE | law=A,B",
        help="the file first: series of a motor (netCDF, CSV, or a run.nc) or impacts (netCDF, CSV); then "
        "what is free, and all else as of a run. Several laws are weighed against each other",
    )
    parser.add_argument(
        "--noise",
        metavar="SHARE",
        help="standard deviation of the noise, over the root mean square of each series, or over the "
        "approach of an impact in the norm of the kinetic energy; 'free' finds it; default: as the data "
        "state it, else free",
    )
    parser.add_argument(
        "--discrepancy",
        choices=("off", "on", "both"),
        default="off",
        help="whether the laws may be wrong, by an amount that is found; both says by the evidence whether "
        "that is needed; default: %(default)s",
    )
    parser.add_argument(
        "--student",
        metavar="NU",
        help="Student-t noise with NU degrees of freedom, which outliers do not mislead; 'free' finds NU; "
        "default: normal noise",
    )
    parser.add_argument("--series", metavar="A,B", help="which series of the data; default: all")
    parser.add_argument(
        "--points", type=int, default=POINTS, metavar="N", help="live points; default: %(default)s"
    )
    parser.add_argument(
        "--starts", type=int, default=STARTS, metavar="N", help="of least squares; default: %(default)s"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="default: %(default)s")
    parser.add_argument(
        "--synthetic",
        action="store_true",
        help="make data by a known law instead, data.nc, from the words of a run: of its motor, or with "
        "--impacts of bodies that hit a plate",
    )
    parser.add_argument(
        "--impacts", type=int, nargs="?", const=IMPACTS, metavar="N", help=f"how many; default: {IMPACTS}"
    )
    parser.add_output("fit", "fit.html, posterior.nc and figures, or data.nc,")
    given = parser.read(arguments)
    _check(parser, given)
    check_output(given.output)
    # Imported here: they bring the compiler, which --help does not need.
    from contactlab.config import ConfigurationError
    from contactlab.inference.nested_sampling import NoSamplerError
    from contactlab.laws import LawError

    try:
        return _make(given) if given.synthetic else _fit(given)
    except ConfigurationError as error:
        raise RefusalError("\n".join(error.faults)) from error
    except (ValueError, LawError, NoSamplerError) as error:
        raise RefusalError(str(error)) from error


def _check(parser: Parser, given: Namespace) -> None:
    """Refuse options that are out of range or do not belong together."""
    for name, least in {"points": 25, "starts": 1, "seed": 0}.items():
        if getattr(given, name) < least:
            parser.error(f"--{name} is {getattr(given, name)}, it must be at least {least}")
    if given.impacts is not None:
        if not given.synthetic:
            parser.error("--impacts is for data that are made; it must come with --synthetic")
        if given.series:
            parser.error(
                "--impacts and --series are both given, and made data are one of them; leave one out"
            )
        if given.impacts < 1:
            parser.error(f"--impacts is {given.impacts}, it must be at least 1")
    _check_kind(parser, given)


def _check_kind(parser: Parser, given: Namespace) -> None:
    """Refuse what does not belong to a fit, or to data that are made."""
    if given.synthetic and given.student:
        parser.error("--student is of a fit, and --synthetic makes data; leave one out")
    if given.student not in (None, "free") and not 0.0 < _number(given.student) < inf:
        parser.error(f"--student is {given.student}, it must be a number greater than 0, or 'free'")
    if given.synthetic and given.discrepancy != "off":
        parser.error("--discrepancy is of a fit, and --synthetic makes data; leave one out")
    if not given.synthetic and (not given.words or "=" in given.words[0]):
        parser.error("there is no file; the first word must be one, of series or of impacts")
    if given.noise not in (None, "free") and not 0.0 < _number(given.noise) <= 1.0:
        parser.error(f"--noise is {given.noise}, it must be greater than 0 and at most 1, or 'free'")


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _fit(given: Namespace) -> int:
    from contactlab.cli.idle_words import KEPT, LASTING, refuse_idle, refuse_of_motor
    from contactlab.inference.fit import digest_told, left_of_others, pose, read
    from contactlab.inference.law_choice import sorted_words
    from contactlab.inference.nested_sampling import available
    from contactlab.measured.repeats import copies_warning
    from contactlab.measured.series import MeasuredSeries
    from contactlab.studies.fit_page import as_text, save

    available()
    path, output = Path(given.words[0]), given.output
    try:
        data = read(path)
    except OSError as error:
        words = f"'{path}' cannot be read ({error.strerror or error}); it must be a file of measurements."
        raise RefusalError(words) from error
    digest, words = digest_told(data, path), given.words[1:]
    if isinstance(data, MeasuredSeries):
        refuse_idle(words, "a fit, which takes its times from the data,", *KEPT, *LASTING)
    else:
        refuse_of_motor(words)
        if warning := copies_warning(data):
            tell(warning, sys.stderr)
    tails = inf if given.student is None else None if given.student == "free" else float(given.student)
    chosen = _chosen(data, given)
    questions = pose(chosen, sorted_words(words), given.discrepancy, path.name, digest, tails)
    try:
        output.mkdir(parents=True, exist_ok=True)
        for left in left_of_others(output, questions, given.points, given.seed):
            tell(f"'{left}' is of another fit, or of another version, and is removed.", sys.stderr)
            left.unlink()
        try:
            answers = _answered(questions, given)
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                "Interrupted; the same command goes on from where it was some seconds ago."
            ) from None
        names = save(answers, output)
        for left in output.glob(".*.checkpoint"):
            left.unlink()
    except OSError as error:
        raise unwritable(output, error) from error
    print(as_text(answers))
    print(f"\nWritten to {output}: {', '.join(names)} and figures.")
    return COMPLETE


def _answered(questions: "list[Question]", given: Namespace) -> "list[Answer]":
    """Answer the questions; Ctrl-C waits for the end of an evaluation, of which others would print."""
    from contactlab.inference.fit import fit

    total = len(questions)
    with terminal.waiting() as look, terminal.progress(total, "laws", "The fit") as advance:

        def tell_and_look(done: float) -> None:
            advance(done)
            look()

        numbers = {name: getattr(given, name) for name in ("points", "seed", "starts")}
        announce = partial(tell, stream=sys.stderr)
        return fit(questions, given.output, **numbers, advance=tell_and_look, announce=announce)


def _chosen(data: "Data", given: Namespace) -> "Data":
    """Give the series that were asked for, with the noise that is known."""
    from contactlab.inference.synthetic import with_noise, without_errors
    from contactlab.measured.series import MeasuredSeries

    if given.series is not None:
        if not isinstance(data, MeasuredSeries):
            raise RefusalError("--series is given and the data are impacts; leave it out.")
        data = data.only([name.strip() for name in given.series.split(",")])
    if given.noise is None:
        return data
    return without_errors(data) if given.noise == "free" else with_noise(data, float(given.noise))


def _make(given: Namespace) -> int:
    from contactlab.cli.idle_words import KEPT, LASTING, acting, refuse_idle, refuse_of_motor
    from contactlab.config import build
    from contactlab.config.schema import FRICTION
    from contactlab.inference.law_choice import LAW
    from contactlab.inference.synthetic import made_impacts, made_series
    from contactlab.measured.files import write_impacts
    from contactlab.measured.series import chosen_names, write_series

    if given.noise == "free":
        raise RefusalError("--noise is free, and made data must have some; give a number, --noise 0.01.")
    noise = NOISE if given.noise is None else float(given.noise)
    if given.impacts is not None:
        refuse_of_motor(given.words)
    idle = [key for key in KEPT if key != "record"]
    refuse_idle(given.words, "a measured series", *idle, "record.picture")
    setup = build(given.words)
    place = given.output / DATA
    try:
        if given.impacts is not None:
            impacts = made_impacts(setup.law, given.impacts, noise, given.seed, setup.configuration)
            given.output.mkdir(parents=True, exist_ok=True)
            write_impacts(impacts, place)
            said = f"{given.impacts} impacts"
        else:
            names = chosen_names(given.series)
            series = made_series(setup, names, noise, given.seed)
            given.output.mkdir(parents=True, exist_ok=True)
            write_series(series, place)
            said = f"{', '.join(names)} at {series.time.size} times"
    except OSError as error:
        raise unwritable(given.output, error) from error
    print(f"{said} under {setup.law.name}, with {noise:g} of noise: written to {place}.")
    # The data contain their own times, and a number with a value would be fixed.
    words = [
        word
        for word in acting(given.words, *KEPT, *LASTING)
        if not word.startswith((f"{LAW}.", f"{FRICTION}="))
    ]
    tell_next("fit", [str(place), *words], "finds the numbers again")
    return COMPLETE
