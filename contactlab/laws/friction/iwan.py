"""Springs with sliders in parallel, which begin to slide one after the other."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import asin, copysign, cos, pi, sqrt
from types import MappingProxyType
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import RATE_DEPENDENT, Friction
from contactlab.laws.declaration import Coefficient
from contactlab.laws.memory import ODD, InternalVariable, dependent
from contactlab.parameter import Parameter, positive

LEAST = Parameter("x_min/x_s", "1", "smallest amplitude of slip that is resolved", at_least=1e-6, at_most=1.0)

FIRST = 1.0 / 3.0
"""Way over x_min up to which the first element reaches: to a cycle of x_min it adds FIRST^3/2 of the loss."""

ELEMENTS = Parameter("n", "1", "springs with sliders in parallel", at_least=1, at_most=100)

TOGETHER = 1e-10
"""Way over x_s by which a slider begins late, or early with those that slide: what has come back to where
it slid before has many at their limits, and what has only just turned some."""

YIELD, REVERSE = 0, 1
"""Guards: the next slider holds; the slip goes on as it went when sliders began."""


@final
@dataclass(frozen=True)
class Iwan(Friction):
    """Jenkins elements whose distribution is that of microslip in a round contact.

    Under a constant N the first loading is that of Mindlin and Deresiewicz (1953), J. Appl. Mech. 20, 327,
    F = mu N [1 - (1 - x/x_s)^(3/2)], and its reversals follow by Masing's rule. What sticks at x has the
    share u = sqrt(1 - x/x_s) of the stiffness 3 mu N/(2 x_s); an element has that of u between two edges, and
    the friction that belongs to it. So a small slip's stiffness and a large one's friction are exact.
    x_s is the slip at which all slides: between spheres mu d/kappa of the depth d, with kappa as in
    `mindlin`.

    A cycle of small amplitude A loses 4 sum s_j x_j max(A - x_j, 0) N for mu N x_s (A/x_s)^3/2: too little
    by 3 (D/x_j)^2/4 as A comes to the limit of an element of width D, too much by (D/x_j)^2/6 for those that
    slide. So each edge phi, u = cos phi, x = x_s sin^2 phi, is the same multiple of the one before, from
    x_min/3 to x_s, and D/x_j about d = 2 ln(phi_n/phi_1)/(n - 1). From A = x_min on the loss is too small by
    0.6 d^2 at most and too large by d^2/6 + 2 %, 4.6 and 3.3 % by default, and the force right within
    d^2/16 of itself. A cycle smaller than x_min/6 loses nothing.

    To its limit an element has the way x_j - z_j to go, which never falls with j: those that slide are
    always the first ones. They stick where the slip reverses. Stiffness and limits are in proportion
    to N, and stretches stay where it changes.
    """

    name = "iwan"
    equation = "F = -N sum s_j z_j, |z_j| <= x_j, dz_j/dt = v - sliding; mu N (1 - (1 - x/x_s)^1.5) at first"
    source = "Iwan (1966), J. Appl. Mech. 33, 893; Iwan (1967), J. Appl. Mech. 34, 612"
    validity = "normal force that hardly changes while the contact is loaded"
    friction_kind = RATE_DEPENDENT
    exact_stick = False
    guards = 2
    violations = MappingProxyType(
        {
            "friction_opposes_slip": "stretched springs grow stiffer with the normal force, which gives them "
            "energy that nothing brought."
        }
    )

    elements: Annotated[int, ELEMENTS] = 25
    full_slip: Annotated[float, positive("x_s", "m", "slip at which all elements slide")] = 4e-7
    least_ratio: Annotated[float, LEAST] = 0.01

    @dependent
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        """Stretches by their limits, and how many slide."""
        count = range(1, self.elements + 1)
        stretches = [
            InternalVariable(f"stretch_{j}", f"z_{j}", "m", f"stretch {j}", parity=ODD) for j in count
        ]
        sliding = InternalVariable(
            "sliding", "J", "1", "elements that slide, with the sign of slip", parity=ODD, discrete=True
        )
        return *stretches, sliding

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return mu, x_s, the limits x_j [m] and the stiffnesses over N, s_j [m-1]."""
        n, mu, whole = self.elements, self.friction_coefficient, self.full_slip
        first = asin(sqrt(FIRST * self.least_ratio))
        growth = (0.5 * pi / first) ** (1.0 / max(n - 1, 1))
        pairs = [*pairwise([1.0, *(cos(first * growth**j) for j in range(n - 1)), 0.0])]
        return {
            "friction_coefficient": mu,
            "static_ratio": 1.0,
            "full_slip": whole,
            "limit": tuple(whole * (1.0 - (a * a + a * b + b * b) / 3.0) for a, b in pairs),
            "stiffness": tuple(1.5 * mu / whole * (a - b) for a, b in pairs),
        }

    @staticmethod
    @kernel
    def state(normal, z, stiffness):
        force, stored = 0.0, 0.0
        for j in range(len(stiffness)):
            part = max(normal, 0.0) * stiffness[j] * z[j]
            force -= part
            stored += 0.5 * part * z[j]
        return force, stored, 0.0

    @staticmethod
    @kernel
    def rate(which, slip, sliding, limit):
        # An element that slides keeps its stretch.
        return slip if abs(sliding) <= which < len(limit) else 0.0

    @staticmethod
    @kernel
    def guard(which, slip, z, sliding, limit, full_slip):
        # The way to the next limit [m], or the slip.
        if which == REVERSE:
            return copysign(1.0, sliding) * slip if sliding != 0.0 else 1.0
        kept = int(abs(sliding))
        if kept == len(limit):
            return 1.0
        stretch = z[kept] if sliding > 0.0 else -z[kept] if sliding < 0.0 else abs(z[kept])
        return limit[kept] + TOGETHER * full_slip - stretch

    @staticmethod
    @kernel
    def jump(which, event, z, sliding, limit, full_slip):
        # How many slide, with the sign of their slip.
        n = len(limit)
        if which < n:
            # What slid lies at its limit, to which its event was located: the other way is free.
            return min(max(z[which], -limit[which]), limit[which]) if event == REVERSE else z[which]
        if event < 0:
            return z[which]
        if event == REVERSE:
            return 0.0
        begun = int(abs(sliding))
        direction = copysign(1.0, sliding if begun > 0 else z[0])
        begun = min(begun + 1, n)
        while begun < n and limit[begun] - direction * z[begun] <= TOGETHER * full_slip:
            begun += 1
        return direction * begun
