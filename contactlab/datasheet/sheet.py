"""Setups -> data sheet: a dataset, and on demand its table, figure and page in a folder."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray
import yaml

from contactlab.config import ConfigurationError, Setup
from contactlab.datasheet.curve import BEST, Curve, greatest, root
from contactlab.datasheet.measurement import UNKNOWN, Number
from contactlab.datasheet.operation import Point, operate
from contactlab.datasheet.quantities import MOTOR, POINT
from contactlab.datasheet.transients import holding_torque, start_time, stop_time
from contactlab.laws import ContactLaw
from contactlab.motor import Motor
from contactlab.orbits.search import steady_setup
from contactlab.results.files import whole_file, whole_netcdf
from contactlab.results.netcdf import cf_attributes
from contactlab.results.provenance import checkout_state, code_digest, versions

ROLES: Final = ("stall", "greatest power", "greatest efficiency", "no load")
"""Points of the curve that have a name."""


def characterise(
    motors: Motor | Setup | Sequence[Motor | Setup],
    law: ContactLaw | None = None,
    *,
    output: str | Path | None = None,
) -> xarray.Dataset:
    """Make the data sheet of a motor, under one law or several.

        cl.characterise(cl.build(["law=newton"]))
        cl.characterise([cl.build([f"law={law}"]) for law in ("newton", "hertz_penalty")], output="sheet")
        cl.characterise(motor, cl.Newton())

        >>> import contactlab as cl
        >>> sheet = cl.characterise(cl.build(["law=hertz_penalty"]))
        >>> abs(sheet["velocity"]).max().round(3).item(), sheet["velocity"].attrs["units"]
        (2.739, 'rad s-1')

    Args:
        motors: setups, or motors made in Python; duration and record interval mean nothing here.
        law: what acts in the motors that are no setups, which have a law of their own.
        output: folder for sheet.nc, sheet.png, sheet.pdf and sheet.html; None writes nothing.

    Returns:
        Every quantity of `contactlab.datasheet.quantities` and its error, `NAME_error`, over the dimensions
        `law` and `point`. The points are the belts of the speed-torque curve in the order of their velocity,
        and the free rotor; `kind` says what motion was found there, `load` what the load does there, and
        `role` which are `ROLES`. Velocities and torques are in the motor's own sense of rotation, whose sign
        in the model is `sense`.

    Raises:
        ConfigurationError: a setup has a load, which the sheet itself puts onto the motor.
        NoPeriodError: the drive does not repeat itself.
        OSError: the folder cannot be written to.
    """
    listed = [motors] if isinstance(motors, Motor | Setup) else list(motors)
    setups = [steady_setup(motor, law) for motor in listed]
    if not setups:
        raise ConfigurationError(["There is nothing to characterise; give one setup or more."])
    loads = [setup.motor.rotor.load_torque for setup in setups if setup.motor.rotor.load_torque != 0.0]
    if loads:
        raise ConfigurationError(
            [
                f"rotor.load_torque is {loads[0]:.12g} N m; it must be 0 N m: the sheet loads the motor "
                "itself, from beyond stall to beyond no load. Leave it out."
            ]
        )
    data = _dataset(setups)
    if output is not None:
        write(data, Path(output))
    return data


def write(data: xarray.Dataset, folder: Path) -> None:
    """Write sheet.nc, sheet.png, sheet.pdf and sheet.html into a folder, each whole or not at all."""
    # They bring the plotting.
    from contactlab.datasheet.figure import save
    from contactlab.datasheet.page import page

    folder.mkdir(parents=True, exist_ok=True)
    with whole_netcdf(folder / "sheet.nc") as partial:
        data.to_netcdf(partial, engine="netcdf4")
    picture = save(data, folder)
    with whole_file(folder / "sheet.html") as partial:
        partial.write_text(page(data, picture), encoding="utf-8")


def _sheet(setup: Setup) -> tuple[list[Point], dict[str, Number], float]:
    """Characterise one motor: the points of its curve, the free rotor's last, its own numbers, its sense."""
    free = operate(setup)
    velocity, error = free.numbers.get("velocity", UNKNOWN)
    if free.run is None or not abs(velocity) > error:
        return [free], {}, 0.0
    sense = float(np.sign(velocity))
    points = Curve(setup, velocity).points
    memory = np.array([free.run.series[name][0] for name in free.run.lasting])
    stop, coasting = stop_time(setup, free.run.motor, velocity, memory)
    stalled = next(point for point in points if point.belt == 0.0)
    numbers = {
        "no_load_velocity": (abs(velocity), error),
        "curve_root": root(points),
        "stall_torque": stalled.numbers.get("torque", UNKNOWN),
        "holding_torque": holding_torque(setup, velocity),
        "start_time": start_time(setup, velocity),
        "stop_time": stop,
        "coasting_velocity": coasting,
    }
    return [*points, free.turned(sense)], numbers, sense


