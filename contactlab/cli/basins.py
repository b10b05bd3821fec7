"""`contactlab basins [KEY=VALUE ...]`: to which of its steady states a motor comes from where it starts."""

import re
from typing import TYPE_CHECKING

import numpy as np

from contactlab.cli import terminal
from contactlab.cli.arguments import Parser, number_in
from contactlab.cli.jobs import check_output, unwritable
from contactlab.cli.terminal import COMPLETE, RefusalError
from contactlab.results.files import whole_file, whole_netcdf

if TYPE_CHECKING:
    from contactlab.arrays import Array
    from contactlab.config import Setup

COUNT = 12
"""Starts along each coordinate."""

_OVER = re.compile(r"(?P<name>\w+)=(?P<start>.+?)\.\.(?P<end>.+)")


def main(arguments: list[str]) -> int:
    """Map the starts, write dataset and picture and print the attractors.

    Raises:
        RefusalError: there is no such map, or the folder cannot be written to.
    """
    parser = Parser(
        "basins",
        ", over two coordinates of its start. It leaves basins.nc and basins.png. A start is judged as soon "
        "as the motor is near an orbit that is known to draw it in.",
    )
    parser.add_argument("words", nargs="*", metavar="KEY=VALUE | GROUP=OPTION", help="as of a run")
    parser.add_argument(
        "--over",
        nargs=2,
        metavar="NAME=START..END",
        help="rotor_velocity [rad/s], drive_phase in its periods, tip_displacement [m], tip_velocity [m/s]; "
        "default: rotor_velocity as far as the tip's goes, and drive_phase=0..1",
    )
    parser.add_argument("--count", type=int, default=COUNT, help="starts along each: %(default)s")
    parser.add_output("basins", "basins.nc and basins.png")
    given = parser.read(arguments)
    if not 2 <= given.count <= 1000:
        parser.error(f"--count is {given.count}, it must be at least 2 and at most 1000")
    check_output(given.output)
    # Imported here: they bring the compiler, which --help does not need.
    from contactlab.cli.idle_words import KEPT, LASTING, refuse_idle
    from contactlab.config import ConfigurationError, build
    from contactlab.orbits import NoPeriodError, UnboundedError, basins

    refuse_idle(given.words, "a map of basins", *KEPT, *LASTING)
    try:
        setup = build(given.words)
        axes = _axes(setup, given.over, given.count)
        total = np.prod([values.size for values in axes.values()])
        with terminal.raising(), terminal.progress(float(total), "starts", "The map") as advance:
            found = basins(setup, axes, report=lambda done: advance(float(done)))
    except (ConfigurationError, NoPeriodError, UnboundedError) as error:
        raise RefusalError(str(error)) from error
    data = found.to_xarray()
    for i in range(data.sizes["attractor"]):
        one = data.isel(attractor=i)
        velocity = f"{float(one.velocity):9.5g} rad/s" if float(one.velocity_error) == 0.0 else ""
        velocity = velocity or f"{float(one.velocity):9.5g} +- {float(one.velocity_error):.1g} rad/s"
        print(f"{100.0 * float(one.share):5.1f} %  {one.kind.values!s:15}  {velocity}")
    print(f"{found.labels.size} starts; of {found.unresolved} it cannot be told where they go.")
    try:
        given.output.mkdir(parents=True, exist_ok=True)
        with whole_netcdf(given.output / "basins.nc") as partial:
            data.to_netcdf(partial, engine="netcdf4")
        with whole_file(given.output / "basins.png") as partial:
            found.plot().savefig(partial, format="png", metadata={"Software": None})
    except OSError as error:
        raise unwritable(given.output, error) from error
    print(f"Written to {given.output}: basins.nc, basins.png.")
    return COMPLETE


def _axes(setup: "Setup", over: list[str] | None, count: int) -> "dict[str, Array]":
    """Give the values of both coordinates."""
    from contactlab.orbits.basins import COORDINATES, default_axes
    from contactlab.parameter import from_cf

    if over is None:
        return default_axes(setup, count)
    axes = {}
    for word in over:
        found = _OVER.fullmatch(word)
        if not found or found["name"] not in COORDINATES:
            raise RefusalError(
                f"--over has {word}; it must be NAME=START..END with one of {', '.join(COORDINATES)} as the "
                "name, as in rotor_velocity=-3..3."
            )
        unit = from_cf(COORDINATES[found["name"]][0])
        start, end = (
            number_in(unit, found[side], f"The {side} of --over {found['name']}") for side in ("start", "end")
        )
        # The end of a turn is its start.
        whole = found["name"] == "drive_phase" and end - start == 1.0
        axes[found["name"]] = np.linspace(start, end, count, endpoint=not whole)
    if len(axes) != 2:
        raise RefusalError(
            f"--over has {over[0]} and {over[1]}; it must be two coordinates. Name another one."
        )
    return axes
