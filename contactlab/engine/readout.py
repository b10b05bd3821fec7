"""From the memory of a run to what a user reads: series by name."""

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.engine.run import END, INTERVAL, Run
from contactlab.variables import SERIES


def record_times(run: Run, records: int) -> Array:
    """Times of the records [s], as the recorder took them."""
    time = np.arange(records) * run.real[INTERVAL]
    if records == run.series.shape[0]:
        time[-1] = run.real[END]
    return np.asarray(time, dtype=np.float64)


def energy_of(series: dict[str, Array]) -> Array:
    """Energy of motor and contact [J] at every record."""
    return series["kinetic_energy"] + series["strain_energy"] + series["contact_energy"]


def take_series(run: Run, time: Array) -> tuple[dict[str, Array], NDArray[np.int8]]:
    """Take the recorded columns out of a run, by name: its memory, of which a long run has no second one.

    Impulses become mean forces, and the ledger has its residual.

    Args:
        run: what ran; its records are to be taken once.
        time: of the records [s], see `record_times`.
    """
    table = run.series[: time.size]
    series = {v.name: table[:, column] for column, v in enumerate(SERIES)}
    interval = np.diff(time)
    for name in ("normal_force", "friction_force"):
        impulse = series[name]
        impulse[1:] = np.diff(impulse) / interval
        impulse[:1] = 0.0
    energy = energy_of(series)
    losses = sum(
        series[name] for name in ("damping_loss", "friction_loss", "contact_loss", "load_work")
    )
    series["energy_residual"][:] = energy - energy[0] - (series["drive_work"] - losses)
    return series, run.modes[: time.size]
