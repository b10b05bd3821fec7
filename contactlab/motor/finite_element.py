"""The converged resonator: Hermite cubic elements, reduced to normal modes with static correction.

The curvature jumps at a patch edge and under the tip; with nodes there, the frequencies converge with
the fourth power of the element. Loads of the tip and of the electrodes (moments at the patch edges,
eq. 31) act on nodes, where cubic elements are exact in statics on any mesh.

The tip is a rigid body, or a steel rod of its mass that stands on the beam, bends in the beam's plane and
does not stretch. Its bending is a cantilever's on a foot that turns with the beam's slope; what the contact
sees of it is the deflection of its end, as the slope theta = w_end / L of a rigid tip.

Modes that are left out carry flexibility that the contact feels. The static correction keeps it
(MacNeal 1971, Rubin 1975): the responses K^-1 b to unit loads b of tip force, tip moment and both
electrodes, made orthogonal to the kept modes, span a space in which M and K are diagonalised
once more. Its at most four pseudo-modes are oscillators like the others, with

* the flexibility R K^-1 R' at the tip and the answer to constant voltages exact to round-off,
* frequencies above the kept ones, pseudo-mode i not below mode (kept + i) of the mesh, because the
  space is a part of what the left-out modes span,
* the damping of the model, since C = alpha M + beta K: the flexibility left out follows with the
  time constant beta, as that of all high modes does; with a damping ratio they have that.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.motor.motor import NormalModes
from contactlab.motor.patched_beam import PatchedBeam, resolved_eigenpairs
from contactlab.parameter import Parameter

FREQUENCY_ERROR = 1.2e-6
"""Relative error of the highest kept frequency, PHASE^4 / 1440 for a uniform beam; lower ones have less."""

PHASE = 0.2
"""Largest element over the wave length / 2 pi of the highest kept mode in its section [rad]."""

MOST_ELEMENTS = 2000
"""Elements of the whole beam; its dense matrices then have 4000 rows."""

DEPENDENT = 1e-8
"""A unit vector's distance from the others' span at which it is dropped: it adds nothing but round-off."""

_ROD = Parameter(
    "L_tip",
    "m",
    "length of the tip as a steel rod of tip_mass that bends, in place of a rigid one with tip_inertia",
    above=0.0,
    hint="null is a rigid tip.",
)

# Of as many, the frequencies are verified to FREQUENCY_ERROR.
_KEPT = Parameter("n", "1", "number of normal modes", at_least=1, at_most=40)


@final
@dataclass(frozen=True)
class HermiteBeam:
    """Hermite cubic elements of a clamped-clamped Bernoulli-Euler beam, in coordinates of their curvature.

    A cubic element bends with a linear curvature, w'' = a + b s for s from -1 to 1, and stores the
    energy (E I h / 2) (a^2 + b^2 / 3): two numbers an element, no coupling between elements. From the
    left clamp on, deflection and slope of the nodes are sums of them,

        theta_(e+1) = theta_e + a h,    w_(e+1) = w_e + theta_e h + a h^2 / 2 - b h^2 / 6,

    and the right clamp is two linear conditions. In coordinates y = (a sqrt(E I h), b sqrt(E I h / 3))
    that satisfy these conditions the stiffness matrix is the identity: with the nodes at x = T y,

        K^-1 = T T',    K phi = omega^2 M phi  <=>  (T' M T) y = y / omega^2,  phi = omega T y.

    It is the space of assembled elements without their stiffness matrix, whose condition number grows
    like the fourth power of length over element: no short element costs a digit here.

    Args:
        size: h of every element from the left clamp on [m], shape (element,).
        rigidity: E I [N m^2], shape (element,).

    Degrees of freedom are (deflection [m], slope [1]) of every node but the left clamp, in this
    order; the last two are the right clamp's and remain zero.
    """

    size: Array
    rigidity: Array

    @cached_property
    def shapes(self) -> Array:
        """T [m J^-1/2 and J^-1/2], shape (dof, 2 element), with K^-1 = T T'."""
        free = self.cantilever
        clamp = np.linalg.qr(free[-2:].T)[0]
        return np.asarray(free - (free @ clamp) @ clamp.T, dtype=np.float64)

    @property
    def cantilever(self) -> Array:
        """T of the beam without its right clamp."""
        h = self.size
        constant = 1.0 / np.sqrt(self.rigidity * h)
        linear = np.sqrt(3.0) * constant
        count = h.size
        # Row: node at the end of an element; column: element that bends, at or before it.
        before = np.tril(np.ones((count, count)))
        nodes = np.cumsum(h)
        arm = nodes[:, None] - nodes
        free = np.zeros((2 * count, 2 * count))
        free[0::2, 0::2] = before * (0.5 * h**2 + h * arm) * constant
        free[0::2, 1::2] = before * (-(h**2) / 6.0) * linear
        free[1::2, 0::2] = before * h * constant
        return free

    def mass_matrix(self, mass: Array, first: int = 2) -> Array:
        """Return M [kg, kg m, kg m^2] of a mass per length in every element [kg/m], shape (dof, dof).

        Without the first degrees of freedom; 2 are those of the left clamp.
        """
        count = self.size.size
        matrix = np.zeros((2 * count + 2, 2 * count + 2))
        for e, (h, m) in enumerate(zip(self.size, mass, strict=True)):
            matrix[2 * e : 2 * e + 4, 2 * e : 2 * e + 4] += (m * h / 420.0) * np.array(
                [
                    [156.0, 22.0 * h, 54.0, -13.0 * h],
                    [22.0 * h, 4.0 * h**2, 13.0 * h, -3.0 * h**2],
                    [54.0, 13.0 * h, 156.0, -22.0 * h],
                    [-13.0 * h, -3.0 * h**2, -22.0 * h, 4.0 * h**2],
                ]
            )
        return matrix[first:, first:]

    def node_at(self, position: float) -> int:
        """Return the degree of freedom of the deflection nearest to a position [m]; its slope is the next."""
        return 2 * int(np.abs(np.cumsum(self.size) - position).argmin())


