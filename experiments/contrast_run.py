"""The result of a run of `law_contrasts`, whole or under way, after one of its motors was computed again."""

from itertools import count, takewhile
from pathlib import Path
from typing import Final

import numpy as np
import xarray
from law_contrasts import CALIBRATED, STARTED, LawContrasts, computed
from motor_population import GROUPS, drawn
from results_store import SAME

import contactlab as cl
from contactlab.studies.study import TASKS, Result

OF_A_MOTOR: Final = ("value", "error", "outcome", "group_value", "secant", "prediction_error")
"""Variables of one motor."""

AGAIN: Final = 0
"""Motor that is computed again: one whose start is timed and to which laws are fitted."""


def motors_of(folder: Path, most: int) -> list[xarray.Dataset]:
    """Return the data of the motors of a run in their order: of one under way, those before the first gap.

    Motors that take long are no others than those that do not, so that what follows a gap is left out.

    Raises:
        ValueError: the folder has none.
    """
    whole = folder / f"{LawContrasts.name}.nc"
    if whole.is_file():
        with xarray.open_dataset(whole, engine="netcdf4") as data:
            own = data[[*OF_A_MOTOR]].load()
        own = own.drop_vars([*own.coords])
        motors = [own.isel(motor=number) for number in range(own.sizes["motor"])]
    else:
        # A finished task is known by its motor's first group, which is drawn.
        numbers = {drawn(number)[GROUPS[0]]: number for number in range(most)}
        done: dict[int, xarray.Dataset] = {}
        for file in sorted((folder / TASKS).glob("*-*.nc")):
            with xarray.open_dataset(file, engine="netcdf4") as data:
                done[numbers[float(data["group_value"][0])]] = data[[*OF_A_MOTOR]].load()
        motors = [done[number] for number in takewhile(done.__contains__, count())]
    if not motors:
        raise ValueError(f"{folder} has neither {whole.name} nor the first motor of a run under way.")
    return motors


def result_of(folder: Path, setup: cl.Setup) -> Result:
    """Return the result of the run of a folder.

    Raises:
        ValueError: there is none, or its motor `AGAIN` has other digits under the present code.
    """
    study = LawContrasts()
    motors = motors_of(folder, study.motors)
    again = computed(AGAIN, AGAIN < STARTED, AGAIN < CALIBRATED).data.to_dataset()
    for name in OF_A_MOTOR:
        if not np.allclose(again[name], motors[AGAIN][name], rtol=SAME, atol=0.0, equal_nan=True):
            raise ValueError(f"{name} of motor {AGAIN} in {folder} is another one under the present code.")
    parts = {f"{number:04d}": xarray.DataTree(motor) for number, motor in enumerate(motors)}
    return Result.of(study, {"": setup}, study.combine({"": setup}, parts))
