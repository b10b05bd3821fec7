"""The piezoelectric beam resonator: matrices of the Ritz basis and their normal modes.

Source: Andersen, Blanke and Helbo (2001), eqs. 19-34. Signs and factors follow the consistent
form: masses are positive (eqs. 23, 27, 28 print them negative), a patch set counts both of its
layers in the mass (eq. 28 prints one), and the sign of the coupling is that of the paper's Table 1
(eq. 31 prints the opposite).
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from contactlab.beam import ClampedBeam
from contactlab.materials import Piezoceramic, Steel

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class NormalModes:
    """A resonator as everything after it sees it: mass-orthonormal, decoupled oscillators.

        qdd_j + c_j qd_j + k_j q_j = sum_e coupling[j, e] U_e(t) + tip force terms

    Args:
        stiffness: k_j = omega_j^2 [1/s^2], shape (mode,).
        damping: c_j = 2 zeta_j omega_j [1/s], shape (mode,).
        coupling: modal force per voltage [N/V kg^-1/2], shape (mode, electrode).
        tip_displacement: u = tip_displacement . q [kg^-1/2], shape (mode,).
        tip_slope: theta = tip_slope . q [kg^-1/2 m^-1], shape (mode,).
        shape_coupling: Gamma [N/V], shape (shape, electrode), in the basis before the modes.
    """

    stiffness: Array
    damping: Array
    coupling: Array
    tip_displacement: Array
    tip_slope: Array
    shape_coupling: Array

    @property
    def natural_frequency(self) -> Array:
        """Undamped natural frequencies f_j [Hz], shape (mode,)."""
        return np.asarray(np.sqrt(self.stiffness) / (2.0 * np.pi), dtype=np.float64)

    @property
    def damping_ratio(self) -> Array:
        """zeta_j [1], shape (mode,); 1 is critical, more is overdamped."""
        return np.asarray(0.5 * self.damping / np.sqrt(self.stiffness), dtype=np.float64)


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
        stiffness, vectors = eigh(self.stiffness, self.mass)
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
class RitzResonator:
    """A clamped beam with two mirrored pairs of piezoceramic patches and a rigid tip at its centre.

    Args:
        length: L [m].
        width: w_s [m].
        beam_thickness: t_s [m].
        patch_thickness: t_p of one layer [m].
        patch_start, patch_end: a_11, a_12 [m]; the second set is the mirror image, [L - a_12, L - a_11].
        tip_mass: M_tip [kg].
        tip_inertia: I_tip about the tip's foot [kg m^2].
        steel, piezoceramic: the materials.
        shapes: number of beam shapes, 1 to 40. Four are the paper's; the frequencies of the
            patched beam converge slowly because smooth shapes cannot bend sharply at a patch edge.
        mass_damping: alpha [1/s].
        stiffness_damping: beta [s].

    Not modelled: rotary inertia and shear of the layers, and adhesive between them.
    """

    length: float = 57e-3
    width: float = 16e-3
    beam_thickness: float = 1e-3
    patch_thickness: float = 1e-3
    patch_start: float = 0.914e-3
    patch_end: float = 10.146e-3
    tip_mass: float = 1.181e-3
    tip_inertia: float = 1.321e-7
    steel: Steel = field(default_factory=Steel)
    piezoceramic: Piezoceramic = field(default_factory=Piezoceramic)
    shapes: int = 4
    mass_damping: float = 7.5
    stiffness_damping: float = 2e-5

    def __post_init__(self) -> None:
        half = 0.5 * self.length
        if not 0.0 <= self.patch_start < self.patch_end <= half:
            raise ValueError(
                f"The patches lie at {self.patch_start} to {self.patch_end} m; they must satisfy "
                f"0 <= start < end <= {half} m, half the beam, or they leave it or overlap their mirror."
            )

    @cached_property
    def beam(self) -> ClampedBeam:
        """The beam shapes of the basis."""
        return ClampedBeam(self.length, self.shapes)

    @cached_property
    def patches(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Start and end of both patch sets [m]: the given one (electrode 0) and its mirror (electrode 1)."""
        start, end = self.patch_start, self.patch_end
        return ((start, end), (self.length - end, self.length - start))

    @cached_property
    def matrices(self) -> RitzMatrices:
        """M, C, K, Gamma and C_p of eqs. 19-34."""
        w, ts, tp, beam = self.width, self.beam_thickness, self.patch_thickness, self.beam
        steel, piezo = self.steel, self.piezoceramic
        steel_inertia = w * ts**3 / 12.0
        layers_inertia = 2.0 / 3.0 * w * (1.5 * tp**2 * ts + 0.75 * ts**2 * tp + tp**3)
        displacement = beam.evaluate(0.5 * self.length)
        slope = beam.evaluate(0.5 * self.length, 1)

        mass = steel.density * w * ts * beam.integrate(0.0, self.length)
        stiffness = steel.bending_modulus * steel_inertia * beam.integrate(0.0, self.length, 2)
        coupling = np.empty((self.shapes, len(self.patches)))
        for electrode, (start, end) in enumerate(self.patches):
            mass += piezo.density * 2.0 * w * tp * beam.integrate(start, end)
            stiffness += piezo.bending_modulus * layers_inertia * beam.integrate(start, end, 2)
            turn = beam.evaluate(end, 1) - beam.evaluate(start, 1)
            coupling[:, electrode] = w * (ts + tp) * piezo.bending_coupling * turn
        mass += self.tip_mass * np.outer(displacement, displacement)
        mass += self.tip_inertia * np.outer(slope, slope)

        capacitance = 2.0 * w * piezo.permittivity * (self.patch_end - self.patch_start) / tp
        return RitzMatrices(
            mass=mass,
            damping=self.mass_damping * mass + self.stiffness_damping * stiffness,
            stiffness=stiffness,
            coupling=coupling,
            capacitance=capacitance * np.eye(len(self.patches)),
            tip_displacement=displacement,
            tip_slope=slope,
        )

    @cached_property
    def modes(self) -> NormalModes:
        """The normal modes of `matrices`."""
        return self.matrices.modes()