class Discretisation(NamedTuple):
    """The beam on a mesh, in coordinates y whose stiffness matrix is the identity.

    Args:
        shapes: the nodes at x = T y, shape (dof, 2 element).
        mass: M, tip included, on the nodes, shape (dof, dof).
        spread: int psi psi' dx on the nodes [m], shape (dof, dof).
        loads: unit tip force, unit tip moment and 1 V on either electrode, shape (dof, 4).
    """

    shapes: Array
    mass: Array
    spread: Array
    loads: Array

    def lowest(self, count: int) -> tuple[Array, Array]:
        """Return omega^2 [1/s^2] of the lowest modes, shape (count,), and their y, shape (2 element, count).

        The largest 1 / omega^2 are computed, so that the low frequencies are the most accurate.
        """
        inverse = self.shapes.T @ self.mass @ self.shapes
        largest = [len(inverse) - count, len(inverse) - 1]
        squares, vectors = resolved_eigenpairs(inverse, subset_by_index=largest)
        return 1.0 / squares[::-1], vectors[:, ::-1]

    def static_remainder(self, kept: Array) -> tuple[Array, Array]:
        """Return the pseudo-modes of the loads beside the kept modes: omega^2 and y like `lowest`.

        Orthogonal in y is orthogonal in stiffness; against eigenvectors it is so in mass as well.
        """
        static = self.shapes.T @ self.loads
        remainder = static - kept @ (kept.T @ static)
        # What is left of a vector that the kept modes contain is their round-off.
        remainder -= kept @ (kept.T @ remainder)
        size = np.linalg.norm(remainder, axis=0)
        remainder = remainder[:, size > DEPENDENT * np.linalg.norm(static, axis=0)]
        remainder /= np.linalg.norm(remainder, axis=0)
        basis, independence, _ = np.linalg.svd(remainder, full_matrices=False)
        basis = basis[:, independence > DEPENDENT]
        nodal = self.shapes @ basis
        inverse, vectors = np.linalg.eigh(nodal.T @ self.mass @ nodal)
        return 1.0 / inverse[::-1], basis @ vectors[:, ::-1]