def _roles(points: Sequence[Point]) -> list[str]:
    """Name the points that have a role."""
    motoring = [point for point in points if point["output_power"] > 0.0]
    role = {id(point): "stall" for point in points if point.belt == 0.0}
    role |= {id(points[-1]): "no load"}
    for name, quantity in zip(ROLES[1:3], BEST, strict=True):
        if (best := greatest(motoring, quantity)) is not None:
            role[id(best)] = f"{role[id(best)]} and efficiency" if id(best) in role else name
    return [role.get(id(point), "") for point in points]


def _loads(points: Sequence[Point]) -> list[str]:
    """Say what the load does at the points, by the quadrant of velocity and torque."""
    quadrants = {(1, 1): "brakes", (-1, 1): "turns the motor back", (1, -1): "drives the motor on"}
    return [
        quadrants.get((np.sign(p["velocity"]), np.sign(p["torque"])), "") if p.belt else "" for p in points
    ]


def _dataset(setups: Sequence[Setup]) -> xarray.Dataset:
    sheets = [_sheet(setup) for setup in setups]
    names = [setup.law.name for setup in setups]
    labels = [f"{n} ({names[:i].count(n) + 1})" if names.count(n) > 1 else n for i, n in enumerate(names)]
    shape = len(setups), max(len(points) for points, *_ in sheets)
    values: dict[str, Any] = {}
    for name, said in POINT.items():
        numbers = np.full((2, *shape), np.nan)
        for i, (points, *_) in enumerate(sheets):
            numbers[:, i, : len(points)] = np.transpose([(p[name], p.error(name)) for p in points])
        values |= _with_error(said, numbers)
    for name, said in MOTOR.items():
        numbers = np.transpose([own.get(name, UNKNOWN) for _, own, _ in sheets])
        values |= _with_error(said, numbers)
    texts = {"kind": lambda points: [p.kind for p in points], "role": _roles, "load": _loads}
    texts["reason"] = lambda points: [point.message for point in points]
    for name, of in texts.items():
        table = np.full(shape, "", dtype=object)
        for i, (points, *_) in enumerate(sheets):
            table[i, : len(points)] = of(points)
        values[name] = ("law", "point"), table.astype(str)
    about = {"units": "1", "long_name": "sign of the motor's sense in the model, 0 where it does not turn"}
    values["sense"] = ("law",), np.array([sense for *_, sense in sheets]), about
    configurations = [yaml.safe_dump(s.configuration, sort_keys=False, allow_unicode=True) for s in setups]
    revision, dirty = checkout_state()
    code = versions()
    return xarray.Dataset(
        values,
        coords={"law": labels, "point": np.arange(shape[1]), "configuration": ("law", configurations)},
        attrs={
            "Conventions": "CF-1.11",
            "title": f"Data sheet of a standing-wave piezoelectric motor: {', '.join(labels)}",
            "source": f"contactlab {code['contactlab_version']}, numerical simulation",
            **code,
            "code_digest": code_digest(),
            "git_revision": revision,
            "git_dirty": dirty,
        },
    )


def _with_error(said: Any, numbers: np.ndarray) -> dict[str, Any]:
    """Give a quantity and its error as variables of a dataset."""
    attributes = cf_attributes(said)
    error = {"units": said.units, "long_name": f"error of the {said.name.replace('_', ' ')}"}
    return {
        said.name: (said.dims, numbers[0], attributes | {"ancillary_variables": f"{said.name}_error"}),
        f"{said.name}_error": (said.dims, numbers[1], error),
    }
