"""How the velocity at the end of a run depends on the voltage."""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np
import xarray
from matplotlib.figure import Figure

from contactlab import Estimate, Parameter, Study
from contactlab.studies import Part, Task, function_of, table
from contactlab.variables import Variable


@dataclass(frozen=True, kw_only=True)
class Gain(Study):
    """How does the velocity at the end of a run grow with the voltage?"""

    name: ClassVar[str] = "gain"
    quantities: ClassVar[tuple[Variable, ...]] = (
        Variable("slope", (), "rad s-1", "G", "velocity per share"),
    )

    points: Annotated[int, Parameter("n", "1", "number of voltages", at_least=2)] = 5

    def tasks(self, setups):
        (setup,) = setups.values()
        shares = np.linspace(0.5, 1.0, self.points)
        return [Task(f"{share:.6g}", final_velocity, (setup, share)) for share in shares.tolist()]

    def combine(self, setups, parts):
        data = xarray.concat([part.to_dataset() for part in parts.values()], "share")
        return xarray.DataTree(data)

    def numbers(self, data):
        slope, intercept = np.polyfit(data["share"], data["velocity"], 1)
        spread = np.abs(data["velocity"] - intercept - slope * data["share"]).max()
        return {"slope": Estimate(float(slope), float(spread))}

    def tables(self, data):
        rows = [
            {"share": s, "velocity": v}
            for s, v in zip(data["share"].values, data["velocity"].values, strict=True)
        ]
        return {"velocities": table(rows, units={"velocity": "rad s-1"}, caption="Velocity over the voltage")}

    def figures(self, data):
        figure = Figure(figsize=(5.0, 3.0), layout="constrained")
        axes = figure.subplots()
        axes.plot(data["share"], data["velocity"], "o-")
        axes.set(xlabel="share of the voltage", ylabel="velocity (rad/s)")
        return {"gain": figure}


def final_velocity(setup, share):
    drive = replace(setup.motor.drive, phasors=share * setup.motor.drive.phasors)
    run = replace(setup, motor=replace(setup.motor, drive=drive)).run()
    velocity = ((), run.series["rotor_velocity"][-1], {"units": "rad s-1"})
    return Part(xarray.DataTree(xarray.Dataset({"velocity": velocity}, {"share": share})))


gain = function_of(Gain)
