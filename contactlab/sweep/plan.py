"""What a map runs: a configuration for every combination of swept values, cut into chunks."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from math import ceil, prod
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from contactlab import plausibility
from contactlab.config import Setup, build
from contactlab.laws import law_class
from contactlab.output.provenance import digest_of
from contactlab.sweep.cells import Axis, Value
from contactlab.sweep.job import code_of
from contactlab.sweep.many import Wanted

Configuration = Mapping[str, Any]

METRICS_SOURCES: Final = Path(plausibility.__file__).parent


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
        places = np.unravel_index(cell, self.shape)
        return tuple(axis.values[int(place)] for axis, place in zip(self.axes, places, strict=True))

    def setup(self, cell: int) -> Setup:
        """What runs in a cell.

        Raises:
            ConfigurationError: the values are faulty together.
        """
        return build(self.configuration(self.point(cell)))

    def configuration(self, point: Sequence[Value]) -> Configuration:
        """The configuration with a value on each axis."""
        base = 0
        for axis, value in zip(self.axes, point, strict=True):
            if axis.name in self.groups:
                base = base * len(axis.values) + axis.values.index(value)
        found = self.bases[base]
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


def code_digest_of(bases: Sequence[Configuration]) -> str:
    """Digest of what the numbers depend on beside the plan: the laws' code, and that of the metrics."""
    laws = [law_class(base["law"]["name"]) for base in bases]
    parts = [part for law in laws for part in code_of(law)]
    return sha256("\0".join([*parts, digest_of(METRICS_SOURCES)]).encode()).hexdigest()


def with_key(configuration: Configuration, path: Sequence[str], value: Value) -> Configuration:
    """A configuration with another value of a key; what the key lies in is copied, the rest shared."""
    first, *rest = path
    if not rest:
        return {**configuration, first: value}
    below = configuration.get(first)
    inner = below if isinstance(below, Mapping) else {}
    return {**configuration, first: with_key(inner, rest, value)}
