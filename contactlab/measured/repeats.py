"""Independent measurements among measured impacts: equal rows and labelled repeats count as one."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array

from contactlab.arrays import Array
from contactlab.measured.impacts import MeasuredImpacts


def measurements(impacts: MeasuredImpacts) -> NDArray[np.int64]:
    """Return the number of the measurement that each impact belongs to, from 0, shape (impact,).

    Impacts belong to one measurement if their rows are equal to the last bit or have the same label. Numbers
    are in the order of first occurrence.
    """
    equal = _equal_rows(impacts)
    if impacts.measurement is None:
        return equal
    labels = np.unique(impacts.measurement, return_inverse=True)[1].astype(np.int64)
    # A graph of rows and labels: equal rows of two labels unite these.
    from scipy.sparse.csgraph import connected_components

    size = int(equal.max(initial=-1)) + 1
    edges = coo_array(
        (np.ones(len(impacts)), (equal, size + labels)), shape=(size + int(labels.max(initial=-1)) + 1,) * 2
    )
    return _in_order(connected_components(edges, directed=False)[1][equal])


def copies_warning(impacts: MeasuredImpacts) -> str:
    """Return a sentence with the number of rows that repeat an earlier one exactly; empty without any."""
    copies = len(impacts) - int(_equal_rows(impacts).max(initial=-1)) - 1
    if not copies:
        return ""
    return (
        f"{copies} of {len(impacts)} impacts equal an earlier one in every measured number. Each counts as "
        "independent evidence, so that intervals are too narrow if they are copies; remove the copies."
    )


def _equal_rows(impacts: MeasuredImpacts) -> NDArray[np.int64]:
    """Return the same number for rows whose measured numbers are all equal."""
    parts: list[Array] = [
        impacts.velocity_before,
        impacts.velocity_after,
        impacts.delassus.reshape(-1, 4),
        np.column_stack([impacts.kinetic_energy, impacts.outside]),
    ]
    if impacts.covariance is not None:
        parts.append(impacts.covariance.reshape(-1, 4))
    return _in_order(np.unique(np.hstack(parts), axis=0, return_inverse=True)[1].ravel())


def _in_order(labels: NDArray[np.int64]) -> NDArray[np.int64]:
    """Number labels by their first occurrence."""
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.empty(first.size, dtype=np.int64)
    rank[np.argsort(first)] = np.arange(first.size)
    return np.asarray(rank[inverse.ravel()])
