"""The study `simulate`: one run of the configured duration."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from contactlab.estimate import Estimate
from contactlab.metrics import METRICS, assess
from contactlab.results.netcdf import to_datatree
from contactlab.studies.study import Part, Setups, Study, Task
from contactlab.variables import Variable

if TYPE_CHECKING:
    import xarray

    from contactlab.config import Setup


@dataclass(frozen=True, kw_only=True)
class Simulate(Study):
    """What does the motor do from its start to the end of the configured duration?"""

    name: ClassVar[str] = "simulate"
    ignored: ClassVar[tuple[str, ...]] = ()
    quantities: ClassVar[tuple[Variable, ...]] = tuple(
        Variable(key, (), metric.units, metric.symbol, metric.meaning)
        for key, metric in METRICS.items()
        if metric.usual
    )

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return one run a setup."""
        return [Task(label, _simulated, (setup,)) for label, setup in setups.items()]

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the usual metrics; a single run has no estimate of their error."""
        every = assess(data, [quantity.name for quantity in self.quantities])
        return {name: Estimate(value, float("nan")) for name, value in every.items()}


def _simulated(setup: Setup) -> Part:
    return Part(to_datatree(setup.run(), setup.configuration))
