"""Whether the ledger of a run is closed: looked at after every step, however coarse its records are."""

import numpy as np

from contactlab.compiled import part_kernel
from contactlab.energy import openness
from contactlab.engine.ledger import DAMPING, DRIVE, FRICTIONAL, LOAD, NORMAL_LOSS
from contactlab.engine.plant import Plant
from contactlab.engine.run import LEAST_OPEN, MOST_OPEN, TURNED_OVER, Run
from contactlab.engine.step import MODE, Step
from contactlab.laws.base import FREE


@part_kernel
def weigh(plant: Plant, step: Step, run: Run) -> None:
    """Note the work of drive and load after a step, and what the ledger leaves where nothing touches.

    In contact what the law stores is not known without asking it; it is back, or lost, at the release.
    """
    drive, load = run.total[DRIVE], run.total[LOAD]
    run.real[TURNED_OVER] = max(run.real[TURNED_OVER], abs(drive), abs(load))
    if step.whole[MODE] != FREE:
        return
    left = load - drive + run.total[DAMPING] + run.total[FRICTIONAL] + run.total[NORMAL_LOSS]
    for j in range(step.q.size):
        left += 0.5 * step.v[j] * step.v[j] + 0.5 * plant.stiffness[j] * step.q[j] * step.q[j]
    run.real[LEAST_OPEN] = min(run.real[LEAST_OPEN], left)
    run.real[MOST_OPEN] = max(run.real[MOST_OPEN], left)


def openness_of(run: Run, start: float, recorded: float) -> float:
    """Energy that a run's ledger cannot account for, over the energy turned over [1].

    Args:
        run: its memory.
        start: energy at the start [J].
        recorded: largest residual of the records [J], which knows of contacts as well.
    """
    seen = run.real[[LEAST_OPEN, MOST_OPEN]]
    # Without any flight there is neither a least nor a most.
    residual = np.abs(np.append(seen[np.isfinite(seen)] - start, recorded)).max()
    work = float(run.real[TURNED_OVER])
    return openness(float(residual), work, 0.0, start)
