"""Operating points of a settled motor as an inference problem: predictions are steady states."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, build
from contactlab.config.nesting import flat, nested
from contactlab.config.schema import declared_in
from contactlab.inference.free_parameters import FreeParameter
from contactlab.inference.problem import LOG_TWO_PI
from contactlab.inference.series_problem import MotorProblem
from contactlab.laws import LawError
from contactlab.measured.points import VELOCITY, MeasuredPoints
from contactlab.motor.table import MeasurementError
from contactlab.steady_state import BrokenOffError, NotSettledError, steady
from contactlab.suggestion import suggestion


@final
@dataclass(frozen=True, eq=False, kw_only=True)
class PointsProblem(MotorProblem):
    """See `Problem`.

    Args:
        points: values of the keys of each point, in SI.
        units: of the first key.
    """

    measured: MeasuredPoints
    points: tuple[Mapping[str, float], ...]
    units: str

    @property
    def data(self) -> xarray.Dataset:
        """The velocities, over the first key of the points."""
        key = self.measured.keys[0]
        coordinate = ("point", np.array([each[key] for each in self.points]), {"units": self.units})
        velocity = ("point", self.measured.values[VELOCITY], {"units": "rad s-1"})
        return xarray.Dataset({VELOCITY: velocity}, {key: coordinate})

    def predict(self, values: Array) -> dict[str, Array] | None:
        """Return the settled velocities by name; None where the motor has no steady state at a point."""
        chosen = self.chosen(values)
        try:
            velocities = [steady(build(nested({**chosen, **point}))).velocity.value for point in self.points]
        # Values that are admitted one by one need not be so together.
        except (ConfigurationError, LawError, NotSettledError, BrokenOffError, ValueError):
            return None
        return {VELOCITY: np.array(velocities)}

    def normal_log_densities(self, missed: Array, noise: Array, amplitude: float) -> Array:
        """Return the log density of each residual; points have no discrepancy."""
        del amplitude
        return np.asarray(-0.5 * (LOG_TWO_PI + (missed / noise) ** 2) - np.log(noise))


def points_problem(
    measured: MeasuredPoints,
    configuration: Mapping[str, Any],
    keys: Sequence[FreeParameter],
    *,
    degrees_of_freedom: float | None = inf,
) -> PointsProblem:
    """Return the problem of a motor's operating points.

    Raises:
        ConfigurationError: a column is no number of the configuration, has another unit, or is free as well.
    """
    declared, columns = declared_in(configuration), {}
    for key in measured.keys:
        if key not in declared:
            hint = suggestion(key, declared, "contactlab --help lists the keys.")
            raise ConfigurationError(f"The data have a column {key}, which is no number of the motor. {hint}")
        if key in [item.name for item in keys]:
            raise ConfigurationError(f"{key} is free and a column of the data; it must be one of them.")
        try:
            columns[key] = measured.table.numbers(key, declared[key].units).tolist()
        except MeasurementError as error:
            raise ConfigurationError(f"The data: {error}") from error
    points = tuple(dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
    settings = flat(configuration)
    for point in points:
        build(nested({**settings, **point}))
    units = declared[measured.keys[0]].units
    return PointsProblem(
        measured=measured,
        configuration=settings,
        keys=tuple(keys),
        points=points,
        units=units,
        degrees_of_freedom=degrees_of_freedom,
    )
