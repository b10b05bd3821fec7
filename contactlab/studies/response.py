"""The study `response`: amplitude and phase of orbits over one number, for several laws."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Final

import numpy as np
import pandas
import xarray

from contactlab.config import ConfigurationError, Setup
from contactlab.estimate import Estimate
from contactlab.laws import ContactLaw
from contactlab.laws.composed import label_of
from contactlab.motor import Motor
from contactlab.parameter import Parameter
from contactlab.quantity import in_si
from contactlab.steady_state.branches import branch as followed, family, unit_of
from contactlab.steady_state.response import check_quantity, first_tone, linear_dataset, with_response
from contactlab.studies.branch import Branch
from contactlab.studies.function import Put, function_of, of_motors
from contactlab.studies.study import Part, Range, Setups, Task, option
from contactlab.studies.tables import with_unit

LINEAR: Final = "linear"
"""Group of the free motor's response."""

SAMPLES: Final = 201
"""Values of the number at which the free motor's response is drawn, beside those of the orbits."""


@dataclass(frozen=True, kw_only=True)
class Response(Branch):
    """What are amplitude and phase of a motion over one number, KEY=START..END, stable and unstable?

    Along the branch of periodic orbits that begins at START, as of `branch`: mean, amplitude and phase of a
    recorded quantity at the drive's first tone, for every law, and beside them the linear response of the
    motor without contact. KEY is drive.frequency, a voltage, contact.clearance or any number that a branch
    follows: contactlab response 'drive.frequency=2.5 kHz..3.5 kHz' study.quantity=gap law=A,B.

        >>> import contactlab as cl
        >>> swing = cl.oscillator(1.0, 1e4, damping=10.0, gap=1.0, force=1.0)
        >>> law = cl.HertzPenalty(stiffness=1e9)
        >>> result = cl.response(swing, "drive.frequency", 15.0, 17.0, law=law)
        >>> result["law_1/amplitude"].max().round(5).item(), 1.0 / (10.0 * 100.0)
        (0.001, 0.001)

    Raises:
        ConfigurationError: there is no such key or quantity, or the drive has no tone.
        NoBranchError, NoPeriodError, BrokenOffError: as of `contactlab.branch`.
    """

    name: ClassVar[str] = "response"
    several: ClassVar[bool] = True

    quantity: Annotated[str, option("recorded quantity, as gap or tip_tangential_displacement")] = (
        "tip_normal_displacement"
    )
    step: Annotated[
        float, Parameter("h", "1", "first step, in parts of range and motion", above=0.0, at_most=1.0)
    ] = 0.1

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return a branch of orbits for each setup.

        Raises:
            ConfigurationError: there is no such number or quantity, or no tone.
        """
        check_quantity(self.quantity)
        tasks = []
        for label, setup in setups.items():
            first_tone(setup.motor.drive)
            (task,) = super().tasks({"": setup})
            name = label_of(setup.law) if not label or label.isdigit() else label
            arguments = (*task.arguments, self.quantity, name)
            tasks.append(replace(task, key=label, function=response_under, arguments=arguments))
        return tasks

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return a group for each law, law_1, law_2, and the free response of the first motor."""
        del setups
        groups: dict[str, xarray.Dataset] = {}
        for number, part in enumerate(parts.values(), 1):
            groups[f"law_{number}"] = part.to_dataset()
            groups.setdefault(LINEAR, part[LINEAR].to_dataset())
        data = xarray.DataTree.from_dict(groups)
        parameter = groups["law_1"].attrs["parameter"]
        data.attrs["title"] = f"Response of the {self.quantity.replace('_', ' ')} over {parameter}"
        return data

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return those of the branch under the first law."""
        return super().numbers(next(_branches(data)))

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return largest amplitude, events and end for each law."""
        sentences = []
        for branch in _branches(data):
            every, label = branch.to_dataset(), branch.attrs["label"]
            top = every.isel(point=int(np.argmax(every["amplitude"].values)))
            size, at = (
                with_unit(Estimate(float(top[name]), 0.0), top[name].attrs["units"])
                for name in ("amplitude", "value")
            )
            kind = "stable" if top["stable"] else "unstable"
            largest = f"the largest amplitude is {size} at {at}, of an orbit that is {kind}."
            sentences += [f"{label}: {text}" for text in (largest, *super().findings(branch))]
        return sentences

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return ends and events for each law."""
        result = {}
        for number, branch in enumerate(_branches(data), 1):
            (events,) = super().tables(branch).values()
            events.attrs["caption"] += f", {branch.attrs['label']}"
            result[f"events_{number}"] = events
        return result

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return amplitude and phase over the number, all laws together."""
        # Imported here: it brings matplotlib.
        from contactlab.studies.figures import captioned
        from contactlab.studies.orbit_figures import draw_response

        caption = (
            f"{data.attrs['title']}: amplitude and phase at the drive's first tone, solid where orbits are "
            "stable, dashed where unstable; dotted: the motor without contact, linear."
        )
        branches = [branch.to_dataset() for branch in _branches(data)]
        return {self.name: captioned(draw_response(branches, data[LINEAR].to_dataset()), caption)}


def _branches(data: xarray.DataTree) -> Iterator[xarray.DataTree]:
    """Yield the branch of each law."""
    return (group for name, group in data.children.items() if name != LINEAR)


def response_under(
    setup: Setup,
    key: str,
    start: float,
    end: float,
    belt: float | None,
    step: float,
    quantity: str,
    name: str,
) -> Part:
    """Follow the orbits under one law and read them, and the free motor beside them."""
    details = followed(setup, key, start, end, belt=belt, step=step)
    data, at = with_response(details, quantity), family(setup, key, belt)
    data.attrs["label"] = name
    values = np.union1d(np.linspace(start, end, SAMPLES), data["value"].values)
    linear = linear_dataset([at(value).setup for value in values], values, quantity, data["value"].attrs)
    return Part(xarray.DataTree.from_dict({"/": data, LINEAR: linear}), details)


def _ranges(
    motors: Motor | Setup | Sequence[Motor | Setup] | Mapping[str, Motor | Setup],
    parameter: str,
    start: float,
    end: float,
    *,
    law: ContactLaw | Sequence[ContactLaw] | None = None,
) -> Put:
    """Put the response to motors.

    Args:
        motors: setups, or motors made in Python: one or several, by label if they have any.
        parameter: as of `contactlab.branch`; drive.amplitude is that of the first tone of a motor made in
            Python, in the unit of its drive.
        start, end: of the range, in SI.
        law: what acts in the motors that are no setups, one or several; setups have their own.
    """
    setups, _ = of_motors(motors, law)
    if not setups:
        raise ConfigurationError("There is nothing to respond; there must be a motor.")
    unit = unit_of(next(iter(setups.values())), parameter)
    over = Range(parameter, in_si("start", start, unit), in_si("end", end, unit))
    return setups, {"over": over}


response = function_of(Response, _ranges, without=["over"])
