"""The plan of a sweep from what somebody asked for; every value of it is checked, and every fault told."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from itertools import product
from math import ceil, prod
from typing import Final, Protocol, TypeVar

from contactlab.config import ConfigurationError, Setup, validate
from contactlab.config.nesting import Value, flat
from contactlab.config.quantity import describe
from contactlab.config.schema import declared_in
from contactlab.suggestion import suggestion
from contactlab.sweeps.dataset import Axis
from contactlab.sweeps.plan import Configuration, Outputs, Plan, code_digest_of, with_key
from contactlab.sweeps.values import FORMS, MOST_RUNS, SweepError, call_in, number, spread

CHUNK: Final = 1000
"""Runs in a chunk where nothing is said: seconds of work."""

MOST_CHUNKS: Final = 1000
"""Clusters take arrays of about so many tasks."""

NOTHING: Final = (
    f"Nothing is swept; there must be one parameter at least: KEY={FORMS}. One run alone needs no "
    "sweep."
)

TIMES: Final = ("solver.duration", "record.interval")
"""Keys that the times of the records depend on."""

Columns = Mapping[str, Sequence[Value]]
"""What is swept: values by key or group, each a number, a text, or a text that stands for several."""

Progress = Callable[[float, str, str], AbstractContextManager[Callable[[float], object]]]
"""Shows how far something has come, of a total in some unit; see `contactlab.cli.terminal.progress`."""

Found = TypeVar("Found")


def unseen(*_: object) -> AbstractContextManager[Callable[[float], object]]:
    """Show nothing."""
    return nullcontext(lambda _: None)


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
    progress: Progress = unseen,
) -> Plan:
    """Plan a sweep, and check every value of it.

    Args:
        composer: gives the configurations that values are swept over.
        columns: the values by full key or group.
        outputs: what is kept of every run.
        samples: whether the columns are those of a table, a run a row.
        chunk: runs in a chunk; None takes the default.
        progress: shows how far the check has come.

    Raises:
        ConfigurationError: with every fault that was found.
    """
    groups = {key: options for key in columns if (options := composer.options(key))}
    faults = [*_faults_of(columns, groups, outputs)]
    raise_faults(faults)
    listing = [columns[group] for group in groups]
    combined = zip(*listing, strict=True) if samples and groups else product(*listing)
    choices = tuple(dict.fromkeys(combined))
    bases = tuple(composer.compose(dict(zip(groups, chosen, strict=True))) for chosen in choices)
    values = {key: column for key, column in columns.items() if key not in groups}
    trials = _trials(bases, values)

    def ran(trial: Configuration) -> Configuration:
        return composer.build(trial).configuration

    declared = declared_in(validate(_first_sound(ran, trials))) if values else {}
    axes = []
    for key, column in columns.items():
        said, found = declared.get(key), []
        units, meaning = (said.units, said.meaning) if said else ("", "")
        try:
            given = _spread(key, column, units, samples) if key in values else column
        except SweepError as error:
            faults.append(str(error))
            continue
        with progress(len(given), "values", f"Checking {key}") as show:
            for count, value in enumerate(given, 1):
                # Each of a table's rows is built, which tells more than its values one by one.
                if key in groups or samples:
                    found.append(value)
                    continue
                try:
                    tried = [with_key(trial, key.split("."), value) for trial in trials]
                    told = flat(_first_sound(ran, tried)).get(key)
                    # A radius that a stiffness was computed from is gone from what runs.
                    found.append(value if told is None else told)
                except ConfigurationError as error:
                    faults += error.faults
                show(count)
        if not samples and len({*found}) < len(found):
            faults.append(f"{key} has a value twice; give every value once.")
        axes.append(Axis(key, tuple(found), units, meaning))
    raise_faults(faults)
    cells = len(axes[0].values) if samples else prod(len(axis.values) for axis in axes)
    if cells > MOST_RUNS:
        sizes = " x ".join(str(len(axis.values)) for axis in axes)
        raise_faults(
            [
                f"{sizes} = {cells:.4g} runs are asked for; a sweep must have at most {MOST_RUNS}, whose "
                "numbers fit into memory. Take fewer values."
            ]
        )
    return Plan(
        axes=tuple(axes),
        groups=tuple(groups),
        choices=choices,
        bases=bases,
        samples=samples,
        outputs=outputs,
        chunk=chunk or max(CHUNK, ceil(cells / MOST_CHUNKS)),
        code=code_digest_of(bases),
    )


def setups_of(
    plan: Plan, composer: Composer, progress: Progress = unseen
) -> Iterator[tuple[int, Setup]]:
    """Build every run of a plan: give cell and setup of the sound ones, and refuse the others at the end."""
    faults: list[str] = []
    with progress(plan.cells, "runs", "Checking the sweep") as show:
        for cell in range(plan.cells):
            try:
                yield cell, composer.build(plan.configuration(cell))
            except ConfigurationError as error:
                faults += error.faults
            show(cell + 1)
    raise_faults(faults)


def full_keys(columns: Columns, composer: Composer) -> dict[str, Sequence[Value]]:
    """Put full keys in the place of names that are the end of one: 'contact.clearance' for 'clearance'.

    The parts of a name may be joined as in the names of a dataset.

    Raises:
        ConfigurationError: a name is the end of several.
    """
    known = flat(composer.compose({}))
    found: dict[str, Sequence[Value]] = {}
    for name, column in columns.items():
        whole = name in known or composer.options(name)
        ends = [] if whole else [k for k in known if f"_{k.replace('.', '_')}".endswith(f"_{name}")]
        if len(ends) > 1:
            raise ConfigurationError([f"{name} may be {' or '.join(ends)}. Name one of them."])
        found[ends[0] if ends else name] = column
    return found


def raise_faults(faults: Iterable[str]) -> None:
    """Raise a ConfigurationError of the faults, each told once; nothing where there is none."""
    if told := list(dict.fromkeys(faults)):
        raise ConfigurationError(told)


def _faults_of(
    columns: Columns, groups: Mapping[str, Sequence[str]], outputs: Outputs
) -> Iterator[str]:
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
        if outputs.series and key in TIMES:
            yield (
                f"{key} is swept and series are kept; they must be at the same times in every run. Keep "
                "none, or set it."
            )


def _first_sound(
    attempt: Callable[[Configuration], Found], trials: Sequence[Configuration]
) -> Found:
    """Give what comes of the first trial that is sound; where none is, the faults of the first."""
    first: ConfigurationError | None = None
    for trial in trials:
        try:
            return attempt(trial)
        except ConfigurationError as error:
            first = first or error
    assert first is not None
    raise first


def _trials(bases: Sequence[Configuration], columns: Columns) -> list[Configuration]:
    """Give combinations that values are tried in: every base, and it with the first and the last values."""
    found = list(bases)
    for base, end in product(bases, (0, -1)):
        trial = base
        for key, column in columns.items():
            value = column[end]
            # Of what is spaced the ends are tried.
            if call := call_in(value):
                value = call[1][: 2 if end else 1][-1]
            trial = with_key(trial, key.split("."), value)
        found.append(trial)
    return found


def _spread(key: str, column: Sequence[Value], units: str, samples: bool) -> Sequence[Value]:
    """Give all values that a column stands for; those of a table are one each, numbers in SI."""
    if samples:
        return [number(key, v, units) if units and isinstance(v, str) else v for v in column]
    return [one for value in column for one in spread(key, value, units)]
