"""An estimate of the errors of measured impacts from what no impulse can have made."""

import numpy as np
from scipy.special import gammaincinv

from contactlab.arrays import Array
from contactlab.measured.impacts import MeasuredImpacts


def noise_from_outside(impacts: MeasuredImpacts, coordinates: int) -> Array:
    """Estimate the covariance of the velocity after, where the file gives none, shape (impact, 2, 2).

    If the jump's errors are normal and alike in all directions of the norm of the kinetic energy, with the
    covariance s^2 M^-1, then 2 outside / s^2 has a chi-square distribution with coordinates - 2 degrees of
    freedom, and the contact's velocities the covariance s^2 D [m^2/s^2]. s^2 [J] is that of the median, which
    outliers do not move.

    It is what errors are, if they are so: a tracked angle may be better known than a position. A second
    contact or a bending body is in it too, then it is too large for an error; what moves along the impulses
    is not, then it is too small.

    Args:
        impacts: with the energy outside of the impulses' span.
        coordinates: how many velocities were measured of each impact, 3 or more.

    Raises:
        ValueError: there are fewer coordinates, or no energy lies outside.
    """
    if coordinates < 3:
        raise ValueError(
            f"There are {coordinates} coordinates; there must be at least 3, or impulses explain everything."
        )
    middle = float(np.median(2.0 * impacts.outside)) if len(impacts) else 0.0
    if not middle > 0.0:
        raise ValueError(
            "No energy lies outside of the impulses' span; nothing tells the errors. Give them with the data."
        )
    return np.asarray(middle / (2.0 * gammaincinv(0.5 * (coordinates - 2), 0.5)) * impacts.delassus)
