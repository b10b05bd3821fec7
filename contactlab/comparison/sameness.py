"""Whether runs are of one motor with one drive, and what sets them apart if not."""

import json
from collections.abc import Mapping, Sequence
from math import isclose
from typing import Any

import numpy as np
import xarray

from contactlab.comparison.arrays import holds, series
from contactlab.config.nesting import flat

FREE = ("law", "solver", "record", "hydra")
"""Sections in which compared runs may differ."""

MOST_NAMES = 2
"""Runs that a sentence names for one value."""

SAME = 1e-9
"""Relative difference at which two numbers count as one: another machine rounds otherwise."""


def differences(
    trees: Mapping[str, xarray.DataTree], configurations: Mapping[str, Mapping[str, Any]]
) -> tuple[list[str], list[str]]:
    """What sets runs apart other than their laws.

    Args:
        trees: runs by their names.
        configurations: by the same names.

    Returns:
        Faults, and notes on what could not be checked; a sentence each.
    """
    faults, notes = [], []
    keys = {
        name: {k: v for k, v in flat(c).items() if k.partition(".")[0] not in FREE}
        for name, c in configurations.items()
    }
    sections = dict.fromkeys(key.partition(".")[0] for mine in keys.values() for key in mine)
    for section in sections:
        telling = {
            name: {k: v for k, v in mine.items() if k.partition(".")[0] == section}
            for name, mine in keys.items()
            if section in configurations[name]
        }
        for key in dict.fromkeys(key for mine in telling.values() for key in mine):
            groups = _grouped({name: mine.get(key) for name, mine in telling.items()})
            if len(groups) > 1:
                faults.append(_sentence(key, groups))
    for name in trees:
        missing = [section for section in sections if section not in configurations[name]]
        if missing:
            notes.append(
                f"'{name}' does not say its {', '.join(missing)}; that they are those of the other "
                "runs is taken on trust."
            )
    durations = _grouped({name: float(series(tree, "time")[-1]) for name, tree in trees.items()})
    if len(durations) > 1:
        faults.append(_sentence("solver.duration [s]", durations))
    modes = {
        name: series(tree, "natural_frequency").tolist()
        for name, tree in trees.items()
        if holds(tree, "natural_frequency")
    }
    # Where a key has told of it already, once is enough.
    if not faults and len(groups := _grouped(modes)) > 1:
        faults.append(_sentence("The natural frequency [Hz]", groups))
    return faults, notes


def law_keys(tree: xarray.DataTree, configuration: Mapping[str, Any]) -> dict[str, Any]:
    """The law's parameters by key; from its own record where the configuration has none."""
    section = configuration.get("law")
    if not isinstance(section, Mapping):
        section = json.loads(str(tree.attrs.get("law_parameters") or "{}"))
    said = {k: v for k, v in flat(section).items() if v is not None and k != "name"}
    return {key.removesuffix(".name"): value for key, value in said.items()}


def shown(value: Any) -> str:
    """A value in a sentence or a label."""
    if value is None:
        return "not given"
    if isinstance(value, list):
        return " ".join(shown(entry) for entry in value)
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def _grouped(values: Mapping[str, Any]) -> list[tuple[Any, list[str]]]:
    """Names that share a value."""
    groups: list[tuple[Any, list[str]]] = []
    for name, value in values.items():
        for known, names in groups:
            if _same(known, value):
                names.append(name)
                break
        else:
            groups.append((value, [name]))
    return groups


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and bool(np.allclose(one, other, rtol=SAME, atol=0.0))
    numbers = all(isinstance(x, int | float) and not isinstance(x, bool) for x in (one, other))
    return isclose(one, other, rel_tol=SAME) if numbers else bool(one == other)


def _sentence(key: str, groups: Sequence[tuple[Any, list[str]]]) -> str:
    said = " and ".join(f"{shown(value)} in {_some(names)}" for value, names in groups)
    return (
        f"{key} is {said}; laws are compared in one motor with one drive over one time, so it must be "
        "the same in all runs. Leave runs out, or run one of them again."
    )


def _some(names: Sequence[str]) -> str:
    """The first of some runs, and how many there are."""
    first = ", ".join(f"'{name}'" for name in names[:MOST_NAMES])
    rest = len(names) - MOST_NAMES
    return f"{first} and {rest} more" if rest > 0 else first
