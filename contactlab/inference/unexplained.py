"""Which impacts no law explains: those whose error under every law is more than noise."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from contactlab.arrays import Array
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.noise import noise_from_outside

RARE: Final = 0.01
"""Share of the impacts that noise alone takes over the bound."""

PLANAR: Final = 3
"""Coordinates of a body in the plane."""


class Noise(NamedTuple):
    """What noise may make of an error.

    Args:
        bound: on the error under a law that is right, shape (impact,); NaN where the noise is not known.
        words: where the bound comes from; the end of a sentence.
    """

    bound: Array
    words: str


def noise_of(impacts: MeasuredImpacts) -> Noise:
    """Give the error that noise alone exceeds in one of a hundred impacts.

    With the covariance C of the velocity after, the square of the error that impulses reach,
    r' D^-1 r/(2 K), is a sum of squares of normal variables whose variances are the eigenvalues of
    D^-1 C/(2 K): the larger one bounds it, as a chi-square of two. What no impulse reaches of the impact is
    in the bound. Where the data state no covariance it is estimated from that part of all the impacts, see
    `contactlab.measured.noise`, of one body in the plane; where there is none either, nothing tells it.
    """
    covariance, origin = impacts.covariance, "the stated covariance"
    if covariance is None:
        if not np.median(impacts.outside) > 0.0:
            unknown = "not known: the data state no covariance, and all of the jumps is what impulses reach"
            return Noise(np.full(len(impacts), np.nan), unknown)
        covariance = noise_from_outside(impacts, PLANAR)
        origin = "a covariance estimated from what no impulse reaches"
    variances = np.linalg.eigvals(np.linalg.solve(impacts.delassus, covariance)).real
    square = (2.0 * impacts.outside + float(chi2.ppf(1.0 - RARE, 2)) * variances.max(axis=1)) / (
        2.0 * impacts.kinetic_energy
    )
    bound = np.asarray(np.sqrt(square))
    return Noise(
        bound, f"{np.median(bound):.3f} (median), which {origin} exceeds in {RARE:.0%} of the impacts"
    )


def unexplained(errors: Array, noise: Noise) -> NDArray[np.bool_]:
    """Tell which impacts have an error above noise under every law.

    Args:
        errors: under the laws, shape (law, impact).
        noise: of the impacts.
    """
    return np.asarray(errors.min(axis=0) > noise.bound)
