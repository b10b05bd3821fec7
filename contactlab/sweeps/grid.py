"""Motors over all combinations of some parameters, run in one go from Python."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from math import prod
from typing import Any, final

import numpy as np
import xarray

from contactlab.checks import check_kind
from contactlab.config import Setup
from contactlab.engine.arguments import default_contact_step
from contactlab.laws import ContactLaw
from contactlab.motor.motor import Motor
from contactlab.results.netcdf import cf_attributes
from contactlab.results.provenance import versions
from contactlab.sweeps.cells import Axis, dataset_of
from contactlab.sweeps.many import USUAL, Report, wanted_of
from contactlab.sweeps.workers import Pool, processors
from contactlab.variables import SERIES


@final
@dataclass(frozen=True)
class MotorGrid:
    """A motor for every combination of some parameters.

        MotorGrid(
            {"clearance": np.linspace(0.0, 2e-6, 100), "phase": np.linspace(-np.pi, np.pi, 100)},
            lambda clearance, phase: Motor(modes, drive_with(phase), ContactGeometry(clearance=clearance)),
        )

    Args:
        axes: the values of every parameter, in the order of the answer's dimensions. An `Axis` brings
            its unit with it.
        motor: makes the motor from the parameters, given by name. What it raises makes the run a
            failed one.

    Raises:
        ValueError: there is no parameter, or one without a value.
    """

    axes: Mapping[str, Sequence[float] | Axis]
    motor: Callable[..., Motor]

    def __post_init__(self) -> None:
        empty = [axis.name for axis in self.parameters if not axis.values]
        if empty or not self.axes:
            raise ValueError(
                f"{', '.join(empty) or 'The grid'} has no values; there must be one at least of every "
                "parameter, and one parameter at least. Give a list or an array of numbers."
            )

    @cached_property
    def parameters(self) -> tuple[Axis, ...]:
        """The axes with their values as numbers."""
        return tuple(
            Axis(name, tuple(map(float, given.values)), given.units)
            if isinstance(given, Axis)
            else Axis(name, tuple(map(float, given)))
            for name, given in self.axes.items()
        )

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each parameter."""
        return tuple(len(axis.values) for axis in self.parameters)

    def point(self, cell: int) -> dict[str, float]:
        """The parameters of a cell; the last one changes first."""
        places = np.unravel_index(cell, self.shape)
        return {
            axis.name: float(axis.values[int(place)])
            for axis, place in zip(self.parameters, places, strict=True)
        }


def simulate_many(
    motors: MotorGrid,
    law: ContactLaw | Callable[..., ContactLaw],
    *,
    duration: float,
    record_interval: float | None = None,
    contact_step: float | None = None,
    tolerance: float | None = None,
    metrics: Sequence[str] = USUAL,
    series: Sequence[str] = (),
    workers: int | None = None,
    report: Report | None = None,
) -> xarray.Dataset:
    """Run a law on a grid of motors.

    Every number is that of the run alone to the last bit, whatever the number of workers.

    Args:
        motors: what moves.
        law: what acts between tip and rotor, or a function that makes it from the parameters.
        duration: [s].
        record_interval: time between records [s]; None keeps but the last, which `USUAL` and the
            other metrics of `contactlab.sweeps.many.AT_ANY_INTERVAL` are content with.
        contact_step, tolerance: as for `contactlab.engine.simulate`.
        metrics: keys of `contactlab.metrics.METRICS`.
        series: names of `contactlab.variables.SERIES` that are kept whole, each as NAME_series.
        workers: processes at work; None is one a processor.
        report: told now and then how many runs have ended since the last time.

    Returns:
        The metrics over the parameters, with `status` (see `contactlab.sweeps.status.Status`) and `reason`
        of every run; a run that is not complete has NaN.

    Raises:
        TypeError: what is no grid of motors, or neither a law nor a function.
        ValueError: a metric or series that there is not, or records that are needed and not asked for.
        WorkerError: a worker process died.
    """
    check_kind("The grid", motors, MotorGrid)
    if not callable(law):
        check_kind("The law", law, ContactLaw)
    wanted = wanted_of(metrics, series)
    if wanted.sampled and record_interval is None:
        raise ValueError(
            "The record interval is None; series, and metrics beyond "
            "contactlab.sweeps.many.AT_ANY_INTERVAL, need records. Give a record_interval in seconds."
        )

    def setup_at(cell: int) -> Setup:
        point = motors.point(cell)
        acting = law if isinstance(law, ContactLaw) else law(**point)
        motor = motors.motor(**point)
        return Setup(
            motor=motor,
            law=acting,
            duration=duration,
            record_interval=record_interval or duration,
            contact_step=default_contact_step(motor.modes, acting)
            if contact_step is None
            else contact_step,
            tolerance=tolerance,
            configuration=_facts(motor, acting),
        )

    count = prod(motors.shape)
    with Pool(setup_at, wanted, workers or processors()) as pool:
        found = pool.answers(range(count), report)
    columns = zip(wanted.metrics, found.metrics.T, strict=True)
    dataset = dataset_of(
        motors.parameters,
        {key: column.reshape(motors.shape) for key, column in columns},
        found.status.reshape(motors.shape),
        np.array(found.reason, dtype=object).reshape(motors.shape),
        {"duration": duration, **versions()},
    )
    dims = tuple(axis.name for axis in motors.parameters)
    said = {variable.name: variable for variable in SERIES}
    for name, rows in found.series.items():
        shaped = rows.reshape(*motors.shape, found.time.size)
        dataset[f"{name}_series"] = ((*dims, "time"), shaped, cf_attributes(said[name]))
    return dataset.assign_coords(time=found.time) if wanted.series else dataset


def _facts(motor: Motor, law: ContactLaw) -> dict[str, Any]:
    """What the metrics ask of the configuration, where there is none but the motor itself."""
    facts: dict[str, Any] = {
        "law": {"name": law.name, **law.describe()},
        "rotor": {"radius": motor.geometry.rotor_radius, **asdict(motor.rotor)},
        "contact": {"clearance": motor.geometry.clearance},
    }
    if motor.drive.frequency.size:
        facts["drive"] = {"frequency": float(motor.drive.frequency[0])}
    if (friction := law.describe().get("friction_coefficient")) is not None:
        facts["contact"]["friction_coefficient"] = friction
    return facts
