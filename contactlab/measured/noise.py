"""Errors of measured impacts, estimated from the part of the velocity jumps that no impulse makes."""

import numpy as np
from scipy.special import gammaincinv

from contactlab.arrays import Array
from contactlab.measured.impacts import MeasuredImpacts


def noise_from_outside(impacts: MeasuredImpacts, coordinates: int) -> Array:
    """Estimate the covariance of the velocity after [m^2/s^2], shape (impact, 2, 2).

    If the jump's errors are normal and isotropic in the norm of the kinetic energy, with the covariance
    s^2 M^-1, then 2 outside / s^2 has a chi-square distribution with coordinates - 2 degrees of freedom, and
    the contact's velocities the covariance s^2 D. s^2 [J] follows from the median, which outliers do not
    move. A second contact or a bending body makes it too large.

    Args:
        impacts: with the energy outside of the impulses' span.
        coordinates: number of velocities measured of each impact, 3 or more.

    Raises:
        ValueError: there are fewer coordinates, or no energy lies outside.
    """
    if coordinates < 3:
        raise ValueError(f"There are {coordinates} coordinates; there must be at least 3.")
    middle = float(np.median(2.0 * impacts.outside)) if len(impacts) else 0.0
    if not middle > 0.0:
        raise ValueError("No energy lies outside of the impulses' span; state the errors with the data.")
    return np.asarray(middle / (2.0 * gammaincinv(0.5 * (coordinates - 2), 0.5)) * impacts.delassus)
