"""Published impacts of a rigid ellipse on a flat plate: a CSV that `contactlab validate` reads.

    python experiments/ellipses.py ellipse_impacts.mat ellipses.csv

In the MATLAB file of the authors `bounce_array` has for each impact `states`, x, y, angle and their rates
before and the same after (m, rad), `n` and `d`, the rows of the normal and tangential contact Jacobian in
these coordinates, and six `flags`, each of which marks an impact that is not one clean contact.

The disc has the axes 70 and 50 mm and a mass of 36.4 g, M = m diag(1, 1, (a^2 + b^2)/4) with a = 35 mm,
b = 25 mm. It was tracked at 250 Hz: the gravity of one frame, 9.81 m/s^2 times 4 ms, is in the velocities.

The arm in `d` is the height of the centre, as for an angle counted counter-clockwise. With its sign reversed,
as it is written, sixty times less of the jumps' energy lies outside of what impulses can do: so the angle is
counted clockwise, or x is mirrored. `n` is right either way, since the normal's arm changes its sign with it.

Source: Fazeli, Zapolsky, Drumwright and Rodriguez (2020), Fundamental limitations in performance and
interpretability of common planar rigid-body contact models, in Robotics Research, 555.
"""

import sys
from pathlib import Path
from typing import Final

import numpy as np
import scipy.io
import xarray

from contactlab.motor.table import write_csv

MASS: Final = 36.4e-3  # [kg], as in the repository DAIRLab/ImpactModeling
AXES: Final = (35e-3, 25e-3)  # [m] half axes

TEXTS: Final = {
    "title": "Impacts of an ellipse on a flat plate",
    "source": "Fazeli, Zapolsky, Drumwright and Rodriguez (2020), Robotics Research, 555; tracked at 250 Hz",
    "licence": "MIT, the authors; BSD-3-Clause, the copy in DAIRLab/ImpactModeling",
    "note": "The third component of the tangential row is reversed.\n"
    "The gravity of one frame of 4 ms is in the velocities: 0.04 m/s.",
}


def convert(source: Path, target: Path, sign: float = -1.0) -> None:
    """Write the impacts of the MATLAB file as CSV, those with a flag marked.

    Args:
        source: the MATLAB file.
        target: the CSV.
        sign: factor of the tangential arm; 1 leaves it as it is published.
    """
    table = scipy.io.loadmat(source, variable_names=["bounce_array"])["bounce_array"].ravel()
    states, normal, tangential, flags = (
        np.array([np.ravel(row) for row in table[name]], dtype=np.float64)
        for name in ("states", "n", "d", "flags")
    )
    tangential[:, 2] *= sign
    columns: dict[str, tuple[object, str]] = {"flag": (flags.any(axis=1).astype(int), "1")}
    for at, (name, velocity, arm) in enumerate(
        (("x", "m s-1", "1"), ("y", "m s-1", "1"), ("angle", "rad s-1", "m rad-1"))
    ):
        columns[f"before_{name}"] = states[:, 3 + at], velocity
        columns[f"after_{name}"] = states[:, 9 + at], velocity
        columns[f"normal_{name}"] = normal[:, at], arm
        columns[f"tangential_{name}"] = tangential[:, at], arm
    masses = {"mass_x": (MASS, "kg"), "mass_y": (MASS, "kg")}
    masses["mass_angle"] = MASS * (sum(axis**2 for axis in AXES) / 4.0), "kg m2"
    variables = {
        name: xarray.Variable(("impact",) * np.ndim(values), values, {"units": units})
        for name, (values, units) in (columns | masses).items()
    }
    write_csv(xarray.Dataset(variables, attrs=TEXTS), target)


if __name__ == "__main__":
    convert(Path(sys.argv[1]), Path(sys.argv[2]))
