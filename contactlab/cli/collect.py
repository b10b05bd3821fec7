"""`contactlab collect DIR`: the runs of a sweep as one dataset over their parameters."""

import sys
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from contactlab.cli import interrupts
from contactlab.cli.arguments import Parser
from contactlab.cli.verbs import VERBS

if TYPE_CHECKING:
    import xarray

DONE, REFUSED = 0, 2
"""Exit statuses; a run that is not complete is a result, no failure of the command."""


def main(arguments: list[str]) -> int:
    """Collect, write the file and print what became of the runs.

    Returns:
        The exit status: 2 for a folder without runs and for a file that cannot be written.
    """
    parser = Parser(
        "collect",
        f"{VERBS['collect'].capitalize()}, with a status and a reason where one is missing.",
    )
    parser.add_argument("directory", metavar="DIR", help="a folder of runs, as -m leaves it")
    parser.add_argument(
        "--output", type=Path, metavar="FILE", help="the dataset; default: DIR/collected.nc"
    )
    parser.add_argument(
        "--series",
        default="",
        metavar="NAME[,NAME]",
        help="time series that go into the group 'series'; the runs must be recorded at the same times",
    )
    given = parser.read(arguments)
    # Imported here: they bring the compiler, which --help does not need.
    from contactlab.results.files import told
    from contactlab.sweeps.chunks import PLAN
    from contactlab.sweeps.collecting import COLLECTED, collect
    from contactlab.sweeps.faults import CollectingError

    if (Path(given.directory) / PLAN).is_file():
        return _map(given)
    output: Path = given.output or Path(given.directory) / COLLECTED
    series = [name.strip() for name in given.series.split(",") if name.strip()]
    try:
        with interrupts.raising():
            dataset = collect(given.directory, output, series)
    except CollectingError as error:
        print(error, file=sys.stderr)
        return REFUSED
    except OSError as error:
        print(f"The runs could not be collected: {told(error)}", file=sys.stderr)
        return REFUSED
    except KeyboardInterrupt:
        print("Interrupted before the runs were collected; nothing was written.", file=sys.stderr)
        return interrupts.STATUS
    print(report(dataset, output))
    return DONE


def _map(given: Namespace) -> int:
    """Collect the chunks of a map that are finished so far."""
    from contactlab.cli.map_summary import summary
    from contactlab.results.files import told
    from contactlab.sweeps.chunks import MAP, MapFolder
    from contactlab.sweeps.faults import MapError

    if given.output or given.series:
        print(
            f"'{given.directory}' is the folder of a map, whose dataset is its {MAP} with the series that it "
            "keeps; --output and --series must be left out.",
            file=sys.stderr,
        )
        return REFUSED
    try:
        folder = MapFolder.opened(Path(given.directory))
        with interrupts.raising():
            dataset = folder.merge()
    except MapError as error:
        print(error, file=sys.stderr)
        return REFUSED
    except OSError as error:
        print(f"The map could not be collected: {told(error)}", file=sys.stderr)
        return REFUSED
    except KeyboardInterrupt:
        print("Interrupted before the map was collected; nothing was written.", file=sys.stderr)
        return interrupts.STATUS
    print(summary(dataset, folder.file))
    return DONE


def report(dataset: "xarray.Dataset", path: Path) -> str:
    """What became of the runs: a line a status, a line a run that is not complete, and the file."""
    from contactlab.sweeps.status import Status

    counts = {status: int(dataset.attrs[f"runs_{status.name.lower()}"]) for status in Status}
    width = len(str(max(counts.values())))
    lines = [f"{count:>{width}} {status.name.lower()}" for status, count in counts.items() if count]
    columns = (dataset[name].values.ravel() for name in ("job", "status", "reason"))
    for job, status, reason in zip(*columns, strict=True):
        if job and status != Status.COMPLETE:
            lines.append(f"{job}: {Status(status).name.lower()}. {reason}")
    sizes = " x ".join(f"{name} {size}" for name, size in dataset.sizes.items())
    return "\n".join([*lines, f"Collected in {path}: {sizes}."])
