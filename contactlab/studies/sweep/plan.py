"""The plan of a sweep: what is kept of each run, and a configuration for every combination of values.

Every value is checked beforehand, and all faults are reported.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from itertools import product
from math import ceil, prod
from typing import TYPE_CHECKING, Any, Final, Literal, final

import numpy as np

from contactlab.checks import read_json
from contactlab.config import ConfigurationError, Setup, rebuild
from contactlab.config.composition import options_of, with_references
from contactlab.config.faults import faults_added, raise_faults
from contactlab.config.nesting import Value, with_key
from contactlab.config.schema import KEYS, declared_in
from contactlab.config.variation import Variation
from contactlab.laws import ContactLaw
from contactlab.metrics import METRICS
from contactlab.quantity import describe
from contactlab.results.netcdf import internal_series
from contactlab.settling.criterion import STEADY
from contactlab.studies.keys import WITH_STUDY, study_in
from contactlab.studies.registry import study_class
from contactlab.studies.run_state import code_digest_of
from contactlab.studies.sweep.dataset import SERIES, Axis
from contactlab.studies.sweep.values import FORMS, MOST_RUNS, call_in, in_si, listed, spread
from contactlab.suggestion import suggestion
from contactlab.variables import INTERNAL, Variable

if TYPE_CHECKING:
    from contactlab.studies.study import Study

CHUNK: Final = 100
"""Least number of runs in a task that keeps numbers: a file of each task is written."""

FEWEST_TASKS: Final = 16
"""Tasks of a sweep of a study that has as many cells: processes share them."""

MOST_TASKS: Final = 1000
"""Number of tasks from which on each has more runs."""

NOTHING: Final = f"Nothing is swept; there must be one parameter at least: KEY={FORMS}."

MOST_JOBS: Final = 100_000
"""Runs that leave a folder each, which takes a tenth of a second beside the run."""

Configuration = Mapping[str, Any]

ONE_PROCESS: Final[Configuration] = {"workers": 1, "scheduler": None}
"""Options of a study in a sweep, whose workers do whole cells."""

_TIMES: Final = ("solver.duration", "solver.until", "solver.precision", "record.interval")

Compose = Callable[[Mapping[str, Value]], Configuration]
"""Returns the configuration with these options of groups, all else as it is set; a ConfigurationError if it
cannot."""

Columns = Mapping[str, Sequence[Value]]
"""Swept values by key or group, each a number, a text, or a text that stands for several."""


@final
@dataclass(frozen=True)
class Outputs:
    """Names of the metrics and time series that are kept of every run.

    Args:
        metrics: keys of `contactlab.metrics.METRICS`, or the numbers of a study.
        series: names of time series, internal variables of laws included.
        internal: the internal variables among the series, which depend on the laws.
        study: name of the study whose numbers are kept, each with its error, in place of metrics of a run.
    """

    metrics: tuple[str, ...] = tuple(key for key, metric in METRICS.items() if metric.usual)
    series: tuple[str, ...] = ()
    internal: tuple[Variable, ...] = ()
    study: str = ""

    @classmethod
    def of_study(cls, name: str) -> "Outputs":
        """Return the outputs of a study: its numbers."""
        return cls(tuple(variable.name for variable in cls(study=name).numbers), study=name)

    @classmethod
    def named(
        cls, metrics: Iterable[str] | str | None, series: Iterable[str] | str, group: str = ""
    ) -> "Outputs":
        """Return outputs by names, each once; None is the usual metrics and 'all' all of them.

        Faults name the keys `metrics` and `series` of a group, 'sweep.'.

        Raises:
            ConfigurationError: a name that is no metric or no series, or nothing at all.
        """
        chosen = cls.metrics if metrics is None else METRICS if metrics == "all" else metrics
        kept, recorded = (
            tuple(dict.fromkeys(listed(each) if isinstance(each, str) else each)) for each in (chosen, series)
        )
        unknown = [("metrics", name, [*METRICS]) for name in kept if name not in METRICS]
        unknown += [
            ("series", name, [*SERIES])
            for name in recorded
            if name not in SERIES and not name.startswith(INTERNAL)
        ]
        raise_faults(
            f"{group}{key} has '{name}'; it must be one of {', '.join(known)}. {suggestion(name, known)}"
            for key, name, known in unknown
        )
        if not kept and not recorded:
            raise ConfigurationError(f"{group}metrics and {group}series have none; there must be one.")
        return cls(kept, recorded)

    def of_laws(self, laws: Iterable[ContactLaw]) -> "Outputs":
        """Return the outputs with the internal variables of these laws among the series.

        Raises:
            ConfigurationError: one that no law has, or that is not the same in all that have it.
        """
        wanted = {name: set[Variable]() for name in self.series if name not in SERIES}
        for law in laws if wanted else ():
            for variable in internal_series(law):
                wanted.get(variable.name, set()).add(variable)
        raise_faults(
            f"The series '{name}' is {'ambiguous' if variables else 'unknown'} with these laws; leave it out."
            for name, variables in wanted.items()
            if len(variables) != 1
        )
        return replace(self, internal=tuple(each for variables in wanted.values() for each in variables))

    @property
    def kept(self) -> tuple[Variable, ...]:
        """The series as variables, once the laws are known."""
        known = SERIES | {each.name: each for each in self.internal}
        return tuple(known[name] for name in self.series)

    @property
    def numbers(self) -> tuple[Variable, ...]:
        """The quantities of a study and their errors as variables; none for metrics of a run."""
        every = study_class(self.study).quantities if self.study else ()
        errors = [
            replace(
                q,
                name=f"{q.name}_error",
                symbol=f"error of {q.symbol}",
                long_name=f"error of the {q.long_name}",
            )
            for q in every
        ]
        return (*every, *errors)

    @property
    def sampled(self) -> bool:
        """Whether more records than the last are needed."""
        return bool(self.series) or any(METRICS[key].needs_records for key in self.metrics if key in METRICS)


@final
@dataclass(frozen=True, kw_only=True)
class Plan:
    """Runs of a sweep: every combination of the axes, the last one changing first, or samples.

    Args:
        samples: whether the n-th run has the n-th value of every axis.
        groups: keys of the axes whose values are options of a group of the configuration.
        choices: the combinations of options that there are, in the order of the groups.
        bases: a configuration for each of them, of a run and, where a study is put to it, its section.
        chunk: runs in a task.
        code: digest of the code that makes the numbers.
    """

    axes: tuple[Axis, ...]
    samples: bool
    outputs: Outputs
    groups: tuple[str, ...] = ()
    choices: tuple[tuple[Value, ...], ...] = ((),)
    bases: tuple[Configuration, ...] = ({},)
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

    def rows(self, cells: Sequence[int]) -> "Plan":
        """Return the plan of some cells alone, as samples."""
        if not self.axes:
            return replace(self, samples=True)
        places = np.unravel_index(cells, self.shape) * (len(self.axes) if self.samples else 1)
        axes = (
            replace(axis, values=tuple(axis.values[place] for place in along))
            for axis, along in zip(self.axes, places, strict=True)
        )
        return replace(self, axes=tuple(axes), samples=True)

    def places(self, cell: int) -> list[int]:
        """Return the place of a cell's value on each axis."""
        places = [int(place) for place in np.unravel_index(cell, self.shape)]
        return places * len(self.axes) if self.samples else places

    def point(self, cell: int) -> dict[str, Value]:
        """Return the value of each key in a cell."""
        places = zip(self.axes, self.places(cell), strict=True)
        return {axis.key: axis.values[place] for axis, place in places}

    def _of_base(self, cell: int) -> tuple[int, dict[str, Value]]:
        """Return the number of a cell's base, and the value of each key that is no group."""
        point = self.point(cell)
        return self.choices.index(tuple(point.pop(group) for group in self.groups)), point

    def configuration(self, cell: int) -> Configuration:
        """Return the configuration of a cell."""
        base, point = self._of_base(cell)
        configuration = self.bases[base]
        for key, value in point.items():
            configuration = with_key(configuration, key, value)
        return configuration

    @cached_property
    def _variations(self) -> list[Variation]:
        return [Variation(base, _built) for base in self.bases]

    def setup_at(self, cell: int) -> Setup:
        """Build the setup of a cell; a ConfigurationError if its values together are faulty."""
        base, point = self._of_base(cell)
        return self._variations[base].setup(point)

    def check(self, cell: int) -> None:
        """Refuse the values of a cell together as `setup_at` does."""
        base, point = self._of_base(cell)
        self._variations[base].check(point)

    def study_at(self, cell: int) -> "Study":
        """Return the study that is put to the setup of a cell."""
        return study_in(with_references(self.configuration(cell))["study"])

    def text(self) -> str:
        """Write the plan as JSON, the same for the same plan."""
        return json.dumps(asdict(self), indent=1, ensure_ascii=False)

    @classmethod
    def of_text(cls, text: str | bytes) -> "Plan":
        """Read the plan that `text` wrote; a ValueError if it is something else."""
        return read_json(text, cls)


