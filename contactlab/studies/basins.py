"""The study `basins`: to which of its steady states a motor comes from where it starts."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
import pandas
import xarray

from contactlab.arrays import Array
from contactlab.checks import as_array
from contactlab.config import ConfigurationError, Setup
from contactlab.estimate import Estimate
from contactlab.laws import ContactLaw
from contactlab.motor import Motor
from contactlab.parameter import from_cf
from contactlab.quantity import UnitError
from contactlab.steady_state.basins import COORDINATES, basins as mapped, default_axes
from contactlab.steady_state.search import steady_setup
from contactlab.studies.function import Put, function_of
from contactlab.studies.study import LENGTH, Part, Range, Setups, Study, Task, option
from contactlab.studies.tables import table, with_unit
from contactlab.variables import Variable


@dataclass(frozen=True, kw_only=True)
class Basins(Study):
    """To which of its steady states does the motor come from where it starts?

    Two coordinates of the start are varied, by default the rotor velocity and the phase of the drive; others
    are tip_displacement and tip_velocity, in the first mode: contactlab basins rotor_velocity=-3..3
    'tip_displacement=0..1 um'. A start is assigned as soon as the motor is in a neighbourhood of an orbit
    that it does not leave.

    Raises:
        ValueError: the axes are not two coordinates.
        NoPeriodError: the drive does not repeat itself.
        UnboundedError: an internal variable of the law comes to no steady value.
    """

    name: ClassVar[str] = "basins"
    ignored: ClassVar[tuple[str, ...]] = (*Study.ignored, *LENGTH)
    quantities: ClassVar[tuple[Variable, ...]] = (
        Variable("attractor_count", (), "1", "n", "number of attractors"),
        Variable("largest_share", (), "1", "s", "share of the starts in the largest basin"),
    )

    over: Annotated[
        list[Range] | Mapping[str, Any] | None,
        option("two coordinates, NAME=START..END; in Python values of each too"),
    ] = None
    count: Annotated[int, option("starts along each coordinate", at_least=2, at_most=1000)] = 12

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return the one task of the map: a start may end near an orbit that an earlier one has found.

        Raises:
            ConfigurationError: the coordinates are not two, or their ranges have other units.
        """
        (setup,) = setups.values()
        return [Task("", _map, (setup, self._axes(setup)))]

    def _axes(self, setup: Setup) -> Mapping[str, Array]:
        """Return the values of both coordinates."""
        if self.over is None:
            return default_axes(setup, self.count)
        if isinstance(self.over, Mapping):
            return self.over
        if len(self.over) != 2 or len({each.name for each in self.over} & {*COORDINATES}) != 2:
            raise ConfigurationError(
                f"study.over is {', '.join(map(str, self.over))}; it must be ranges NAME=START..END of "
                f"two of {', '.join(COORDINATES)}."
            )
        axes = {}
        for each in self.over:
            try:
                start, end = each.within(from_cf(COORDINATES[each.name][0]))
            except UnitError as error:
                raise ConfigurationError(f"study.over has {error}.") from error
            # The end of a period is its start.
            whole = each.name == "drive_phase" and end - start == 1.0
            axes[each.name] = np.linspace(start, end, self.count, endpoint=not whole)
        return axes

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the number of attractors and the share of the largest basin."""
        shares = data.to_dataset()["share"].values
        return {
            "attractor_count": Estimate(float(shares.size), 0.0),
            "largest_share": Estimate(float(shares.max(initial=0.0)), 0.0),
        }

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return the share of the starts that comes to each attractor, and how many were assigned."""
        every = data.to_dataset()
        sentences = []
        for place in np.argsort(-every["share"].values, kind="stable"):
            here = every.isel(attractor=int(place))
            velocity = Estimate(float(here["velocity"]), float(here["velocity_error"]))
            sentences.append(
                f"{float(here['share']):.1%} of the starts come to a motion that is {here['kind'].item()}, "
                f"with {with_unit(velocity, 'rad s-1')}."
            )
        left = int(data.attrs["unresolved"])
        return [*sentences, f"{every['label'].size} starts, {left} of them not assigned."]

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return the attractors, a row each."""
        columns = data.to_dataset()[["share", "kind", "velocity", "velocity_error"]]
        rows = [
            {"share": x.share, "motion": x.kind, "velocity": Estimate(x.velocity, x.velocity_error)}
            for x in columns.to_dataframe().itertuples()
        ]
        return {"attractors": table(rows, units={"velocity": "rad s-1"}, caption="Attractors")}

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return the map of the starts."""
        # Imported here: it brings matplotlib.
        from contactlab.studies.figures import captioned
        from contactlab.studies.orbit_figures import draw_basins

        caption = f"{data.attrs['title']}: the steady state to which each start leads."
        return {self.name: captioned(draw_basins(data.to_dataset()), caption)}


def _map(setup: Setup, axes: Mapping[str, Array]) -> Part:
    details = mapped(setup, axes)
    return Part(xarray.DataTree(details.to_xarray()), details)


def _starts(
    motor: Motor | Setup, axes: Mapping[str, Array] | None = None, *, law: ContactLaw | None = None
) -> Put:
    """Put the map to a motor.

    Args:
        motor: what moves, or a whole setup.
        axes: values of two coordinates of the start, keys of `COORDINATES` in
            `contactlab.steady_state.basins`; None takes `count` values of the default ones.
        law: what acts between tip and rotor; a setup has its own.
    """
    over = None
    if axes is not None:
        units = {name: unit for name, (unit, _) in COORDINATES.items()}
        over = {name: as_array(name, values, units.get(name, "1")) for name, values in axes.items()}
    return {"": steady_setup(motor, law)}, {"over": over}


basins = function_of(Basins, _starts, without=["over"])
