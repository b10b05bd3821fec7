"""The harmonic balance of an oscillator on a Jenkins element, a judge that shares nothing with the engine.

m xdd + c xd + k x + z = F cos(w t), where z is the force of a spring k_t that slides at |z| = f. The motion
is a sum of odd harmonics; z is evaluated over time and taken back to its harmonics (alternating frequency and
time: Cameron and Griffin 1989, J. Appl. Mech. 56, 149).
"""

from dataclasses import dataclass
from math import acos, pi, sin

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, root

SAMPLES = 1024
"""Instants of a period at which the element's force is evaluated."""


@dataclass(frozen=True)
class JenkinsOscillator:
    """Mass, stiffness and damping of the oscillator, stiffness k_t and sliding force f of the element, SI."""

    mass: float
    stiffness: float
    damping: float
    spring: float
    limit: float

    def single_harmonic(self, force: float, frequency: float) -> complex:
        """Return the part X_1 [m] by the element's describing function, in closed form but for one root.

        Of a sine of amplitude X > f/k_t, with cos(s) = 1 - 2 f/(k_t X), the element's stiffness is
        k_t (s - sin(2 s)/2)/pi, and its loss in a cycle 4 f (X - f/k_t) (Caughey 1960).
        """
        omega, edge = 2.0 * pi * frequency, self.limit / self.spring

        def dynamic_stiffness(amplitude: float) -> complex:
            turn = acos(1.0 - 2.0 * edge / amplitude) if amplitude > edge else pi
            stiffness = self.spring / pi * (turn - 0.5 * sin(2.0 * turn))
            lost = 4.0 * self.limit * max(amplitude - edge, 0.0) / (pi * amplitude)
            elastic = self.stiffness + stiffness - self.mass * omega**2
            return complex(elastic, self.damping * omega + lost / amplitude)

        def missing(amplitude: float) -> float:
            return abs(dynamic_stiffness(amplitude)) * amplitude - force

        amplitude = float(brentq(missing, 1e-9, 1e3 * force / self.stiffness, xtol=1e-18))
        return force / dynamic_stiffness(amplitude)

    def balanced(self, force: float, frequency: float, harmonics: int) -> NDArray[np.complex128]:
        """Return the parts X_1, X_3, ... [m] of x = sum Re X_h exp(i h w t), as many as asked for."""
        omega, orders = 2.0 * pi * frequency, 2 * np.arange(harmonics) + 1
        waves = np.exp(2j * pi * np.outer(np.arange(SAMPLES) / SAMPLES, orders))
        impedance = self.stiffness - self.mass * (orders * omega) ** 2 + 1j * self.damping * orders * omega

        def missing(unknowns: NDArray[np.float64]) -> NDArray[np.float64]:
            parts = (unknowns[:harmonics] + 1j * unknowns[harmonics:]) * scale
            sliding = 2.0 / SAMPLES * (self._forces((waves @ parts).real) @ waves.conj())
            left = impedance * parts + sliding
            left[0] -= force
            return np.append(left.real, left.imag) / force

        scale = self.single_harmonic(force, frequency)
        first = np.zeros(2 * harmonics)
        first[0] = 1.0
        result = root(missing, first, tol=1e-11)
        assert result.success, result.message
        return (result.x[:harmonics] + 1j * result.x[harmonics:]) * scale

    def _forces(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the element's force over a period of a motion, at rest before it [N]."""
        z, forces = 0.0, np.empty(2 * SAMPLES)
        for i, step in enumerate(np.tile(np.diff(x, prepend=x[-1]), 2).tolist()):
            z = min(max(z + self.spring * step, -self.limit), self.limit)
            forces[i] = z
        # From the second period on it repeats itself.
        return forces[SAMPLES:]
