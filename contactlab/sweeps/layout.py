"""How runs lie over their parameters: as a grid where they form one, else one after the other."""

import re
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import prod
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.config import validate
from contactlab.config.nesting import flat
from contactlab.config.schema import declared_in
from contactlab.parameter import Parameter
from contactlab.sweeps.dataset import RUN, Axis, names_of, text_of
from contactlab.sweeps.discovery import FoundRun
from contactlab.sweeps.manifest import common_of

_KEY: Final = re.compile(r"\w+(\.\w+)+")
_GROUP: Final = re.compile(r"\w+(/\w+)*")
"""What can be a key or a group; a configuration of one's own may be anything."""

MOST_EMPTY: Final = 2
"""Cells of a grid over runs; a sweep that was cut or extended still is one."""


@final
@dataclass(frozen=True)
class Layout:
    """Tells where every run stands.

    Args:
        axes: the parameters along the dimensions, or along the one dimension `RUN`.
        beside: parameters that follow from those of the axes, with their values by cell.
        shape: of the cells.
        place: of every run among the cells in C order, shape (run,).
        grid: whether each axis is a dimension.
    """

    axes: tuple[Axis, ...]
    beside: tuple[tuple[Axis, NDArray[Any]], ...]
    shape: tuple[int, ...]
    place: NDArray[np.intp]
    grid: bool

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions."""
        return tuple(names_of(self.axes)) if self.grid else (RUN,)

    @property
    def names_beside(self) -> list[str]:
        """Names of the parameters beside."""
        return names_of([*self.axes, *(axis for axis, _ in self.beside)])[len(self.axes) :]

    def spread(self, values: Sequence[Any], empty: Any, dtype: Any) -> NDArray[Any]:
        """Give one value a run as an array over the cells."""
        cells = np.full(prod(self.shape), empty, dtype=dtype)
        cells[self.place] = np.asarray(values, dtype=dtype)
        return cells.reshape(self.shape)


def layout_of(runs: Sequence[FoundRun], *, samples: bool = False) -> Layout:
    """Lay runs out: as a grid if they nearly fill one, share no cell and are no samples."""
    parameters = _parameters(runs)
    chosen: list[Axis] = []
    rest: list[Axis] = []
    for axis in parameters:
        more = len(_tuples([*chosen, axis])) > len(_tuples(chosen))
        (chosen if more else rest).append(axis)
    if samples or not _is_grid(chosen, rest, len(runs)):
        return Layout(tuple(parameters), (), (len(runs),), np.arange(len(runs)), grid=False)
    along = tuple(replace(a, values=tuple(np.unique(a.coordinate).tolist())) for a in chosen)
    steps = [
        [number[value] for value in axis.values]
        for axis, sorted_axis in zip(chosen, along, strict=True)
        for number in [{value: n for n, value in enumerate(sorted_axis.values)}]
    ]
    shape = tuple(len(axis.values) for axis in along)
    grid = Layout(along, (), shape, np.ravel_multi_index(tuple(np.array(steps)), shape), grid=True)
    return replace(grid, beside=tuple((axis, _beside(axis, grid)) for axis in rest))


def common_settings(runs: Sequence[FoundRun]) -> dict[str, Any]:
    """Give what all runs have in common, by full key; runs whose configuration is not known do not count."""
    return common_of([flat(run.job.configuration) for run in runs if run.job.configuration])


def _beside(axis: Axis, grid: Layout) -> NDArray[Any]:
    """Give a parameter over the cells of a grid."""
    if axis.units:
        return grid.spread(axis.values, np.nan, np.float64)
    return grid.spread(axis.values, "", np.dtypes.ObjectDType())


def _is_grid(chosen: Sequence[Axis], rest: Sequence[Axis], runs: int) -> bool:
    cells = prod(len(set(axis.values)) for axis in chosen)
    if not chosen or len(_tuples(chosen)) < runs or cells > MOST_EMPTY * runs:
        return False
    if any(axis.units and np.isnan(axis.coordinate).any() for axis in chosen):
        return False
    # Parameters that follow from an option belong to it; numbers that follow from a number are
    # points that somebody chose.
    return not rest or any(not axis.units for axis in chosen)


def _tuples(axes: Sequence[Axis]) -> set[tuple[Any, ...]]:
    """Give the different values of all axes together; a NaN equals itself here."""
    rows = zip(*(map(repr, axis.values) for axis in axes), strict=True)
    return set(rows) if axes else {()}


def _parameters(runs: Sequence[FoundRun]) -> list[Axis]:
    """Find what differs between runs, of what they were asked for or else of what they recorded."""
    settings = [
        {key: value for key, value in flat(run.job.configuration).items() if _KEY.fullmatch(key)}
        for run in runs
    ]
    columns: dict[str, list[Any]] = {}
    if all(run.told for run in runs):
        for group in dict.fromkeys(group for run in runs for group in run.job.choices):
            if _GROUP.fullmatch(group):
                named = [run.job.choices.get(group) or "" for run in runs]
                columns[group] = named
        keys = _asked(runs, settings)
    else:
        keys = list(dict.fromkeys(key for setting in settings for key in setting))
    for key in keys:
        columns[_short(key)] = [setting.get(key) for setting in settings]
    declared = _declared(runs, settings, keys)
    return [
        _axis(name, values, declared.get(name))
        for name, values in columns.items()
        if any(value != values[0] for value in values)
    ]


def _asked(runs: Sequence[FoundRun], settings: Sequence[Mapping[str, Any]]) -> list[str]:
    """Give the keys that overrides set, one by one or as a group of keys."""
    lines = dict.fromkeys(line for run in runs for line in run.job.overrides)
    groups = {group for run in runs for group in run.job.choices}
    given = {line.partition("=")[0].lstrip("+~") for line in lines} - groups
    known = dict.fromkeys(key for setting in settings for key in setting)
    return [key for key in known if any(f"{key}.".startswith(f"{name}.") for name in given)]


def _short(key: str) -> str:
    """Name the choice of the law by its group: the key that tells it is the law's name."""
    return key.removesuffix(".name")


def _declared(
    runs: Sequence[FoundRun], settings: Sequence[Mapping[str, Any]], keys: Sequence[str]
) -> dict[str, Parameter]:
    """Find what is declared of keys, from the first configurations that have them."""
    declared: dict[str, Parameter] = {}
    missing = set(keys)
    for run, setting in zip(runs, settings, strict=True):
        if missing & setting.keys():
            # A configuration of one's own may be anything, and a law may no longer be installed.
            with suppress(Exception):
                declared |= declared_in(validate(run.job.configuration))
                missing -= setting.keys()
        if not missing:
            break
    return declared


def _axis(name: str, values: Sequence[Any], said: Parameter | None) -> Axis:
    if all(value is None or _is_number(value) for value in values):
        numbers = tuple(np.nan if v is None else float(v) for v in values)
        return Axis(name, numbers, said.units if said else "1", said.meaning if said else "")
    return Axis(name, tuple(text_of(value) for value in values))


def _is_number(value: Any) -> bool:
    if isinstance(value, int):
        return not isinstance(value, bool) and abs(value) < 2**sys.float_info.max_exp
    return isinstance(value, float)
