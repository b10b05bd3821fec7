"""Over what the runs of a sweep lie: the parameters in which they differ, and those that form a grid."""

import re
from collections.abc import Sequence
from contextlib import suppress
from math import prod
from types import NoneType
from typing import Any, Final

import numpy as np
import pandas
import xarray

from contactlab.config import validate
from contactlab.config.nesting import flat
from contactlab.config.schema import declared_in
from contactlab.parameter import Parameter
from contactlab.sweeps.dataset import RUN, Axis, text_of
from contactlab.sweeps.state import Job

MOST_EMPTY: Final = 2
"""Cells of a grid over runs; a sweep that was cut or extended still is one."""

_KEY: Final = re.compile(r"\w+(\.\w+)+")
_GROUP: Final = re.compile(r"\w+(/\w+)*")
"""What can be a key or a group; a configuration of one's own may be anything."""


def dimensions(dataset: xarray.Dataset) -> list[str]:
    """Give the parameters over which runs form a grid: they nearly fill it, and share no cell."""
    table = pandas.DataFrame({name: found.values for name, found in dataset.coords.items()})
    chosen: list[str] = []
    for name in table:
        if _different(table[[*chosen, name]]) > _different(table[chosen]):
            chosen.append(name)
    cells, runs = prod(table[chosen].nunique()), dataset.sizes[RUN]
    if _different(table[chosen]) < runs or cells > MOST_EMPTY * runs:
        return []
    # Parameters that follow from an option belong to it; numbers that follow from a number are points
    # that somebody chose.
    numbers = [name for name in chosen if "units" in dataset[name].attrs]
    follow = len(chosen) == len(table.columns) or len(numbers) < len(chosen)
    return chosen if follow and not table[numbers].isna().any(axis=None) else []


def _different(table: Any) -> int:
    """Count the different rows of a table; without columns all are one."""
    return len(table.drop_duplicates()) if len(table.columns) else 1


def parameters(jobs: Sequence[Job], asked: bool) -> list[Axis]:
    """Find what differs between runs, of what they were asked for or else of what they recorded."""
    settings = [
        {key: value for key, value in flat(job.configuration).items() if _KEY.fullmatch(key)} for job in jobs
    ]
    keys = list(dict.fromkeys(key for setting in settings for key in setting))
    columns: dict[str, list[Any]] = {}
    if asked:
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
    declared = _declared(jobs, {*keys})
    return [
        _axis(name, values, declared.get(name))
        for name, values in columns.items()
        if any(value != values[0] for value in values)
    ]


def _declared(jobs: Sequence[Job], keys: set[str]) -> dict[str, Parameter]:
    """Find what is declared of keys, from the first configurations that have them."""
    declared: dict[str, Parameter] = {}
    for job in jobs:
        if missing := keys & flat(job.configuration).keys():
            # A configuration of one's own may be anything, and a law may no longer be installed.
            with suppress(Exception):
                declared |= declared_in(validate(job.configuration))
                keys = keys - missing
    return declared


def _axis(name: str, values: Sequence[Any], said: Parameter | None) -> Axis:
    if all(type(value) in (int, float, NoneType) for value in values):
        # Of somebody's own a whole number may have any size.
        with suppress(OverflowError):
            numbers = tuple(np.nan if value is None else float(value) for value in values)
            return Axis(name, numbers, said.units if said else "1", said.meaning if said else "")
    return Axis(name, tuple(text_of(value) for value in values))