def size_of_tasks(cells: int, keep: str = "metrics", study: str = "") -> int:
    """Return the number of runs in a task, or of cells of a study."""
    if study:
        return max(min(study_class(study).together, cells // FEWEST_TASKS), 1)
    return max(1 if keep == "runs" else CHUNK, ceil(cells / MOST_TASKS))


def planned(
    compose: Compose,
    columns: Columns,
    outputs: Outputs,
    *,
    options: Callable[[str], Sequence[str]] = options_of,
    samples: bool = False,
    chunk: int | None = None,
    keep: Literal["runs", "metrics"] = "metrics",
) -> Plan:
    """Plan a sweep over values by full key or group, and check every value, or every row of a table.

    A value is sound if one of the combinations of options admits it, beside the first or the last values of
    the other keys; a cell whose values together are faulty is refused at its place.

    Raises:
        ConfigurationError: with every fault.
    """
    groups = {key: own for key in columns if (own := options(key))}
    raise_faults(_faults_of(columns, groups, outputs))
    listing = [columns[group] for group in groups]
    choices = tuple(dict.fromkeys(zip(*listing, strict=True) if samples and groups else product(*listing)))
    bases = tuple(compose(dict(zip(groups, chosen, strict=True))) for chosen in choices)
    if keep == "metrics" and "study" in bases[0]:
        # The workers of the sweep share its runs.
        bases = tuple({**base, "study": {**base["study"], **ONE_PROCESS}} for base in bases)
    if outputs.series and any(base["solver"].get("until") == STEADY for base in bases):
        raise ConfigurationError("solver.until is steady; series must be at the same times in every run.")
    values = {key: column for key, column in columns.items() if key not in groups}
    trials = [Variation(trial, _built) for trial in _trials(bases, values)]
    outputs = outputs.of_laws(setup.law for setup in _sound_setups(trials))
    declared = {}
    # Of groups alone too: a value that none of them admits is refused before anything is written.
    sound = (next(_sound_setups(trials), None) or trials[0].setup({})).configuration
    if values:
        study = {"study": bases[0]["study"]} if "study" in bases[0] else {}
        declared = declared_in({**sound, **study}, WITH_STUDY if study else KEYS)
    axes: list[Axis] = []
    faults: list[str] = []
    for key, column in columns.items():
        units, meaning = (declared[key].units, declared[key].meaning) if key in declared else ("", "")
        numbers = [in_si(value, units) for value in column]
        # All values of a grid are checked, those that a text stands for too.
        if not samples and key in values:
            with faults_added(faults):
                numbers = [each for value in column for each in spread(key, value, units)]
                for number in numbers:
                    with faults_added(faults):
                        _check(trials, {key: number})
        if not samples and len({*numbers}) < len(numbers):
            faults.append(f"{key} has a value twice; every value must occur once.")
        axes.append(Axis(key, tuple(numbers), units, meaning))
    raise_faults(faults)
    plan = Plan(
        axes=tuple(axes),
        samples=samples,
        outputs=outputs,
        groups=tuple(groups),
        choices=choices,
        bases=bases,
        code=code_digest_of(bases),
        keep=keep,
    )
    plan = replace(plan, chunk=chunk or size_of_tasks(plan.cells, keep, outputs.study))
    if plan.cells > (most := MOST_JOBS if keep == "runs" else MOST_RUNS):
        shown = f"{' x '.join(map(str, plan.shape))} = {plan.cells:.4g} runs"
        raise ConfigurationError(f"The sweep has {shown}; it must have at most {most} (sweep.keep={keep}).")
    for cell in range(plan.cells if samples else 0):
        with faults_added(faults):
            plan.check(cell)
    raise_faults(faults)
    return plan


def full_keys(
    columns: Columns, known: Mapping[str, object], options: Callable[[str], Sequence[str]] = options_of
) -> Columns:
    """Return columns by full key in place of a name that is the end of one: 'clearance'.

    The parts of a name may be joined as in the names of a dataset.

    Args:
        columns: values by name.
        known: the full keys, each with what it stands for; keys of the same are one.
        options: returns the options of a group, none for what is no group.

    Raises:
        ConfigurationError: a name is the end of several keys, or two names stand for one.
    """
    full: dict[str, Sequence[Value]] = {}
    swept: set[object] = set()
    for name, column in columns.items():
        whole = name in known or options(name)
        ends = [name] if whole else [k for k in known if f"_{k.replace('.', '_')}".endswith(f"_{name}")]
        different = {known.get(key, key): key for key in reversed(ends)}
        if len(different) > 1:
            raise ConfigurationError(f"{name} may be {' or '.join(ends)}. Name one of them.")
        what, key = next(iter(different.items()), (name, name))
        if what in swept:
            raise ConfigurationError(f"{key} is swept by two names, {name} one of them. Leave one out.")
        swept.add(what)
        full[key] = column
    return full


def _built(configuration: Configuration) -> Setup:
    """Build the setup of a cell, and check its study where it has one.

    Raises:
        ConfigurationError: with every fault.
    """
    run = with_references(configuration)
    if "study" in run and (study := study_in(run.pop("study"))).base:
        raise ConfigurationError(
            f"study.data state a motor of their own; a sweep of {study.name} would not be of it."
        )
    return rebuild(run)


def _faults_of(columns: Columns, groups: Mapping[str, Sequence[str]], outputs: Outputs) -> Iterator[str]:
    """Yield why columns can be no sweep at all."""
    for key, column in columns.items():
        if not len(column):
            yield f"{key} has no values; it must have one at least."
        for value in column:
            if not isinstance(value, float | int | str):
                yield f"{key} has the value {value}; it must be a number, a text, true or false."
            elif key in groups and value not in groups[key]:
                listing, hint = ", ".join(groups[key]), suggestion(str(value), groups[key])
                yield f"{key} is {describe(value)}; it must be one of {listing}. {hint}"
        if outputs.series and key in _TIMES:
            yield f"{key} is swept and series are kept; they must be at the same times in every run."


def _check(trials: Sequence[Variation], point: Mapping[str, Value]) -> None:
    """Refuse a point that is sound in no trial, by the faults of the first."""
    for trial in trials:
        with suppress(ConfigurationError):
            trial.check(point)
            return
    trials[0].check(point)


def _sound_setups(trials: Iterable[Variation]) -> Iterator[Setup]:
    """Yield the setups of the trials that are sound as they are."""
    for trial in trials:
        with suppress(ConfigurationError):
            yield trial.setup({})


def _trials(bases: Sequence[Configuration], columns: Columns) -> list[Configuration]:
    """Return combinations that values are tried in: every base, and it with the first and the last values."""
    trials = list(bases)
    for trial, end in product(bases, (0, -1)):
        for key, column in columns.items():
            call = call_in(column[end])
            # Of what is spaced the ends are tried.
            trial = with_key(trial, key, call[1][:2][end] if call else column[end])
        trials.append(trial)
    return trials
