"""Sweeps and maps whose simulation is over at once, so that tests may have many, and what they leave."""

import dataclasses
import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hydra.core.plugins import Plugins
from hydra.core.utils import JobReturn
from hydra.plugins.launcher import Launcher
from hydra.plugins.sweeper import Sweeper
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig
from support.synthetic import CONFIGURATION, synthetic_trajectory

from contactlab.motor.motor import Motor
from contactlab.results.netcdf import to_datatree, write_tree
from contactlab.studies.run_state import COMPLETE, Job, State, write_state
from contactlab.studies.runner import done_parts
from contactlab.studies.sweep.plan import Outputs, planned
from contactlab.studies.sweep.study import Sweep, begin, composing
from contactlab.trajectory import Ending, Trajectory

METRICS_ALONE = ("-m", "sweep.keep=metrics")

QUICK = ("record.picture=false", "hydra.sweep.dir=sweep")
"""Overrides that all these sweeps have."""


@dataclass
class Simulations:
    """Stands for `contactlab.engine.simulate`.

    Args:
        seen: clearances that were simulated [um], in their order.
        endings: how a run ends by its clearance [um], a complete one where nothing is said.
        duration: of the runs by clearance [s].
    """

    seen: list[float] = field(default_factory=list)
    endings: dict[float, Ending | BaseException] = field(default_factory=dict)
    duration: Callable[[float], float] = lambda _: 1e-3

    def __call__(self, motor: Motor, *_: object, **__: object) -> Trajectory:
        clearance = round(motor.geometry.clearance * 1e6, 9)
        self.seen.append(clearance)
        how = self.endings.get(clearance, Ending.COMPLETE)
        if isinstance(how, BaseException):
            raise how
        message = "" if how is Ending.COMPLETE else "It ended too early."
        trajectory = synthetic_trajectory(duration=self.duration(clearance))
        return dataclasses.replace(trajectory, ending=how, message=message)


class ChoosingSweeper(Sweeper):
    """Chooses its values while it runs, as an optimiser does, and one that is refused."""

    def __init__(self, **_: object) -> None:
        self.launcher: Launcher

    def setup(self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig) -> None:
        self.launcher = Plugins.instance().instantiate_launcher(
            hydra_context=hydra_context, task_function=task_function, config=config
        )

    def sweep(self, arguments: list[str]) -> list[JobReturn]:
        returned: list[JobReturn] = []
        for number, clearance in enumerate(("1e-6", "2e-6", "-1e-6")):
            batch = [[*arguments, f"contact.clearance={clearance}"]]
            returned += self.launcher.launch(batch, initial_job_idx=number)
        return returned


def folder(clearance: str, *before: str) -> Path:
    """The folder of a job of such a sweep; Hydra spells values as Python does."""
    lines = sorted([f"contact.clearance={clearance}", *before, "record.picture=false"])
    return Path("sweep") / ",".join(lines)


def state_of(place: Path) -> dict[str, Any]:
    """What a run's folder says of it."""
    read: dict[str, Any] = json.loads((place / "state.json").read_text(encoding="utf-8"))
    return read


def left_run(folder: Path) -> Path:
    """A run's folder as a run leaves it."""
    folder.mkdir(parents=True)
    digest = write_tree(to_datatree(synthetic_trajectory(), CONFIGURATION), folder / "run.nc")
    write_state(folder, State(COMPLETE, Job(key="key"), digest=digest))
    return folder / "run.nc"


CELLS, CHUNK = 9, 3


def small_sweep(first: float = 0.0, series: tuple[str, ...] = ("gap",)) -> Sweep:
    """A sweep of nine short runs in three tasks."""
    composer = composing(["law=newton", "solver.duration=1e-4", "record.interval=1e-5"])
    values = {"drive.phase": [first + number for number in range(CELLS)]}
    return Sweep(plan=planned(composer, values, Outputs(("peak_force",), series), chunk=CHUNK))


def begun(path: Path, finished: int, **changes: Any) -> Sweep:
    """Such a sweep that was interrupted once some of its tasks were finished."""

    def stop(done: int, _: int) -> None:
        if done >= finished:
            raise InterruptedError

    sweep = small_sweep(**changes)
    begin(path, sweep.plan)
    with suppress(InterruptedError):
        done_parts(sweep, {}, path, stop)
    return sweep
