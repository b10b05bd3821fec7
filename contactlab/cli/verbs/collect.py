"""Put the runs of a sweep into one dataset over their parameters.

Where a run is missing, the dataset has a status and a reason.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from contactlab.cli import terminal
from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, RefusalError, tell


def main(arguments: list[str]) -> int:
    """Collect, write the file and print the status of the runs; one that failed is a result.

    Raises:
        RefusalError: a folder without runs, or a file that cannot be written.
    """
    parser = Parser(__name__, __doc__, "DIR", "a folder of runs, as -m leaves it")
    parser.option("output", "FILE", "the dataset; DIR/sweep.nc")
    parser.option(
        "series",
        "NAME[,NAME]",
        "time series that go into the group 'series'; the runs must be recorded at the same times",
    )
    (folder,), options = parser.read(arguments)
    output = Path(options["output"]) if "output" in options else None
    if output and (output.suffix != ".nc" or not output.parent.is_dir()):
        raise RefusalError(f"output is '{output}'; it must end in .nc and lie in a folder that exists.")
    _collect(Path(folder), output, options.get("series", ""))
    return COMPLETE


def collect_swept(folder: Path, series: Sequence[str] = (), metrics: Sequence[str] = ()) -> None:
    """Collect what a sweep left; its failure is printed and is none of the sweep."""
    try:
        _collect(folder, None, series, metrics)
    except RefusalError as error:
        tell(f"The runs could not be collected: {error}", sys.stderr)


def _collect(folder: Path, output: Path | None, *kept: Sequence[str]) -> None:
    # Imported here: they bring the compiler, which --help does not need.
    from contactlab.results.files import error_text
    from contactlab.studies.sweep.collection import collect
    from contactlab.studies.sweep.dataset import summary

    try:
        with terminal.progress(1.0, "folder"), terminal.raising():
            dataset = collect(folder, output, *kept)
    except ValueError as error:
        raise RefusalError(str(error)) from error
    except OSError as error:
        raise RefusalError(error_text(error), INCOMPLETE) from error
    print(summary(dataset, dataset.encoding["source"]))
