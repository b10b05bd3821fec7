"""How runs lie over their parameters: as a grid where they form one, else one after the other."""

import re
import sys
from collections.abc import Sequence
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
from contactlab.sweeps.dataset import Axis, text_of
from contactlab.sweeps.discovery import FoundRun

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
        axes: the parameters along the dimensions, or along the one dimension of the runs.
        beside: parameters that follow from those of the axes, a value a run.
        shape: of the cells.
        place: of every run among the cells in C order, shape (run,).
        grid: whether each axis is a dimension.
    """

    axes: Sequence[Axis]
    beside: Sequence[Axis]
    shape: tuple[int, ...]
    place: NDArray[np.intp]
    grid: bool

    def spread(self, values: Sequence[Any], empty: Any) -> NDArray[Any]:
        """Give one value a run, all of the kind of `empty`, in the order of the cells."""
        kind = object if isinstance(empty, str) else np.asarray(empty).dtype
        cells = np.full(prod(self.shape), empty, dtype=kind)
        cells[self.place] = np.asarray(values, dtype=kind)
        return cells


def layout_of(runs: Sequence[FoundRun], *, samples: bool = False) -> Layout:
    """Lay runs out: as a grid if they nearly fill one, share no cell and are no samples."""
    parameters = _parameters(runs)
    chosen: list[Axis] = []
    rest: list[Axis] = []
    for axis in parameters:
        more = _different([*chosen, axis]) > _different(chosen)
        (chosen if more else rest).append(axis)
    if samples or not _is_grid(chosen, rest, len(runs)):
        return Layout(parameters, (), (len(runs),), np.arange(len(runs)), grid=False)
    along = [np.unique(axis.coordinate, return_inverse=True) for axis in chosen]
    shape = tuple(values.size for values, _ in along)
    place = np.ravel_multi_index([steps for _, steps in along], shape)
    axes = [
        replace(axis, values=tuple(values.tolist()))
        for axis, (values, _) in zip(chosen, along, strict=True)
    ]
    grid = Layout(axes, (), shape, place, grid=True)
    beside = [
        replace(a, values=tuple(grid.spread(a.values, np.nan if a.units else ""))) for a in rest
    ]
    return replace(grid, beside=beside)


def _is_grid(chosen: Sequence[Axis], rest: Sequence[Axis], runs: int) -> bool:
    cells = prod(len(set(axis.values)) for axis in chosen)
    if not chosen or _different(chosen) < runs or cells > MOST_EMPTY * runs:
        return False
    if any(axis.units and np.isnan(axis.coordinate).any() for axis in chosen):
        return False
    # Parameters that follow from an option belong to it; numbers that follow from a number are
    # points that somebody chose.
    return not rest or any(not axis.units for axis in chosen)


def _different(axes: Sequence[Axis]) -> int:
    """Count the different values of all axes together; a NaN equals itself here."""
    return len(set(zip(*(map(repr, axis.values) for axis in axes), strict=True))) or 1


def _parameters(runs: Sequence[FoundRun]) -> list[Axis]:
    """Find what differs between runs, of what they were asked for or else of what they recorded."""
    settings = [
        {key: value for key, value in flat(run.configuration).items() if _KEY.fullmatch(key)}
        for run in runs
    ]
    keys = list(dict.fromkeys(key for setting in settings for key in setting))
    columns: dict[str, list[Any]] = {}
    jobs = [run.job for run in runs if run.job]
    if len(jobs) == len(runs):
        groups = dict.fromkeys(group for job in jobs for group in job.choices)
        given = {line.partition("=")[0].lstrip("+~") for job in jobs for line in job.overrides}
        columns = {
            group: [job.choices.get(group) or "" for job in jobs]
            for group in groups
            if _GROUP.fullmatch(group)
        }
        # Overrides set keys one by one or as a group of keys.
        given -= groups.keys()
        keys = [key for key in keys if any(f"{key}.".startswith(f"{name}.") for name in given)]
    for key in keys:
        # The choice of the law is named by its group: the key that tells it is the law's name.
        columns[key.removesuffix(".name")] = [setting.get(key) for setting in settings]
    declared = _declared(runs, {*keys})
    return [
        _axis(name, values, declared.get(name))
        for name, values in columns.items()
        if any(value != values[0] for value in values)
    ]


def _declared(runs: Sequence[FoundRun], keys: set[str]) -> dict[str, Parameter]:
    """Find what is declared of keys, from the first configurations that have them."""
    declared: dict[str, Parameter] = {}
    for run in runs:
        if missing := keys & flat(run.configuration).keys():
            # A configuration of one's own may be anything, and a law may no longer be installed.
            with suppress(Exception):
                declared |= declared_in(validate(run.configuration))
                keys = keys - missing
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
