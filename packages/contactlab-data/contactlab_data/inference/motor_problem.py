"""Measured series or operating points of a motor as an inference problem: runs from rest, or steady states.

Residuals are white noise and a discrepancy of the model, an Ornstein-Uhlenbeck process of the standard
deviation delta and the correlation time tau, so that residuals at t_i and t_j have the covariance

    sigma_i^2 (i = j) + delta^2 exp(-|t_i - t_j| / tau)

The process is Markov, so that a Kalman filter of one state yields the density of every residual given those
before it, and their product is that of the multivariate normal, in n steps in place of n^3.

Sources: Uhlenbeck and Ornstein (1930), Phys. Rev. 36, 823; Kalman (1960), J. Basic Eng. 82, 35; of the
discrepancy Kennedy and O'Hagan (2001), J. R. Stat. Soc. B 63, 425.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import exp, inf, lgamma, log, pi, sqrt
from typing import Any, ClassVar, Final, final

import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab import variables
from contactlab.arrays import Array
from contactlab.compiler.kernels import kernel
from contactlab.config import ConfigurationError, build, rebuild
from contactlab.config.faults import as_fault
from contactlab.config.nesting import flat, nested
from contactlab.config.schema import declared_in
from contactlab.laws import LawError
from contactlab.motor.outputs import output_variables
from contactlab.settling.criterion import PRECISION
from contactlab.settling.verdict import configured_period
from contactlab.steady_state import BrokenOffError, NotSettledError, steady
from contactlab.studies.compare.repeats import NEGLIGIBLE, OF_FRICTION, REPEATS, repeated, spread_of
from contactlab.suggestion import suggestion
from contactlab_data.inference.free_parameters import FreeParameter, to_cube
from contactlab_data.inference.impact_problem import STEP
from contactlab_data.inference.known_orbits import KnownOrbits
from contactlab_data.inference.problem import (
    LOG_TWO_PI,
    Problem,
    size_prior,
    student_factor,
    student_shrinkage,
)
from contactlab_data.measured.series import MEASURABLE, VELOCITY, MeasuredPoints, MeasuredSeries

ON_GRID: Final = 1e-3
"""Tolerance of equidistant times, as a share of the interval."""

FINER: Final = 4
"""Number of records within the smallest interval of times that are not equidistant."""

ON_RECORDS: Final = ("normal_force", "friction_force")
"""Series that are means over the interval of records that ends at their time."""

NOISE, DISCREPANCY = "noise", "discrepancy"


@dataclass(frozen=True, eq=False, kw_only=True)
class MotorProblem(Problem):
    """Quantities of a motor; see `Problem`.

    Args:
        measured: the quantities.
        configuration: of the motor by full key, without the free numbers.
        keys: free numbers of law and motor, named by full keys.
        correlation: correlation time of the discrepancy [s]; 0 for no discrepancy.
        degrees_of_freedom: of Student-t noise; infinite is the normal distribution, None is free.
        repeat: name of the motor in `REPEATS`; empty for the motor itself.

    Attributes:
        repeats: names of the motors that are the same one for these data: a series has its own start.
    """

    repeats: ClassVar[tuple[str, ...]] = tuple(OF_FRICTION)

    measured: MeasuredSeries | MeasuredPoints
    configuration: Mapping[str, Any]
    keys: tuple[FreeParameter, ...]
    correlation: float = 0.0
    degrees_of_freedom: float | None = inf
    repeat: str = ""

    @property
    def law(self) -> str:
        """Name of the law."""
        return str(self.configuration["law.name"])

    @property
    def parameters(self) -> tuple[FreeParameter, ...]:
        """The free numbers of law and motor."""
        return self.keys

    @cached_property
    def nuisances(self) -> tuple[FreeParameter, ...]:
        """Noise that is not stated, discrepancy and degrees of freedom."""
        result = []
        for name, series in self.measured.values.items():
            size, units = root_mean_square(series), MEASURABLE[name].units
            if name not in self.measured.errors:
                result.append(size_prior(f"{NOISE}.{name}", units, size, "noise"))
            if self.correlation > 0.0:
                meaning = "amplitude of the discrepancy"
                result.append(size_prior(f"{DISCREPANCY}.{name}", units, size, meaning))
        return (*result, *self.free_tails)

    @property
    def step(self) -> float | None:
        """Step of differences of motions integrated to a tolerance."""
        return STEP

    def chosen(self, values: Array) -> dict[str, Any]:
        """Return the configuration by full key with these values of law and motor."""
        numbers = zip(self.keys, values, strict=False)
        settings = {**self.configuration, **{item.name: float(value) for item, value in numbers}}
        return flat(repeated(build(nested(settings)), self.repeat)) if self.repeat else settings

    def spread(self, values: Array) -> float:
        """Return the range of the misfit over motors that are one, over its size [1]."""
        motors = [self, *(replace(self, repeat=name) for name in self.repeats)]
        misfits = [root_mean_square(motor.residuals(values)) for motor in motors]
        errors = self.measured.errors
        sizes = [x / errors.get(name, root_mean_square(x)) for name, x in self.measured.values.items()]
        return float(spread_of(np.array(misfits), least=NEGLIGIBLE * root_mean_square(np.concatenate(sizes))))

    def residuals(self, values: Array) -> Array:
        """Return measured minus predicted over the noise, the size of a quantity where it has no value."""
        predicted, measured, tails = self.predict(values), self.measured.values, self.tails(values)
        if predicted is None:
            return np.full(sum(x.size for x in measured.values()), np.nan)
        every = []
        for name, series in measured.items():
            missed, deviation = self.innovations(name, series - predicted[name], values)
            every.append(missed / deviation * student_shrinkage((missed / deviation) ** 2, tails, 1))
        return np.concatenate(every)

    def log_densities(
        self, predicted: Mapping[str, Array], values: Array, observed: Mapping[str, Array] | None = None
    ) -> dict[str, Array]:
        """Return the log density of each datum given those before it, by name."""
        tails, result = self.tails(values), {}
        for name, series in (self.measured.values if observed is None else observed).items():
            missed, deviation = self.innovations(name, series - predicted[name], values)
            if tails < inf:
                result[name] = student_log_densities(missed, deviation, tails)
            else:
                result[name] = -0.5 * (LOG_TWO_PI + (missed / deviation) ** 2) - np.log(deviation)
        return result

    def innovations(self, name: str, missed: Array, values: Array) -> tuple[Array, Array]:
        """Return residuals less what those before them make likely, and their standard deviations."""
        return missed, self.noise(name, values)

    def replicate(
        self, predicted: Mapping[str, Array], values: Array, draws: np.random.Generator
    ) -> dict[str, Array]:
        """Draw data: prediction, discrepancy and noise."""
        tails, made = self.tails(values), {}
        for name, series in predicted.items():
            noise = self.noise(name, values) * draws.standard_normal(series.size)
            made[name] = series + noise * student_factor(draws, tails, series.size)
            if (amplitude := self.amplitude(name, values)) > 0.0:
                assert isinstance(self.measured, MeasuredSeries)
                path = draws.standard_normal(series.size)
                ornstein_uhlenbeck(path, self.measured.time, amplitude, self.correlation)
                made[name] += path
        return made

    def noise(self, name: str, values: Array) -> Array:
        """Return the standard deviation of the noise of each datum."""
        if name in self.measured.errors:
            return self.measured.errors[name]
        series = self.measured.values[name]
        return self.value(values, f"{NOISE}.{name}", root_mean_square(series)) * np.ones(series.size)

    def amplitude(self, name: str, values: Array) -> float:
        """Return the standard deviation of the discrepancy."""
        return self.value(values, f"{DISCREPANCY}.{name}", 0.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class OverTime(MotorProblem):
    """Quantities over time; see `Problem`; times are those of the data."""

    measured: MeasuredSeries

    @cached_property
    def data(self) -> xarray.Dataset:
        """The series."""
        series = {n: ("time", x, {"units": MEASURABLE[n].units}) for n, x in self.measured.values.items()}
        return xarray.Dataset(series, {"time": self.measured.time})

    def innovations(self, name: str, missed: Array, values: Array) -> tuple[Array, Array]:
        """Return residuals less what those before them make likely, and their deviations: a Kalman filter."""
        noise, amplitude = self.noise(name, values), self.amplitude(name, values)
        if amplitude == 0.0:
            return missed, noise
        result, deviation = np.empty((2, missed.size))
        filtered(missed, self.measured.time, noise, amplitude, self.correlation, result, deviation)
        return result, deviation


@final
@dataclass(frozen=True, eq=False, kw_only=True)
class SeriesProblem(OverTime):
    """Series of a motor.

    Args:
        interval: of the records [s].
        places: indices of the records at the times of the data; None where they lie between records.
    """

    interval: float
    places: NDArray[np.int64] | None

    def predict(self, values: Array) -> dict[str, Array] | None:
        """Return the series of the run at the times of the data, by name; None if it ends before."""
        try:
            run = build(nested(self.chosen(values))).run(record_interval=self.interval)
        # Values that are admitted one by one need not be so together.
        except (ConfigurationError, LawError, ValueError):
            return None
        if not run.ending.reached_end:
            return None
        series = {name: run.series[name] for name in self.measured.values}
        if self.places is None:
            return {name: np.interp(self.measured.time, run.time, x) for name, x in series.items()}
        return {name: x[self.places] for name, x in series.items()}


def series_problem(
    measured: MeasuredSeries,
    configuration: Mapping[str, Any],
    keys: Sequence[FreeParameter],
    *,
    discrepancy: bool,
    degrees_of_freedom: float | None = inf,
) -> SeriesProblem:
    """Return the problem of a motor's series.

    Args:
        configuration: of a run, checked; duration and records follow from the data.
        keys: free numbers, named by full keys.
        discrepancy: whether the law may be wrong, by a process with the drive's period as correlation time.
        degrees_of_freedom: of Student-t noise; infinite is the normal distribution, None is free.

    Raises:
        ConfigurationError: a discrepancy with Student-t noise, whose likelihood has no closed form, a
            current or charge of an unknown capacitance, forces at times that are not equidistant, or a drive
            without a period.
    """
    interval, places = records_at(measured.time)
    if places is None and (odd := [name for name in measured.values if name in ON_RECORDS]):
        raise ConfigurationError(
            f"{', '.join(odd)} is measured at times that are no multiples of one interval; it must be, "
            "since forces are means over intervals. Leave it out of series, or put it on a grid."
        )
    computed = {*variables.SERIES, *output_variables(rebuild(configuration).motor.modes)}
    if unknown := set(measured.values) - {each.name for each in computed}:
        raise ConfigurationError(
            f"{', '.join(sorted(unknown))} is measured, but the resonator has no such capacitance. Give "
            "it one (capacitance_1_1 of a resonator.file), or leave it out of series."
        )
    period = configured_period(configuration)
    if discrepancy and not period > 0.0:
        raise ConfigurationError(
            "The drive has no period, the discrepancy's correlation time. Leave discrepancy out."
        )
    check_noise(discrepancy, degrees_of_freedom)
    duration = max(float(measured.time[-1]), interval)
    times = {"solver.duration": duration, "solver.until": "duration", "solver.precision": PRECISION}
    settings = {**flat(configuration), **times, "record.interval": interval}
    step = settings.get("solver.contact_step")
    settings["solver.contact_step"] = None if step is None else min(step, duration)
    return SeriesProblem(
        measured=measured,
        configuration=settings,
        keys=tuple(keys),
        interval=interval,
        places=places,
        correlation=period if discrepancy else 0.0,
        degrees_of_freedom=degrees_of_freedom,
    )


def check_noise(discrepancy: bool, degrees_of_freedom: float | None) -> None:
    """Raise a ConfigurationError for a discrepancy with Student-t noise."""
    if discrepancy and degrees_of_freedom != inf:
        raise ConfigurationError(
            "Student-t noise and a discrepancy of a series cannot be combined. Leave one out."
        )


def records_at(time: Array) -> tuple[float, NDArray[np.int64] | None]:
    """Return an interval of records [s] and the indices of times among them; None for other times."""
    interval = float(np.median(np.diff(time)))
    # The last time has the most digits.
    steps = np.round(time / interval)
    if steps[-1] > 0.0:
        interval = float(time[-1] / steps[-1])
    if np.abs(time - steps * interval).max() <= ON_GRID * interval and (np.diff(steps) > 0.0).all():
        return interval, steps.astype(np.int64)
    return float(np.diff(time).min()) / FINER, None


def root_mean_square(values: Array) -> float:
    """Return the size of a series without its gaps, one where it is zero."""
    return float(np.sqrt(np.mean(values[~np.isnan(values)] ** 2))) or 1.0


@kernel
def filtered(
    residuals: Array,
    time: Array,
    white: Array,
    amplitude: float,
    correlation: float,
    missed: Array,
    deviation: Array,
) -> None:
    """Write the innovations of a series, residuals less their mean given those before, and their deviations.

    Args:
        residuals: measured minus predicted, shape (time,), in any unit.
        time: increasing [s].
        white: standard deviation of each one's noise, shape (time,), positive, in the unit of the residuals.
        amplitude: standard deviation of the discrepancy in that unit; 0 is none.
        correlation: its correlation time [s].
        missed, deviation: shape (time,).
    """
    mean, variance, stationary = 0.0, amplitude * amplitude, amplitude * amplitude
    for i in range(residuals.size):
        if i > 0:
            kept = exp(-(time[i] - time[i - 1]) / correlation)
            mean *= kept
            variance = kept * kept * variance + (1.0 - kept * kept) * stationary
        total = variance + white[i] * white[i]
        missed[i] = residuals[i] - mean
        deviation[i] = sqrt(total)
        gain = variance / total
        mean += gain * missed[i]
        variance *= 1.0 - gain


@kernel
def ornstein_uhlenbeck(normals: Array, time: Array, amplitude: float, correlation: float) -> None:
    """Turn standard normal numbers into an Ornstein-Uhlenbeck process, in place."""
    for i in range(normals.size):
        if i == 0:
            normals[i] *= amplitude
        else:
            kept = exp(-(time[i] - time[i - 1]) / correlation)
            normals[i] = kept * normals[i - 1] + amplitude * sqrt(1.0 - kept * kept) * normals[i]


def student_log_densities(residuals: Array, scale: Array, degrees_of_freedom: float) -> Array:
    """Return the log density of independent residuals with Student-t distributions, shape as the residuals.

    Args:
        residuals: measured minus predicted, in any unit.
        scale: of each one's distribution, positive, in that unit.
        degrees_of_freedom: positive, finite.
    """
    half = 0.5 * degrees_of_freedom
    constant = lgamma(half + 0.5) - lgamma(half) - 0.5 * log(degrees_of_freedom * pi)
    square = (residuals / scale) ** 2
    return np.asarray(constant - np.log(scale) - (half + 0.5) * np.log1p(square / degrees_of_freedom))


@final
@dataclass(frozen=True, eq=False, kw_only=True)
class PointsProblem(MotorProblem):
    """See `Problem`.

    Args:
        points: values of the keys of each point, in SI.
        units: of the first key.
        known: orbits that steady states follow; None for motors that come from rest.
    """

    repeats: ClassVar[tuple[str, ...]] = REPEATS

    measured: MeasuredPoints
    points: tuple[Mapping[str, float], ...]
    units: str
    known: KnownOrbits | None = None

    @property
    def data(self) -> xarray.Dataset:
        """The velocities, over the first key of the points."""
        key = self.measured.keys[0]
        coordinate = ("point", np.array([each[key] for each in self.points]), {"units": self.units})
        velocity = ("point", self.measured.values[VELOCITY], {"units": "rad s-1"})
        return xarray.Dataset({VELOCITY: velocity}, {key: coordinate})

    def predict(self, values: Array) -> dict[str, Array] | None:
        """Return the settled velocities by name; None where the motor has no steady state at a point."""
        chosen, velocities = self.chosen(values), []
        shares = to_cube(self.keys, values[: len(self.keys)])
        try:
            for number, point in enumerate(self.points):
                setup = build(nested({**chosen, **point}))
                state = steady(setup) if self.known is None else self.known.steady(number, shares, setup)
                velocities.append(state.velocity.value)
        # Values that are admitted one by one need not be so together.
        except (ConfigurationError, LawError, NotSettledError, BrokenOffError, ValueError):
            return None
        return {VELOCITY: np.array(velocities)}

    def following(self, values: Array | None = None) -> Problem:
        """Return the problem whose steady states follow those found before, or those at some values."""
        problem = replace(self, known=(known := KnownOrbits()))
        if values is not None:
            problem.predict(values)
            known.complete()
        return problem


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
        with as_fault("The data: "):
            columns[key] = measured.table.numbers(key, declared[key].units).tolist()
    points = tuple(dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True))
    settings = flat(configuration)
    for point in points:
        build(nested({**settings, **point}))
    return PointsProblem(
        measured=measured,
        configuration=settings,
        keys=tuple(keys),
        points=points,
        units=declared[measured.keys[0]].units,
        degrees_of_freedom=degrees_of_freedom,
    )
