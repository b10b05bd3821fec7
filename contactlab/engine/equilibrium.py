"""Where a motor rests before its drive is switched on, pressed together by a constant force."""

from dataclasses import replace
from typing import Final

import numpy as np
import scipy

from contactlab.engine.binding import FORCE
from contactlab.engine.preparation import take_in
from contactlab.laws.base import ContactLaw, PenaltyLaw
from contactlab.motor.motor import ModalState, Motor

DEEPEST: Final = 1e-3
"""Largest penetration at rest that is looked for [m]."""

OPEN: Final = 1e-15
"""Gap at which a rigid contact begins [m], which round-off must not close."""


def at_rest(motor: Motor, law: ContactLaw) -> Motor:
    """Return a motor that begins in its static equilibrium, without a drive.

        k_j q_j = a_j - N rho_j,   g_0 - sum_j rho_j q_j = -d(N)

    with the preload a_j, the rows rho_j of tip towards rotor and the penetration d at which the law's normal
    force at rest is N; a rigid law has none. Where one coordinate has no stiffness, as a rotor on a bearing
    without a spring's, N is what its preload asks for.

    Raises:
        ValueError: no contact force up to a penetration of `DEEPEST` balances the preload.
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.
    """
    k, row = motor.modes.stiffness, motor.modes.approach
    preload = np.zeros_like(k) if motor.preload is None else motor.preload
    free, clearance = np.flatnonzero(k == 0.0), motor.geometry.clearance
    elastic = k > 0.0
    yields, comes = (
        float(row[elastic] ** 2 @ (1.0 / k[elastic])),
        float(row[elastic] @ (preload[elastic] / k[elastic])),
    )

    def penetration(force: float) -> float:
        """Return d of a normal force, less a little of a rigid law."""
        if not isinstance(law, PenaltyLaw):
            return -OPEN
        parameters, _, bound, errors = take_in(law)

        def missing(depth: float) -> float:
            return float(bound.kernels[FORCE](-depth, 0.0, 0.0, 0.0, parameters)[0]) - force

        with errors():
            if missing(DEEPEST) > 0.0:
                return float(scipy.optimize.brentq(missing, 0.0, DEEPEST, xtol=1e-20, rtol=1e-14))
        raise ValueError(f"No penetration up to {DEEPEST} m has the normal force {force:.6g} N at rest.")

    force = 0.0
    if free.size:
        force = float(preload[free[0]] / row[free[0]]) if row[free[0]] else 0.0
    elif comes > clearance:
        most = (comes - clearance) / yields
        force = most + OPEN / yields
        if isinstance(law, PenaltyLaw):
            force = scipy.optimize.brentq(
                lambda n: (most - n) * yields - penetration(n), 0.0, most, xtol=1e-20
            )
    q = np.zeros_like(k)
    q[elastic] = (preload[elastic] - force * row[elastic]) / k[elastic]
    if free.size and force > 0.0:
        q[free[0]] = (clearance + penetration(force) - row[elastic] @ q[elastic]) / row[free[0]]
    return replace(motor, start=ModalState(q, np.zeros_like(k)))
