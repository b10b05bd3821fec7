"""The study `drive`: forces and losses of laws on a prescribed path."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final

import numpy as np
import pandas
import xarray

from contactlab.config import ConfigurationError, Setup
from contactlab.driving import DEGREE, FRAME, drive, integrated
from contactlab.estimate import Estimate
from contactlab.laws import LawError
from contactlab.motor.table import MeasurementError, read_table
from contactlab.parameter import Parameter
from contactlab.results.files import check_file, damage
from contactlab.studies.law_study import LawStudy, groups_of, read_file
from contactlab.studies.study import Part, Setups, Task, listing, option
from contactlab.studies.tables import table_of_quantities
from contactlab.trajectory import Ending
from contactlab.variables import Variable

PATH: Final = {"slip": "m", "velocity": "m s-1", "gap": "m", "normal": "N"}
"""Units of what is prescribed: slip or its rate, and either gap or normal force."""

FORCES: Final = ("normal_force", "friction_force")
"""What a file may have of a measured contact [N]."""

NOTE: Final = "path"
"""Attribute of a path that is integrated: a sentence on its error."""

FEWEST: Final = 8
"""Smallest number of samples."""


@dataclass(frozen=True, kw_only=True)
class Driven(LawStudy):
    """What forces does a law bring on a prescribed path, without a motor, and what does it lose?

    The file of the path has columns time, slip or its velocity, and gap or normal (a normal force), each with
    its unit: contactlab drive path.csv law=composed law/friction=dahl,lugre. A velocity is integrated. Forces
    in the file are drawn beside those of the laws.
    """

    name: ClassVar[str] = "drive"
    files: ClassVar[str] = "data"
    quantities: ClassVar[tuple[Variable, ...]] = (
        Variable("drive_work", (), "J", "W", "work of the path"),
        Variable("friction_loss", (), "J", "W_F", "energy lost by friction"),
        Variable("contact_loss", (), "J", "W_N", "energy lost along the normal"),
        Variable("largest_normal_force", (), "N", "N", "largest mean normal force between two records"),
        Variable("largest_friction_force", (), "N", "F", "largest mean friction between two records"),
    )

    data: Annotated[str | Path, option("file of the path")] = ""
    degree: Annotated[int, option("of the spline through its samples: 1, 3, 5 or 7")] = DEGREE
    period: Annotated[
        float | None, Parameter("", "s", "time after which the path repeats itself", above=0.0)
    ] = None
    duration: Annotated[float | None, Parameter("", "s", "of the run; the path's, once", above=0.0)] = None
    frame_stiffness: Annotated[float | None, FRAME["frame_stiffness"]] = None
    frame_damping: Annotated[float, FRAME["frame_damping"]] = 0.0
    frame_force: Annotated[float, FRAME["frame_force"]] = 0.0

    def path(self) -> xarray.Dataset:
        """Return the path, see `read_path`.

        Raises:
            ConfigurationError: the file cannot be read, or has none.
        """
        return read_file(self.data, read_path)

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return one task a law."""
        setups = self.chosen(setups)
        times = {"degree": self.degree, "period": self.period, "duration": self.duration}
        times |= {name: getattr(self, name) for name in FRAME}
        path = self.path()
        return [Task(label, _driven, (setup, path, times)) for label, setup in setups.items()]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return the runs, a group for each law, and the measured forces."""
        tree = super().combine(setups, parts)
        path = self.path()
        tree.attrs |= path.attrs
        if {*FORCES} & {*path}:
            tree["measured"] = xarray.DataTree(path)
        return tree

    def title(self, names: str) -> str:
        """Return the title of the data."""
        return f"{names} on a prescribed path"

    def of_group(self, group: xarray.DataTree) -> dict[str, Estimate]:
        """Return work, losses and largest forces of a run."""
        root = group.to_dataset()
        open_by = abs(float(root["energy_residual"][-1]))
        names = ("drive_work", "friction_loss", "contact_loss")
        result = {name: Estimate(float(root[name][-1]), open_by) for name in names}
        for name in FORCES:
            result[f"largest_{name}"] = Estimate(float(np.abs(root[name]).max()), 0.0)
        return result

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return losses and largest forces of each law, and which runs did not reach the end of the path."""
        quantities = [q for q in self.quantities if q.name != "drive_work"]
        every = [f"{label}: {listing(quantities, own)}." for label, own in self.columns(data).items()]
        every += [data.attrs[NOTE]] if NOTE in data.attrs else []
        return every + [
            f"{label} does not reach the end of the path: {run.attrs['message']}"
            for label, run in groups_of(data).items()
            if not run.attrs["complete"]
        ]

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return the numbers, a column a law."""
        caption = "Forces and losses on the path"
        return {self.name: table_of_quantities(self.quantities, self.columns(data), caption)}

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return forces over path and time, of all laws together and of each."""
        # Imported here: they bring matplotlib.
        from contactlab.plot.driven import draw_driven
        from contactlab.studies.figures import captioned, draw_paths

        runs = groups_of(data)
        measured = data["measured"].to_dataset() if "measured" in data.children else None
        beside = " and as measured" if measured is not None else ""
        caption = f"Forces of {', '.join(runs)} over displacement and time{beside}."
        figures = {self.name: captioned(draw_paths(runs, measured), caption)}
        for label, run in runs.items():
            name = "run" if len(runs) == 1 else label.replace(" + ", "_")
            caption = f"{label} on the path: forces, and internal variables or work and losses."
            figures[name] = captioned(draw_driven(run, label), caption)
        return figures


