"""Measured series of a motor under one law: a run for every set of values, compared at the data's times."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Any, Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, build
from contactlab.config.nesting import flat, nested
from contactlab.datasheet.electrodes import currents
from contactlab.inference.free_parameters import Free
from contactlab.inference.likelihood import series_terms, student_factor, student_terms, wandering
from contactlab.inference.problem import DEGREES_OF_FREEDOM, Measured, size_prior
from contactlab.laws import LawError
from contactlab.measured.series import CURRENTS, MEASURABLE, MeasuredSeries
from contactlab.settling.periods import period_told
from contactlab.settling.until import PRECISION
from contactlab.trajectory import Trajectory

ON_GRID: Final = 1e-3
"""Part of an interval by which times of equal distance may be off."""

FINER: Final = 4
"""How many records lie in the shortest distance of times that are not of equal distance."""

MEANS: Final = ("normal_force", "friction_force")
ON_RECORDS: Final = (*MEANS, *(one.name for one in CURRENTS))
"""What is only known at the records of a run, and not between."""

NOISE, DISCREPANCY = "noise", "discrepancy"


@final
@dataclass(frozen=True, eq=False)
class SeriesModel:
    """See `contactlab.inference.problem.Model`.

    Args:
        measured: the series.
        configuration: the run's, checked, without what is free; times are those of the data.
        keys: what of law and motor is free, named by full keys.
        interval: of the records [s].
        places: of the records at the times of the data; None where they lie between records.
        correlation: time of the discrepancy [s], the drive's period; 0 for none.
        degrees_of_freedom: of the Student-t distribution of the noise; infinite is the normal one, None is
            free.
    """

    measured: MeasuredSeries
    configuration: Mapping[str, Any]
    keys: tuple[Free, ...]
    interval: float
    places: Array | None
    correlation: float
    degrees_of_freedom: float | None = inf
    free: tuple[Free, ...] = field(init=False)

    def __post_init__(self) -> None:
        noises = []
        for one in self.data:
            # What is constant but for noise would have no size of its own.
            size = float(np.sqrt(np.mean(one.values**2))) or 1.0
            if one.name not in self.measured.errors:
                noises.append(size_prior(f"{NOISE}.{one.name}", one.units, size, "noise"))
            if self.correlation > 0.0:
                said = "amplitude of the discrepancy"
                noises.append(size_prior(f"{DISCREPANCY}.{one.name}", one.units, size, said))
        if self.degrees_of_freedom is None:
            noises.append(DEGREES_OF_FREEDOM)
        object.__setattr__(self, "free", (*self.keys, *noises))

    @property
    def law(self) -> str:
        """Name of the law."""
        return str(self.configuration["law.name"])

    @property
    def physical(self) -> int:
        """How many of what is free belong to law and motor."""
        return len(self.keys)

    @property
    def data(self) -> tuple[Measured, ...]:
        """The series."""
        return tuple(
            Measured(name, ("time",), values, MEASURABLE[name].units)
            for name, values in self.measured.values.items()
        )

    @property
    def coordinates(self) -> dict[str, Array]:
        """The times."""
        return {"time": self.measured.time}

    def run(self, values: Array) -> Trajectory | None:
        """Run the motor with these values of what is free of law and motor; None where it cannot."""
        given = {one.name: float(value) for one, value in zip(self.keys, values, strict=False)}
        try:
            run = build(nested({**self.configuration, **given})).run(record_interval=self.interval)
        # Values that are sound one by one need not be so together.
        except (ConfigurationError, LawError, ValueError):
            return None
        return run if run.ending.reached_end else None

    def predicted(self, values: Array) -> dict[str, Array] | None:
        """Give what the run has at the times of the data, by name; None where it has not reached them."""
        run = self.run(values)
        if run is None:
            return None
        series = dict(run.series)
        if any(one.name in self.measured.values for one in CURRENTS):
            series |= dict(zip((one.name for one in CURRENTS), currents(run), strict=True))
        if self.places is None:
            return {
                name: np.interp(self.measured.time, run.time, series[name]) for name in self.measured.values
            }
        places = self.places.astype(np.int64)
        return {name: series[name][places] for name in self.measured.values}

    def residuals(self, values: Array) -> Array:
        """Give measured minus predicted over the stated noise, or over the size of the series."""
        found = self.predicted(values)
        if found is None:
            return np.full(self.measured.time.size * len(self.measured.values), np.nan)
        return np.concatenate(
            [
                (one.values - found[one.name])
                / self.measured.errors.get(one.name, np.sqrt(np.mean(one.values**2)) or 1.0)
                for one in self.data
            ]
        )

    def terms(self, predicted: Mapping[str, Array], values: Array) -> dict[str, Array]:
        """Give the log density of each datum given those before it, by name."""
        noise, time, tails = self._noise(values), self.measured.time, self._tails(values)
        terms = {}
        for one in self.data:
            white, amplitude = noise[one.name]
            missed = one.values - predicted[one.name]
            if tails < inf:
                terms[one.name] = student_terms(missed, white, tails)
                continue
            terms[one.name] = series_terms(missed, time, white, amplitude, self.correlation or 1.0)
        return terms

    def replicated(
        self, predicted: Mapping[str, Array], values: Array, draws: np.random.Generator
    ) -> dict[str, Array]:
        """Give prediction, discrepancy and noise, as drawn."""
        noise, time, tails = self._noise(values), self.measured.time, self._tails(values)
        made = {}
        for name, series in predicted.items():
            white, amplitude = noise[name]
            normal = draws.standard_normal(time.size)
            made[name] = series + white * normal * student_factor(draws, tails, time.size)
            if amplitude > 0.0:
                made[name] += wandering(draws, time, amplitude, self.correlation)
        return made

    def _tails(self, values: Array) -> float:
        """Return the degrees of freedom of the noise, which stand last where they are free."""
        return float(values[-1]) if self.degrees_of_freedom is None else self.degrees_of_freedom

    def _noise(self, values: Array) -> dict[str, tuple[Array, float]]:
        """Give the standard deviation of the noise at each time, and that of the discrepancy, by name."""
        given = {one.name: float(x) for one, x in zip(self.free, values, strict=True)}
        same = np.ones(self.measured.time.size)
        return {
            name: (
                self.measured.errors[name]
                if name in self.measured.errors
                else given[f"{NOISE}.{name}"] * same,
                given.get(f"{DISCREPANCY}.{name}", 0.0),
            )
            for name in self.measured.values
        }


def series_model(
    measured: MeasuredSeries,
    configuration: Mapping[str, Any],
    keys: Sequence[Free],
    *,
    discrepancy: bool,
    degrees_of_freedom: float | None = inf,
) -> SeriesModel:
    """Pose the question what of a motor's keys its series tell.

    Args:
        measured: the series.
        configuration: of a run, checked; its duration and its records follow from the data.
        keys: what is free, named by full keys, with ranges.
        discrepancy: whether the law may be wrong, by a process with the drive's period as correlation time.
        degrees_of_freedom: of the Student-t distribution of the noise; infinite is the normal one, None is
            free.

    Raises:
        ConfigurationError: a discrepancy with Student-t noise, whose likelihood has no closed form,
            forces or currents at times of unequal distance, or no drive that has a period.
    """
    interval, places = records_at(measured.time)
    if places is None and (odd := [name for name in measured.values if name in ON_RECORDS]):
        words = (
            f"{', '.join(odd)} is measured at times that are no whole multiples of one interval; it must be, "
            "since forces are means over intervals. Leave it out by --series, or put it on a grid."
        )
        raise ConfigurationError([words])
    period = period_told(configuration)
    if discrepancy and not period > 0.0:
        words = "The drive has no period, the discrepancy's correlation time. Leave --discrepancy out."
        raise ConfigurationError([words])
    if discrepancy and degrees_of_freedom != inf:
        words = "Student-t noise and a discrepancy of a series cannot be combined. Leave one out."
        raise ConfigurationError([words])
    duration = max(float(measured.time[-1]), interval)
    times = {"solver.duration": duration, "solver.until": "duration", "solver.precision": PRECISION}
    times |= {"record.interval": interval}
    settings = {**flat(configuration), **times}
    step = settings.get("solver.contact_step")
    settings["solver.contact_step"] = None if step is None else min(step, duration)
    correlation = period if discrepancy else 0.0
    return SeriesModel(measured, settings, tuple(keys), interval, places, correlation, degrees_of_freedom)


def records_at(time: Array) -> tuple[float, Array | None]:
    """Give an interval of records [s] and the places of times among them; None for times that are not."""
    interval = float(np.median(np.diff(time)))
    # The last time is that of most digits.
    steps = np.round(time / interval)
    if steps[-1] > 0.0:
        interval = float(time[-1] / steps[-1])
    if np.abs(time - steps * interval).max() <= ON_GRID * interval and (np.diff(steps) > 0.0).all():
        return interval, steps
    return float(np.diff(time).min()) / FINER, None
