"""The study `synthetic`: measurements made by a known law, to which laws can be fitted."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, ClassVar

import xarray

from contactlab.config import ConfigurationError, Setup
from contactlab.estimate import Estimate
from contactlab.studies.study import Part, Setups, Study, Task, option
from contactlab_data.inference.synthetic import made_impacts, made_series
from contactlab_data.measured.files import to_xarray
from contactlab_data.measured.series import MEASURABLE


@dataclass(frozen=True, kw_only=True)
class Synthetic(Study):
    """What would be measured of a motor, or of impacts, under a known law?

    Series of the motor with white noise, or with impacts=N an ellipse that hits a plate. The file contains
    the truth, which `contactlab fit` compares with what it finds.
    """

    name: ClassVar[str] = "synthetic"
    ignored: ClassVar[tuple[str, ...]] = ("record.picture", "solver.changes")

    impacts: Annotated[
        int | None, option("number of impacts, instead of series", at_least=1, at_most=1_000_000)
    ] = None
    series: Annotated[list[str] | None, option("series of the motor; rotor_velocity")] = None
    noise: Annotated[
        float, option("standard deviation over the size of the data", above=0.0, at_most=1.0)
    ] = 0.01
    seed: Annotated[int, option("seed of all random numbers", at_least=0)] = 0

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return the one task.

        Raises:
            ConfigurationError: there is no such series.
        """
        names = self.series or ["rotor_velocity"]
        if unknown := [name for name in names if name not in MEASURABLE]:
            raise ConfigurationError(
                f"study.series is {', '.join(unknown)}; it must be some of {', '.join(MEASURABLE)}."
            )
        if self.series and self.impacts:
            raise ConfigurationError("study.series and study.impacts exclude each other; leave one out.")
        (setup,) = setups.values()
        return [Task("", _synthetic, (setup, self.impacts, names, self.noise, self.seed))]

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the number of impacts or times."""
        (size,) = {n for name, n in data.to_dataset().sizes.items() if name in ("impact", "time")}
        return {"size": Estimate(float(size), 0.0)}

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return what was made."""
        return [f"{data.attrs['title']}: {', '.join(map(str, data.to_dataset().data_vars))}."]


def _synthetic(setup: Setup, impacts: int | None, names: list[str], noise: float, seed: int) -> Part:
    if impacts is None:
        return Part(xarray.DataTree(made_series(setup, names, noise, seed).to_xarray()))
    made = made_impacts(setup.law, impacts, noise, seed, setup.configuration)
    return Part(xarray.DataTree(to_xarray(made)))
