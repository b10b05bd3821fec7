"""A law at the end of a cantilever, at rest at every position of its base: the force curve of a microscope.

    import contactlab as cl
    import numpy as np

    law = cl.Composed(cl.Jkr(radius=20e-9, effective_modulus=1e9, work_of_adhesion=0.05))
    position = 1e-9 * np.append(np.linspace(10.0, -5.0, 301), np.linspace(-5.0, 10.0, 301))
    force = cl.force_curve(law, position, cantilever_stiffness=1.0)

With z the position of the base, positive away from the surface, and y = z - z_0 from the contact point the
gap g and the law's force F(g) at rest are those of

    g = y + F(g)/k

so that in contact y(g) = g - F(g)/k. From the deepest contact outwards y rises up to y_off, the fold at which
k = dF/dg, or to the gap at which the law parts the bodies. Beyond it the tip is free; below the gap y_on <=
y_off at which the law begins a contact it touches. In between, it does what it did one row before: at y_on
and y_off it jumps.

Where y ends the force has a root of its distance to that end, and Hertz's force a power 3/2; both are smooth
in s = sqrt(g_end - g), over which force and y are a spline through equal steps.

Source: Butt, Cappella and Kappl (2005), Surf. Sci. Rep. 59, 1, sec. 2.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import sqrt
from typing import Annotated, Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from contactlab.arrays import Array
from contactlab.checks import check_shape, checked_arguments
from contactlab.engine.arguments import check_law
from contactlab.engine.binding import FORCE, LIMITS, row_of
from contactlab.engine.preparation import take_in
from contactlab.laws.base import ContactLaw, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.motor.bodies import FLAT
from contactlab.parameter import Parameter, positive

CURVE: Final = {
    "contact_point": Parameter("z_0", "m", "position of the base at which the undeflected tip touches"),
    "baseline": Parameter("F_0", "N", "force that is measured of the free tip, at the first row"),
    "tilt": Parameter("b", "N m-1", "slope of that force over the position of the base"),
    "cantilever_stiffness": positive("k", "N m-1", "measured force over deflection; none: no deflection"),
}
"""Numbers of a force curve beside those of the law, by their names as arguments and options."""

BY_LAW, FREE, TOUCHING = -1, 0, 1
"""States of the tip in a row: the first is that of the law at this place of the curve."""

NODES: Final = 257
"""Gaps at which the law is evaluated; forces of the spline through them err by 1e-9 of the largest,
beside a kink of the law, as where the middles meet under `maugis`, by 1e-3 of the pull-off force."""

DEEPEST: Final = 1e-3
"""Largest penetration that is looked for [m]."""

CORRECTIONS: Final = 12
"""Of Newton's method in a cell of the spline, more than it takes beside a fold."""

TINY: Final = 1e-18
"""Least depth of the spline [m]."""


