"""The plan of a sweep: a configuration for every combination of swept values, or for every sample.

Every value is checked beforehand, and every fault told.
"""

import json
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from itertools import product
from math import ceil, prod
from typing import TYPE_CHECKING, Any, Final, Literal, Protocol, final

import numpy as np
from pydantic import TypeAdapter

from contactlab.config import ConfigurationError, Setup, build, validate
from contactlab.config.nesting import Value, flat
from contactlab.config.quantity import describe
from contactlab.config.schema import declared_in
from contactlab.config.studies import study_of
from contactlab.laws import ContactLaw
from contactlab.parameter import Parameter
from contactlab.settling.until import STEADY
from contactlab.suggestion import suggestion
from contactlab.sweeps.dataset import Axis
from contactlab.sweeps.outputs import Outputs
from contactlab.sweeps.state import code_digest_of
from contactlab.sweeps.values import FORMS, MOST_RUNS, SweepError, call_in, in_si, spread

if TYPE_CHECKING:
    from contactlab.studies.study import Study

CHUNK: Final = 100
"""Least number of runs in a task: a file of each is written."""

MOST_TASKS: Final = 1000
"""Number of tasks from which on each has more runs."""

NOTHING: Final = (
    f"Nothing is swept; there must be one parameter at least: KEY={FORMS}. One run alone needs no sweep."
)

MOST_JOBS: Final = 100_000
"""Runs that leave a folder each, which takes a fifth of a second beside the run."""

Configuration = Mapping[str, Any]

ONE_PROCESS: Final[Configuration] = {"workers": 1, "scheduler": None}
"""Options of a study in a sweep, whose workers do whole cells."""

_TIMES: Final = ("solver.duration", "solver.until", "solver.precision", "record.interval")

Columns = Mapping[str, Sequence[Value]]
"""What is swept: values by key or group, each a number, a text, or a text that stands for several."""


@final
@dataclass(frozen=True, kw_only=True)
class Plan:
    """Runs of a sweep: every combination of the axes, the last one changing first, or samples.

    Args:
        samples: whether the n-th run has the n-th value of every axis.
        groups: keys of the axes whose values are options of a group of the configuration.
        choices: the combinations of options that there are, in the order of the groups.
        bases: a configuration for each of them.
        chunk: runs in a task.
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
    keep: Literal["runs", "metrics"] = "metrics"

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of values along each dimension."""
        sizes = tuple(len(axis.values) for axis in self.axes)
        return sizes[:1] if self.samples else sizes

    @property
    def cells(self) -> int:
        """The number of runs."""
        return prod(self.shape)

    def rows(self, cells: range) -> "Plan":
        """Return the plan of some cells alone, as samples."""
        places = [self.places(cell) for cell in cells]
        axes = (
            replace(axis, values=tuple(axis.values[row[number]] for row in places))
            for number, axis in enumerate(self.axes)
        )
        return replace(self, axes=tuple(axes), samples=True)

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
            found = with_key(found, key, value)
        return found

    def setup_at(self, cell: int) -> Setup:
        """Build what runs in a cell; a ConfigurationError says what is faulty in its values together."""
        return build(self.configuration(cell))

    def study_at(self, cell: int) -> "Study":
        """Return the study that is put to the setup of a cell."""
        return study_of(validate(self.configuration(cell))["study"])

    def text(self) -> str:
        """Write the plan as JSON, the same for the same plan."""
        return json.dumps(asdict(self), indent=1, ensure_ascii=False)

    @classmethod
    def of_text(cls, text: str | bytes) -> "Plan":
        """Read the plan that `text` wrote; a ValueError tells that it is something else."""
        return TypeAdapter(cls).validate_json(text)


def size_of_tasks(cells: int) -> int:
    """Return the number of runs in a task."""
    return max(CHUNK, ceil(cells / MOST_TASKS))


class Composer(Protocol):
    """Gives configurations from the options of groups; a ConfigurationError says why it cannot."""

    def options(self, key: str) -> list[str]:
        """Give the options of a group; none for what is no group."""

    def compose(self, chosen: Mapping[str, Value]) -> Configuration:
        """Give the configuration with these options, all else as it is set."""

    def build(self, configuration: Configuration) -> Setup:
        """Build what a configuration says."""


