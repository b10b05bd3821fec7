"""`contactlab compare DIR...`: the laws of several runs side by side, judged, drawn and reported."""

import sys
from argparse import ArgumentTypeError
from functools import partial
from pathlib import Path

from contactlab.cli.arguments import Parser
from contactlab.cli.jobs import check_output, unwritable
from contactlab.cli.terminal import COMPLETE, RefusalError, tell
from contactlab.comparison import ComparisonError, compare
from contactlab.comparison.findings import conclusion, headline
from contactlab.comparison.report import SAMPLES, STARTS
from contactlab.comparison.scorecard import as_text


def main(arguments: list[str]) -> int:
    """Compare, write the files and print the scorecard.

    Returns:
        The exit status; a law that fails a metric is a result, no failure of the command.

    Raises:
        RefusalError: the runs cannot be compared, or the folder cannot be written to.
    """
    parser = Parser(
        "compare",
        ". The runs must be of one motor with one drive. What is compared is the motion that it settles to "
        "with every law, and every difference is weighed against all that could explain it: numerical error, "
        "basis of the resonator, parameters within their ranges, other starts.",
    )
    parser.add_argument(
        "runs", nargs="+", metavar="DIR", help="a run's folder, its run.nc, or a folder of such folders"
    )
    parser.add_output("comparison", "tables, figures and report.html")
    parser.add_argument(
        "--no-refine",
        action="store_true",
        help="a quick look: nothing that tells what a difference between laws is due to",
    )
    parser.add_argument(
        "--transient", action="store_true", help="compare the runs as they were recorded, from their start on"
    )
    parser.add_argument(
        "--samples",
        type=int,
        default=SAMPLES,
        metavar="N",
        help="rows of the design in which law, parameters, basis and step are drawn together, a power of "
        "two, or 0 for none; default: %(default)s",
    )
    parser.add_argument(
        "--starts",
        type=int,
        default=STARTS,
        metavar="N",
        help="from which steady states are looked for; default: %(default)s",
    )
    parser.add_argument(
        "--range",
        action="append",
        default=[],
        type=_range,
        metavar="KEY=SHARE",
        help="half the range of a parameter over its value, contact.clearance=0.1, beside or in place of "
        "what the runs state in `uncertainty`; 0 is known exactly; may be given again",
    )
    parser.add_argument(
        "--measured",
        nargs="+",
        default=[],
        metavar="FILE",
        help="files of measured impacts (CSV or netCDF, docs/measured_data.md) or of measured series of this "
        "motor (docs/fitting.md), which the laws are held against with the parameters of their runs",
    )
    given = parser.read(arguments)
    output: Path = given.output
    check_output(output)
    try:
        data = compare(
            given.runs,
            output,
            refine=not given.no_refine,
            transient=given.transient,
            samples=given.samples,
            starts=given.starts,
            ranges=dict(given.range),
            measured=given.measured,
            announce=partial(tell, stream=sys.stderr),
        )
    except ComparisonError as error:
        raise RefusalError("\n".join(error.faults)) from error
    except OSError as error:
        raise unwritable(output, error) from error
    print(*headline(data), conclusion(data), "", as_text(data), sep="\n")
    if notes := data.attrs["notes"]:
        print(f"\nNotes:\n{notes}")
    print(f"\nWritten to {output}: report.html, scorecard.csv, scorecard.tex, metrics.nc and figures.")
    return COMPLETE


def _range(word: str) -> tuple[str, float]:
    """Read KEY=SHARE."""
    key, sign, share = word.partition("=")
    try:
        return key, float(share)
    except ValueError:
        said = f"'{word}' is no range; it must be KEY=SHARE" if sign else f"'{word}' has no share"
        raise ArgumentTypeError(f"{said}, such as contact.clearance=0.1") from None
