"""Mindlin's patch in rings: microslip that follows the patch as it grows and shrinks."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, final

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import RATE_DEPENDENT, Friction
from contactlab.laws.memory import AT_TOUCH, ODD, InternalVariable, dependent
from contactlab.parameter import Parameter, positive

RINGS = Parameter("n", "1", "rings of the patch", at_least=2, at_most=100)

KNEE = 0.005
"""Stretch over which a ring begins to slide, over the slip at which a patch of n full rings slides."""

SPARE = 1e-9
"""Part by which the rings of a contact at rest exceed its patch: round-off must not outgrow them."""

DOUBLE = 0
"""Guard: the patch has outgrown the rings."""


@inner_kernel
def ring_of(j, normal, normal_stiffness, ring, friction_coefficient, stiffness_ratio):
    """Return stiffness k_j [N/m] of ring j and the stretch at which it slides [m]; 0, 0 outside the patch."""
    inner = j * ring
    outer = min(inner + ring, normal_stiffness)
    if outer <= inner or normal <= 0.0:
        return 0.0, 0.0
    a, b = inner / normal_stiffness, outer / normal_stiffness
    share = 0.5 * (b - a) * (3.0 - (a * a + a * b + b * b))
    return outer - inner, friction_coefficient * normal * share / (stiffness_ratio * (outer - inner))


@final
@dataclass(frozen=True)
class Microslip(Friction):
    """A patch that slips from its rim inwards, after Cattaneo, Mindlin and Deresiewicz.

        F = -kappa sum_j k_j clip(z_j, -x_j, x_j),  dz_j/dt = v - z_j max(dk_j/dt, 0)/k_j - (sliding)

    The patch of the normal stiffness k = dN/dd is a foundation of springs along 0 < s < k, of the normal
    stiffness ds and the tangential stiffness kappa ds. Ring j takes (j - 1) r < s < min(j r, k), so that k_j
    is at most r, and slides at mu N_j, its share of N (3 s/k - (s/k)^3)/2 as between spheres:

        x_j = mu N_j/(kappa k_j),  sum_j N_j = N,  sum_j k_j = k

    Rings at the rim begin to slide first, and stop where the slip reverses or the limit outgrows it. Springs
    that the patch gains carry nothing; those that it loses take their share of the force along. Where the
    patch outgrows n rings, neighbours are united to rings twice as stiff, so that n/2 to n rings resolve the
    largest patch of the contact so far. At constant N the first loading is

        F = mu N [1 - (1 - x/x_s)^(3/2)],  x_s = 3 mu N/(2 kappa k) = mu d/kappa between spheres

    with an error of the order of 1/n^2, and unloading follows by Masing's rule. With n rings a cycle of
    amplitude A loses as much within 2 (x_s/(n A))^2 of it, and nothing below x_s/n. Without microslip it is
    `mindlin`, with stiffness and limits in proportion to N `iwan`. A ring that slides is stretched beyond its
    limit by x_s/50 at most, with x_s of the largest patch; its force is the limit.

    Source: Cattaneo (1938); Mindlin and Deresiewicz (1953), J. Appl. Mech. 20, 327; that springs with sliders
    are their solution also under a normal force that changes: Popov and Hess (2015), Method of Dimensionality
    Reduction in Contact Mechanics and Friction, ch. 5.
    """

    name = "microslip"
    equation = "F = -kappa sum k_j z_j, |kappa k_j z_j| <= mu N_j; mu N (1 - (1 - x/x_s)^1.5) at first"
    source = "Mindlin and Deresiewicz (1953), J. Appl. Mech. 20, 327; Popov and Hess (2015), ch. 5"
    validity = "contacts of spheres; elsewhere the rings have another share of N"
    friction_kind = RATE_DEPENDENT
    exact_stick = False
    # Rings begin, slide and end within a step, and each error lasts for the rest of the contact.
    convergence_order = 0.8
    guards = 1
    violations = MappingProxyType(
        {
            "friction_opposes_slip": "a ring that slides is stretched beyond its limit, by x_s/50 at most; "
            "where the limit grows before the ring has come back, so does its force, which gives it energy "
            "that nothing brought.",
            "inside_the_cone": "rings begin to slide within a step, whose polynomial overshoots by some "
            "millionths.",
        }
    )

    stiffness_ratio: Annotated[float, positive("kappa", "1", "tangential over normal stiffness")] = 0.82
    rings: Annotated[int, RINGS] = 12
    first_ring: Annotated[float, positive("r_0", "N m-1", "normal stiffness of a ring at touch-down")] = 1e5

    @dependent
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        """Stretches from the centre outwards, and the normal stiffness r of a full ring."""
        stretches = [
            InternalVariable(f"stretch_{j}", f"z_{j}", "m", f"stretch of ring {j}", parity=ODD)
            for j in range(1, self.rings + 1)
        ]
        about = "normal stiffness of a full ring"
        full = InternalVariable("ring", "r", "N m-1", about, self.first_ring, discrete=True)
        return *stretches, full

    @staticmethod
    @kernel
    def state(normal, normal_stiffness, z, ring, rings, friction_coefficient, stiffness_ratio):
        force, stored = 0.0, 0.0
        for j in range(int(rings)):
            own, limit = ring_of(j, normal, normal_stiffness, ring, friction_coefficient, stiffness_ratio)
            stretch = min(max(z[j], -limit), limit)
            force -= stiffness_ratio * own * stretch
            stored += 0.5 * stiffness_ratio * own * stretch * stretch
        return force, stored, 0.0

    @staticmethod
    @kernel
    def rate(
        which,
        normal,
        normal_stiffness,
        normal_stiffness_rate,
        depth_rate,
        slip,
        z,
        ring,
        rings,
        friction_coefficient,
        stiffness_ratio,
    ):
        if which >= int(rings):
            return 0.0
        own, limit = ring_of(which, normal, normal_stiffness, ring, friction_coefficient, stiffness_ratio)
        if limit <= 0.0:
            return 0.0
        stretch, sign = z[which], 1.0 if z[which] > 0.0 else -1.0
        growth = max(normal_stiffness_rate, 0.0) / own if own < ring else 0.0
        # Towards the limit, which the depth moves.
        nearing = sign * slip - friction_coefficient / stiffness_ratio * depth_rate
        # Between spheres the stretch at which the largest patch slides, however small it is by now.
        largest = 1.5 * friction_coefficient * normal / stiffness_ratio * (rings * ring) ** 2
        knee = KNEE * largest / normal_stiffness**3
        yielding = max(abs(stretch) - max(limit - knee, 0.0), 0.0) / knee
        return slip - growth * stretch - sign * max(nearing, 0.0) * yielding

    @staticmethod
    @kernel
    def guard(normal_stiffness, ring, rings):
        return rings * ring - normal_stiffness

    @staticmethod
    @kernel
    def jump(
        which,
        event,
        normal,
        normal_stiffness,
        normal_stiffness_rate,
        z,
        ring,
        rings,
        friction_coefficient,
        stiffness_ratio,
    ):
        n = int(rings)
        if event == AT_TOUCH and which == n:
            # A stiffness that rises from there on, as that of a line, hangs on the last digits of the gap.
            at_rest = normal_stiffness_rate == 0.0
            return max(ring, (1.0 + SPARE) * normal_stiffness / n) if at_rest else ring
        if event != DOUBLE:
            return z[which]
        if which == n:
            return 2.0 * ring
        total, own = 0.0, 0.0
        for j in range(2 * which, min(2 * which + 2, n)):
            part, limit = ring_of(j, normal, normal_stiffness, ring, friction_coefficient, stiffness_ratio)
            total += part * min(max(z[j], -limit), limit)
            own += part
        return total / own if own > 0.0 else 0.0
