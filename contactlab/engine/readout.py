"""From the memory of a run to what a user reads: series by name."""

import numpy as np
from numpy.typing import NDArray

from contactlab.engine.run import END, INTERVAL, Run
from contactlab.variables import SERIES

Array = NDArray[np.float64]


def record_times(run: Run, records: int) -> Array:
    """Times of the records [s], as the recorder took them."""
    time = np.arange(records) * run.real[INTERVAL]
    if records == run.series.shape[0]:
        time[-1] = run.real[END]
    return np.asarray(time, dtype=np.float64)


def energy_of(series: dict[str, Array]) -> Array:
    """Energy of motor and contact [J] at every record."""
    return series["kinetic_energy"] + series["strain_energy"] + series["contact_energy"]


def read_series(run: Run, records: int) -> tuple[dict[str, Array], NDArray[np.int8]]:
    """The recorded columns by name: mean forces out of impulses, and the ledger's residual."""
    table = run.series[:records]
    series = {v.name: table[:, column].copy() for column, v in enumerate(SERIES)}
    interval = np.diff(record_times(run, records))
    for name in ("normal_force", "friction_force"):
        series[name] = np.concatenate([[0.0], np.diff(series[name]) / interval])
    energy = energy_of(series)
    losses = sum(
        series[name] for name in ("damping_loss", "friction_loss", "contact_loss", "load_work")
    )
    series["energy_residual"] = energy - energy[0] - (series["drive_work"] - losses)
    return series, run.modes[:records].copy()
