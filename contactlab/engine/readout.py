"""From the memory of a run to what a user reads: series by name, and the ending in a sentence."""

import numpy as np
from numpy.typing import NDArray

from contactlab.engine.inconsistency import inconsistency
from contactlab.engine.run import (
    CHATTERED,
    END,
    ENDING,
    EVENT_LIMIT,
    INCONSISTENT,
    INTERVAL,
    TIME,
    UNSOLVED,
    WINDOW,
    Run,
)
from contactlab.trajectory import Ending
from contactlab.variables import SERIES

Array = NDArray[np.float64]


def explain(run: Run, contact_step: float) -> tuple[Ending, str]:
    """The ending of a run that stopped by itself, and a sentence on it."""
    time = float(run.real[TIME])
    if run.whole[ENDING] == CHATTERED:
        return Ending.CHATTERED, (
            f"The contact chatters at {time:.6g} s: more than {EVENT_LIMIT} touch-downs and friction "
            f"switches within {run.real[WINDOW]:.3g} s, or no progress. The run stops there; a "
            f"shorter contact step than {contact_step:.3g} s or another law may pass it."
        )
    if run.whole[ENDING] == UNSOLVED:
        return Ending.DIVERGED, (
            f"The run ends at {time:.6g} s: no step in contact, however short, satisfies the law. "
            "Check the law's parameters, or loosen the tolerance."
        )
    if run.whole[ENDING] == INCONSISTENT:
        return Ending.INCONSISTENT, inconsistency(run)
    return Ending.DIVERGED, (
        f"The run diverges at {time:.6g} s: the state is not finite, the tip lies deeper in the rotor "
        "than a tenth of its radius, or it moves too fast to be followed. Check the drive and the "
        f"law's parameters, or shorten the contact step, {contact_step:.3g} s."
    )


def record_times(run: Run, records: int) -> Array:
    """Times of the records [s], as the recorder took them."""
    time = np.arange(records) * run.real[INTERVAL]
    if records == run.series.shape[0]:
        time[-1] = run.real[END]
    return np.asarray(time, dtype=np.float64)


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
    energy = series["kinetic_energy"] + series["strain_energy"] + series["contact_energy"]
    losses = sum(
        series[name] for name in ("damping_loss", "friction_loss", "contact_loss", "load_work")
    )
    series["energy_residual"][:] = energy - energy[0] - (series["drive_work"] - losses)
    return series, run.modes[: time.size]
