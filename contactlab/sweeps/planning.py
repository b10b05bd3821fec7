"""The plan of a sweep from what somebody asked for; every value of it is checked, and every fault told."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from itertools import product
from math import ceil, prod
from typing import Any, Final, Protocol

from contactlab.config import ConfigurationError, Setup, build, validate
from contactlab.config.nesting import Value, flat
from contactlab.config.quantity import UnitError, describe, to_si
from contactlab.config.schema import declared_in
from contactlab.parameter import Parameter, from_cf
from contactlab.suggestion import suggestion
from contactlab.sweeps.dataset import Axis
from contactlab.sweeps.plan import (
    Configuration,
    Outputs,
    Plan,
    Resolve,
    Setups,
    code_digest_of,
    with_key,
)
from contactlab.sweeps.values import FORMS, MOST_RUNS, SweepError, is_spaced, listed, spread

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


def unseen(*_: object) -> AbstractContextManager[Callable[[float], object]]:
    """Show nothing."""
    return nullcontext(lambda _: None)


class Composer(Protocol):
    """Gives configurations from the options of groups."""

    def options(self, key: str) -> list[str]:
        """Give the options of a group; none for what is no group."""

    def compose(self, chosen: Mapping[str, Value]) -> Configuration:
        """Give the configuration with these options, all else as it is set.

        Raises:
            ConfigurationError: it cannot be composed.
        """

    def resolve(self, configuration: Configuration) -> Configuration:
        """Put values in the place of references to them.

        Raises:
            ConfigurationError: one refers to what there is not.
        """


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
    groups = tuple(key for key in columns if composer.options(key))
    faults = [*_faults_of(columns, outputs)]
    for group in groups:
        options = composer.options(group)
        for value in columns[group]:
            if value not in options:
                hint = suggestion(str(value), options, "Choose from them.")
                faults.append(
                    f"{group} is {describe(value)}; it must be one of {', '.join(options)}. {hint}"
                )
    _raise(faults)
    listing = [columns[group] for group in groups]
    combined = zip(*listing, strict=True) if samples and groups else product(*listing)
    choices = tuple(dict.fromkeys(combined))
    bases = tuple(composer.compose(dict(zip(groups, chosen, strict=True))) for chosen in choices)
    values = {key: column for key, column in columns.items() if key not in groups}
    trials = _trials(bases, values)
    declared = _declared(trials, composer.resolve) if values else {}
    axes = []
    for key, column in columns.items():
        said = declared.get(key)
        units, meaning = (said.units, said.meaning) if said else ("", "")
        try:
            found = [*column] if key in groups else _spread(key, column, units, samples)
        except (SweepError, UnitError) as error:
            faults.append(str(error) if isinstance(error, SweepError) else f"{key}: {error}.")
            continue
        # Each of a table's rows is built, which tells more than its values one by one.
        if not samples and key not in groups:
            with progress(len(found), "values", f"Checking {key}") as show:
                found = _as_run(key, found, trials, composer.resolve, faults, show)
        if not samples and len({*found}) < len(found):
            faults.append(f"{key} has a value twice; give every value once.")
        axes.append(Axis(key, tuple(found), units, meaning))
    _raise(faults)
    cells = len(axes[0].values) if samples else prod(len(axis.values) for axis in axes)
    if cells > MOST_RUNS:
        sizes = " x ".join(str(len(axis.values)) for axis in axes)
        faults = [
            f"{sizes} = {cells:.4g} runs are asked for; a sweep must have at most {MOST_RUNS}, whose "
            "numbers fit into memory. Take fewer values."
        ]
    _raise(faults)
    return Plan(
        axes=tuple(axes),
        groups=groups,
        choices=choices,
        bases=bases,
        samples=samples,
        outputs=outputs,
        chunk=chunk or max(CHUNK, ceil(cells / MOST_CHUNKS)),
        code=code_digest_of(bases),
    )


def setups_of(
    plan: Plan, resolve: Resolve | None = None, progress: Progress = unseen
) -> Iterator[tuple[int, Setup]]:
    """Build every run of a plan, and tell all that are faulty at the end.

    Args:
        plan: the plan.
        resolve: where the configurations have references.
        progress: shows how far it has come.

    Yields:
        The cell of each sound run, and what runs.

    Raises:
        ConfigurationError: with every fault that was found.
    """
    setup_at = Setups(plan, resolve)
    faults: list[str] = []
    with progress(plan.cells, "runs", "Checking the sweep") as show:
        for cell in range(plan.cells):
            try:
                yield cell, setup_at(cell)
            except ConfigurationError as error:
                faults += error.faults
            show(cell + 1)
    _raise(faults)


def full_keys(columns: Columns, composer: Composer) -> dict[str, Sequence[Value]]:
    """Put full keys in the place of names that are the end of one: 'contact.clearance' for 'clearance'.

    Raises:
        ConfigurationError: a name is the end of several.
    """
    known = flat(composer.compose({}))
    found: dict[str, Sequence[Value]] = {}
    for name, column in columns.items():
        ends = [] if composer.options(name) or name in known else _ending(name, known)
        if len(ends) > 1:
            raise ConfigurationError([f"{name} may be {' or '.join(ends)}. Name one of them."])
        found[ends[0] if ends else name] = column
    return found


def _raise(faults: Sequence[str]) -> None:
    if faults:
        raise ConfigurationError(list(dict.fromkeys(faults)))


def _ending(name: str, known: Iterable[str]) -> list[str]:
    """Give the keys that end in a name, whose parts may be joined as in the names of a dataset."""
    return [key for key in known if f"_{key.replace('.', '_')}".endswith(f"_{name}")]


def _faults_of(columns: Columns, outputs: Outputs) -> Iterator[str]:
    """Say what can be no sweep at all."""
    for key, column in columns.items():
        if not len(column):
            yield f"{key} has no values; it must have one at least. Name one."
        for value in column:
            if not isinstance(value, float | int | str):
                yield f"{key} has the value {value}; each must be a number, a text or true or false."
        if outputs.series and key in TIMES:
            yield (
                f"{key} is swept and series are kept; they must be at the same times in every run. Keep "
                "none, or set it."
            )


def _declared(trials: Sequence[Configuration], resolve: Resolve) -> dict[str, Parameter]:
    """Give what is declared of the keys of some sound combination of values.

    Raises:
        ConfigurationError: no combination is sound.
    """
    first: ConfigurationError | None = None
    for trial in trials:
        try:
            return declared_in(validate(resolve(trial)))
        except ConfigurationError as error:
            first = first or error
    assert first is not None
    raise first


def _as_run(
    key: str,
    values: Sequence[Value],
    trials: Sequence[Configuration],
    resolve: Resolve,
    faults: list[str],
    show: Callable[[float], object],
) -> list[Value]:
    """Give the values as they run; a fault is noted for each that no combination tried admits."""
    path = key.split(".")
    resolved: list[Value] = []
    for count, value in enumerate(values, 1):
        first: ConfigurationError | None = None
        for trial in trials:
            try:
                found: Any = build(resolve(with_key(trial, path, value))).configuration
            except ConfigurationError as error:
                first = first or error
                continue
            for step in path:
                found = found[step]
            # A radius that a stiffness was computed from is gone from what runs.
            resolved.append(value if found is None else found)
            break
        else:
            faults += first.faults if first else []
        show(count)
    return resolved


def _trials(bases: Sequence[Configuration], columns: Columns) -> list[Configuration]:
    """Give combinations that values are tried in: every base, and it with the first and the last values."""
    found = list(bases)
    for base, end in product(bases, (0, -1)):
        trial = base
        for key, column in columns.items():
            value = column[end]
            # Of what is spaced the ends are tried.
            if is_spaced(value):
                ends = listed(str(value).partition("(")[2].rpartition(")")[0])
                value = ends[min(1, len(ends) - 1) if end else 0] if ends else ""
            trial = with_key(trial, key.split("."), value)
        found.append(trial)
    return found


def _spread(key: str, column: Sequence[Value], unit: str, samples: bool) -> list[Value]:
    """Give all values that a column stands for; those of a table are one each, numbers in SI."""
    if samples:
        return [_number(v, unit) if unit and isinstance(v, str) else v for v in column]
    return [one for value in column for one in spread(key, value, lambda text: _number(text, unit))]


def _number(text: str, unit: str) -> float:
    """Give the SI number of an end of what is spaced.

    Raises:
        UnitError: it is none.
    """
    try:
        return to_si(text, from_cf(unit) if unit else "1")
    except UnitError as error:
        raise UnitError(f"{describe(text)}, {error}") from None
