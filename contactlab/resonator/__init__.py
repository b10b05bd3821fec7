"""The resonator: one beam, several bases, and normal modes as the one face of all of them.

RitzResonator             the paper's basis of smooth beam shapes
FiniteElementResonator    elements that can bend sharply at a patch edge: converged
"""

from contactlab.resonator.finite_element import FiniteElementResonator
from contactlab.resonator.modes import NormalModes
from contactlab.resonator.patched_beam import PatchedBeam
from contactlab.resonator.ritz import RitzMatrices, RitzResonator

__all__ = [
    "FiniteElementResonator",
    "NormalModes",
    "PatchedBeam",
    "RitzMatrices",
    "RitzResonator",
]
