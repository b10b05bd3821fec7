"""Where a motor rests before its drive is switched on, pressed together by a constant force."""

from dataclasses import replace
from typing import Final

import numpy as np
import scipy

from contactlab.arrays import Array
from contactlab.checks import checked_arguments
from contactlab.engine.binding import FORCE
from contactlab.engine.initial_state import AT_REST
from contactlab.engine.preparation import take_in
from contactlab.laws.base import ContactLaw, PenaltyLaw
from contactlab.motor.motor import ModalState, Motor

DEEPEST: Final = 1e-3
"""Largest penetration at rest that is looked for [m]."""

OPEN: Final = 0.1 * AT_REST
"""Gap at which a rigid contact rests [m], which round-off must not close."""

MOST_CORRECTIONS, CLOSED = 25, 1e-3
"""Of Newton's method, and error of the gap over `OPEN` at which it ends."""


@checked_arguments()
def at_rest(motor: Motor, law: ContactLaw) -> Motor:
    """Return a motor that begins in its static equilibrium, without a drive.

        k_j q_j = a_j - N rho_j,   g(q) = -d(N),   rho_j = -dg/dq_j

    with the preload a_j, the gap g and the penetration d at which the law's normal force at rest is N; a
    rigid law has none. A tip that leans has another gap than its displacement, which takes Newton's method.
    Where one coordinate has no stiffness, as a rotor on a bearing without a spring's, N is what its preload
    asks for.

    Raises:
        ValueError: no contact force up to a penetration of `DEEPEST` balances the preload, the tip leans too
            far, or a mode without stiffness gives way.
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.
    """
    modes, geometry = motor.modes, motor.geometry
    k, row, clearance = modes.stiffness, -motor.rows_at_rest[0], geometry.clearance
    # The gap is linear in q but for a tip that leans: solved for its tangent, g = clearance - row q, and once
    # more about the tilt that this gives.
    for _ in range(MOST_CORRECTIONS):
        q, force = _balanced(motor, law, row, clearance)
        u, th = float(modes.approach @ q), float(modes.tip_slope @ q)
        gap, n_u, n_th, _, _ = geometry.frame(u, th)
        if abs(gap - (clearance - float(row @ q))) <= CLOSED * OPEN:
            if force == 0.0 and gap < 0.0:
                raise ValueError("A mode without stiffness gives way to the preload: nothing balances it.")
            return replace(motor, start=ModalState(q, np.zeros_like(k)))
        row = -n_u * modes.approach - n_th * modes.tip_slope
        clearance = gap + float(row @ q)
    raise ValueError(f"The preload leans the tip by {th:.3g} rad, where no equilibrium was reached.")


def _balanced(motor: Motor, law: ContactLaw, row: Array, clearance: float) -> tuple[Array, float]:
    """Return amplitudes and contact force [N] at rest where the gap is clearance - row q."""
    k = motor.modes.stiffness
    preload = np.zeros_like(k) if motor.preload is None else motor.preload
    free, elastic = np.flatnonzero(k == 0.0), k > 0.0
    yields, comes = (
        float(row[elastic] ** 2 @ (1.0 / k[elastic])),
        float(row[elastic] @ (preload[elastic] / k[elastic])),
    )

    def penetration(force: float) -> float:
        """Return d of a normal force, less a little of a rigid law."""
        return float(penetrations(law, np.array([force]))[0]) if isinstance(law, PenaltyLaw) else -OPEN

    force = 0.0
    # A coordinate without stiffness is held by the contact alone: the force is what its own preload asks for.
    # Else tip and rotor meet if the preload closes the gap, and the force is that at which elastic
    # displacement and penetration add up to what it closes.
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
    return q, force


def penetrations(law: PenaltyLaw, forces: Array) -> Array:
    """Return the penetrations [m] at which a law's normal force at rest is each of some positive ones [N].

    Raises:
        ValueError: there is none up to `DEEPEST`.
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.
    """
    parameters, _, bound, errors = take_in(law)

    def missing(depth: float, force: float) -> float:
        with errors():
            return float(bound.kernels[FORCE](-depth, 0.0, 0.0, 0.0, parameters)[0]) - force

    # Each force once: brentq takes some ten answers of the law for it.
    distinct, places = np.unique(forces, return_inverse=True)
    result = np.empty_like(distinct)
    for i, force in enumerate(distinct):
        if not missing(DEEPEST, force) > 0.0:
            raise ValueError(
                f"No penetration up to {DEEPEST} m has the normal force {force:.6g} N at rest under "
                f"{law.name}; it must be less."
            )
        result[i] = scipy.optimize.brentq(missing, 0.0, DEEPEST, (force,), xtol=1e-20, rtol=1e-14)
    return result[places]
