"""The study `characterise`: the data sheet of a motor."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from typing import Any, ClassVar, Final

import numpy as np
import pandas
import xarray

from contactlab.config import ConfigurationError
from contactlab.estimate import Estimate
from contactlab.motor.motor import lever_of
from contactlab.studies.characterise.sheet import MOTOR, POINT, data_sheet
from contactlab.studies.function import function_of, of_motors
from contactlab.studies.study import LENGTH, Setups, Study, Task, estimates, listing
from contactlab.studies.tables import table_of_quantities, with_unit
from contactlab.variables import Variable

BALANCE: Final = (
    *("active_power", "output_power", "damping_power", "friction_power", "contact_power"),
    *("dielectric_power", "balance"),
)
"""Where the electrical input goes."""


@dataclass(frozen=True, kw_only=True)
class Characterise(Study):
    """What is the motor's data sheet: speed-torque curve, power, efficiencies, start and stop?

    The sheet is in the motor's own sense of rotation: a load that brakes has a positive torque there, one
    that drives the motor a negative one. rotor.load_torque is positive against positive rotation of the
    model. Several laws, law=A,B, share a sheet.

        >>> import contactlab as cl
        >>> sheet = cl.characterise(cl.build(["law=hertz_penalty"]))
        >>> abs(sheet["velocity"]).max().round(3).item(), sheet["velocity"].attrs["units"]
        (2.739, 'rad s-1')

    Raises:
        ConfigurationError: a setup has a load, which the sheet itself applies to the motor.
        NoPeriodError: the drive does not repeat itself.
        OSError: the folder cannot be written to.
    """

    name: ClassVar[str] = "characterise"
    several: ClassVar[bool] = True
    ignored: ClassVar[tuple[str, ...]] = (*Study.ignored, *LENGTH, "rotor.load_torque")
    quantities: ClassVar[tuple[Variable, ...]] = tuple(MOTOR.values())

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return one task a setup.

        Raises:
            ConfigurationError: there is no setup, or one has a load, which the sheet itself applies to the
                motor.
        """
        if not setups:
            raise ConfigurationError("There is nothing to characterise; there must be a setup.")
        for setup in setups.values():
            if isnan(lever_of(setup.motor.geometry.rotor_radius)):
                plant = setup.motor.plant.name if setup.motor.plant else "a motor with a flat contact"
                raise ConfigurationError(
                    f"plant is {plant}; it must have a rotor that turns, as plant=motor or plant=slider: a "
                    "data sheet is over torque and velocity. Take steady, simulate or branch."
                )
            if (load := setup.motor.rotor.load_torque) != 0.0:
                raise ConfigurationError(
                    f"rotor.load_torque is {load:.12g} N m; it must be 0 N m: the sheet loads the motor "
                    "itself, from beyond stall to beyond no load. Leave it out."
                )
        return [Task(label, data_sheet, (setup,)) for label, setup in setups.items()]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return the sheets of all laws over the dimension `law`."""
        labels = pandas.Index(unique([setup.law.name for setup in setups.values()]), name="law")
        sheets = [part.to_dataset() for part in parts.values()]
        # Texts of a point that a law lacks are empty.
        data = xarray.concat(sheets, labels, join="outer", fill_value=dict.fromkeys(TEXTS, ""))
        data.attrs["title"] = f"Data sheet of a standing-wave piezoelectric motor: {', '.join(labels)}"
        return xarray.DataTree(data)

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the numbers of the motor under the first law."""
        return estimates(data.to_dataset().isel(law=0), self.quantities)

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return the numbers of the motor, and for each law points and power balance."""
        every = data.to_dataset()
        labels = [str(label) for label in every["law"].values]
        numbers = {label: estimates(every.sel(law=label), self.quantities) for label in labels}
        tables = {"motor": table_of_quantities(self.quantities, numbers, "Motor")}
        parts = {
            "points": [quantity for name, quantity in POINT.items() if name not in BALANCE],
            "power": [POINT[name] for name in BALANCE],
        }
        for label in labels:
            sheet = every.sel(law=label)
            points = {
                str(role): estimates(sheet.isel(point=number), POINT.values())
                for number, role in enumerate(sheet["role"].values)
                if role
            }
            # Without a steady state nothing is known of any point.
            if not any(np.isfinite(each.value) for of in points.values() for each in of.values()):
                continue
            for name, chosen in parts.items():
                caption = f"{name.capitalize()}, {label}"
                tables[f"{name}_{label}"] = table_of_quantities(chosen, points, caption)
        return tables

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return the numbers of each law, then sense, loads, limits, once for all that share a sentence."""
        every, laws = data.to_dataset(), dict[str, list[str]]()
        sentences = {str(label): [*_findings(every.sel(law=label))] for label in every["law"].values}
        for part in (slice(1), slice(1, None)):
            for label, own in sentences.items():
                for sentence in own[part]:
                    laws.setdefault(sentence, []).append(label)
        return [f"{', '.join(labels)}: {sentence}" for sentence, labels in laws.items()]

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return torque, output power and efficiency over velocity, all laws together, if one has a curve."""
        sheets = data.to_dataset()
        if not sheets["sense"].any():
            return {}
        # Imported here: it brings matplotlib.
        from contactlab.studies.characterise.figure import draw
        from contactlab.studies.figures import captioned

        return {self.name: captioned(draw(sheets), CAPTION)}


CAPTION: Final = (
    "Torque, output power and electrical efficiency over the velocity in the motor's sense. Points have the "
    "rotor held at a velocity; between them torque and input are straight lines. A cross is the free rotor."
)
"""Of the figure."""

TEXTS: Final = ("kind", "role", "load", "reason")


def unique(names: Sequence[str]) -> list[str]:
    """Return names of which each that occurs several times has a number."""
    return [f"{n} ({names[:i].count(n) + 1})" if names.count(n) > 1 else n for i, n in enumerate(names)]


def _findings(law: xarray.Dataset) -> Iterator[str]:
    """Yield the sentences about one law."""
    if not law["no_load_velocity"] > 0.0:
        reasons = sorted({str(reason) for reason in law["reason"].values} - {""})
        if reasons:
            yield f"the free rotor has no steady state to characterise. {' '.join(reasons)}"
            return
        kinds = ", ".join(sorted({str(kind) for kind in law["kind"].values} - {""}))
        velocity = Estimate(*(float(law[name].values[-1]) for name in ("velocity", "velocity_error")))
        yield (
            f"the free rotor's velocity, {velocity.text()} rad/s ({kinds}), is not distinguishable from "
            "zero; there is no curve to draw."
        )
        return
    yield f"{_summary(law)}."
    sign, minus = ("positive", "") if law["sense"] > 0.0 else ("negative", "-")
    yield (
        f"the motor turns in the {sign} sense of the model. Velocity and torque are given in the motor's "
        "sense, in which a load that brakes is positive: a load of M here is rotor.load_torque="
        f"{minus}M in the model, and the other sign drives the motor on."
    )
    friction, output = law["friction_power"].values, law["output_power"].values
    driving = (output > 0.0) & (friction < -law["friction_power_error"].values)
    if driving.any():
        worst = int(np.argmin(np.where(driving, friction, np.inf)))
        yield (
            f"friction is no loss but gives {with_unit(-friction[worst], 'W')} where the output is "
            f"{with_unit(output[worst], 'W')}, at {law['velocity'].values[worst]:.3g} rad/s: the friction "
            "impulse of this law reverses the slip. No motor does this; power and efficiency owe it to that."
        )
    if np.isinf(law["peak_force_error"].values).any():
        yield (
            "the peak force has no limit as the step falls: a rigid impact has an impulse and no force, and "
            "nothing follows for a tip's strength."
        )
    for kind in sorted({str(kind) for kind in law["kind"].values} - {"periodic", ""}):
        where = ", ".join(f"{v:.3g}" for v in law["velocity"].values[law["kind"].values == kind])
        yield f"the motion is {kind} at {where} rad/s; numbers are means over a long run there."
    apart = abs(float(law["no_load_velocity"] - law["curve_root"]))
    free = law.isel(point=int(np.flatnonzero(law["role"].values == "no load")[0]))
    errors = float(law["no_load_velocity_error"] + law["curve_root_error"])
    known = float(free["velocity_ripple"]) + errors
    if errors < apart <= known:
        yield (
            f"the speed-torque curve is zero at {float(law['curve_root']):.6g} rad/s, {apart:.2g} rad/s from "
            f"the free rotor's velocity: that one swings by {float(free['velocity_ripple']):.2g} rad/s in a "
            "period, and the rotor of the curve is held."
        )
    if apart > known:
        yield (
            f"the free rotor's velocity and the root of the curve differ by {apart:.2g} rad/s, more than "
            f"ripple and errors, {known:.2g} rad/s: on a belt the motor comes to another motion."
        )
    if np.isinf(law["stop_time"]):
        share = float(law["coasting_velocity"] / law["no_load_velocity"])
        yield (
            f"switched off, the tip leaves the rotor, which coasts on at {share:.1%} of its velocity: "
            "nothing brakes it (rotor.damping is 0)."
        )
    if law["holding_torque"] == 0.0:
        yield "without drive the tip does not press on the rotor: nothing holds it."


def _summary(law: xarray.Dataset) -> str:
    """Return velocity without load, stall torque, and the greatest power and efficiency."""
    text = listing([MOTOR["no_load_velocity"], MOTOR["stall_torque"]], estimates(law, MOTOR.values()))
    for word, name in (("power", "output_power"), ("efficiency", "electrical_efficiency")):
        for place in (i for i, role in enumerate(law["role"].values) if word in str(role)):
            point = estimates(law.isel(point=place), [POINT[name]])
            text = f"{text}, greatest {listing([POINT[name]], point)}"
    return text


characterise = function_of(Characterise, of_motors)
