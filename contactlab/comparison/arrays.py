"""Numbers out of a run's tree."""

import numpy as np
import xarray
from numpy.typing import NDArray

Array = NDArray[np.float64]


def series(tree: xarray.DataTree, name: str) -> Array:
    """A variable of the root."""
    return np.asarray(tree.dataset[name].values, dtype=np.float64)


def holds(tree: xarray.DataTree, *names: str) -> bool:
    """Whether the root has all of these variables."""
    return set(names) <= set(tree.dataset.variables)


def column(tree: xarray.DataTree, name: str) -> Array:
    """A column of the contacts."""
    return np.asarray(tree.children["contacts"].dataset[name].values, dtype=np.float64)


def contacts_hold(tree: xarray.DataTree, *names: str) -> bool:
    """Whether there is a contact at all, with all of these columns."""
    group = tree.children.get("contacts")
    if group is None or not set(names) <= set(group.dataset.variables):
        return False
    return all(group.dataset[name].size > 0 for name in names)
