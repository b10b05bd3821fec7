"""The beam that every basis describes: dimensions, materials and what follows from them alone.

Bending strains a fibre by -1 along the beam and by +nu through the thickness (the layers are
stress-free there), b = [0, -1, nu, 0, 0, 0] in Voigt order with x2 along the beam and x3 through
the thickness (Andersen, Blanke and Helbo 2001, eqs. 13 and 33).

Source: Andersen, Blanke and Helbo (2001), eqs. 19-34. Signs and factors follow the consistent
form: masses are positive (eqs. 23, 27, 28 print them negative), a patch set counts both of its
layers in the mass (eq. 28 prints one), and the sign of the coupling is that of the paper's Table 1
(eq. 31 prints the opposite).
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Annotated, Any, final

import numpy as np
import scipy
from threadpoolctl import threadpool_limits

from contactlab.arrays import Array
from contactlab.checks import Checked
from contactlab.motor.motor import NormalModes
from contactlab.motor.residual import add_residual_modes
from contactlab.parameter import Parameter, not_negative, positive

RESOLVED = 1e-9
"""Smallest eigenvalue over the largest that is still known.

The eigenvalues of a symmetric matrix are found to within a few units of round-off of the largest one
(8 at most in what was measured), so that omega^2 is right to 2e-6 here, and omega to 1e-6."""

UNRESOLVED = (
    "Dimensions, materials, placement and tip together give modes that double precision does not "
    "resolve: mass and stiffness must be finite and positive definite, and the highest natural "
    f"frequency at most {RESOLVED**-0.5:.0f} times the lowest. Check the orders of magnitude, or take "
    "fewer modes."
)


def resolved_eigenpairs(a: Array, b: Array | None = None, **options: Any) -> tuple[Array, Array]:
    """Solve a x = lambda b x for symmetric matrices, eigenvalues ascending, or refuse it by UNRESOLVED."""
    if not all(np.isfinite(matrix).all() for matrix in (a, b) if matrix is not None):
        raise ValueError(UNRESOLVED)
    eigenvalues, vectors = scipy.linalg.eigh(a, b, **options)
    # Not the other way round: nothing is larger than what is no number.
    if not eigenvalues[0] > RESOLVED * eigenvalues[-1]:
        raise ValueError(UNRESOLVED)
    return eigenvalues, vectors


VACUUM_PERMITTIVITY = 8.8541878128e-12
"""F/m, CODATA 2018."""

_DENSITY = positive("rho_p", "kg m-3", "density")
_POISSON = Parameter("nu", "1", "Poisson's ratio", above=-1.0, below=0.5)
_STRAIN_RATIO = Parameter("nu_p", "1", "ratio of the strains through the thickness and along the beam")
_CLAMPED = positive("eps33^S", "F m-1", "permittivity through the thickness, all strains clamped")
_IN_THE_BEAM = positive(
    "eps_p",
    "F m-1",
    "permittivity through the thickness, free to strain in it, clamped along and across the beam",
)
_FREE = positive("eps33^T", "F m-1", "permittivity through the thickness, all stresses zero")
_LOSS_TANGENT = Parameter(
    "tan delta",
    "1",
    "dielectric loss tangent of the free material, as data sheets have it",
    at_least=0.0,
    at_most=1.0,
    hint="0 is a dielectric without loss.",
)


def bending_vector(poisson_ratio: float) -> Array:
    """Return the strain of a fibre under unit curvature at unit height, b = [0, -1, nu, 0, 0, 0] (eq. 33)."""
    return np.array([0.0, -1.0, poisson_ratio, 0.0, 0.0, 0.0])


@final
@dataclass(frozen=True)
class Steel(Checked):
    """An isotropic beam material.

    >>> import contactlab as cl
    >>> cl.RitzResonator(steel=cl.Steel(youngs_modulus=195e9)).modes.natural_frequency[:2].round(1)
    array([3182.7, 5379.1])
    """

    youngs_modulus: Annotated[float, positive("E", "Pa", "Young's modulus")] = 210e9
    poisson_ratio: Annotated[float, _POISSON] = 0.3
    density: Annotated[float, positive("rho_s", "kg m-3", "density")] = 7850.0

    @property
    def bending_modulus(self) -> float:
        """c_s = b c b' with the full isotropic tensor [Pa] (eq. 29); 235.442 GPa for steel."""
        nu = self.poisson_ratio
        shear = self.youngs_modulus / (2.0 * (1.0 + nu))
        lame = self.youngs_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
        tensor = np.diag([2.0 * shear] * 3 + [shear] * 3)
        tensor[:3, :3] += lame
        b = bending_vector(nu)
        return float(b @ tensor @ b)


