"""Beams for the oracles."""

import numpy as np
from oracle.stepped_beam import SteppedBeam

from contactlab.motor import FiniteElementResonator


def stepped_beam(resonator: FiniteElementResonator) -> SteppedBeam:
    """The same beam for the transfer matrices, from dimensions and materials alone."""
    r, w = resonator, resonator.width
    inner, outer = 0.5 * r.beam_thickness, 0.5 * r.beam_thickness + r.patch_thickness
    bare = r.steel.bending_modulus * w * 2.0 / 3.0 * inner**3
    patched = bare + r.piezoceramic.bending_modulus * w * 2.0 / 3.0 * (outer**3 - inner**3)
    light = r.steel.density * w * 2.0 * inner
    heavy = light + r.piezoceramic.density * w * 2.0 * (outer - inner)
    # Either layer pulls with w e_p per volt at its middle, (inner + outer) / 2 from the axis.
    moment = w * r.piezoceramic.bending_coupling * (inner + outer)
    return SteppedBeam(
        edges=np.array([0.0, r.patch_start, r.patch_end, 0.5 * r.length]),
        rigidity=np.array([bare, patched, bare]),
        mass=np.array([light, heavy, light]),
        moments=np.array([-moment, moment]),
        tip_mass=r.tip_mass,
        tip_inertia=r.tip_inertia,
        alpha=r.mass_damping,
        beta=r.stiffness_damping,
    )
