"""`contactlab map`: a law over many values of many parameters, in chunks that are kept when finished."""

import sys
from pathlib import Path

from contactlab.cli import interrupts
from contactlab.cli.arguments import Parser
from contactlab.cli.verbs import VERBS

DONE, INCOMPLETE, REFUSED = 0, 1, 2
"""Exit statuses; a run that fails is a result, no failure of the command."""


def main(arguments: list[str]) -> int:
    """Make the map, or go on with it.

    Returns:
        The exit status: 2 for a faulty command line, 1 where chunks are missing at the end.
    """
    wanted = _parser().read(arguments)
    # Imported here: they bring Hydra and the compiler, which --help does not need.
    from contactlab.cli.mapping import make_map
    from contactlab.config import ConfigurationError
    from contactlab.results.files import told
    from contactlab.sweeps.faults import MapError
    from contactlab.sweeps.workers import WorkerError

    try:
        return DONE if make_map(wanted) else INCOMPLETE
    except ConfigurationError as error:
        print(*error.faults, sep="\n", file=sys.stderr)
    except MapError as error:
        print(error, file=sys.stderr)
    except WorkerError as error:
        print(error, file=sys.stderr)
        return INCOMPLETE
    except OSError as error:
        print(f"The map could not be written: {told(error)}", file=sys.stderr)
        return INCOMPLETE
    except KeyboardInterrupt:
        print(
            "Interrupted. The chunks that are finished are kept: the same command goes on there.",
            file=sys.stderr,
        )
        return interrupts.STATUS
    return REFUSED


def _parser() -> Parser:
    parser = Parser(
        "map",
        f"{VERBS['map'].capitalize()}. Results are metrics, a number a run: "
        "docs/plausibility.md says what they are. Finished chunks are kept: the same command goes on "
        "where it was stopped, and ends with the same bits.",
        epilog="example: contactlab map law=lagrange_stick 'sweep.contact.clearance=linspace(0,2e-6,100)' "
        "'sweep.drive.phase=linspace(-180 deg,180 deg,73)' solver.duration=2e-3",
    )
    parser.add_argument(
        "arguments",
        nargs="+",
        metavar="KEY=VALUE",
        help="as for a run; sweep.KEY=VALUES sweeps a key or group: 1e-6,2e-6 or "
        "range(START,STOP,STEP) without STOP or linspace(FIRST,LAST,COUNT) or geomspace(FIRST,LAST,COUNT)",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="where map.nc goes; the default is a folder in maps/ named by what is swept",
    )
    parser.add_argument(
        "--metrics",
        metavar="NAME,...",
        help="metrics that are kept, or all; a cheap few by default",
    )
    parser.add_argument(
        "--series", metavar="NAME,...", default="", help="time series that are kept as well"
    )
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes at work; the default is one a processor"
    )
    parser.add_argument(
        "--chunk",
        type=int,
        metavar="N",
        help="runs in a chunk, which is kept when it is finished; the default is 1000, or what makes 1000 "
        "chunks",
    )
    parser.add_argument(
        "--config-dir", metavar="DIR", help="a folder of more options, DIR/law/NAME.yaml"
    )
    return parser
