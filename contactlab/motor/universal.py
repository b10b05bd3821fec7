"""Normal modes of a universal file, which modal tests and finite-element programs write."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import check_shape, checked_arguments
from contactlab.motor import NormalModes
from contactlab.motor.bodies import FLAT
from contactlab.motor.table import MeasurementError
from contactlab.suggestion import excerpt

_NORMAL_MODE: Final = 2
"""Analysis type of a dataset 55."""


@checked_arguments(tip_length="m")
def read_universal(
    path: str | Path,
    node: int,
    coupling: Array,
    *,
    towards: Sequence[float] = (0.0, 1.0, 0.0),
    along: Sequence[float] = (1.0, 0.0, 0.0),
    tip_length: float = FLAT,
) -> NormalModes:
    """Return the normal modes of a universal file (datasets 55 of real modes), by rising frequency.

    Shapes are divided by the root of the modal mass that stands beside them. The file must be in SI units; a
    universal file has no electrodes.

    Args:
        path: the file, text or binary.
        node: number of the node that touches the rotor.
        coupling: modal force per voltage, for the shapes of the file as they stand and in the order of its
            modes [N/V], shape (mode, electrode).
        towards, along: directions towards the rotor and along its surface, in the node's coordinates.
        tip_length: of the contact's geometry [m]; the default is a flat contact.

    Raises:
        ModuleNotFoundError: pyuff is not installed; contactlab[universal] brings it.
        OSError: the file cannot be read.
        MeasurementError: it has no modes, no such node, other units, or an impossible number.
    """
    try:
        # Imported here: nothing else needs it.
        import pyuff
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            'Universal files need pyuff; pip install "contactlab[universal]" brings it.'
        ) from error
    path = Path(path)
    with path.open("rb"):
        pass
    try:
        sets: Any = pyuff.UFF(str(path)).read_sets()
    # It raises what its parser came upon.
    except Exception as error:
        raise MeasurementError(f"'{path}' cannot be read as a universal file: {excerpt(error)}.") from error
    every = [sets] if isinstance(sets, dict) else list(sets)
    if units := [each["length"] for each in every if each["type"] == 164 and each["length"] != 1.0]:
        raise MeasurementError(f"'{path}' has a unit of length of 1/{units[0]:g} m; it must be in SI units.")
    modes = [each for each in every if each["type"] == 55 and each["analysis_type"] == _NORMAL_MODE]
    if not modes:
        raise MeasurementError(f"'{path}' has no dataset 55 of normal modes; it must have one for each mode.")
    check_shape("coupling", coupling, (len(modes), -1), "a row a mode of the file and a column an electrode")
    frequency, mass, ratio = (
        np.array([float(each[key]) for each in modes]) for key in ("freq", "modal_m", "modal_damp_vis")
    )
    for name, values, good in (
        ("frequency", frequency, frequency >= 0.0),
        ("modal mass", mass, mass > 0.0),
        ("damping ratio", ratio, ratio >= 0.0),
    ):
        if not good.all():
            raise MeasurementError(f"'{path}' has a {name} of {values[~good][0]:g}; it must be positive.")
    shapes = np.array([_shape_at(each, node, path) for each in modes]) / np.sqrt(mass)[:, None]
    order, omega = np.argsort(frequency, kind="stable"), 2.0 * np.pi * frequency
    return NormalModes(
        stiffness=(omega**2)[order],
        damping=(2.0 * ratio * omega)[order],
        coupling=(coupling / np.sqrt(mass)[:, None])[order],
        tip_displacement=(shapes @ np.asarray(towards, np.float64))[order],
        tip_slope=-(shapes @ np.asarray(along, np.float64))[order] / tip_length,
    )


def _shape_at(mode: dict[str, Any], node: int, path: Path) -> Array:
    """Return the displacement of a node in a mode, shape (3,)."""
    place = np.flatnonzero(np.asarray(mode["node_nums"]) == node)
    if not place.size:
        raise MeasurementError(f"'{path}' has no node {node}; it must be one of those of its modes.")
    values = [np.asarray(mode[f"r{i}"])[place[0]] if f"r{i}" in mode else 0.0 for i in (1, 2, 3)]
    if np.iscomplexobj(values):
        raise MeasurementError(f"'{path}' has complex shapes; normal modes must be real.")
    return np.array(values, dtype=np.float64)
