"""`contactlab branch KEY=START..END ...`: periodic orbits over one number, stable and unstable."""

import re
from pathlib import Path
from typing import TYPE_CHECKING

from contactlab.cli import terminal
from contactlab.cli.arguments import Parser, number_in
from contactlab.cli.jobs import check_output, unwritable
from contactlab.cli.terminal import COMPLETE, RefusalError
from contactlab.results.files import whole_file, whole_netcdf

if TYPE_CHECKING:
    from contactlab.orbits.branches import Branch

RANGE = re.compile(r"(?P<key>[\w.]+)=(?P<start>.+?)\.\.(?P<end>.+)")
"""What a parameter and its range look like; no number ends in a point here."""


def main(arguments: list[str]) -> int:
    """Follow the branch, write dataset and picture and print what happens on it.

    Raises:
        RefusalError: there is no branch, or the folder cannot be written to.
    """
    parser = Parser(
        "branch",
        ", through folds and along unstable orbits too, from the orbit that the motor settles in at START. "
        "It leaves branch.nc and branch.png.",
    )
    parser.add_argument(
        "words",
        nargs="+",
        metavar="KEY=START..END | KEY=VALUE | GROUP=OPTION",
        help="what changes, 'contact.clearance=1 um..4 um', or belt=-2..2 for a rotor that is held at a "
        "velocity; and what stays, as of a run",
    )
    parser.add_argument("--belt", metavar="VELOCITY", help="hold the rotor at a velocity [rad/s]")
    parser.add_argument(
        "--step", type=float, default=0.02, help="first step, a part of the range: %(default)s"
    )
    parser.add_output("branch", "branch.nc and branch.png")
    given = parser.read(arguments)
    spans = [span for word in given.words if (span := RANGE.fullmatch(word))]
    if len(spans) != 1:
        words = f"{len(spans)} of the arguments have a range KEY=START..END; it must be one"
        parser.error(words, "Write it like 'contact.clearance=1 um..4 um'.")
    span = spans[0]
    if span["key"] == "belt" and given.belt is not None:
        raise RefusalError(f"{span.string} and --belt are both given; it must be one of them. Leave one out.")
    if not 0.0 < given.step <= 1.0:
        parser.error(f"--step is {given.step:g}, it must be greater than 0 and at most 1")
    check_output(given.output)
    # Imported here: they bring the compiler, which --help does not need.
    from contactlab.cli.idle_words import KEPT, LASTING, refuse_idle
    from contactlab.config import ConfigurationError, build
    from contactlab.orbits import BrokenOffError, NoPeriodError, NotSettledError
    from contactlab.orbits.branches import NoBranchError, branch, unit_of

    refuse_idle(given.words, "an orbit", *KEPT, *LASTING)
    rest = [word for word in given.words if word != span.string]
    try:
        setup = build(rest)
        key, unit = span["key"], unit_of(setup, span["key"])
        start, end = (number_in(unit, span[side], f"The {side} of {key}") for side in ("start", "end"))
        belt = None if given.belt is None else number_in("rad/s", given.belt, "--belt")
        with terminal.raising():
            found = branch(setup, key, start, end, belt=belt, step=given.step)
    except (ConfigurationError, NoBranchError, NoPeriodError) as error:
        raise RefusalError(str(error)) from error
    except (BrokenOffError, NotSettledError) as error:
        raise RefusalError(f"No steady state was found to begin with: {error}") from error
    _print(found)
    try:
        _write(found, given.output)
    except OSError as error:
        raise unwritable(given.output, error) from error
    print(f"Written to {given.output}: branch.nc, branch.png.")
    return COMPLETE


def _print(found: "Branch") -> None:
    """Print ends and events of a branch, a line each."""
    print(f"{found.parameter:>16}  rotor velocity  largest multiplier")
    last = len(found.points) - 1
    for i, point in enumerate(found.points):
        if point.mark or i in (0, last):
            name = point.mark.name.lower().replace("_", " ") if point.mark else "end" if i else "start"
            largest = abs(point.orbit.multipliers[0])
            print(f"{point.value:16.9g}  {point.velocity:8.5g} rad/s  {largest:18.6g}  {name}")
    share = sum(point.orbit.stable for point in found.points)
    print(f"{len(found.points)} orbits, {share} of them stable. {found.end}")


def _write(found: "Branch", folder: Path) -> None:
    """Write dataset and picture."""
    folder.mkdir(parents=True, exist_ok=True)
    packed = {"zlib": True, "complevel": 1, "shuffle": True}
    data = found.to_xarray()
    with whole_netcdf(folder / "branch.nc") as partial:
        encoding = {str(name): packed for name in data.variables}
        data.to_netcdf(partial, engine="netcdf4", encoding=encoding)
    with whole_file(folder / "branch.png") as partial:
        found.plot().savefig(partial, format="png", metadata={"Software": None})
