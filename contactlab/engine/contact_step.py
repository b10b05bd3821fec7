"""The step in contact where none is asked for: the law's own, or less where the tip has fast modes."""

from typing import Final

import numpy as np

from contactlab.engine.plant import persisting_rates
from contactlab.laws.base import ContactLaw, MultiplierLaw
from contactlab.motor import NormalModes

LARGEST_TURN: Final = 0.01
"""Largest step in rigid contact, times the tip's rate [1]."""


def default_contact_step(modes: NormalModes, law: ContactLaw) -> float:
    """Step in contact [s] of a law on a resonator, never longer than the law's `default_contact_step`.

    A rigid law that projects puts the tip back onto the closed gap after every step, after an impact at
    speed v by about v h / 2. That bends the modes, which costs or gives energy of the order of rate h
    times that of the impact and is in no term of the ledger, with

        rate^2 = sum_j row_j^2 min(omega_j, k_j/c_j)^2 / sum_j row_j^2,

    row_j being the tip's displacement in mode j; an overdamped mode counts by its slow root.
    """
    step = law.default_contact_step
    if not isinstance(law, MultiplierLaw) or not law.projects:
        return step
    row = modes.tip_displacement
    turning = float(np.linalg.norm(row * persisting_rates(modes.stiffness, modes.damping)))
    return min(step, LARGEST_TURN * float(np.linalg.norm(row)) / turning) if turning > 0.0 else step
