"""Published impacts of a rigid ellipse on a flat plate, from the MATLAB file of their authors.

`bounce_array` has for each impact `states`, x, y, angle and their rates before and the same after (m, rad),
`n` and `d`, the rows of the normal and tangential contact Jacobian in these coordinates, and six `flags`,
each of which marks an impact that is not one clean contact.

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

from contactlab.measured.bodies import BodyImpacts
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.motor.table import MeasurementError
from contactlab.suggestion import excerpt

MASS: Final = 36.4e-3  # [kg], as in the repository DAIRLab/ImpactModeling
AXES: Final = (35e-3, 25e-3)  # [m] half axes

_COLUMNS: Final = {"states": 12, "n": 3, "d": 3, "flags": 6}


def read_ellipses(path: Path) -> MeasuredImpacts:
    """Read the impacts without flags, with the sign of the tangential arm that leaves less energy outside.

    Raises:
        MeasurementError: it is another file.
    """
    # Only here: scipy.io takes part of every start otherwise.
    import scipy.io

    try:
        table = np.asarray(scipy.io.loadmat(path, variable_names=["bounce_array"])["bounce_array"]).ravel()
        states, normal, tangential, flags = (
            np.array([np.asarray(row, dtype=np.float64).ravel() for row in table[name]]).reshape(-1, width)
            for name, width in _COLUMNS.items()
        )
    # A truncated file ends in an OSError, a damaged one in nearly any exception.
    except (
        *(OSError, LookupError, ValueError, TypeError, NotImplementedError),
        scipy.io.matlab.MatReadError,
    ) as error:
        raise MeasurementError(
            f"it is not the MATLAB file with the impacts of ellipses ({excerpt(error)}); write other "
            "measurements as CSV or netCDF, see docs/measured_data.md."
        ) from error
    if not all(np.isfinite(column).all() for column in (states, normal, tangential, flags)):
        raise MeasurementError("some of its numbers are not finite.")
    clean = ~flags.any(axis=1)
    mass = MASS * np.diag([1.0, 1.0, sum(axis**2 for axis in AXES) / 4.0])
    masses = np.broadcast_to(mass, (int(clean.sum()), 3, 3))
    states, normal, tangential = states[clean], normal[clean], tangential[clean]
    made = [
        BodyImpacts(
            states[:, 3:6], states[:, 9:12], masses, normal, tangential * [1.0, 1.0, sign], rotation=2
        )
        for sign in (1.0, -1.0)
    ]
    shares = [bodies.outside_share() for bodies in made]
    bodies, taken = (made[1], "reversed") if shares[1] < shares[0] else (made[0], "as it stands")
    return MeasuredImpacts.of_bodies(
        bodies,
        title="Impacts of an ellipse on a flat plate",
        source="Fazeli, Zapolsky, Drumwright and Rodriguez (2020), Robotics Research, 555; tracked at 250 Hz",
        licence="MIT, the authors; BSD-3-Clause, the copy in DAIRLab/ImpactModeling",
        left_out=int((~clean).sum()),
        number=np.flatnonzero(clean) + 1,
        notes=(
            f"The third component of the tangential row is taken {taken}: so {100.0 * min(shares):.2f} % "
            "of the jump's energy (median) lies outside of what impulses can do, and "
            f"{100.0 * max(shares):.2f} % with the other sign.",
            "The gravity of one frame of 4 ms is in the velocities: 0.04 m/s.",
        ),
    )