@final
@dataclass(frozen=True)
class Piezoceramic(Checked):
    """A piezoceramic layer poled through its thickness, by modulus and coupling in bending.

    The modulus is b c^E b' (eq. 30), the coupling nu_p e33 - e31 (eq. 31). The defaults are PZ26 with
    both identified from the couplings and frequencies of Table 1; `PiezoceramicDatasheet` has the
    catalogue's values, and the permittivities are those that follow from them.

        >>> import contactlab as cl
        >>> layer = cl.Piezoceramic(loss_tangent=0.02)
        >>> modes = cl.RitzResonator(piezoceramic=layer).modes
        >>> (1e9 * modes.capacitance.diagonal()).round(3) # nF
        array([2.35, 2.35])
    """

    bending_modulus: Annotated[float, positive("c_p", "Pa", "bending modulus")] = 94.295e9
    bending_coupling: Annotated[float, Parameter("e_p", "C m-2", "bending coupling")] = 9.196
    density: Annotated[float, _DENSITY] = 7700.0
    permittivity: Annotated[float, _IN_THE_BEAM] = 700.0 * VACUUM_PERMITTIVITY + 14.7**2 / 123e9
    free_permittivity: Annotated[float, _FREE] = 1.1709334182747709e-08
    loss_tangent: Annotated[float, _LOSS_TANGENT] = 0.0

    @property
    def capacitive_loss_tangent(self) -> float:
        """Loss tangent of the capacitance at clamped modes, tan(delta) eps33^T / eps_p [1].

        Where compliance s^E and charge constants d are real, the loss is Im eps33^T; eps_p is eps33^T less a
        real number, so both have the same imaginary part.
        """
        return self.loss_tangent * self.free_permittivity / self.permittivity


@final
@dataclass(frozen=True)
class PiezoceramicDatasheet(Checked):
    """The constants of a piezoceramic, transversely isotropic about x3, in which it is poled; those of PZ26.

    c12 enters the free permittivity alone: the strain across the width is zero in bending.
    """

    c11: Annotated[float, positive("c11^E", "Pa", "elastic constant")] = 168e9
    c12: Annotated[float, Parameter("c12^E", "Pa", "elastic constant")] = 110e9
    c13: Annotated[float, Parameter("c13^E", "Pa", "elastic constant")] = 99.9e9
    c33: Annotated[float, positive("c33^E", "Pa", "elastic constant")] = 123e9
    e31: Annotated[float, Parameter("e31", "C m-2", "piezoelectric constant")] = -2.8
    e33: Annotated[float, Parameter("e33", "C m-2", "piezoelectric constant")] = 14.7
    poisson_ratio: Annotated[float, _STRAIN_RATIO] = 0.334
    density: Annotated[float, _DENSITY] = 7700.0
    permittivity: Annotated[float, _CLAMPED] = 700.0 * VACUUM_PERMITTIVITY
    loss_tangent: Annotated[float, _LOSS_TANGENT] = 0.0

    def in_bending(self) -> Piezoceramic:
        """Compute the constants of a layer in bending (eqs. 30 and 31) and its permittivities.

        From T = c^E S - e' E and D = e S + eps^S E (IEEE Std 176-1987): at S1 = S2 = 0 and T3 = 0,
        eps_p = eps33^S + e33^2 / c33^E, where the strain S2 of the modes acts through the coupling; at T = 0,
        eps33^T = eps33^S + e (c^E)^-1 e'.
        """
        c11, c12, c13 = self.c11, self.c12, self.c13
        normal = np.array([[c11, c12, c13], [c12, c11, c13], [c13, c13, self.c33]])
        b = bending_vector(self.poisson_ratio)[:3]
        e = np.array([self.e31, self.e31, self.e33])
        return Piezoceramic(
            bending_modulus=float(b @ normal @ b),
            bending_coupling=float(b @ e),
            density=self.density,
            permittivity=self.permittivity + self.e33**2 / self.c33,
            free_permittivity=float(self.permittivity + e @ np.linalg.solve(normal, e)),
            loss_tangent=self.loss_tangent,
        )


