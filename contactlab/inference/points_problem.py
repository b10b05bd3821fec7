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
from contactlab.inference.impact_problem import STEP
from contactlab.inference.problem import LOG_TWO_PI, Problem, size_prior, student_factor
from contactlab.inference.series_problem import NOISE, root_mean_square, student_log_densities
from contactlab.laws import LawError
from contactlab.measured.points import VELOCITY, MeasuredPoints
from contactlab.motor.table import MeasurementError
from contactlab.steady_state import BrokenOffError, NotSettledError, steady
from contactlab.suggestion import suggestion


@final
@dataclass(frozen=True, eq=False)
class PointsProblem(Problem):
    """See `Problem`.

    Args:
        measured: the points.
        configuration: of the motor by full key, without free numbers and those of the points.
        points: values of the keys of each point, in SI.
        units: of the first key.
        keys: free numbers of law and motor, named by full keys.
        degrees_of_freedom: of Student-t noise; infinite is the normal distribution, None is free.
    """

    measured: MeasuredPoints
    configuration: Mapping[str, Any]
    points: tuple[Mapping[str, float], ...]
    units: str
    keys: tuple[FreeParameter, ...]
    degrees_of_freedom: float | None = inf

    @property
    def law(self) -> str:
        """Name of the law."""
        return str(self.configuration["law.name"])

    @property
    def parameters(self) -> tuple[FreeParameter, ...]:
        """The free numbers of law and motor."""
        return self.keys

    @property
    def nuisances(self) -> tuple[FreeParameter, ...]:
        """Noise that is not stated, and degrees of freedom."""
        name, size = f"{NOISE}.{VELOCITY}", root_mean_square(self.measured.values[VELOCITY])
        noise = () if self.measured.errors else (size_prior(name, "rad s-1", size, "noise"),)
        return (*noise, *self.free_tails)

    @property
    def data(self) -> xarray.Dataset:
        """The velocities, over the first key of the points."""
        key = self.measured.keys[0]
        coordinate = ("point", np.array([each[key] for each in self.points]), {"units": self.units})
        velocity = ("point", self.measured.values[VELOCITY], {"units": "rad s-1"})
        return xarray.Dataset({VELOCITY: velocity}, {key: coordinate})

    @property
    def step(self) -> float | None:
        """Step of differences of steady states, whose contacts are integrated to a tolerance."""
        return STEP

    def predict(self, values: Array) -> dict[str, Array] | None:
        """Return the settled velocities by name; None where the motor has no steady state at a point."""
        chosen = {item.name: float(value) for item, value in zip(self.keys, values, strict=False)}
        try:
            velocities = [
                steady(build(nested({**self.configuration, **chosen, **point}))).velocity.value
                for point in self.points
            ]
        # Values that are admitted one by one need not be so together.
        except (ConfigurationError, LawError, NotSettledError, BrokenOffError, ValueError):
            return None
        return {VELOCITY: np.array(velocities)}

    def residuals(self, values: Array) -> Array:
        """Return measured minus predicted over the stated noise, or over the size of the velocities."""
        predicted, measured = self.predict(values), self.measured.values[VELOCITY]
        if predicted is None:
            return np.full(measured.size, np.nan)
        return (measured - predicted[VELOCITY]) / self.measured.errors.get(
            VELOCITY, root_mean_square(measured)
        )

    def log_densities(
        self, predicted: Mapping[str, Array], values: Array, observed: Mapping[str, Array] | None = None
    ) -> dict[str, Array]:
        """Return the log density of each velocity."""
        measured = self.measured.values if observed is None else observed
        missed, noise = measured[VELOCITY] - predicted[VELOCITY], self._noise(values)
        if (tails := self.tails(values)) < inf:
            return {VELOCITY: student_log_densities(missed, noise, tails)}
        return {VELOCITY: -0.5 * (LOG_TWO_PI + (missed / noise) ** 2) - np.log(noise)}

    def replicate(
        self, predicted: Mapping[str, Array], values: Array, draws: np.random.Generator
    ) -> dict[str, Array]:
        """Draw velocities: prediction and noise."""
        count = predicted[VELOCITY].size
        noise = self._noise(values) * draws.standard_normal(count)
        return {VELOCITY: predicted[VELOCITY] + noise * student_factor(draws, self.tails(values), count)}

    def _noise(self, values: Array) -> Array:
        """Return the standard deviation of the noise of each velocity [rad/s]."""
        if self.measured.errors:
            return self.measured.errors[VELOCITY]
        return self.value(values, f"{NOISE}.{VELOCITY}", 0.0) * np.ones(len(self.points))


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
            raise ConfigurationError(
                [f"The data have a column {key}, which is no number of the motor. {hint}"]
            )
        if key in [item.name for item in keys]:
            raise ConfigurationError([f"{key} is free and a column of the data; it must be one of them."])
        try:
            columns[key] = measured.table.numbers(key, declared[key].units).tolist()
        except MeasurementError as error:
            raise ConfigurationError([f"The data: {error}"]) from error
    points = tuple(dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
    settings = flat(configuration)
    for point in points:
        build(nested({**settings, **point}))
    units = declared[measured.keys[0]].units
    return PointsProblem(measured, settings, points, units, tuple(keys), degrees_of_freedom)
