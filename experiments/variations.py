"""Variations of the configured motor, its sweeps and its settled states under several laws."""

import sys
from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any, ClassVar

import numpy as np
import pandas
import xarray
from experiment import Experiment, part_of

import contactlab as cl
from contactlab.config.nesting import flat, nested
from contactlab.metrics import Run, assess
from contactlab.steady_state import BrokenOffError, NotSettledError
from contactlab.studies.run_state import Status
from contactlab.studies.study import Part, Setups, Task

STIFFNESS = 1e10
"""Stiffness of a Hertz contact where a rigid law is configured [N/m^1.5]: a 5 mm steel tip."""

CHUNK = 12
"""Steady states of one task."""

Cell = tuple[cl.Motor, cl.ContactLaw, Sequence[str]]
"""Motor, law and metrics of a steady state."""


def changed(setup: cl.Setup, changes: Mapping[str, object]) -> cl.Setup:
    """Return the setup with other values of some full keys."""
    return cl.build(nested({**flat(setup.configuration), **changes}))


def placed(setup: cl.Setup, start: float, end: float) -> cl.NormalModes:
    """Return the modes of the configured resonator with another placement of the first patch [m]."""
    return changed(setup, {"placement.start": start, "placement.end": end}).motor.modes


def tip_phasors(modes: cl.NormalModes, drive: cl.Drive) -> tuple[np.ndarray, np.ndarray]:
    """Return the phasors of tip displacement [m] and slope [rad] in steady vibration, shape (tone,)."""
    w = drive.angular_frequency
    dynamic = modes.stiffness[:, None] + 1j * modes.damping[:, None] * w - w**2
    steady = (modes.coupling @ drive.phasors) / dynamic
    return modes.tip_displacement @ steady, modes.tip_slope @ steady


def with_clearance(motor: cl.Motor, clearance: float) -> cl.Motor:
    """Return the motor with another clearance [m]."""
    return replace(motor, geometry=replace(motor.geometry, clearance=clearance))


def laws_of(setup: cl.Setup) -> dict[str, cl.ContactLaw]:
    """Return the paper's three laws with the configured friction, and stiffness if the law has one."""
    mu = setup.configuration["contact"]["friction_coefficient"]
    stiffness = setup.configuration["law"].get("stiffness") or STIFFNESS
    return {
        "lagrange_slip": cl.LagrangeSlip(mu),
        "lagrange_stick": cl.LagrangeStick(mu),
        "hertz_penalty": cl.HertzPenalty(stiffness, mu),
    }


def quantity(numbers: Sequence[float] | np.ndarray, units: str) -> xarray.DataArray:
    """Return the values of a swept parameter with their unit."""
    return xarray.DataArray(np.asarray(numbers), attrs={"units": units})


def swept(
    setup: cl.Setup,
    over: Mapping[str, object],
    *,
    motor: Callable[..., cl.Motor] | None = None,
    laws: Mapping[str, cl.ContactLaw] | None = None,
    duration: float | None = None,
    record_interval: float | None = None,
    **options: Any,
) -> xarray.Dataset:
    """Return a sweep of transients under every law, which is the first dimension.

    A run that is not complete has NaN; its reason is printed.

    Args:
        setup: the configured motor.
        over: values by name.
        motor: makes the motor from them; None is the configured one.
        laws: by name; None is all three.
        duration: that of the setup by default [s].
        record_interval: as of `contactlab.simulate` [s].
        options: of `contactlab.sweep`.
    """
    laws, runs = laws or laws_of(setup), []

    def made(law: cl.ContactLaw, **values: Any) -> cl.Setup:
        moved = motor(**values) if motor else setup.motor
        return cl.Setup.of(moved, law, duration or setup.duration, record_interval)

    for name, law in laws.items():
        data = cl.sweep(over, partial(made, law), **options)
        report({f"{name}: {reason}" for reason in {*data.reason.values.ravel()} - {""}})
        runs.append(data.drop_vars(["status", "reason"]).where(data.status == Status.COMPLETE))
    every = xarray.concat(runs, pandas.Index([*laws], name="law")).drop_attrs(deep=False)
    if "time" in every:
        every.time.attrs["units"] = "s"
    return every


def report(reasons: set[str]) -> None:
    """Print why numbers are missing."""
    for reason in sorted(reasons):
        print(reason, file=sys.stderr)


def settled(cells: Sequence[Cell]) -> Part:
    """Compute steady states; the mean over a long run where a motor has no periodic motion.

    The dataset has, over `cell`, the mean `rotor_velocity`, its `error`, the number of `periods` of the
    drive after which the motion repeats itself (0 for never), the `settling_time` in which small
    deviations fall by e, and the metrics. Where there is no steady state, numbers are NaN.
    """
    names = ("rotor_velocity", "error", "periods", "settling_time")
    rows, reasons = [], set()
    for motor, law, metrics in cells:
        try:
            state = cl.steady(motor, law).details
        except (BrokenOffError, NotSettledError) as error:
            reasons.add(f"{law.name}: {error}")
            rows.append(dict.fromkeys((*names, *metrics), np.nan))
            continue
        time = state.orbit.settling_time if state.orbit else np.nan
        values = assess(Run.of_trajectory(state.motion, {}), metrics) if metrics else {}
        rows.append(dict(zip(names, (*state.velocity, state.periods, time), strict=True)) | values)
    report(reasons)
    columns = pandas.DataFrame(rows)
    return part_of(xarray.Dataset({name: ("cell", columns[name].to_numpy()) for name in columns}))


class SettledMap(Experiment):
    """Base class of experiments on steady states under several laws over values of parameters."""

    metrics: ClassVar[tuple[str, ...]]
    """Keys of `contactlab.metrics.METRICS`."""

    @abstractmethod
    def axes(self, setup: cl.Setup) -> dict[str, xarray.DataArray]:
        """Return the values by name."""

    @abstractmethod
    def laws(self, setup: cl.Setup) -> dict[str, cl.ContactLaw]:
        """Return the laws by name."""

    @abstractmethod
    def varied(self, setup: cl.Setup, law: cl.ContactLaw, **values: float) -> tuple[cl.Motor, cl.ContactLaw]:
        """Return motor and law with some values."""

    def tasks(self, setups: Setups) -> Iterator[Task]:
        """Yield tasks of `CHUNK` steady states each."""
        (setup,) = setups.values()
        axes = self.axes(setup)
        cells: list[Cell] = []
        for law in self.laws(setup).values():
            for values in product(*(values.values.tolist() for values in axes.values())):
                made = self.varied(setup, law, **dict(zip(axes, values, strict=True)))
                cells.append((*made, self.metrics))
        for first in range(0, len(cells), CHUNK):
            yield Task(f"{first:06d}", settled, (cells[first : first + CHUNK],))

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return the steady states over law and values."""
        cells, axes, laws = xarray.concat(parts, "cell"), self.axes(setup), [*self.laws(setup)]
        shape = (len(laws), *(values.size for values in axes.values()))
        return xarray.Dataset(
            {name: (("law", *axes), column.values.reshape(shape)) for name, column in cells.items()},
            coords={"law": laws, **{name: (name, v.values, v.attrs) for name, v in axes.items()}},
        )
