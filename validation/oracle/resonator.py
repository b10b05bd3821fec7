"""Ritz model of the clamped beam with two piezo sets and a tip, in shape coordinates.

    M r'' + C r' + K r = Gamma U + S' f        (eqs. 19-34, signs of masses and Gamma corrected)

r are the amplitudes of the clamped-clamped beam shapes [m], U = (U_A, U_B) the voltages [V],
f = (force along u [N], torque on the slope [N m]) the load on the tip, S = (psi(L/2); dpsi(L/2)).
No normal modes are formed anywhere.  The shapes are written about the middle of the beam, with
xi = x - L/2 and h = kappa L/2:

    symmetric       psi = cosh(kappa xi)/cosh(h) - cos(kappa xi)/cos(h)
    antisymmetric   psi = sin(kappa xi)/sin(h) - sinh(kappa xi)/sinh(h)

This is cosh - cos - s (sinh - sin) from the left clamp, same normalisation, without its
cancellation.
Not valid for beams whose rotary inertia or shear matters: Bernoulli-Euler only.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.integrate import fixed_quad
from scipy.linalg import eigh
from scipy.optimize import brentq

QUADRATURE_POINTS = 64


class Resonator(NamedTuple):
    """Matrices of n shapes; electrode 0 is the set at patch_start..patch_end, 1 its mirror."""

    mass: np.ndarray  # M, kg, (n, n)
    damping: np.ndarray  # C = alpha M + beta K, N s/m, (n, n)
    stiffness: np.ndarray  # K, N/m, (n, n)
    coupling: np.ndarray  # Gamma, N/V, (n, 2)
    tip: np.ndarray  # S: row 0 psi(L/2) [1], row 1 dpsi(L/2) [1/m], (2, n)


class Section(NamedTuple):
    """Layered beam; lengths in m, moduli in Pa, densities in kg/m^3, coupling in C/m^2."""

    length: float
    width: float
    beam_thickness: float
    piezo_thickness: float
    patch_start: float
    patch_end: float
    steel_modulus: float
    steel_poisson: float
    steel_density: float
    piezo_bending_modulus: float
    piezo_bending_coupling: float
    piezo_density: float


def wave_numbers(count: int, length: float) -> np.ndarray:
    """First `count` roots kappa [1/m] of cos(kappa L) = 1/cosh(kappa L), shape (count,)."""

    def characteristic(x: float) -> float:
        return np.cos(x) - 1.0 / np.cosh(x)

    centres = (np.arange(1, count + 1) + 0.5) * np.pi
    roots = [brentq(characteristic, x - 0.5, x + 0.5, xtol=1e-15, rtol=1e-15) for x in centres]
    return np.array(roots) / length


def shapes(position: np.ndarray | float, count: int, length: float, derivative: int = 0) -> np.ndarray:
    """Derivative of order 0, 1 or 2 of the shapes at `position` [m from the left clamp].

    Returns shape (count, *position.shape), unit 1/m^derivative.
    """
    if derivative not in (0, 1, 2):
        raise ValueError(f"derivative is {derivative}; it must be 0, 1 or 2.")
    xi = np.asarray(position, dtype=float) - 0.5 * length
    rows = []
    for index, kappa in enumerate(wave_numbers(count, length)):
        h, z = 0.5 * kappa * length, kappa * xi
        # Each derivative of a cosine or sine is the same function a quarter turn ahead.
        turned = z + 0.5 * np.pi * derivative
        if index % 2 == 0:
            hyperbolic = np.sinh(z) if derivative == 1 else np.cosh(z)
            row = hyperbolic / np.cosh(h) - np.cos(turned) / np.cos(h)
        else:
            hyperbolic = np.cosh(z) if derivative == 1 else np.sinh(z)
            row = np.sin(turned) / np.sin(h) - hyperbolic / np.sinh(h)
        rows.append(kappa**derivative * row)
    return np.array(rows)


def steel_bending_modulus(modulus: float, poisson: float) -> float:
    """Bending modulus b c b' [Pa] of the isotropic tensor c with b = (0, -1, nu, 0, 0, 0)."""
    scale = modulus / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    c11, c12 = scale * (1.0 - poisson), scale * poisson
    return c11 - 2.0 * poisson * c12 + poisson**2 * c11


def gram(section: Section, count: int, start: float, end: float, derivative: int) -> np.ndarray:
    """Integral from start to end [m] of the products of derivatives, shape (count, count)."""

    def products(x: np.ndarray) -> np.ndarray:
        values = shapes(x, count, section.length, derivative)
        return values[:, None, :] * values[None, :, :]

    return fixed_quad(products, start, end, n=QUADRATURE_POINTS)[0]


def build_resonator(
    section: Section,
    count: int,
    tip_mass: float,
    tip_inertia: float,
    mass_damping: float,
    stiffness_damping: float,
) -> Resonator:
    """Assemble M, C, K, Gamma and the tip rows from the section and `count` shapes.

    tip_mass [kg]; tip_inertia about the tip's lower end [kg m^2]; mass_damping alpha [1/s];
    stiffness_damping beta [s].
    """
    s = section
    ts, tp, width, length = s.beam_thickness, s.piezo_thickness, s.width, s.length
    sets = ((s.patch_start, s.patch_end), (length - s.patch_end, length - s.patch_start))
    beam_inertia = width * ts**3 / 12.0
    piezo_inertia = 2.0 / 3.0 * width * (1.5 * tp**2 * ts + 0.75 * ts**2 * tp + tp**3)

    def over_beam(derivative: int) -> np.ndarray:
        return gram(s, count, 0.0, length, derivative)

    def over_sets(derivative: int) -> np.ndarray:
        return np.sum([gram(s, count, a, b, derivative) for a, b in sets], axis=0)

    middle = 0.5 * length
    tip = np.array([shapes(middle, count, length, d) for d in (0, 1)])
    mass = s.steel_density * width * ts * over_beam(0)
    mass += s.piezo_density * 2.0 * width * tp * over_sets(0)
    mass += tip.T @ np.diag([tip_mass, tip_inertia]) @ tip
    steel = steel_bending_modulus(s.steel_modulus, s.steel_poisson)
    stiffness = steel * beam_inertia * over_beam(2)
    stiffness += s.piezo_bending_modulus * piezo_inertia * over_sets(2)
    slopes = [shapes(b, count, length, 1) - shapes(a, count, length, 1) for a, b in sets]
    coupling = width * (ts + tp) * s.piezo_bending_coupling * np.column_stack(slopes)
    damping = mass_damping * mass + stiffness_damping * stiffness
    return Resonator(mass, damping, stiffness, coupling, tip)


def natural_frequencies(resonator: Resonator) -> np.ndarray:
    """Undamped natural frequencies [Hz], ascending, from K x = w^2 M x."""
    return np.sqrt(eigh(resonator.stiffness, resonator.mass, eigvals_only=True)) / (2.0 * np.pi)