@final
@dataclass(frozen=True)
class FiniteElementResonator(PatchedBeam):
    """The patched beam in converged normal modes.

    A pseudo-mode is no resonance. `NormalModes.shape_coupling` has the couplings of these modes, scaled
    to int psi^2 dx = L as the paper's beam shapes are; a mode's sign is that of u + L theta at the tip.

        >>> import contactlab as cl
        >>> cl.FiniteElementResonator().modes.natural_frequency[:2].round(1)
        array([2137.5, 3766.3])
    """

    kept_modes: Annotated[int, _KEPT] = 6
    static_correction: Annotated[
        bool, Parameter("", "1", "whether up to four pseudo-modes stand for the modes left out")
    ] = True
    rod_length: Annotated[float | None, _ROD] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rod_length is not None:
            self._refuse_beside("rod_length", "tip_inertia")
        if self.residual_mass and (self.rod_length is not None or not self.static_correction):
            raise ValueError(
                "residual_mass is True: rod_length must be None, and static_correction True, the "
                "residual flexibility of which the residual modes have."
            )

    def _solve(self) -> NormalModes:
        """Compute kept modes and pseudo-modes, in ascending order of frequency."""
        if self.residual_mass:
            return self._with_residual_modes(static_correction=False)
        beam = self.discretise(self.mesh)
        squares, vectors = beam.lowest(self.kept_modes)
        if self.static_correction:
            pseudo_squares, pseudo_vectors = beam.static_remainder(vectors)
            squares = np.concatenate([squares, pseudo_squares])
            vectors = np.hstack([vectors, pseudo_vectors])
        nodal = beam.shapes @ vectors * np.sqrt(squares)
        loads = nodal.T @ beam.loads
        loads *= np.where(loads[:, 0] + self.length * loads[:, 1] < 0.0, -1.0, 1.0)[:, None]
        spread = np.sum(nodal * (beam.spread @ nodal), axis=0)
        tip_displacement, tip_slope, *electrodes = loads.T.copy()
        coupling = np.stack(electrodes, axis=1)
        return NormalModes(
            stiffness=squares,
            damping=self.modal_damping(squares),
            coupling=coupling,
            tip_displacement=tip_displacement,
            tip_slope=tip_slope,
            shape_coupling=coupling * np.sqrt(self.length / spread)[:, None],
        )

    @cached_property
    def mesh(self) -> tuple[int, ...]:
        """Elements in every section of the left half, fine enough for the highest kept mode.

        A frequency on a coarse mesh lies above the true one, so elements that suit it are small enough.
        """
        size, rigidity, mass = self._sections
        coarse = np.ceil(4 * self.kept_modes * size / self.length) + 1.0
        highest = self.discretise(tuple(map(int, coarse))).lowest(self.kept_modes)[0][-1]
        fine = np.maximum(1.0, np.ceil((highest * mass / rigidity) ** 0.25 * size / PHASE))
        if (elements := 2.0 * fine.sum()) > MOST_ELEMENTS:
            raise ValueError(
                f"{self.kept_modes} kept modes need {elements:.0f} elements; there may be "
                f"{MOST_ELEMENTS} at most. The paper's motor needs 610 for forty modes: check the "
                "orders of magnitude of the materials or keep fewer modes."
            )
        return tuple(map(int, fine))

    @property
    def _sections(self) -> tuple[Array, Array, Array]:
        """Length [m], bending rigidity [N m^2] and mass per length [kg/m] from the clamp to the centre."""
        size = np.diff([0.0, self.patch_start, self.patch_end, 0.5 * self.length])
        layers = np.array([0.0, 1.0, 0.0])[size > 0.0]
        rigidity = self.steel_rigidity + layers * self.layer_rigidity
        every = size[size > 0.0], rigidity, self.steel_mass + layers * self.layer_mass
        if self.rod_length is None:
            return every
        area = self.tip_mass / (self.steel.density * self.rod_length)
        # A round rod, I = A^2 / (4 pi).
        rod = (
            self.rod_length,
            self.steel.youngs_modulus * area**2 / (4.0 * np.pi),
            self.tip_mass / self.rod_length,
        )
        size, rigidity, mass = (np.append(values, x) for values, x in zip(every, rod, strict=True))
        return size, rigidity, mass

    def discretise(self, mesh: tuple[int, ...]) -> Discretisation:
        """Mesh the beam by `mesh[i]` equal elements in section i of its left half, and their mirrors.

        The last section is the rod, where the tip is one.
        """
        size, rigidity, mass = self._sections
        beam_alone = slice(None if self.rod_length is None else -1)
        halves = (
            np.repeat(values, mesh)[: sum(mesh[beam_alone])] for values in (size / mesh, rigidity, mass)
        )
        sizes, rigidities, masses = (np.concatenate([half, half[::-1]]) for half in halves)
        beam = HermiteBeam(sizes, rigidities)
        matrix = beam.mass_matrix(masses)
        tip = beam.node_at(0.5 * self.length)
        matrix[tip, tip] += self.tip_mass
        matrix[tip + 1, tip + 1] += self.tip_inertia if self.rod_length is None else 0.0
        loads = np.zeros((len(matrix), 2 + len(self.patches)))
        loads[tip, 0] = loads[tip + 1, 1] = 1.0
        for column, edges in enumerate(self.patches, start=2):
            for edge, sign in zip(edges, (-1.0, 1.0), strict=True):
                # A moment on a clamp does no work.
                if 0.0 < edge < self.length:
                    loads[beam.node_at(edge) + 1, column] += sign * self.moment_per_voltage
        alone = Discretisation(beam.shapes, matrix, beam.mass_matrix(np.ones_like(masses)), loads)
        if self.rod_length is None:
            return alone
        return self._with_rod(alone, tip + 1, np.full(mesh[-1], size[-1] / mesh[-1]), rigidity[-1], mass[-1])

    @staticmethod
    def _with_rod(
        beam: Discretisation, foot: int, size: Array, rigidity: float, mass: float
    ) -> Discretisation:
        """Return the beam with a rod on it, whose foot turns with one of the beam's degrees of freedom."""
        rod = HermiteBeam(size, np.full_like(size, rigidity))
        height = np.cumsum(size)
        # The foot carries the rod along as a rigid one.
        carried = np.ravel(np.column_stack([height, np.ones_like(height)]))[:, None] * beam.shapes[foot]
        nothing = np.zeros((len(beam.shapes), len(carried)))
        shapes = np.block([[beam.shapes, nothing], [carried, rod.cantilever]])
        places = np.append(foot, len(beam.mass) + np.arange(len(carried)))
        matrix, spread = (np.pad(each, (0, len(carried))) for each in (beam.mass, beam.spread))
        matrix[np.ix_(places, places)] += rod.mass_matrix(np.full_like(size, mass), first=1)
        loads = np.pad(beam.loads, ((0, len(carried)), (0, 0)))
        loads[:, 1] = 0.0
        loads[-2, 1] = 1.0 / height[-1]
        return Discretisation(shapes, matrix, spread, loads)
