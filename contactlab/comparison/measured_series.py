"""Laws against measured series of the motor: how far a run from rest is off over the measured time."""

from collections.abc import Iterator, Sequence
from math import nan
from typing import Final

import numpy as np

from contactlab.comparison.measurements import ENDS, Judged, Measurement, row
from contactlab.comparison.runs import FREE, ComparisonError, shown
from contactlab.config import ConfigurationError, Setup, build
from contactlab.config.nesting import flat, nested
from contactlab.inference.series_problem import series_problem
from contactlab.laws.declaration import SHARED
from contactlab.measured.series import MEASURABLE, MeasuredSeries
from contactlab.metrics import Metric

FRICTION: Final = f"contact.{SHARED}"


def by_series(
    one: Measurement, series: MeasuredSeries, labels: Sequence[str], setups: Sequence[Setup | None], mark: str
) -> Judged:
    """Give the rows of measured series: the rms of what a law misses."""
    notes: list[str] = []
    values = np.full((len(series.values), len(labels)), nan)
    for place, (label, setup) in enumerate(zip(labels, setups, strict=True)):
        if setup is None:
            notes.append(
                f"{label} is not held against {one.title}: its run has no configuration that builds."
            )
            continue
        if faults := [*_of_other_motor(one, series, setup)]:
            raise ComparisonError(faults)
        try:
            model = series_problem(series, setup.configuration, (), discrepancy=False)
        except ConfigurationError as error:
            raise ComparisonError([f"'{one.path}': {fault}" for fault in error.faults]) from error
        found = model.predict(np.empty(0))
        if found is None:
            notes.append(f"{label} does not reach the end of the measured time of {one.title}.")
            continue
        for i, (name, measured) in enumerate(series.values.items()):
            missed = (found[name] - measured) / series.errors.get(name, 1.0)
            values[i, place] = np.sqrt(np.mean(missed**2))
    laws = len(labels)
    empty = np.full((laws, laws, len(ENDS)), nan)
    rows = tuple(_series_row(one, name, name in series.errors, mark) for name in series.values)
    return Judged(one, rows, values, np.full_like(values, nan), empty, tuple(notes))


def _series_row(one: Measurement, name: str, stated: bool, mark: str) -> Metric:
    said = MEASURABLE[name]
    words, best = (" over its stated error", "; 1 is the error itself") if stated else ("", "")
    return row(
        f"{name}_misfit{mark}",
        f"rms of {said.symbol} - {said.symbol}_law" + (" over its error" if stated else ""),
        f"misfit of the measured {said.long_name}{words}, less is better ({one.title}): rms over the "
        f"measured time{best}",
        "1" if stated else said.units,
        "; ".join(filter(None, (one.title, one.source))),
    )


def _of_other_motor(one: Measurement, series: MeasuredSeries, setup: Setup) -> Iterator[str]:
    """Say what of the motor that was measured is not that of the runs, as far as the file tells.

    The friction coefficient is a law's parameter, wherever it stands.
    """
    here = flat(setup.configuration)
    told = flat({name: keys for name, keys in series.configuration.items() if name not in FREE})
    try:
        there = flat(build(nested({**here, **told})).configuration)
    except ConfigurationError as error:
        yield f"'{one.path}': its configuration is not sound: {error.faults[0]}"
        return
    for key in told:
        if key in here and key != FRICTION and shown(here[key]) != shown(there[key]):
            yield (
                f"{key} is {shown(there[key])} in '{one.path}' and {shown(here[key])} in the runs; series "
                "are compared with the motor they were measured on. Run that motor, or leave the file out."
            )
