"""Sweeps of three chunks whose runs are made up."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from contactlab.sweeps.answers import Answers
from contactlab.sweeps.dataset import Axis
from contactlab.sweeps.plan import Outputs, Plan
from contactlab.sweeps.store import Store

CELLS, CHUNK = 9, 3


def plan(first: float = 0.0, series: tuple[str, ...] = ()) -> Plan:
    return Plan(
        axes=(Axis("drive.phase", tuple(first + np.arange(CELLS, dtype=float)), "rad"),),
        groups=(),
        choices=((),),
        bases=({"law": {"name": "newton"}},),
        samples=False,
        outputs=Outputs(("peak_force",), series),
        chunk=CHUNK,
        code="code",
    )


class Made:
    """Stands for the processes of a sweep: a run's peak force is the number of its cell.

    Args:
        meanwhile: what happens while the runs are made.
    """

    def __init__(self, meanwhile: Callable[[], object] = lambda: None) -> None:
        self.meanwhile = meanwhile

    def answers(self, cells: Sequence[int]) -> Answers:
        self.meanwhile()
        time = np.linspace(0.0, 1.0, 5)
        return Answers(
            metrics=np.array(cells, dtype=float)[:, np.newaxis],
            status=np.zeros(len(cells), dtype=np.int8),
            reason=[""] * len(cells),
            series={"gap": np.outer(cells, time)},
            time=time,
        )


def begun(path: Path, finished: int, **of_plan: tuple[str, ...]) -> Store:
    """A sweep of three chunks, some of which are finished."""
    folder = Store(path, plan(**of_plan))
    folder.begin()
    for chunk in range(finished):
        folder.run(chunk, Made())
    return folder
