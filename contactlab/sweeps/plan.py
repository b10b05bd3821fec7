"""What a sweep runs: a configuration for every combination of swept values, or for every sample."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from hashlib import sha256
from math import ceil, prod
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from contactlab import metrics
from contactlab.config import Setup, build
from contactlab.config.nesting import Value
from contactlab.laws import law_class
from contactlab.metrics import METRICS
from contactlab.results.provenance import digest_of
from contactlab.suggestion import suggestion
from contactlab.sweeps.dataset import SERIES, Axis
from contactlab.sweeps.state import code_of

Configuration = Mapping[str, Any]

Resolve = Callable[[Configuration], Configuration]
"""Gives a configuration without references to others of its values."""

SOURCES: Final = (Path(metrics.__file__).parent, Path(__file__).parent)
"""Of what `code_of` leaves out, because a single run does not depend on it."""

AT_ANY_INTERVAL: Final = tuple(k for k, metric in METRICS.items() if not metric.needs_records)
"""Metrics that need no records but the last, so that none is taken where only these are asked for."""

USUAL: Final = tuple(key for key, metric in METRICS.items() if metric.usual)
"""Metrics where none are named: those that cost next to nothing."""


@final
@dataclass(frozen=True)
class Outputs:
    """Names what is kept of every run.

    Args:
        metrics: keys of `contactlab.metrics.METRICS`.
        series: names of `contactlab.variables.SERIES`, kept whole.
    """

    metrics: tuple[str, ...] = USUAL
    series: tuple[str, ...] = ()

    @classmethod
    def named(cls, metrics: Iterable[str] | str | None, series: Iterable[str] | str) -> "Outputs":
        """Take names, each once; None stands for the usual metrics and 'all' for all of them.

        Raises:
            ValueError: a name that is no metric or no series, or nothing at all.
        """
        usual: Iterable[str] = USUAL if metrics is None else METRICS
        chosen = usual if metrics is None or metrics == "all" else _names(metrics)
        asked = {"metric": dict.fromkeys(chosen), "series": dict.fromkeys(_names(series))}
        known = {"metric": list(METRICS), "series": list(SERIES)}
        for kind, names in asked.items():
            for name in names:
                if name not in known[kind]:
                    hint = suggestion(name, known[kind], f"One is {known[kind][0]}.")
                    raise ValueError(
                        f"There is no {kind} '{name}'; it must be one of {', '.join(known[kind])}. {hint}"
                    )
        if not any(asked.values()):
            raise ValueError("Nothing is asked for; there must be one metric or series at least.")
        return cls(tuple(asked["metric"]), tuple(asked["series"]))

    @property
    def sampled(self) -> bool:
        """Whether more records than the last are needed."""
        return bool(self.series) or not set(self.metrics) <= set(AT_ANY_INTERVAL)

    def interval(self, setup: Setup) -> float:
        """The time between records [s]: as configured where any but the last are needed."""
        return setup.record_interval if self.sampled else setup.duration


@final
@dataclass(frozen=True)
class Plan:
    """Says what a sweep runs.

    Args:
        axes: what is swept, the last one changing first.
        groups: keys of the axes whose values are options of a group of the configuration.
        choices: the combinations of options that there are, in the order of the groups.
        bases: a configuration for each of them.
        samples: whether the n-th run has the n-th value of every axis; else every combination runs.
        outputs: what is kept of every run.
        chunk: runs in a chunk.
        code: digest of the code that makes the numbers.
    """

    axes: tuple[Axis, ...]
    groups: tuple[str, ...]
    choices: tuple[tuple[Value, ...], ...]
    bases: tuple[Configuration, ...]
    samples: bool
    outputs: Outputs
    chunk: int
    code: str

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """The number of values along each dimension."""
        sizes = tuple(len(axis.values) for axis in self.axes)
        return sizes[:1] if self.samples else sizes

    @property
    def cells(self) -> int:
        """The number of runs."""
        return prod(self.shape)

    @property
    def chunks(self) -> int:
        """The number of chunks."""
        return ceil(self.cells / self.chunk)

    def cells_of(self, chunk: int) -> range:
        """Give the cells of a chunk."""
        return range(chunk * self.chunk, min((chunk + 1) * self.chunk, self.cells))

    def places(self, cell: int) -> tuple[int, ...]:
        """Give the place of a cell's value on each axis."""
        if self.samples:
            return (cell,) * len(self.axes)
        return tuple(map(int, np.unravel_index(cell, self.shape)))

    def point(self, cell: int) -> dict[str, Value]:
        """Give the value of each key in a cell."""
        places = self.places(cell)
        return {axis.key: axis.values[place] for axis, place in zip(self.axes, places, strict=True)}

    def base_of(self, point: Mapping[str, Value]) -> int:
        """Tell which of the bases the values belong to."""
        return self.choices.index(tuple(point[group] for group in self.groups))

    def configuration(self, point: Mapping[str, Value]) -> Configuration:
        """Give the configuration with these values."""
        found = self.bases[self.base_of(point)]
        for key, value in point.items():
            if key not in self.groups:
                found = with_key(found, key.split("."), value)
        return found

    def text(self) -> str:
        """Write the plan as JSON, the same for the same plan."""
        return json.dumps({"keep": "metrics", **asdict(self)}, indent=1, ensure_ascii=False)

    @classmethod
    def of_text(cls, text: str) -> "Plan":
        """Read the plan that `text` wrote.

        Raises:
            ValueError, TypeError, LookupError: it is something else.
        """
        read = json.loads(text)
        return cls(
            axes=tuple(Axis(**axis | {"values": tuple(axis["values"])}) for axis in read["axes"]),
            groups=tuple(read["groups"]),
            choices=tuple(map(tuple, read["choices"])),
            bases=tuple(read["bases"]),
            samples=bool(read["samples"]),
            outputs=Outputs(tuple(read["outputs"]["metrics"]), tuple(read["outputs"]["series"])),
            chunk=int(read["chunk"]),
            code=str(read["code"]),
        )


@final
class Setups:
    """Gives what runs in each cell of a plan.

    Args:
        plan: the plan.
        resolve: where the bases have references.
    """

    def __init__(self, plan: Plan, resolve: Resolve | None = None) -> None:
        self._plan = plan
        self._resolve = resolve

    def __call__(self, cell: int) -> Setup:
        """Build what runs in a cell.

        Raises:
            ConfigurationError: the values are faulty together.
        """
        configuration = self._plan.configuration(self._plan.point(cell))
        return build(self._resolve(configuration) if self._resolve else configuration)


def code_digest_of(bases: Sequence[Configuration]) -> str:
    """Give the digest of what the numbers depend on beside the plan: laws, metrics and sweeps."""
    laws = [law_class(base["law"]["name"]) for base in bases]
    parts = [part for law in laws for part in code_of(law)]
    return sha256("\0".join([*parts, *map(digest_of, SOURCES)]).encode()).hexdigest()


def with_key(configuration: Configuration, path: Sequence[str], value: Value) -> Configuration:
    """Give a configuration with another value of a key; what the key lies in is copied, the rest shared."""
    first, *rest = path
    if not rest:
        return {**configuration, first: value}
    below = configuration.get(first)
    inner = below if isinstance(below, Mapping) else {}
    return {**configuration, first: with_key(inner, rest, value)}


def _names(given: Iterable[str] | str) -> list[str]:
    """Give names that stand in a list, or in a text with commas."""
    listed = given.split(",") if isinstance(given, str) else given
    return [name.strip() for name in listed if name.strip()]
