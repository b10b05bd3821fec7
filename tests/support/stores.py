"""Maps of three chunks whose runs are made up."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from contactlab.sweeps.dataset import Axis
from contactlab.sweeps.store import Store
from contactlab.sweeps.many import Answers, Report, Wanted
from contactlab.sweeps.plan import Plan

CELLS, CHUNK = 9, 3


def plan(first: float = 0.0, series: tuple[str, ...] = ()) -> Plan:
    return Plan(
        axes=(Axis("drive.phase", tuple(first + np.arange(CELLS, dtype=float)), "rad"),),
        groups=(),
        bases=({"law": {"name": "newton"}},),
        wanted=Wanted(("peak_force",), series),
        chunk=CHUNK,
        code="code",
    )


class Made:
    """Stands for the processes of a map: a run's peak force is the number of its cell.

    Args:
        meanwhile: what happens while the runs are made.
    """

    def __init__(self, meanwhile: Callable[[], object] = lambda: None) -> None:
        self.meanwhile = meanwhile

    def answers(self, cells: Sequence[int], _: Report | None = None) -> Answers:
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
    """A map of three chunks, some of which are finished."""
    folder = Store(path, plan(**of_plan))
    folder.begin()
    for chunk in range(finished):
        folder.run(chunk, Made())
    return folder
