"""What a map runs: a configuration for every combination of swept values, cut into chunks."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from math import ceil, prod
from pathlib import Path
from typing import Any, Final, final

from contactlab import metrics
from contactlab.config import Setup, build, validate
from contactlab.config.nesting import Value
from contactlab.config.schema import Section
from contactlab.laws import law_class
from contactlab.results.provenance import digest_of
from contactlab.sweeps.cells import Axis
from contactlab.sweeps.job import code_of
from contactlab.sweeps.many import Wanted

Configuration = Mapping[str, Any]

SOURCES: Final = (Path(metrics.__file__).parent, Path(__file__).parent)
"""Of what `code_of` leaves out, because a single run does not depend on it."""


@final
@dataclass(frozen=True)
class Plan:
    """A map.

    Args:
        axes: what is swept, the last one changing first.
        groups: names of the axes whose values are options of a group of the configuration.
        bases: a configuration for every combination of options of the groups, in the same order; one
            where no group is swept.
        wanted: what is kept of every run.
        chunk: runs in a chunk.
        code: digest of the code that makes the numbers, see `code_digest_of`.
    """

    axes: tuple[Axis, ...]
    groups: tuple[str, ...]
    bases: tuple[Configuration, ...]
    wanted: Wanted
    chunk: int
    code: str

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values on each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def cells(self) -> int:
        """Number of runs."""
        return prod(self.shape)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return ceil(self.cells / self.chunk)

    def cells_of(self, chunk: int) -> range:
        """The cells of a chunk."""
        return range(chunk * self.chunk, min((chunk + 1) * self.chunk, self.cells))

    def point(self, cell: int) -> tuple[Value, ...]:
        """The value on each axis in a cell."""
        found = []
        for axis in reversed(self.axes):
            cell, place = divmod(cell, len(axis.values))
            found.append(axis.values[place])
        return tuple(reversed(found))

    def base_of(self, point: Sequence[Value]) -> int:
        """Which of the bases the values on the axes belong to."""
        base = 0
        for axis, value in zip(self.axes, point, strict=True):
            if axis.name in self.groups:
                base = base * len(axis.values) + axis.values.index(value)
        return base

    def configuration(self, point: Sequence[Value]) -> Configuration:
        """The configuration with a value on each axis."""
        found = self.bases[self.base_of(point)]
        for axis, value in zip(self.axes, point, strict=True):
            if axis.name not in self.groups:
                found = with_key(found, axis.name.split("."), value)
        return found

    def text(self) -> str:
        """The plan as JSON, the same for the same plan."""
        return json.dumps(
            {
                "axes": [
                    {"name": axis.name, "values": axis.values, "units": axis.units}
                    for axis in self.axes
                ],
                "groups": self.groups,
                "bases": self.bases,
                "metrics": self.wanted.metrics,
                "series": self.wanted.series,
                "chunk": self.chunk,
                "code": self.code,
            },
            indent=1,
            ensure_ascii=False,
        )

    @classmethod
    def of_text(cls, text: str) -> "Plan":
        """The plan that `text` wrote."""
        read = json.loads(text)
        return cls(
            axes=tuple(
                Axis(axis["name"], tuple(axis["values"]), axis["units"]) for axis in read["axes"]
            ),
            groups=tuple(read["groups"]),
            bases=tuple(read["bases"]),
            wanted=Wanted(tuple(read["metrics"]), tuple(read["series"])),
            chunk=read["chunk"],
            code=read["code"],
        )


@final
class Setups:
    """What runs in each cell of a plan; a section that cells have in common is checked once.

    Args:
        plan: the plan.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._checked: dict[tuple[object, ...], Section] = {}

    def __reduce__(self) -> tuple[type["Setups"], tuple[Plan]]:
        return Setups, (self._plan,)

    def __call__(self, cell: int) -> Setup:
        """What runs in a cell.

        Raises:
            ConfigurationError: the values are faulty together.
        """
        plan = self._plan
        point = plan.point(cell)
        base = plan.base_of(point)
        keys: dict[str, tuple[object, ...]] = {name: (base, name) for name in plan.bases[0]}
        for axis, value in zip(plan.axes, point, strict=True):
            if axis.name not in plan.groups:
                section = axis.name.partition(".")[0]
                keys[section] = (*keys.get(section, ()), axis.name, value)
        if not all(key in self._checked for key in keys.values()):
            checked = validate(plan.configuration(point))
            self._checked |= {key: getattr(checked, section) for section, key in keys.items()}
        return build({section: self._checked[key] for section, key in keys.items()})


def code_digest_of(bases: Sequence[Configuration]) -> str:
    """Digest of what the numbers depend on beside the plan: the code of laws, metrics and maps."""
    laws = [law_class(base["law"]["name"]) for base in bases]
    parts = [part for law in laws for part in code_of(law)]
    return sha256("\0".join([*parts, *map(digest_of, SOURCES)]).encode()).hexdigest()


def with_key(configuration: Configuration, path: Sequence[str], value: Value) -> Configuration:
    """A configuration with another value of a key; what the key lies in is copied, the rest shared."""
    first, *rest = path
    if not rest:
        return {**configuration, first: value}
    below = configuration.get(first)
    inner = below if isinstance(below, Mapping) else {}
    return {**configuration, first: with_key(inner, rest, value)}
