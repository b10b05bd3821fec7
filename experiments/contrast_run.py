"""The result of a run of many hours, whole or under way, after one of its motors was computed again."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import count, takewhile
from pathlib import Path
from typing import Final

import numpy as np
import xarray
from experiment import Experiment
from law_contrasts import MOTORS, QUANTITIES, STATES, LawContrasts, computed
from law_practice import FITTED, LawPractice, practised
from motor_population import GROUPS, drawn
from results_store import SAME

import contactlab as cl
from contactlab.studies.study import Part, Result
from contactlab.studies.task import TASKS

AGAIN: Final = 3
"""Motor that is computed again: one that takes little time."""


@dataclass(frozen=True)
class Run:
    """A run of motors in their order.

    Args:
        study: which one; it has a number of motors.
        compute: returns a motor by its number.
        variables: those of one motor.
        sizes: that a motor has; one of an earlier plan in the same folder has others.
        number_of: returns the number of a motor.
    """

    study: Experiment
    compute: Callable[[int], Part]
    variables: tuple[str, ...]
    sizes: dict[str, int]
    number_of: Callable[[xarray.Dataset], int]


@cache
def numbers() -> dict[float, int]:
    """Return the numbers of motors by their first group, which is drawn."""
    return {drawn(number)[GROUPS[0]]: number for number in range(MOTORS)}


RUNS: Final = {
    run.study.name: run
    for run in (
        Run(
            LawContrasts(),
            computed,
            ("value", "error", "outcome", "group_value", "secant"),
            {"state": len(STATES), "quantity": len(QUANTITIES), "group": len(GROUPS)},
            lambda motor: numbers()[float(motor["group_value"][0])],
        ),
        Run(
            LawPractice(),
            practised,
            ("number", "prediction_error", "start_time", "start_time_error"),
            {"law": len(FITTED)},
            lambda motor: int(motor["number"]),
        ),
    )
}
"""Runs by the name of their experiment."""


def motors_of(folder: Path, run: Run) -> list[xarray.Dataset]:
    """Return the motors of a run in their order: of one under way, those before the first gap.

    Those behind it are the ones that take less time, and no fair part of the population.

    Raises:
        ValueError: the folder has none.
    """
    names = [*run.variables]
    whole = folder / f"{run.study.name}.nc"
    if whole.is_file():
        with xarray.open_dataset(whole, engine="netcdf4") as data:
            own = data[names].load()
        return [own.isel(motor=number) for number in range(own.sizes["motor"])]
    # The latest one counts.
    done: dict[int, xarray.Dataset] = {}
    for file in sorted((folder / TASKS).glob("*-*.nc"), key=lambda file: file.stat().st_mtime):
        with xarray.open_dataset(file, engine="netcdf4") as data:
            if run.sizes.items() <= data.sizes.items():
                done[run.number_of(data)] = data[names].load()
    if 0 not in done:
        raise ValueError(f"{folder} has neither {whole.name} nor the first motor of a run under way.")
    return [done[number] for number in takewhile(done.__contains__, count())]


def result_of(folder: Path, run: Run, setup: cl.Setup) -> Result:
    """Return the result of the run of a folder.

    Raises:
        ValueError: there is none, or motor `AGAIN`, or the last one, has other digits under the present code.
    """
    motors = motors_of(folder, run)
    number = min(AGAIN, len(motors) - 1)
    for name, again in run.compute(number).data.to_dataset().data_vars.items():
        if not np.allclose(again, motors[number][name], rtol=SAME, atol=0.0, equal_nan=True):
            raise ValueError(f"{name} of motor {number} in {folder} is another one under the present code.")
    parts = {f"{number:04d}": xarray.DataTree(motor) for number, motor in enumerate(motors)}
    return Result.of(run.study, {"": setup}, run.study.combine({"": setup}, parts))
