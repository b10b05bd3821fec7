"""The study `branch`: periodic orbits over one number, stable and unstable."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import pandas
import xarray

from contactlab.config import ConfigurationError, Setup
from contactlab.estimate import Estimate
from contactlab.laws import ContactLaw
from contactlab.motor import Motor
from contactlab.parameter import Parameter
from contactlab.quantity import UnitError, in_si
from contactlab.steady_state.branches import branch as followed, unit_of
from contactlab.steady_state.search import steady_setup
from contactlab.studies.function import Put, function_of
from contactlab.studies.study import LENGTH, Part, Range, Setups, Study, Task, option
from contactlab.studies.tables import table, with_unit
from contactlab.variables import Variable


@dataclass(frozen=True, kw_only=True)
class Branch(Study):
    """Which periodic orbits has the motor over one number, KEY=START..END, stable and unstable?

    The branch begins with the orbit in which the motor settles at START and continues through folds and
    along unstable orbits. KEY is a configuration key that holds a number, or belt, the velocity at which the
    rotor is held: contactlab branch 'contact.clearance=1 um..4 um'.

        >>> import contactlab as cl
        >>> result = cl.branch(cl.build(), "contact.clearance", 1e-6, 1.05e-6)
        >>> result["rotor_velocity"].values[[0, -1]].round(3)
        array([-2.191, -2.142])

    Raises:
        ConfigurationError: there is no such key, or it does not take one of the values.
        NoBranchError: the motor settles in no periodic orbit at the start, or there is no range.
        NoPeriodError, BrokenOffError: as of `contactlab.steady`.
    """

    name: ClassVar[str] = "branch"
    ignored: ClassVar[tuple[str, ...]] = (*Study.ignored, *LENGTH)
    quantities: ClassVar[tuple[Variable, ...]] = (
        Variable("orbit_count", (), "1", "n", "number of orbits computed"),
        Variable("event_count", (), "1", "m", "number of folds, bifurcations and grazings"),
        Variable("last_value", (), "1", "p", "value of the parameter where the branch ends"),
    )

    over: Annotated[Range | None, option("the number and its range, KEY=START..END")] = None
    belt: Annotated[float | None, Parameter("Omega_b", "rad s-1", "prescribed rotor velocity")] = None
    step: Annotated[
        float, Parameter("h", "1", "first step, in parts of the range", above=0.0, at_most=1.0)
    ] = 0.02

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return the one task of following the branch.

        Raises:
            ConfigurationError: there is no such number, or its range has other units.
        """
        (setup,) = setups.values()
        if self.over is None:
            text = "study.over must be one range KEY=START..END, as in 'contact.clearance=1 um..4 um'."
            raise ConfigurationError(text)
        if self.over.name == "belt" and self.belt is not None:
            raise ConfigurationError(f"study.belt is {self.belt:g} and {self.over} varies it. Leave one out.")
        try:
            ends = self.over.within(unit_of(setup, self.over.name))
        except UnitError as error:
            raise ConfigurationError(f"study.over is {error}.") from error
        return [Task("", _branch, (setup, self.over.name, *ends, self.belt, self.step))]

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return how many orbits and events there are, and where the branch ends."""
        every = data.to_dataset()
        counts = (every.sizes["point"], int((every["mark"] > 0).sum()), float(every["value"][-1]))
        return {q.name: Estimate(float(n), 0.0) for q, n in zip(self.quantities, counts, strict=True)}

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return the number of orbits, stable ones among them, the events, and why the branch ends."""
        every, stable = data.to_dataset(), int(data["stable"].sum())
        names, units = _names_of(every), every["value"].attrs["units"]
        places: dict[str, list[str]] = {}
        for mark, value in zip(every["mark"].values, every["value"].values, strict=True):
            if mark:
                places.setdefault(names[mark], []).append(with_unit(Estimate(float(value), 0.0), units))
        events = "; ".join(f"{name} at {', '.join(at)}" for name, at in places.items()) or "no event"
        return [f"{every.sizes['point']} orbits, {stable} of them stable; {events}.", data.attrs["end"]]

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return both ends and the events."""
        every, parameter = data.to_dataset(), data.attrs["parameter"]
        names = _names_of(every)
        events = {every.sizes["point"] - 1: "end", 0: "start"}
        events |= {i: names[mark] for i, mark in enumerate(every["mark"].values) if mark}
        # Round-off is no velocity.
        turns = abs(every["rotor_velocity"]) > every["rotor_velocity_error"]
        every["rotor_velocity"] = every["rotor_velocity"].where(turns, 0.0)
        rows = [
            {
                parameter: float(every["value"][i]),
                "rotor velocity": float(every["rotor_velocity"][i]),
                "largest multiplier": float(every["largest_multiplier"][i]),
                "event": event,
            }
            for i, event in sorted(events.items())
        ]
        units = {parameter: every["value"].attrs["units"], "rotor velocity": "rad s-1"}
        return {"events": table(rows, units=units, caption=f"Ends and events over {parameter}")}

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return velocity or torque and largest multiplier over the number."""
        # Imported here: it brings matplotlib.
        from contactlab.studies.figures import captioned
        from contactlab.studies.orbit_figures import draw_branch

        caption = (
            f"{data.attrs['title']}: solid where stable, dashed where unstable; below, the largest absolute "
            "value of a Floquet multiplier."
        )
        return {self.name: captioned(draw_branch(data.to_dataset()), caption)}


def _names_of(data: xarray.Dataset) -> list[str]:
    """Return the names of the events by their marks."""
    return [name.replace("_", " ") for name in data["mark"].attrs["flag_meanings"].split()]


def _branch(setup: Setup, key: str, start: float, end: float, belt: float | None, step: float) -> Part:
    details = followed(setup, key, start, end, belt=belt, step=step)
    return Part(xarray.DataTree(details.to_xarray()), details)


def _range(
    motor: Motor | Setup, parameter: str, start: float, end: float, *, law: ContactLaw | None = None
) -> Put:
    """Put the continuation to a motor.

    Args:
        motor: what moves, or a whole setup.
        parameter: a key that holds a number, 'contact.clearance', or 'belt', the velocity at which the
            rotor is held [rad/s]. A motor made in Python has keys of contact, rotor and
            law, and drive.frequency, the first tone, to which others keep their ratios.
        start, end: of the range, in SI.
        law: what acts between tip and rotor; a setup has its own.
    """
    setup = steady_setup(motor, law)
    unit = unit_of(setup, parameter)
    over = Range(parameter, in_si("start", start, unit), in_si("end", end, unit))
    return {"": setup}, {"over": over}


branch = function_of(Branch, _range, without=["over"])
