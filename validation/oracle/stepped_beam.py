"""Exact vibration of the stepped beam with a tip: transfer matrices, no basis and no mesh.

A clamped beam of piecewise constant section, mirrored about its middle, where a rigid tip of mass M
and inertia I sits. At angular frequency w, with damping C = alpha M + beta K,

    E (1 + i w beta) w''''  =  w^2 m (1 - i alpha / w) w

is solved in closed form in every section; deflection, slope, bending moment Q = E w'' and S = E w'''
pass from one to the next, and a patch edge adds a jump of Q. The mirror symmetry leaves half a beam:

    lifting (slope 0 in the middle)        force on the tip  = -2 S - w^2 M u
    turning (deflection 0 in the middle)   moment on the tip =  2 Q - w^2 I theta

Loses digits by cosh(kappa L / 2)^2: good for the first dozen modes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq


class SteppedBeam(NamedTuple):
    """Half a beam from the clamp to the middle, SI units.

    edges: 0 < ... < L/2, (n + 1,); rigidity E I and mass per length of each section, (n,);
    moments: applied at the inner edges by 1 V, (n - 1,).
    """

    edges: np.ndarray
    rigidity: np.ndarray
    mass: np.ndarray
    moments: np.ndarray
    tip_mass: float
    tip_inertia: float
    alpha: float = 0.0
    beta: float = 0.0


def section_matrix(length: float, rigidity: complex, inertia: complex) -> np.ndarray:
    """Takes (w, w', Q, S) from one end of a section to the other; inertia is w^2 m."""
    kappa = (inertia / rigidity) ** 0.25
    z = kappa * length
    even, odd = (np.cosh(z) + np.cos(z)) / 2.0, (np.sinh(z) + np.sin(z)) / (2.0 * kappa)
    even2 = (np.cosh(z) - np.cos(z)) / (2.0 * kappa**2)
    odd3 = (np.sinh(z) - np.sin(z)) / (2.0 * kappa**3)
    e, m = rigidity, inertia
    return np.array(
        [
            [even, odd, even2 / e, odd3 / e],
            [m / e * odd3, even, odd / e, even2 / e],
            [m * even2, m * odd3, even, odd],
            [m * odd, m * even2, m / e * odd3, even],
        ]
    )


def middle_states(beam: SteppedBeam, omega: float) -> np.ndarray:
    """State in the middle for Q = 1, S = 1 at the clamp and for 1 V with neither, columns, (4, 3)."""
    stiff = 1.0 + 1j * omega * beam.beta
    heavy = omega**2 * (1.0 - 1j * beam.alpha / omega)
    states = np.zeros((4, 3), dtype=complex)
    states[2, 0] = states[3, 1] = 1.0
    jumps = np.append(beam.moments, 0.0)
    for length, e, m, jump in zip(np.diff(beam.edges), beam.rigidity, beam.mass, jumps, strict=True):
        states = section_matrix(length, e * stiff, m * heavy) @ states
        states[2, 2] -= jump
    return states


def stored_and_load(beam: SteppedBeam, omega: float, lifting: bool) -> tuple[np.ndarray, ...]:
    """Motion of the tip, motion that symmetry forbids, load on the tip; for each state, (3,)."""
    deflection, slope, moment, shear = middle_states(beam, omega)
    heavy = omega**2 * (1.0 - 1j * beam.alpha / omega)
    if lifting:
        return deflection, slope, -2.0 * shear - heavy * beam.tip_mass * deflection
    return slope, deflection, 2.0 * moment - heavy * beam.tip_inertia * slope


def natural_frequencies(beam: SteppedBeam, highest: float) -> np.ndarray:
    """All undamped natural frequencies [Hz] up to the highest, of both symmetries, ascending."""
    undamped = beam._replace(alpha=0.0, beta=0.0)
    result = []
    for lifting in (True, False):

        def determinant(frequency: float, lifting: bool = lifting) -> float:
            _, stored, load = stored_and_load(undamped, 2.0 * np.pi * frequency, lifting)
            return float((stored[0] * load[1] - stored[1] * load[0]).real)

        grid = np.geomspace(10.0, highest, 2000)
        values = np.array([determinant(f) for f in grid])
        for i in np.flatnonzero(values[:-1] * values[1:] < 0.0):
            result.append(brentq(determinant, grid[i], grid[i + 1], xtol=1e-12, rtol=1e-14))
    return np.sort(result)


def response(beam: SteppedBeam, frequency: float, lifting: bool) -> tuple[complex, complex]:
    """Tip motion per tip load, and per 1 V: equal on both electrodes (lifting) or opposite (turning).

    u in m/N and m/V, or theta in rad/(N m) and rad/V.
    """
    motion, stored, load = stored_and_load(beam, 2.0 * np.pi * frequency, lifting)
    system = np.array([stored[:2], load[:2]])
    compliance = motion[:2] @ np.linalg.solve(system, [0.0, 1.0])
    driven = motion[2] - motion[:2] @ np.linalg.solve(system, [stored[2], load[2]])
    return complex(compliance), complex(driven)