@final
@dataclass(frozen=True)
class Recording:
    """How a force curve was recorded; see `force_curve`.

    Raises:
        ValueError: a number out of range.
    """

    contact_point: float = 0.0
    baseline: float = 0.0
    tilt: float = 0.0
    cantilever_stiffness: float | None = None

    def __post_init__(self) -> None:
        for name, value in self.numbers.items():
            if not CURVE[name].admits(value):
                bound = CURVE[name].range or "finite"
                raise ValueError(f"{name} is {value:g}{CURVE[name].label}; it must be {bound}.")

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers by their names in `CURVE`; no stiffness of a base that the tip follows."""
        every = {name: getattr(self, name) for name in CURVE}
        return {name: float(x) for name, x in every.items() if x is not None}

    def changed(self, numbers: Mapping[str, float]) -> Self:
        """Return the recording with other numbers, by their names in `CURVE`."""
        return replace(self, **{name: float(x) for name, x in numbers.items()})

    def measured(self, position: Array, force: Array) -> Array:
        """Return what is measured of a force [N] at each position of the base [m]."""
        return np.asarray(self.baseline + self.tilt * (position - position[0]) + force)


@final
class LawOnCantilever:
    """A law at the end of a cantilever, made ready once for many sets of its numbers, as by a fit.

    Args:
        law: a compliant one, whose numbers may change, and not its kind.

    Raises:
        TypeError, ValueError, LawError: as of `force_curve`.
    """

    def __init__(self, law: ContactLaw) -> None:
        check_law(law)
        if not isinstance(law, PenaltyLaw):
            raise ValueError(f"{law.name} is rigid; a force curve must have a compliant law.")
        remembering: Any = law.normal if isinstance(law, Composed) else law
        if remembering.internal_variables:
            raise ValueError(
                f"The normal force of {remembering.name} does not follow from its gap alone; a force curve "
                "must have a law without memory along the normal."
            )
        self._parameters, self._row, bound, self._errors = take_in(law.on_rotor(FLAT))
        self._kernels = bound.kernels

    def forces(
        self, law: ContactLaw, position: Array, recording: Recording, state: NDArray[np.int8] | None = None
    ) -> Array:
        """Return the law's force at each position of the base [N], in the order of the rows.

        Args:
            law: with any numbers.
            position: of the base [m], shape (row,).
            recording: of the curve.
            state: of the tip in each row, where it is known: `FREE`, `TOUCHING`, or `BY_LAW`. A tip that
                touches beyond y_off is at y_off.

        Raises:
            LawError: the law's own code raised an exception.
            ValueError: it is a law of another kind, is in no equilibrium at the deepest position, or has
                several at one position.
        """
        row = row_of(law.on_rotor(FLAT))
        if row.shape != self._row.shape:
            raise ValueError(f"{law.name} has {row.size} numbers here; it must have {self._row.size}.")
        self._row[:] = row
        y, k = position - recording.contact_point, recording.cantilever_stiffness
        compliance = 0.0 if k is None else 1.0 / k
        result = np.zeros(y.size)
        with self._errors():
            limits, evaluate = self._kernels[LIMITS], self._kernels[FORCE]
            begins, ends = limits(0.0, self._parameters) if limits else (0.0, 0.0)
            known = np.full(y.size, BY_LAW) if state is None else state
            least = min(float(y.min()), begins)
            if least == begins and not (known == TOUCHING).any():
                return result

            def force_at(root: float) -> float:
                return float(evaluate(ends - root * root, 0.0, 0.0, 0.0, self._parameters)[0])

            def beyond(root: float) -> float:
                return float(ends - root * root - compliance * force_at(root) - least)

            # Under a pull the tip lies deeper than its base.
            far = sqrt(max(ends - least, TINY))
            while beyond(far) > 0.0 and far * far < DEEPEST:
                far *= 2.0
            balanced = beyond(far) <= 0.0
            if balanced and beyond(0.0) > 0.0:
                far = max(brentq(beyond, 0.0, far, xtol=1e-20, rtol=1e-14), sqrt(TINY))
            root = np.linspace(0.0, far, NODES)
            forces = np.array([force_at(x) for x in root])
        if not balanced:
            raise ValueError(
                f"No penetration up to {DEEPEST} m of {law.name} is in equilibrium with the cantilever "
                f"{-least:.3g} m below the contact point; its cantilever_stiffness must be greater."
            )
        base, force = CubicSpline(root, ends - root * root - compliance * forces), CubicSpline(root, forces)
        turns = base.derivative().roots(extrapolate=False)
        places = np.append(0.0, turns[(turns > 0.0) & (turns < root[-1])])
        fold = places[np.argmax(base(places))]
        off = float(base(fold))
        touching = touching_in(y, min(begins, off), off, known)
        nodes = np.append(fold, root[root > fold])
        bases = base(nodes)
        if not (np.diff(bases) < 0.0).all():
            raise ValueError(
                f"{law.name} has several equilibria in contact at one position; it must have one."
            )
        # Between two nodes from the deeper one: next to the fold Newton's method comes from that side alone.
        wanted = np.minimum(y[touching], off)
        cell = np.clip(np.searchsorted(-bases, -wanted), 1, nodes.size - 1)
        least, most, slope = nodes[cell - 1], nodes[cell], base.derivative()
        at = most.copy()
        for _ in range(CORRECTIONS):
            at = np.clip(at - (base(at) - wanted) / slope(at), least, most)
        result[touching] = force(at)
        return result


def touching_in(y: Array, on: float, off: float, known: NDArray[np.int8]) -> NDArray[np.bool_]:
    """Return in which rows the tip is in contact: as one row before between y_on and y_off, first free."""
    state = np.where(known != BY_LAW, known, np.where(y <= on, TOUCHING, np.where(y > off, FREE, BY_LAW)))
    state[0] = max(state[0], FREE)
    last = np.maximum.accumulate(np.where(state != BY_LAW, np.arange(y.size), 0))
    return np.asarray(state[last] == TOUCHING)


@checked_arguments(position="m")
def force_curve(
    law: ContactLaw,
    position: Array,
    *,
    contact_point: Annotated[float, CURVE["contact_point"]] = 0.0,
    baseline: Annotated[float, CURVE["baseline"]] = 0.0,
    tilt: Annotated[float, CURVE["tilt"]] = 0.0,
    cantilever_stiffness: Annotated[float | None, CURVE["cantilever_stiffness"]] = None,
) -> Array:
    """Return the force that is measured at each position z of a cantilever's base [N], shape (row,).

        F_0 + b (z - z of the first row) + F(g),   g = z - z_0 + F(g)/k

    F(g) is the law's normal force at rest, positive where it pushes the tip away, and the tip jumps into
    contact and off it. Damping and friction have no part, and the surface does not pull before the gap at
    which the law begins a contact. Errors of the spline: see `contactlab.force_curves.NODES`.

        >>> import contactlab as cl
        >>> import numpy as np
        >>> law = cl.Composed(cl.Jkr(radius=20e-9, effective_modulus=1e9, work_of_adhesion=0.05))
        >>> position = np.append(np.linspace(6e-9, -2e-9, 8001), np.linspace(-2e-9, 6e-9, 8001))
        >>> force = cl.force_curve(law, position, cantilever_stiffness=1.0)
        >>> f"{-1e9 * force.min():.2f} nN"  # 3/2 pi w R
        '4.71 nN'

    Args:
        law: a compliant one, without memory along the normal.
        position: of the base, in the order of the rows [m], greater away from the surface; shape (row,).
        contact_point: z_0, where the undeflected tip touches [m].
        baseline: F_0, of the free tip at the first row [N].
        tilt: b, its slope [N/m].
        cantilever_stiffness: k [N/m]; None where the position is that of the tip.

    Raises:
        TypeError, ValueError: a law or argument of another kind or out of range, or no equilibrium.
        LawError: the law contradicts itself, or its code raised an exception.
    """
    check_shape("position", position, (-1,), "one number a row")
    recording = Recording(contact_point, baseline, tilt, cantilever_stiffness)
    return recording.measured(position, LawOnCantilever(law).forces(law, position, recording))
