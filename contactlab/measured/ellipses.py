"""The published impacts of a rigid ellipse on a flat plate, from the MATLAB file as its authors share it.

`bounce_array` has for each impact `states`, x, y, angle and their rates before and the same after (m, rad),
`n` and `d`, the rows of the normal and tangential contact Jacobian in these coordinates, and `flags`, six of
them, any of which says that the impact is none of one clean contact.

The disc has the axes 70 and 50 mm and a mass of 36.4 g, M = m diag(1, 1, (a^2 + b^2)/4) with a = 35 mm,
b = 25 mm. It was tracked at 250 Hz: the gravity of one frame, 9.81 m/s^2 times 4 ms, is in the velocities.

The arm in `d` is the height of the centre, as for an angle counted counter-clockwise. With its sign reversed
sixty times less of the jumps' energy lies outside of what impulses can do: so the angle is counted clockwise,
or x is mirrored. `n` is right either way, since the normal's arm changes its sign with the angle.

Source: Fazeli, Zapolsky, Drumwright and Rodriguez (2020), Fundamental limitations in performance and
interpretability of common planar rigid-body contact models, in Robotics Research, 555.
"""

from pathlib import Path
from typing import Final

import numpy as np
import scipy.io

from contactlab.measured.faults import MeasurementError, told_energies
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.reduction import BodyImpacts

MASS: Final = 36.4e-3  # [kg], as the repository DAIRLab/ImpactModeling has it
AXES: Final = (35e-3, 25e-3)  # [m] half axes

_SIGNS: Final = (1.0, -1.0)


def read_ellipses(path: Path) -> MeasuredImpacts:
    """Read the impacts that no flag marks; the sign of the arm of the tangential impulse is found.

    As it stands in the file, or reversed: the one with which less of the velocity jumps lies outside of
    what impulses can do, see `contactlab.measured.reduction`. What was found is in `notes`.

    Raises:
        MeasurementError: it is no such file.
    """
    table = _table(path)
    states, normal, tangential, flags = (_rows(table, *column) for column in _COLUMNS.items())
    clean = ~flags.any(axis=1)
    mass = MASS * np.diag([1.0, 1.0, sum(axis**2 for axis in AXES) / 4.0])
    made = {}
    for sign in _SIGNS:
        made[sign] = BodyImpacts(
            states[clean, 3:6],
            states[clean, 9:12],
            np.broadcast_to(mass, (int(clean.sum()), 3, 3)),
            normal[clean],
            tangential[clean] * [1.0, 1.0, sign],
        )
    shares = {sign: bodies.outside_share() for sign, bodies in made.items()}
    sign = min(_SIGNS, key=lambda each: shares[each])
    bodies, words = made[sign], "as it stands" if sign > 0 else "reversed"
    before, after, delassus = bodies.contact(bodies.before), bodies.contact(bodies.after), bodies.delassus()
    return MeasuredImpacts(
        delassus,
        before,
        after,
        bodies.energy(bodies.before),
        bodies.outside(),
        None,
        "Impacts of an ellipse on a flat plate",
        "Fazeli, Zapolsky, Drumwright and Rodriguez (2020), Robotics Research, 555; tracked at 250 Hz",
        "MIT, the authors; BSD-3-Clause, the copy in DAIRLab/ImpactModeling",
        int((~clean).sum()),
        np.flatnonzero(clean) + 1,
        (
            f"The third component of the tangential row is taken {words}: so {100.0 * shares[sign]:.2f} % "
            "of the jump's energy (median) lies outside of what impulses can do, and "
            f"{100.0 * shares[-sign]:.2f} % with the other sign.",
            "The gravity of one frame of 4 ms is in the velocities: 0.04 m/s.",
            *told_energies(before, after, delassus),
        ),
    )


_COLUMNS: Final = {"states": 12, "n": 3, "d": 3, "flags": 6}


def _table(path: Path) -> np.ndarray:
    try:
        found = scipy.io.loadmat(path, variable_names=["bounce_array"])
    # One that is cut off ends in an OSError, one that is damaged in nearly anything.
    except (OSError, ValueError, TypeError, NotImplementedError, scipy.io.matlab.MatReadError) as error:
        raise MeasurementError(f"it cannot be read as a MATLAB file: {error}.") from error
    table = found.get("bounce_array")
    if table is None or table.dtype.names is None or not set(_COLUMNS) <= set(table.dtype.names):
        raise MeasurementError(
            f"it is a MATLAB file without the ellipse impacts, an array 'bounce_array' with "
            f"{', '.join(_COLUMNS)}; write other measurements as CSV or netCDF, see docs/measured_data.md."
        )
    return np.asarray(table).ravel()


def _rows(table: np.ndarray, name: str, width: int) -> np.ndarray:
    """Give a column of the table, shape (impact, width)."""
    rows = [np.asarray(row, dtype=np.float64).ravel() for row in table[name]]
    for place, row in enumerate(rows):
        if row.size != width or not np.isfinite(row).all():
            raise MeasurementError(
                f"{name} of impact {place + 1} has {row.size} numbers, or some that are not "
                f"finite; it must have {width} finite ones."
            )
    return np.array(rows)