_RESIDUAL_MASS = Parameter(
    "", "1", "whether two residual modes let a rigid impact meet the tip's mass with any number of modes"
)
_DAMPING_RATIO = Parameter(
    "zeta",
    "1",
    "damping ratio of every mode, in place of alpha and beta",
    at_least=0.0,
    below=1.0,
    hint="null takes mass_damping and stiffness_damping.",
)
_TIP_INERTIA = not_negative("I_tip", "kg m2", "inertia of the tip about its foot")


@dataclass(frozen=True)
class PatchedBeam(Checked, ABC):
    """A clamped beam with two mirrored pairs of piezoceramic patches and a rigid tip at its centre.

    A layer is bonded to either side; the second set is the mirror image, [L - a_12, L - a_11].
    C = alpha M + beta K, or 2 zeta omega_j in every mode with a damping ratio. Not modelled: rotary inertia
    and shear of the layers, and adhesive between them.
    """

    length: Annotated[float, positive("L", "m", "length between the clamps")] = 57e-3
    width: Annotated[float, positive("w_s", "m", "width of beam and patches")] = 16e-3
    beam_thickness: Annotated[float, positive("t_s", "m", "thickness of the beam")] = 1e-3
    patch_thickness: Annotated[float, positive("t_p", "m", "thickness of a patch layer")] = 1e-3
    patch_start: Annotated[float, not_negative("a_11", "m", "where the patches begin")] = 0.914e-3
    patch_end: Annotated[float, positive("a_12", "m", "where the patches end")] = 10.146e-3
    tip_mass: Annotated[float, not_negative("M_tip", "kg", "mass of the tip")] = 1.181e-3
    tip_inertia: Annotated[float, _TIP_INERTIA] = 1.321e-7
    steel: Steel = field(default_factory=Steel)
    piezoceramic: Piezoceramic = field(default_factory=Piezoceramic)
    mass_damping: Annotated[float, not_negative("alpha", "s-1", "damping per mass")] = 7.5
    stiffness_damping: Annotated[float, not_negative("beta", "s", "damping per stiffness")] = 2e-5
    damping_ratio: Annotated[float | None, _DAMPING_RATIO] = None
    residual_mass: Annotated[bool, _RESIDUAL_MASS] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.damping_ratio is not None:
            self._refuse_beside("damping_ratio", "mass_damping", "stiffness_damping")
        for name in ("tip_mass", "tip_inertia"):
            if self.residual_mass and not getattr(self, name) > 0.0:
                raise ValueError(f"{name} is 0; with residual_mass it must be positive.")
        half = 0.5 * self.length
        if not self.patch_start < self.patch_end <= half:
            raise ValueError(
                f"The patches lie at {self.patch_start} to {self.patch_end} m; they must satisfy "
                f"0 <= start < end <= {half} m, half the beam, or they leave it or overlap their mirror."
            )

    def _refuse_beside(self, option: str, *others: str) -> None:
        """Refuse numbers that an option takes the place of, unless they have their defaults."""
        for name in others:
            if (value := getattr(self, name)) != (default := getattr(type(self), name)):
                raise ValueError(
                    f"{option} takes the place of {name}, which is {value:g}; it must be left at {default:g}."
                )

    def modal_damping(self, squares: Array) -> Array:
        """Return c_j [1/s] of modes with these omega_j^2 [1/s^2]."""
        if self.damping_ratio is None:
            return self.mass_damping + self.stiffness_damping * squares
        return np.asarray(2.0 * self.damping_ratio * np.sqrt(squares))

    @cached_property
    def modes(self) -> NormalModes:
        """The normal modes in the basis of the subclass; a ValueError where double precision has none."""
        try:
            # More threads gain nothing for matrices of this size, wait for each other on a busy machine and
            # round otherwise. Numbers far from any motor may overflow on the way; the result says so.
            with threadpool_limits(1, user_api="blas"), np.errstate(all="ignore"):
                modes = replace(
                    self._solve(),
                    capacitance=self.capacitance,
                    loss_tangent=self.piezoceramic.capacitive_loss_tangent,
                )
        except (np.linalg.LinAlgError, ArithmeticError) as error:
            raise ValueError(UNRESOLVED) from error
        arrays = [values for values in vars(modes).values() if isinstance(values, np.ndarray)]
        finite = (np.isfinite(values).all() for values in arrays)
        if not (all(finite) and np.all(modes.stiffness > 0.0)):
            raise ValueError(UNRESOLVED)
        return modes

    @abstractmethod
    def _solve(self) -> NormalModes:
        """Compute the normal modes in the basis of the subclass."""

    def _with_residual_modes(self, **options: Any) -> NormalModes:
        """Return the kept modes with residual modes of flexibility and mass."""
        modes = replace(self, residual_mass=False, **options).modes
        tip = np.stack([modes.tip_displacement, modes.tip_slope])
        residual = self.static_response - tip / modes.stiffness @ np.hstack([tip.T, modes.coupling])
        return add_residual_modes(
            modes,
            np.diag([self.tip_mass, self.tip_inertia]),
            residual[:, :2],
            voltage_response=residual[:, 2:],
            damping=self.modal_damping,
        )

    @property
    def static_response(self) -> Array:
        """Deflection and slope at the tip under unit tip force, unit tip moment and 1 V on each electrode.

        Shape (2, 4), [m/N, 1/N, m/V; 1/N, 1/(N m), 1/V], in closed form: each load and each reaction of the
        right clamp works on the curvature by its moment m(x) on a cantilever, and EI w'' is what is left of
        the load's moment orthogonal to the reactions', in the product int m m' dx / (E I).
        """
        centre, (first, second) = 0.5 * self.length, self.patches
        edges = np.unique([0.0, *first, centre, *second, self.length])
        half = 0.5 * np.diff(edges)[:, None]
        # Two Gauss points a section, exact for products of linear moments.
        x = (edges[:-1, None] + half * (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0))).ravel()
        patched = [(start < x) & (x < end) for start, end in self.patches]
        rigidity = self.steel_rigidity + self.layer_rigidity * (patched[0] | patched[1])
        before = x < centre
        loads = [(centre - x) * before, before, *(self.moment_per_voltage * each for each in patched)]
        moments = np.stack([1.0 + 0.0 * x, self.length - x, *loads], axis=1)
        moments *= np.sqrt(np.repeat(half, 2) / rigidity)[:, None]
        reactions = np.linalg.qr(moments[:, :2])[0]
        free = moments[:, 2:] - reactions @ (reactions.T @ moments[:, 2:])
        return np.asarray(free[:, :2].T @ free)

    @property
    def patches(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Start and end of both patch sets [m]: the given one (electrode 0) and its mirror (electrode 1)."""
        start, end = self.patch_start, self.patch_end
        return (start, end), (self.length - end, self.length - start)

    @property
    def steel_mass(self) -> float:
        """Mass of the bare beam per length, rho_s A_s [kg/m]."""
        return self.steel.density * self.width * self.beam_thickness

    @property
    def layer_mass(self) -> float:
        """Mass of both layers of a patch set per length, 2 rho_p A_p [kg/m] (eq. 28)."""
        return self.piezoceramic.density * 2.0 * self.width * self.patch_thickness

    @property
    def steel_rigidity(self) -> float:
        """Bending rigidity of the bare beam, c_s I_s [N m^2] (eq. 29)."""
        return self.steel.bending_modulus * (self.width * self.beam_thickness**3 / 12.0)

    @property
    def layer_rigidity(self) -> float:
        """Bending rigidity of both layers about the middle of the beam, c_p I_p [N m^2] (eq. 30)."""
        ts, tp = self.beam_thickness, self.patch_thickness
        inertia = 2.0 / 3.0 * self.width * (1.5 * tp**2 * ts + 0.75 * ts**2 * tp + tp**3)
        return self.piezoceramic.bending_modulus * inertia

    @property
    def moment_per_voltage(self) -> float:
        """Moment at the end of a patch set, w_s (t_s + t_p) e_p [N m/V]; minus that at its start (eq. 31)."""
        lever = self.width * (self.beam_thickness + self.patch_thickness)
        return lever * self.piezoceramic.bending_coupling

    @property
    def capacitance(self) -> Array:
        """C_p of both patch sets, two layers each, with the modes at rest [F] (eq. 32, at eps_p)."""
        surface = 2.0 * self.width * (self.patch_end - self.patch_start)
        return self.piezoceramic.permittivity * surface / self.patch_thickness * np.eye(len(self.patches))
