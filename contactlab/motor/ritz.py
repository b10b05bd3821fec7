"""The paper's basis of smooth beam shapes: its matrices and their normal modes.

Source: Andersen, Blanke and Helbo (2001), eqs. 19-34; what of the print is corrected is said in
`contactlab.motor.patched_beam`.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, final

import numpy as np
from scipy.linalg import eigh

from contactlab.arrays import Array
from contactlab.motor.beam import SHAPES, ClampedBeam
from contactlab.motor.modes import UNRESOLVED, NormalModes, refuse_unresolved
from contactlab.motor.patched_beam import PatchedBeam


@final
@dataclass(frozen=True)
class RitzMatrices:
    """The matrices of eqs. 19-34 in the basis of beam shapes.

    Args:
        mass, damping, stiffness: M, C, K, shape (shape, shape), SI.
        coupling: Gamma [N/V], shape (shape, electrode).
        capacitance: C_p [F], shape (electrode, electrode).
        tip_displacement, tip_slope: shapes and slopes at the beam's centre, shape (shape,).
    """

    mass: Array
    damping: Array
    stiffness: Array
    coupling: Array
    capacitance: Array
    tip_displacement: Array
    tip_slope: Array

    def modes(self) -> NormalModes:
        """Normal modes; C = alpha M + beta K, so they decouple the damping as well."""
        if not (np.isfinite(self.mass).all() and np.isfinite(self.stiffness).all()):
            raise ValueError(UNRESOLVED)
        stiffness, vectors = eigh(self.stiffness, self.mass)
        refuse_unresolved(stiffness)
        # A mode's sign is free; fix it so that equal inputs give equal modes on every machine.
        largest = np.abs(vectors).argmax(axis=0)
        vectors = vectors * np.sign(vectors[largest, np.arange(vectors.shape[1])])
        damping = np.einsum("ij,ik,kj->j", vectors, self.damping, vectors)
        return NormalModes(
            stiffness=np.asarray(stiffness, dtype=np.float64),
            damping=np.asarray(damping, dtype=np.float64),
            coupling=vectors.T @ self.coupling,
            tip_displacement=vectors.T @ self.tip_displacement,
            tip_slope=vectors.T @ self.tip_slope,
            shape_coupling=self.coupling,
        )


@final
@dataclass(frozen=True)
class RitzResonator(PatchedBeam):
    """The patched beam in the paper's basis: eigenshapes of the bare, clamped beam.

    Four shapes are the paper's; the frequencies of the patched beam converge slowly because smooth
    shapes cannot bend sharply at a patch edge.
    """

    shapes: Annotated[int, SHAPES] = 4

    @cached_property
    def beam(self) -> ClampedBeam:
        """The beam shapes of the basis."""
        return ClampedBeam(self.length, self.shapes)

    @cached_property
    def matrices(self) -> RitzMatrices:
        """M, C, K, Gamma and C_p of eqs. 19-34."""
        beam = self.beam
        displacement = beam.evaluate(0.5 * self.length)
        slope = beam.evaluate(0.5 * self.length, 1)

        mass = self.steel_mass * beam.integrate(0.0, self.length)
        stiffness = self.steel_rigidity * beam.integrate(0.0, self.length, 2)
        coupling = np.empty((self.shapes, len(self.patches)))
        for electrode, (start, end) in enumerate(self.patches):
            mass += self.layer_mass * beam.integrate(start, end)
            stiffness += self.layer_rigidity * beam.integrate(start, end, 2)
            turn = beam.evaluate(end, 1) - beam.evaluate(start, 1)
            coupling[:, electrode] = self.moment_per_voltage * turn
        mass += self.tip_mass * np.outer(displacement, displacement)
        mass += self.tip_inertia * np.outer(slope, slope)

        permittivity, extent = self.piezoceramic.permittivity, self.patch_end - self.patch_start
        capacitance = 2.0 * self.width * permittivity * extent / self.patch_thickness
        return RitzMatrices(
            mass=mass,
            damping=self.mass_damping * mass + self.stiffness_damping * stiffness,
            stiffness=stiffness,
            coupling=coupling,
            capacitance=capacitance * np.eye(len(self.patches)),
            tip_displacement=displacement,
            tip_slope=slope,
        )

    def _solve(self) -> NormalModes:
        """Compute the normal modes of `matrices`."""
        return self.matrices.modes()
