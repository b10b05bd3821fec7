"""Rows of the scorecard from what was measured: impacts under every law, and series of the motor itself.

Impacts are asked of the law alone, with the parameters of its run; how far it is off is
`MeasuredImpacts.errors`. Their rows come with 95 % bootstrap intervals over the impacts, by the same
resamples for all laws, so that a difference between two is one of pairs. Series are those of the motor
that is compared, run from rest over the measured time.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import xarray

from contactlab.comparison.measurements import ENDS, Judged, Measurement
from contactlab.config import ConfigurationError, Setup, build
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.metrics import Run


def judged(measurements: Sequence[Measurement], runs: Sequence[Run]) -> list[Judged]:
    """Hold the laws of runs, with the parameters that they ran with, against what was measured.

    Raises:
        ComparisonError: series that are not of the runs' motor.
    """
    if not measurements:
        return []
    # They bring inference, which no other comparison needs.
    from contactlab.comparison.measured_impacts import by_impacts
    from contactlab.comparison.measured_series import by_series

    setups: list[Setup | None] = []
    for run in runs:
        try:
            setups.append(build(run.configuration) if run.configuration else None)
        except ConfigurationError:
            setups.append(None)
    labels, found = [run.label for run in runs], []
    for number, one in enumerate(measurements, 1):
        mark = f"_{number}" if len(measurements) > 1 else ""
        if isinstance(one.data, MeasuredImpacts):
            found.append(by_impacts(one, one.data, labels, setups, mark))
        else:
            found.append(by_series(one, one.data, labels, setups, mark))
    return found


def with_measurements(data: xarray.Dataset, found: Sequence[Judged]) -> xarray.Dataset:
    """Give a scorecard with where its measured rows come from, and the differences between laws there."""
    if not found:
        return data
    files = [one.measurement for one in found]
    words = {"long_name": "mean error of the other law less that of the law, with its 95 % interval"}
    return data.assign(
        nearer=(("measured", "law", "other_law", "end"), np.array([one.nearer for one in found]), words)
    ).assign_coords(
        other_law=data["law"].values,
        end=[*ENDS],
        measured=[one.title for one in files],
        measured_source=("measured", [one.source for one in files]),
        measured_contents=("measured", [one.contents for one in files]),
        measured_file=("measured", [one.path for one in files]),
        measured_digest=("measured", [one.digest for one in files]),
    )


def differences(data: xarray.Dataset) -> Iterator[str]:
    """Say of every file of impacts which law is nearest to it, and by how much nearer than each other."""
    if "nearer" not in data:
        return
    for title, nearer in zip(map(str, data["measured"].values), data["nearer"].values, strict=True):
        labels = list(map(str, data["law"].values))
        lead = np.nan_to_num(nearer[:, :, 0], nan=-np.inf).max(axis=1)
        if not np.isfinite(lead).any():
            continue
        # The nearest is not behind any other; ties go to the first.
        behind = np.nanmin(np.where(np.isnan(nearer[:, :, 0]), np.inf, nearer[:, :, 0]), axis=1)
        first = int(np.argmax(np.where(np.isfinite(lead), behind, -np.inf)))
        for other in np.argsort(nearer[first, :, 0]):
            apart, low, high = (float(x) for x in nearer[first, other])
            if np.isfinite(apart):
                yield _nearer(labels[first], labels[int(other)], title, apart, low, high)


def _nearer(one: str, other: str, title: str, apart: float, low: float, high: float) -> str:
    if apart == low == high == 0.0:
        return f"{one} and {other} predict the impacts of {title} alike."
    half = 0.5 * (high - low)
    if low > 0.0:
        return (
            f"{one}'s impacts are nearer to what was measured ({title}) than {other}'s by {apart:.2g} +- "
            f"{half:.1g}."
        )
    return (
        f"Whether {one}'s or {other}'s impacts are nearer to what was measured ({title}) cannot be told: "
        f"{apart:.2g} apart, with an interval from {low:.2g} to {high:.2g}."
    )
