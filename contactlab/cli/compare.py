"""`contactlab compare DIR...`: the laws of several runs side by side, judged, drawn and reported."""

from pathlib import Path

from contactlab.cli.arguments import Parser
from contactlab.cli.jobs import refusals
from contactlab.cli.terminal import COMPLETE, RefusalError
from contactlab.results.files import told


def main(arguments: list[str]) -> int:
    """Compare, write the files and print the scorecard.

    Returns:
        The exit status; a law that fails a metric is a result, no failure of the command.

    Raises:
        RefusalError: the runs cannot be compared, or the folder cannot be written to.
    """
    parser = Parser(
        "compare",
        ". The runs must be of one motor with one drive; every law is run again at finer steps first, so "
        "that the difference between laws is seen against the numerical error of each.",
    )
    parser.add_argument(
        "runs", nargs="+", metavar="DIR", help="a run's folder, its run.nc, or a folder of such folders"
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("comparison"),
        metavar="DIR",
        help="where tables, figures and report.html go; default: %(default)s",
    )
    parser.add_argument(
        "--no-refine",
        action="store_true",
        help="take the runs as they are: no numerical error, no sensitivities",
    )
    given = parser.read(arguments)
    # Imported here: they bring the plotting, which --help does not need.
    from contactlab.comparison import ComparisonError, compare
    from contactlab.comparison.findings import conclusion, differences
    from contactlab.comparison.scorecard import as_text

    output: Path = given.output
    for fault in refusals(output, "Choose another one by --output DIR."):
        raise RefusalError(fault)
    try:
        data = compare(given.runs, output, refine=not given.no_refine)
    except ComparisonError as error:
        raise RefusalError("\n".join(error.faults)) from error
    except OSError as error:
        raise RefusalError(f"Nothing more can be written to '{output}': {told(error)}") from error
    print(as_text(data), "", *differences(data), conclusion(data), sep="\n")
    if notes := data.attrs["notes"]:
        print(f"\nNotes:\n{notes}")
    print(f"\nWritten to {output}: report.html, scorecard.csv, scorecard.tex, metrics.nc and figures.")
    return COMPLETE
