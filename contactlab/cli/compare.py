"""`contactlab compare DIR...`: the laws of several runs side by side, judged, drawn and reported."""

import sys
from pathlib import Path

from contactlab.cli.arguments import Parser
from contactlab.cli.verbs import VERBS

DONE, REFUSED = 0, 2
"""Exit statuses; a law that fails a metric is a result, no failure of the command."""

OUTPUT = "comparison"


def main(arguments: list[str]) -> int:
    """Compare, write the files and print the scorecard.

    Returns:
        The exit status: 2 for runs that cannot be compared and for a folder that cannot be written to.
    """
    parser = Parser("compare", _description())
    parser.add_argument(
        "runs",
        nargs="+",
        metavar="DIR",
        help="a run's folder, its run.nc, or a folder of such folders",
    )
    parser.add_argument(
        "--output",
        type=Path,
        default=Path(OUTPUT),
        metavar="DIR",
        help=f"where tables, figures and report.html go; default: {OUTPUT}",
    )
    parser.add_argument(
        "--no-refine",
        action="store_true",
        help="take the runs as they are: no numerical error, no sensitivities",
    )
    given = parser.read(arguments)
    # Imported here: they bring the compiler and the plotting, which --help does not need.
    from contactlab.comparison import ComparisonError, compare
    from contactlab.comparison.findings import conclusion, differences
    from contactlab.comparison.tables import as_text
    from contactlab.results.files import told

    output: Path = given.output
    if fault := _refusal(output):
        print(fault, file=sys.stderr)
        return REFUSED
    try:
        data = compare(given.runs, output, refine=not given.no_refine)
    except ComparisonError as error:
        print(*error.faults, sep="\n", file=sys.stderr)
        return REFUSED
    except OSError as error:
        print(f"Nothing more can be written to '{output}': {told(error)}", file=sys.stderr)
        return REFUSED
    print(as_text(data))
    print()
    print(*differences(data), conclusion(data), sep="\n")
    if notes := data.attrs["notes"]:
        print(f"\nNotes:\n{notes}")
    print(
        f"\nWritten to {output}: report.html, scorecard.csv, scorecard.tex, metrics.nc and figures."
    )
    return DONE


def _description() -> str:
    return (
        f"{VERBS['compare'].capitalize()}. The runs must be of one motor with one drive; every law is "
        "run again at finer steps first, so that the difference between laws is seen against the "
        "numerical error of each."
    )


def _refusal(output: Path) -> str:
    """Why nothing can be written into a folder, if so; nothing is made yet."""
    import os

    place = next(path for path in (output, *output.absolute().parents) if path.exists())
    if place.is_dir() and os.access(place, os.W_OK):
        return ""
    return (
        f"The output folder is '{output}' and cannot be written to ('{place}' is "
        f"{'not writable' if place.is_dir() else 'a file'}); it must be a folder, or a place for one, "
        "with write permission. Choose another one by --output DIR."
    )
