"""A study of many short tasks, for tests of what does them."""

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import xarray

import contactlab as cl
from contactlab.studies import Part, Study, Task
from contactlab.studies.study import Setups, run


@dataclass(frozen=True, kw_only=True)
class Slow(Study):
    """What is the final velocity of twelve runs of one setup?"""

    name: ClassVar[str] = "slow"

    def tasks(self, setups: Setups) -> Iterable[Task]:
        (setup,) = setups.values()
        return [Task(str(number), velocity, (setup, number)) for number in range(12)]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        return xarray.DataTree(xarray.concat([part.to_dataset() for part in parts.values()], "number"))

    def numbers(self, data: xarray.DataTree) -> dict[str, cl.Estimate]:
        return {}


def velocity(setup: cl.Setup, number: int) -> Part:
    time.sleep(0.3)
    run = setup.run(duration=setup.duration * (1.0 + number / 12.0))
    final = run.series["rotor_velocity"][-1]
    return Part(xarray.DataTree(xarray.Dataset({"velocity": ((), final)}, {"number": number})))


def run_by_workers() -> None:
    run(Slow(workers=2), {"": cl.build(["solver.duration=1 ms"])})