def read_path(path: Path) -> xarray.Dataset:
    """Return the path of a CSV or netCDF file in SI, over `time`: `PATH`, and `FORCES` as far as it has them.

    Raises:
        OSError: the file cannot be read.
        MeasurementError: it has no path, or a faulty one.
    """
    try:
        check_file(path)
        if fault := damage(path):
            raise MeasurementError(fault)
        table = read_table(path)
        prescribed = [name for name in PATH if name in table.names]
        moved = {"slip", "velocity"} & {*prescribed}
        if "time" not in table.names or len(moved) != 1 or len(prescribed) != 2:
            raise MeasurementError(
                "it has no path; it must have time, slip or velocity, and either gap or normal."
            )
        units = {"time": "s"} | {name: PATH[name] for name in prescribed} | dict.fromkeys(FORCES, "N")
        units |= {"velocity_error": PATH["velocity"]} if "velocity" in moved else {}
        # A run has other variables.
        if table.dimension != "time":
            table.check_names([*units, *(f"{name}_error" for name in FORCES)])
        columns = {name: table.numbers(name, unit) for name, unit in units.items() if name in table.names}
    except ValueError as error:
        raise MeasurementError(f"'{path}': {error}") from error
    time = columns["time"]
    if time.size < FEWEST or not (np.diff(time) > 0.0).all():
        raise MeasurementError(
            f"'{path}': time has {time.size} values from {time.min(initial=np.inf):.9g} s; it must have at "
            f"least {FEWEST} that increase."
        )
    about = {}
    if "velocity" in columns:
        columns["slip"], about[NOTE] = integrated(time, columns["velocity"], columns.get("velocity_error"))
    units["slip"] = PATH["slip"]
    return xarray.Dataset(
        {name: ("time", values, {"units": units[name]}) for name, values in columns.items()}, attrs=about
    )


def _driven(setup: Setup, path: xarray.Dataset, times: Mapping[str, Any]) -> Part:
    prescribed: dict[str, Any] = {name: path[name].values for name in PATH if name in path}
    prescribed.pop("velocity", None)
    try:
        run = drive(setup.law, path["time"].values, **prescribed, **times)
    except (ValueError, LawError) as error:
        raise ConfigurationError(f"law={setup.law.name}: {error}") from error
    if run.ending is Ending.INTERRUPTED:
        raise KeyboardInterrupt(run.message)
    return Part(run.tree)
