"""Measurements made by a known law, with noise."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, TypeVar

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.config.nesting import flat
from contactlab.impacts import velocities_after
from contactlab.laws import ContactLaw
from contactlab_data.inference.motor_problem import root_mean_square
from contactlab_data.measured.impacts import MeasuredImpacts, squared_norm
from contactlab_data.measured.series import MeasuredPoints, MeasuredSeries

Measured = TypeVar("Measured", bound=MeasuredSeries | MeasuredImpacts | MeasuredPoints)

TRUTH: Final = "truth"
"""Attribute of the true numbers by key, as JSON; of impacts the beginning of a note."""

MASS: Final = 0.036  # [kg] of the body that hits, an ellipse like those that were published
HALF_AXES: Final = (0.035, 0.025)  # [m]
SPEEDS: Final = (0.2, 1.5)  # [m/s] of approach
STEEPEST: Final = 70.0  # [deg] of the approach to the normal


def made_series(setup: Setup, names: Sequence[str], noise: float, seed: int) -> MeasuredSeries:
    """Return series of a motor with white noise.

    Args:
        setup: the truth.
        names: of `contactlab_data.measured.series.MEASURABLE`.
        noise: its standard deviation over the root mean square of each series [1], positive.
        seed: of the noise.

    Raises:
        ValueError: the run does not reach its end.
    """
    run = setup.run()
    if not run.ending.reached_end:
        raise ValueError(f"The truth cannot be run to its end: {run.message}")
    stated = {
        "title": f"Made by law {setup.law.name}, with {noise:g} of noise",
        TRUTH: json.dumps(truth_of(setup.configuration)),
        "seed": seed,
    }
    series = {name: run.series[name] for name in names}
    exact = with_noise(MeasuredSeries(run.time, series, {}, setup.configuration, stated), noise)
    draws = np.random.default_rng(seed)
    values = {
        name: series + exact.errors[name] * draws.standard_normal(run.time.size)
        for name, series in exact.values.items()
    }
    return replace(exact, values=values)


def made_impacts(
    law: ContactLaw, count: int, noise: float, seed: int, configuration: Mapping[str, Any] | None = None
) -> MeasuredImpacts:
    """Return impacts of an ellipse on a plate under a law, with noise.

    Angle of the body, speed and direction of the approach are drawn evenly. The noise is isotropic in the
    norm of the kinetic energy, relative to the approach.

    Args:
        law: the truth.
        noise: standard deviation in that norm [1], positive.
        seed: of approaches and noise.
        configuration: of the law, whose numbers are noted as the truth.

    Raises:
        ValueError: the law does not predict one of them.
    """
    draws = np.random.default_rng(seed)
    delassus, before = _approaches(draws, count)
    after = velocities_after(law, delassus, before)
    if not np.isfinite(after).all():
        raise ValueError(f"The law {law.name} does not predict some of the impacts; choose other values.")
    exact = MeasuredImpacts(
        delassus=delassus,
        velocity_before=before,
        velocity_after=after,
        kinetic_energy=0.5 * squared_norm(delassus, before),
        outside=np.zeros(count),
        covariance=None,
        title=f"Made by law {law.name}, with {noise:g} of noise",
        source=f"contactlab, seed {seed}",
        licence="",
        left_out=0,
        number=np.arange(1, count + 1),
        notes=(f"{TRUTH}: {json.dumps(truth_of(configuration or {}))}",),
    )
    stated = with_noise(exact, noise)
    assert stated.covariance is not None
    error = np.linalg.cholesky(stated.covariance) @ draws.standard_normal((count, 2, 1))
    return replace(stated, velocity_after=after + error[..., 0])


def _approaches(draws: np.random.Generator, count: int) -> tuple[Array, Array]:
    """Draw Delassus matrices [1/kg] and velocities before [m/s]."""
    a, b = HALF_AXES
    angle = draws.uniform(0.0, np.pi, count)
    height = np.sqrt((a * np.sin(angle)) ** 2 + (b * np.cos(angle)) ** 2)
    aside = (a**2 - b**2) * np.sin(angle) * np.cos(angle) / height
    inertia = 0.25 * MASS * (a**2 + b**2)
    delassus = np.empty((count, 2, 2))
    delassus[:, 0, 0] = 1.0 / MASS + aside**2 / inertia
    delassus[:, 1, 1] = 1.0 / MASS + height**2 / inertia
    delassus[:, 0, 1] = delassus[:, 1, 0] = aside * height / inertia
    speed, incidence = draws.uniform(*SPEEDS, count), np.radians(draws.uniform(-STEEPEST, STEEPEST, count))
    return delassus, np.column_stack([-speed * np.cos(incidence), speed * np.sin(incidence)])


def truth_of(configuration: Mapping[str, Any]) -> dict[str, float | str]:
    """Return the numbers of a configuration by key, and the names of its law and of the law's parts."""
    values = flat(configuration)
    return _names(values) | {
        key: float(value)
        for key, value in values.items()
        if isinstance(value, int | float) and not isinstance(value, bool)
    }


def _names(values: Mapping[str, Any]) -> dict[str, float | str]:
    """Return the names of a law and of its parts by their keys, "law.name" and "law.normal.name"."""
    return {key: str(x) for key, x in values.items() if key.startswith("law.") and key.endswith(".name")}


def truth_in(measured: Measured, configuration: Mapping[str, Any]) -> dict[str, float]:
    """Return the numbers that made the data, by key.

    Empty where the data are measured, or made by a law other than the configuration's or by other parts.
    """
    if isinstance(measured, MeasuredSeries | MeasuredPoints):
        text = measured.attributes.get(TRUTH, "{}")
    else:
        head = f"{TRUTH}: "
        text = next((note.removeprefix(head) for note in measured.notes if note.startswith(head)), "{}")
    try:
        result = json.loads(str(text))
    # A note of that name may be anything.
    except ValueError:
        return {}
    if not isinstance(result, dict) or _names(result) != _names(flat(configuration)):
        return {}
    return {str(key): float(x) for key, x in result.items() if isinstance(x, int | float)}


def without_errors(measured: Measured) -> Measured:
    """Return the data without stated noise."""
    if isinstance(measured, MeasuredSeries | MeasuredPoints):
        return replace(measured, errors={})
    return replace(measured, covariance=None)


def with_noise(measured: Measured, noise: float) -> Measured:
    """Return the data with stated noise, over the root mean square of series or the approach of impacts."""
    if isinstance(measured, MeasuredSeries | MeasuredPoints):
        values = measured.values.items()
        return replace(measured, errors={k: np.full(x.size, noise * root_mean_square(x)) for k, x in values})
    scale = squared_norm(measured.delassus, measured.velocity_before)
    return replace(measured, covariance=noise**2 * scale[:, None, None] * measured.delassus)
