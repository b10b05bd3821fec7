"""`contactlab steady [KEY=VALUE ...]`: what a motor does when it has settled, and how fast it gets there."""

import sys
from pathlib import Path

from contactlab.cli.arguments import Parser, number_in
from contactlab.cli.idle_words import KEPT, LASTING, acting, refuse_idle
from contactlab.cli.jobs import check_output, unwritable
from contactlab.cli.next_step import tell_next
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, RefusalError, tell
from contactlab.config import ConfigurationError, build
from contactlab.orbits.search import LONGEST

UNITS = {"belt": "rad/s", "load": "N m", "brake": "N m"}
"""Of the options that hold or load the rotor."""


def main(arguments: list[str]) -> int:
    """Find the steady state, print it and write its files.

    Returns:
        The exit status; 1 where there is no steady state, with a sentence.

    Raises:
        RefusalError: the motor cannot be made, or the folder cannot be written to.
    """
    parser = Parser(
        "steady",
        ". A run of the configured duration tells of a start; this tells of the motor. The steady state is "
        "found at three steps or tolerances, which gives its numerical error.",
    )
    parser.add_argument(
        "overrides", nargs="*", metavar="KEY=VALUE", help="as for a run: GROUP=OPTION or KEY=VALUE"
    )
    parser.add_argument("--belt", metavar="V", help="hold the rotor at this velocity [rad/s]")
    parser.add_argument(
        "--load",
        metavar="TAU",
        help="load torque [N m] in place of rotor.load_torque: positive brakes positive rotation and drives "
        "negative",
    )
    parser.add_argument(
        "--brake", metavar="TAU", help="load torque [N m] against the motor's rotation, whatever its sense"
    )
    parser.add_output("steady", "steady.nc and steady.png")
    parser.add_argument(
        "--longest",
        type=int,
        default=LONGEST,
        metavar="N",
        help="periods of the drive after which a motion without an orbit has its means; default: %(default)s",
    )
    parser.add_argument(
        "--no-refine", action="store_true", help="one step or tolerance alone: no numerical error"
    )
    given = parser.read(arguments)
    held = {
        name: number_in(unit, text, f"--{name}")
        for name, unit in UNITS.items()
        if (text := getattr(given, name)) is not None
    }
    try:
        refuse_idle(given.overrides, "a steady state", *KEPT, "solver.until", "solver.precision")
        setup = build(given.overrides)
    except ConfigurationError as error:
        raise RefusalError("\n".join(error.faults)) from error
    output: Path = given.output
    check_output(output)
    # Imported here: they bring the plotting, which --help does not need.
    from contactlab.orbits import BrokenOffError, NotSettledError, converged
    from contactlab.orbits.figure import picture
    from contactlab.orbits.report import summary_of, tree_of
    from contactlab.results.netcdf import write_tree

    try:
        found = converged(setup, None, refine=not given.no_refine, longest=given.longest, **held)
    except (BrokenOffError, NotSettledError) as error:
        raise SystemExit(_incomplete(str(error))) from error
    except ValueError as error:
        raise RefusalError(str(error)) from error
    lines = summary_of(found)
    width = max(map(len, lines)) + 2
    try:
        output.mkdir(parents=True, exist_ok=True)
        tree = tree_of(found)
        write_tree(tree, output / "steady.nc")
        picture(found, tree, output / "steady.png")
    except OSError as error:
        raise unwritable(output, error) from error
    print(*(f"{label:<{width}}{text}" for label, text in lines.items()), sep="\n")
    print(f"Written to {output}: steady.nc and steady.png.")
    tell_next("characterise", acting(given.overrides, *LASTING), "makes the motor's data sheet")
    return COMPLETE


def _incomplete(reason: str) -> int:
    """Say why there is no steady state."""
    tell(reason, sys.stderr)
    return INCOMPLETE