def planned(
    composer: Composer,
    columns: Columns,
    outputs: Outputs,
    *,
    samples: bool = False,
    chunk: int | None = None,
    keep: Literal["runs", "metrics"] = "metrics",
) -> Plan:
    """Plan a sweep over values by full key or group, and check every value, or every row of a table.

    Raises:
        ConfigurationError: with every fault that was found.
    """
    groups = {key: options for key in columns if (options := composer.options(key))}
    raise_faults(_faults_of(columns, groups, outputs))
    listing = [columns[group] for group in groups]
    combined = zip(*listing, strict=True) if samples and groups else product(*listing)
    choices = tuple(dict.fromkeys(combined))
    bases = tuple(composer.compose(dict(zip(groups, chosen, strict=True))) for chosen in choices)
    if keep == "metrics":
        bases = tuple(_without_workers(base) for base in bases)
    if outputs.series and any(base["solver"].get("until") == STEADY for base in bases):
        words = (
            "solver.until is steady and series are kept; they must be at the same times in every run. Keep "
        )
        raise ConfigurationError([f"{words}none, or leave it out."])
    values = {key: column for key, column in columns.items() if key not in groups}
    trials = _trials(bases, values)
    outputs = outputs.of_laws(_laws(composer, trials))
    declared: Mapping[str, Parameter] = {}
    if values:
        sound = _sound(composer, trials).configuration
        chosen = {"study": bases[0]["study"]} if "study" in bases[0] else {}
        declared = declared_in({**sound, **chosen})
    axes: list[Axis] = []
    faults: list[str] = []
    for key, column in columns.items():
        said = declared.get(key)
        units, meaning = (said.units, said.meaning) if said else ("", "")
        found = [in_si(value, units) for value in column]
        if not samples and key in values:
            try:
                found = [one for value in column for one in spread(key, value, units)]
            except SweepError as error:
                faults.append(str(error))
                continue
            tried = ([with_key(trial, key, value) for trial in trials] for value in found)
            deque(_built(composer, tried, faults), maxlen=0)
        if not samples and len({*found}) < len(found):
            faults.append(f"{key} has a value twice; give every value once.")
        axes.append(Axis(key, tuple(found), units, meaning))
    raise_faults(faults)
    sizes = [len(axis.values) for axis in (axes[:1] if samples else axes)]
    if prod(sizes) > (most := MOST_JOBS if keep == "runs" else MOST_RUNS):
        asked = f"{' x '.join(map(str, sizes))} = {prod(sizes):.4g} runs are asked for"
        way_out = ", or sweep.keep=metrics, which keeps numbers alone" if keep == "runs" else ""
        words = f"{asked}; a sweep must have at most {most}. Take fewer values{way_out}."
        raise ConfigurationError([words])
    plan = Plan(
        axes=tuple(axes),
        samples=samples,
        outputs=outputs,
        groups=tuple(groups),
        choices=choices,
        bases=bases,
        chunk=chunk or size_of_tasks(prod(sizes)),
        code=code_digest_of(bases),
        keep=keep,
    )
    if samples:
        deque(setups_of(plan, composer), maxlen=0)
    return plan


def setups_of(plan: Plan, composer: Composer) -> Iterator[Setup]:
    """Build every run of a plan, cell by cell, and refuse those that are not sound at the end."""
    faults: list[str] = []
    tried = ([plan.configuration(cell)] for cell in range(plan.cells))
    yield from _built(composer, tried, faults)
    raise_faults(faults)


def full_keys(columns: Columns, composer: Composer) -> dict[str, Sequence[Value]]:
    """Put full keys in the place of names that are the end of one: 'contact.clearance' for 'clearance'.

    The parts of a name may be joined as in the names of a dataset. A name that is the end of several is
    refused by a ConfigurationError.
    """
    known = flat(composer.compose({}))
    found: dict[str, Sequence[Value]] = {}
    for name, column in columns.items():
        whole = name in known or composer.options(name)
        ends = [] if whole else [k for k in known if f"_{k.replace('.', '_')}".endswith(f"_{name}")]
        if len(ends) > 1:
            raise ConfigurationError([f"{name} may be {' or '.join(ends)}. Name one of them."])
        key = ends[0] if ends else name
        if key in found:
            raise ConfigurationError([f"{key} is swept by two names, {name} one of them. Leave one out."])
        found[key] = column
    return found


def raise_faults(faults: Iterable[str]) -> None:
    """Raise a ConfigurationError of the faults, each told once; nothing where there is none."""
    if told := list(dict.fromkeys(faults)):
        raise ConfigurationError(told)


def with_key(configuration: Configuration, key: str, value: Value) -> Configuration:
    """Give a configuration with another value of a key; what does not hold the key is shared."""
    first, _, rest = key.partition(".")
    below = configuration.get(first)
    inner = below if isinstance(below, Mapping) else {}
    return {**configuration, first: with_key(inner, rest, value) if rest else value}


def _without_workers(base: Configuration) -> Configuration:
    """Return a configuration whose study is done by one process: those of the sweep share its runs."""
    return {**base, "study": {**base["study"], **ONE_PROCESS}} if "study" in base else base


def _faults_of(columns: Columns, groups: Mapping[str, Sequence[str]], outputs: Outputs) -> Iterator[str]:
    """Say what can be no sweep at all."""
    for key, column in columns.items():
        if not len(column):
            yield f"{key} has no values; it must have one at least. Name one."
        for value in column:
            if not isinstance(value, float | int | str):
                yield f"{key} has the value {value}; each must be a number, a text or true or false."
            elif key in groups and value not in groups[key]:
                hint = suggestion(str(value), groups[key], "Choose from them.")
                listing = ", ".join(groups[key])
                yield f"{key} is {describe(value)}; it must be one of {listing}. {hint}"
        if outputs.series and key in _TIMES:
            yield (
                f"{key} is swept and series are kept; they must be at the same times in every run. Keep "
                "none, or set it."
            )


def _built(
    composer: Composer, tried: Iterable[Sequence[Configuration]], faults: list[str]
) -> Iterator[Setup]:
    """Build the first sound trial of each of many; what is wrong where there is none is added to faults."""
    for trials in tried:
        try:
            yield _sound(composer, trials)
        except ConfigurationError as error:
            faults += error.faults


def _sound(composer: Composer, trials: Sequence[Configuration]) -> Setup:
    """Build the first trial that is sound; where none is, raise the faults of the first."""
    for trial in trials:
        with suppress(ConfigurationError):
            return composer.build(trial)
    return composer.build(trials[0])


def _laws(composer: Composer, trials: Iterable[Configuration]) -> Iterator[ContactLaw]:
    """Give the laws of the trials that are sound."""
    for trial in trials:
        with suppress(ConfigurationError):
            yield composer.build(trial).law


def _trials(bases: Sequence[Configuration], columns: Columns) -> list[Configuration]:
    """Give combinations that values are tried in: every base, and it with the first and the last values."""
    found = list(bases)
    for trial, end in product(bases, (0, -1)):
        for key, column in columns.items():
            call = call_in(column[end])
            # Of what is spaced the ends are tried.
            trial = with_key(trial, key, call[1][:2][end] if call else column[end])
        found.append(trial)
    return found
