"""The data sheet of a motor as a dataset."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
import xarray

from contactlab.config import Setup
from contactlab.estimate import Estimate
from contactlab.results.netcdf import cf_attributes
from contactlab.steady_state.period_map import contact_at_end, memory_at_end, variables_in
from contactlab.studies.characterise.curve import BEST, Curve, greatest, root
from contactlab.studies.characterise.operation import UNKNOWN, Point, operate
from contactlab.studies.characterise.quantities import MOTOR, POINT
from contactlab.studies.characterise.transients import holding_torque, start_time, stop_time
from contactlab.variables import Variable

ROLES: Final = ("stall", "greatest power", "greatest efficiency", "no load")
"""Points of the curve that have a name."""


def data_sheet(setup: Setup) -> xarray.Dataset:
    """Return the data sheet of a motor.

    It has every quantity of `contactlab.studies.characterise.quantities` and its error, `NAME_error`, those
    of points over the dimension `point`: the prescribed rotor speeds of the speed-torque curve in ascending
    order, and the free rotor. `kind` is the kind of motion, `load` the direction of the load, `role` one of
    `ROLES` or empty. Velocities and torques are in the motor's own sense of rotation, whose sign in the
    model is `sense`.

    Raises:
        NoPeriodError: the drive does not repeat itself.
    """
    points, own, sense = _sheet(setup)
    values: dict[str, Any] = {}
    for name, quantity in POINT.items():
        values |= _with_error(quantity, np.transpose([p[name] for p in points]))
    for name, quantity in MOTOR.items():
        values |= _with_error(quantity, np.array(own.get(name, UNKNOWN)))
    texts = {
        "kind": [point.kind for point in points],
        "role": _roles(points),
        "load": _loads(points),
        "reason": [point.message for point in points],
    }
    values |= {name: ("point", np.array(column, dtype=object)) for name, column in texts.items()}
    about = {"units": "1", "long_name": "sign of the motor's sense in the model, 0 where it does not turn"}
    values["sense"] = (), sense, about
    return xarray.Dataset(values, {"point": np.arange(len(points))})


def _sheet(setup: Setup) -> tuple[list[Point], dict[str, Estimate], float]:
    """Characterise one motor: the points of its curve, the free rotor's last, its own numbers, its sense."""
    free = operate(setup)
    velocity, error = free["velocity"]
    if free.run is None or not abs(velocity) > error:
        return [free], {}, 0.0
    sense = float(np.sign(velocity))
    points = Curve(setup, velocity).points
    run, contact = free.run, contact_at_end(free.run)
    rotor = replace(run.motor.rotor, initial_velocity=float(run.series["rotor_velocity"][-1]))
    settled = replace(run.motor, start=run.final, rotor=rotor)
    memory = memory_at_end(run, variables_in(run.law, contact))
    stop, coasting = stop_time(setup, settled, velocity, memory, contact)
    numbers = {
        "no_load_velocity": Estimate(abs(velocity), error),
        "curve_root": root(points),
        "stall_torque": next(point["torque"] for point in points if point.belt == 0.0),
        "holding_torque": holding_torque(setup, velocity),
        "start_time": start_time(setup, velocity),
        "stop_time": stop,
        "coasting_velocity": coasting,
    }
    return [*points, free.turned(sense)], numbers, sense


def _roles(points: Sequence[Point]) -> list[str]:
    """Name the points that have a role."""
    motoring = [point for point in points if point.value("output_power") > 0.0]
    role = {id(point): "stall" for point in points if point.belt == 0.0}
    role |= {id(points[-1]): "no load"}
    for name, quantity in zip(ROLES[1:3], BEST, strict=True):
        if (best := greatest(motoring, quantity)) is not None:
            role[id(best)] = f"{role[id(best)]} and efficiency" if id(best) in role else name
    return [role.get(id(point), "") for point in points]


def _loads(points: Sequence[Point]) -> list[str]:
    """Return what the load does at the points, by the quadrant of velocity and torque."""
    quadrants = {(1, 1): "brakes", (-1, 1): "turns the motor back", (1, -1): "drives the motor on"}
    signs = [(np.sign(p.value("velocity")), np.sign(p.value("torque"))) for p in points]
    return [quadrants.get(pair, "") if p.belt else "" for p, pair in zip(points, signs, strict=True)]


def _with_error(quantity: Variable, numbers: np.ndarray) -> dict[str, Any]:
    """Return a quantity and its error as variables of a dataset."""
    name, attributes = quantity.name, cf_attributes(quantity)
    error = {"units": quantity.units, "long_name": f"error of the {name.replace('_', ' ')}"}
    return {
        name: (quantity.dims, numbers[0], attributes | {"ancillary_variables": f"{name}_error"}),
        f"{name}_error": (quantity.dims, numbers[1], error),
    }
