"""The kernels of a composed law, made of those of its parts.

They depend on how many coefficients and internal variables the parts have, and not on their values: one
compilation serves a whole sweep. In z the friction's variables come first, and so do its guards.
"""

from functools import cache
from typing import Any

from contactlab.compiled import fleeting_kernel, kernel
from contactlab.laws.friction.coulomb import cone_bound


@kernel
def _no_rate(which, first, second, third, fourth, z, parameters, at):
    return 0.0


@kernel
def _no_flow(which, depth, depth_rate, z, parameters, at):
    return 0.0


@kernel
def _kept(which, event, first, second, third, fourth, z, parameters, at):
    return z[which]


@kernel
def _left(which, event, depth, depth_rate, z, parameters, at):
    return z[which]


@kernel
def _cone(normal, slip, z, parameters, at):
    return cone_bound(normal, slip, parameters, at)


@cache
def force_of(elastic: Any, damped: Any, damping: int, friction: int) -> Any:
    """Give the kernel of an elastic force in Coulomb's cone."""

    def composed_force(gap, gap_rate, slip, impact_speed, parameters):
        spring, stored, _, _ = elastic(max(-gap, 0.0), parameters, 0)
        normal = damped(spring, -gap_rate, impact_speed, parameters, damping)
        bound = cone_bound(normal, slip, parameters, friction)
        return normal, bound, stored, (spring - normal) * gap_rate

    return fleeting_kernel(composed_force)


@cache
def friction_of(elastic: Any, state: Any, friction: int) -> Any:
    """Give the kernel of a friction that has at most one internal variable, over an elastic force."""

    def composed_friction(gap, gap_rate, slip, normal, z, parameters):
        _, _, stiffness, slope = elastic(max(-gap, 0.0), parameters, 0)
        rate = -slope * gap_rate
        return state(normal, stiffness, rate, slip, z, parameters, friction)

    return fleeting_kernel(composed_friction)


@cache
def spring_of(force: Any, elastic: Any, limited: bool) -> Any:
    """Give the kernel `NormalForce.force` of any normal force, with limits of its own or none."""
    if force is not None:
        return force

    def spring(depth, depth_rate, z, parameters, at):
        normal, stored, stiffness, slope = elastic(depth, parameters, at)
        return normal, stored, stiffness, slope, 0.0

    def pressed(depth, depth_rate, z, parameters, at):
        # Asked at the instant of a release, where the gap may be open by round-off.
        normal, stored, stiffness, slope = elastic(max(depth, 0.0), parameters, at)
        return normal, stored, stiffness, slope, 0.0

    return fleeting_kernel(spring if limited else pressed)


@cache
def bound_of(bound: Any, remembers: bool) -> Any:
    """Give the kernel `Friction.bound` of any friction, with z."""
    if bound is None:
        return _cone
    if remembers:
        return bound

    def forgetful(normal, slip, z, parameters, at):
        return bound(normal, slip, parameters, at)

    return fleeting_kernel(forgetful)


@cache
def remembering_force(spring: Any, damped: Any, bound: Any, damping: int, friction: int, first: int) -> Any:
    """Give the kernel of any force and bound; from `first` on z is the normal force's."""

    def composed_force(gap, gap_rate, slip, impact_speed, z, parameters):
        alone, stored, _, _, loss = spring(-gap, -gap_rate, z[first:], parameters, 0)
        normal = damped(alone, -gap_rate, impact_speed, parameters, damping)
        largest = bound(normal, slip, z[:first], parameters, friction)
        return normal, largest, stored, loss + (alone - normal) * gap_rate

    return fleeting_kernel(composed_force)


@cache
def forgetful_force(remembering: Any) -> Any:
    """Give the kernel of a force that needs no z."""

    def composed_force(gap, gap_rate, slip, impact_speed, parameters):
        # Nobody reads what stands for z.
        return remembering(gap, gap_rate, slip, impact_speed, parameters, parameters)

    return fleeting_kernel(composed_force)


@cache
def remembering_friction(spring: Any, state: Any, own: bool, friction: int, first: int) -> Any:
    """Give the kernel of a friction over any force: of its `own` variable or of those in z."""

    def of_its_own(gap, gap_rate, slip, normal, variable, z, parameters):
        _, _, stiffness, slope, _ = spring(-gap, -gap_rate, z[first:], parameters, 0)
        return state(normal, stiffness, -slope * gap_rate, slip, variable, parameters, friction)

    def composed_friction(gap, gap_rate, slip, normal, z, parameters):
        _, _, stiffness, slope, _ = spring(-gap, -gap_rate, z[first:], parameters, 0)
        return state(normal, stiffness, -slope * gap_rate, slip, z[:first], parameters, friction)

    return fleeting_kernel(of_its_own if own else composed_friction)


@cache
def forgetful_friction(remembering: Any) -> Any:
    """Give the kernel of a friction over a force that needs no z."""

    def composed_friction(gap, gap_rate, slip, normal, variable, parameters):
        return remembering(gap, gap_rate, slip, normal, variable, parameters, parameters)

    return fleeting_kernel(composed_friction)


@cache
def of_both(spring: Any, of_friction: Any, of_normal: Any, count: int, friction: int, first: int) -> Any:
    """Give the kernel of rates or guards: the friction's, `count` of them, then the normal force's."""
    of_friction, of_normal = of_friction or _no_rate, of_normal or _no_flow

    def composed(which, gap, gap_rate, slip, normal, z, parameters):
        if which >= count:
            return of_normal(which - count, -gap, -gap_rate, z[first:], parameters, 0)
        _, _, stiffness, slope, _ = spring(-gap, -gap_rate, z[first:], parameters, 0)
        rate = -slope * gap_rate
        return of_friction(which, normal, stiffness, rate, slip, z[:first], parameters, friction)

    return fleeting_kernel(composed)


@cache
def jump_of(spring: Any, of_friction: Any, of_normal: Any, guards: int, friction: int, first: int) -> Any:
    """Give the kernel of the jumps; a guard of one part is no event of the other's."""
    of_friction, of_normal = of_friction or _kept, of_normal or _left

    def composed(which, event, gap, gap_rate, slip, normal, z, parameters):
        of_the_friction = which < first
        if event >= 0 and (event < guards) != of_the_friction:
            return z[which]
        if not of_the_friction:
            own = event if event < 0 else event - guards
            return of_normal(which - first, own, -gap, -gap_rate, z[first:], parameters, 0)
        _, _, stiffness, slope, _ = spring(-gap, -gap_rate, z[first:], parameters, 0)
        rate = -slope * gap_rate
        return of_friction(which, event, normal, stiffness, rate, slip, z[:first], parameters, friction)

    return fleeting_kernel(composed)


@cache
def limits_of(limits: Any, remembers: bool, first: int, any_z: bool) -> Any:
    """Give the kernel of the limits, which are the normal force's."""

    def of_memory(z, parameters):
        return limits(z[first:], parameters, 0)

    def of_parameters(parameters):
        return limits(parameters, 0)

    def unread(z, parameters):
        return limits(parameters, 0)

    return fleeting_kernel(of_memory if remembers else unread if any_z else of_parameters)
