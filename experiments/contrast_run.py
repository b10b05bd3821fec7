"""The result of a run of `law_contrasts`, whole or under way, after one of its motors was computed again."""

from itertools import count, takewhile
from pathlib import Path
from typing import Final

import numpy as np
import xarray
from law_contrasts import PRACTISED, QUANTITIES, STATES, LawContrasts, computed, practised
from motor_population import GROUPS, drawn
from results_store import SAME

import contactlab as cl
from contactlab.studies.study import Result
from contactlab.studies.task import TASKS

OF_A_MOTOR: Final = ("value", "error", "outcome", "group_value", "secant")
"""Variables of one motor."""

OF_PRACTICE: Final = ("start_time", "start_time_error", "prediction_error")
"""Variables of a motor to which laws are fitted, in a whole run."""

SIZES: Final = {"state": len(STATES), "quantity": len(QUANTITIES), "group": len(GROUPS)}
"""Sizes that a motor has; a motor of an earlier plan in the same folder has others."""

AGAIN: Final = 0
"""Motor that is computed again: one to which laws are fitted."""


def motors_of(folder: Path, most: int) -> list[xarray.Dataset]:
    """Return the motors of a run in their order: of one under way, those before the first gap.

    Those behind it are the ones that take less time, and no fair part of the population. Laws that are
    fitted come with a whole run alone.

    Raises:
        ValueError: the folder has none.
    """
    whole = folder / f"{LawContrasts.name}.nc"
    if whole.is_file():
        with xarray.open_dataset(whole, engine="netcdf4") as data:
            own = data[[name for name in (*OF_A_MOTOR, *OF_PRACTICE) if name in data]].load()
        own = own.drop_vars([*own.coords])
        return [
            motor if number < PRACTISED else motor.drop_vars(OF_PRACTICE, errors="ignore")
            for number in range(own.sizes["motor"])
            for motor in [own.isel(motor=number)]
        ]
    # A finished task is known by its motor's first group, which is drawn; the latest one counts.
    numbers = {drawn(number)[GROUPS[0]]: number for number in range(most)}
    done: dict[int, xarray.Dataset] = {}
    for file in sorted((folder / TASKS).glob("*-*.nc"), key=lambda file: file.stat().st_mtime):
        with xarray.open_dataset(file, engine="netcdf4") as data:
            if SIZES.items() <= data.sizes.items():
                done[numbers[float(data["group_value"][0])]] = data[[*OF_A_MOTOR]].load()
    if not done.get(0):
        raise ValueError(f"{folder} has neither {whole.name} nor the first motor of a run under way.")
    return [done[number] for number in takewhile(done.__contains__, count())]


def result_of(folder: Path, setup: cl.Setup) -> Result:
    """Return the result of the run of a folder.

    Raises:
        ValueError: there is none, or its motor `AGAIN` has other digits under the present code.
    """
    study = LawContrasts()
    motors = motors_of(folder, study.motors)
    again = computed(AGAIN).data.to_dataset()
    if {*OF_PRACTICE} <= {*motors[AGAIN]}:
        again = again.merge(practised(AGAIN).data.to_dataset())
    for name in again:
        if not np.allclose(again[name], motors[AGAIN][name], rtol=SAME, atol=0.0, equal_nan=True):
            raise ValueError(f"{name} of motor {AGAIN} in {folder} is another one under the present code.")
    parts = {f"{number:04d}": xarray.DataTree(motor[[*OF_A_MOTOR]]) for number, motor in enumerate(motors)}
    for number, motor in enumerate(motors):
        if {*OF_PRACTICE} <= {*motor}:
            parts[f"{number:04d}, practised"] = xarray.DataTree(motor[[*OF_PRACTICE]])
    return Result.of(study, {"": setup}, study.combine({"": setup}, parts))
