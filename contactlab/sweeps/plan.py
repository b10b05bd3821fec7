"""What a sweep runs: a configuration for every combination of swept values, or for every sample."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from math import ceil, prod
from pathlib import Path
from typing import Any, Final, Literal, final

import numpy as np
from pydantic import TypeAdapter

from contactlab import metrics
from contactlab.config import ConfigurationError, Setup, build
from contactlab.config.nesting import Value
from contactlab.laws import law_class
from contactlab.metrics import METRICS
from contactlab.results.provenance import digest_of
from contactlab.suggestion import suggestion
from contactlab.sweeps.dataset import SERIES, Axis
from contactlab.sweeps.state import code_of
from contactlab.sweeps.values import listed

Configuration = Mapping[str, Any]

SOURCES: Final = (Path(metrics.__file__).parent, Path(__file__).parent)
"""Of what `code_of` leaves out, because a single run does not depend on it."""


@final
@dataclass(frozen=True)
class Outputs:
    """Names what is kept of every run: metrics of `contactlab.metrics.METRICS`, and series kept whole."""

    metrics: tuple[str, ...] = tuple(key for key, metric in METRICS.items() if metric.usual)
    series: tuple[str, ...] = ()

    @classmethod
    def named(cls, metrics: Iterable[str] | str | None, series: Iterable[str] | str) -> "Outputs":
        """Take names, each once; None stands for the usual metrics and 'all' for all of them.

        Raises:
            ConfigurationError: a name that is no metric or no series, or nothing at all.
        """
        chosen = cls.metrics if metrics is None else METRICS if metrics == "all" else metrics
        asked = {
            kind: tuple(dict.fromkeys(listed(names) if isinstance(names, str) else names))
            for kind, names in {"metric": chosen, "series": series}.items()
        }
        for (kind, names), known in zip(asked.items(), ([*METRICS], [*SERIES]), strict=True):
            for name in {*names} - {*known}:
                hint = suggestion(name, known, f"One is {known[0]}.")
                raise ConfigurationError(
                    [f"There is no {kind} '{name}'; it must be one of {', '.join(known)}. {hint}"]
                )
        if not any(asked.values()):
            raise ConfigurationError(
                ["Nothing is asked for; there must be one metric or series at least."]
            )
        return cls(*asked.values())

    @property
    def sampled(self) -> bool:
        """Whether more records than the last are needed."""
        return bool(self.series) or any(METRICS[key].needs_records for key in self.metrics)

    def interval(self, setup: Setup) -> float:
        """Give the time between records [s]: as configured where any but the last are needed."""
        return setup.record_interval if self.sampled else setup.duration


@final
@dataclass(frozen=True, kw_only=True)
class Plan:
    """Says what a sweep runs.

    Args:
        axes: what is swept, the last one changing first.
        samples: whether the n-th run has the n-th value of every axis; else every combination runs.
        outputs: what is kept of every run.
        groups: keys of the axes whose values are options of a group of the configuration.
        choices: the combinations of options that there are, in the order of the groups.
        bases: a configuration for each of them.
        chunk: runs in a chunk.
        code: digest of the code that makes the numbers.
    """

    axes: tuple[Axis, ...]
    samples: bool
    outputs: Outputs
    groups: tuple[str, ...] = ()
    choices: tuple[tuple[Value, ...], ...] = ((),)
    bases: tuple[Configuration, ...] = field(default=({},))
    chunk: int = 1
    code: str = ""
    keep: Literal["metrics"] = "metrics"

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of values along each dimension."""
        sizes = tuple(len(axis.values) for axis in self.axes)
        return sizes[:1] if self.samples else sizes

    @property
    def cells(self) -> int:
        """The number of runs."""
        return prod(self.shape)

    @property
    def chunks(self) -> range:
        """The numbers of the chunks."""
        return range(ceil(self.cells / self.chunk))

    def cells_of(self, chunk: int) -> range:
        """Give the cells of a chunk."""
        return range(self.cells)[chunk * self.chunk : (chunk + 1) * self.chunk]

    def places(self, cell: int) -> list[int]:
        """Give the place of a cell's value on each axis."""
        found = [int(place) for place in np.unravel_index(cell, self.shape)]
        return found * len(self.axes) if self.samples else found

    def point(self, cell: int) -> dict[str, Value]:
        """Give the value of each key in a cell."""
        places = zip(self.axes, self.places(cell), strict=True)
        return {axis.key: axis.values[place] for axis, place in places}

    def configuration(self, cell: int) -> Configuration:
        """Give what runs in a cell."""
        point = self.point(cell)
        found = self.bases[self.choices.index(tuple(point.pop(group) for group in self.groups))]
        for key, value in point.items():
            found = with_key(found, key.split("."), value)
        return found

    def setup_at(self, cell: int) -> Setup:
        """Build what runs in a cell; a ConfigurationError says what is faulty in its values together."""
        return build(self.configuration(cell))

    def text(self) -> str:
        """Write the plan as JSON, the same for the same plan."""
        return json.dumps(asdict(self), indent=1, ensure_ascii=False)

    @classmethod
    def of_text(cls, text: str | bytes) -> "Plan":
        """Read the plan that `text` wrote; a ValueError tells that it is something else."""
        return TypeAdapter(cls).validate_json(text)


def code_digest_of(bases: Sequence[Configuration]) -> str:
    """Give the digest of what the numbers depend on beside the plan: laws, metrics and sweeps."""
    laws = [law_class(base["law"]["name"]) for base in bases]
    parts = [part for law in laws for part in code_of(law)]
    return sha256("\0".join([*parts, *map(digest_of, SOURCES)]).encode()).hexdigest()


def with_key(configuration: Configuration, path: Sequence[str], value: Value) -> Configuration:
    """Give a configuration with another value of a key; what the key lies in is copied, the rest shared."""
    first, *rest = path
    below = configuration.get(first)
    inner = below if isinstance(below, Mapping) else {}
    return {**configuration, first: with_key(inner, rest, value) if rest else value}
