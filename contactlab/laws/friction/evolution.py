"""Rate and state with other laws of evolution: slip, a faster healing, stress, and two states at once.

With z = ln(v_0 theta/D) friction is that of `StateFriction` throughout; what differs is how theta evolves.
"""

from dataclasses import dataclass
from math import exp, log
from typing import Annotated, final

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.friction.rate_and_state import FASTEST, StateFriction, state_friction
from contactlab.laws.memory import InternalVariable, dependent
from contactlab.parameter import Parameter, not_negative, positive


@inner_kernel
def slip_evolution(slip, age, distance, reference_velocity):
    """Return the rate of z = ln(v_0 theta/D) under the slip law, -|v|/D (z + ln(|v|/v_0)) [1/s]."""
    speed = abs(slip)
    return -speed / distance * (age + log(speed / reference_velocity)) if speed > 0.0 else 0.0


@final
@dataclass(frozen=True)
class Ruina(StateFriction):
    """The slip law: a contact evolves with slip alone, and does not heal at rest.

    After a step of the velocity z = ln(v_0 theta/D) comes to its steady value as exp(-x/D) of the slip x,
    whatever the velocities are: steps up and down are mirror images, where under `rate_and_state` a step up
    takes the more slip the larger it is, and a step down less. Friction, creep below v_c and parameters are
    those of `rate_and_state`.
    """

    name = "ruina"
    equation = (
        "F = -N a asinh(v/(2 v_0) exp((mu + b ln(v_0 theta/D))/a)), "
        "dtheta/dt = -(|v| theta/D) ln(|v| theta/D)"
    )
    source = "Ruina (1983), J. Geophys. Res. 88, 10359"

    @staticmethod
    @kernel
    def state(
        normal,
        slip,
        age,
        friction_coefficient,
        direct_effect,
        evolution_effect,
        renewal_distance,
        reference_velocity,
        creep_velocity,
    ):
        strength = friction_coefficient + evolution_effect * age
        ratio = state_friction(slip, strength, direct_effect, reference_velocity, creep_velocity)
        evolution = slip_evolution(slip, age, renewal_distance, reference_velocity)
        return -max(normal, 0.0) * ratio, evolution, 0.0, 0.0


@final
@dataclass(frozen=True)
class PerrinRiceZheng(StateFriction):
    """Ageing at rest as in `rate_and_state`, and a renewal with the square of the slip velocity.

    Steady slip has the age 2 D/v. So z = ln(v_0 theta/(2 D)) here, with which mu is the friction at v_0; with
    theta/D in its place mu is less by b ln 2. At a constant velocity theta v/(2 D) is the hyperbolic tangent
    of time while the contact is younger than that, the cotangent while it is older. The rest is as in
    `rate_and_state`; `friction_limit` is that of contacts younger than 2 D/v_0.
    """

    name = "perrin_rice_zheng"
    equation = (
        "F = -N a asinh(v/(2 v_0) exp((mu + b ln(v_0 theta/(2 D)))/a)), dtheta/dt = 1 - (v theta/(2 D))^2"
    )
    source = "Perrin, Rice and Zheng (1995), J. Mech. Phys. Solids 43, 1461"

    @dependent
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        """The age, as a logarithm."""
        fresh = log(0.5 * self.reference_velocity * self.fresh_age / self.renewal_distance)
        return (InternalVariable("age", "z", "1", "ln(v_0 theta/(2 D)) of the age theta", fresh),)

    @staticmethod
    @kernel
    def state(
        normal,
        slip,
        age,
        friction_coefficient,
        direct_effect,
        evolution_effect,
        renewal_distance,
        reference_velocity,
        creep_velocity,
    ):
        strength = friction_coefficient + evolution_effect * age
        ratio = state_friction(slip, strength, direct_effect, reference_velocity, creep_velocity)
        evolution = reference_velocity * exp(-age) - slip * slip / reference_velocity * exp(age)
        return -max(normal, 0.0) * ratio, 0.5 * evolution / renewal_distance, 0.0, 0.0


@final
@dataclass(frozen=True)
class Nagata(StateFriction):
    """Ageing as in `rate_and_state`, and a state that falls as the shear stress rises.

    The stress term is integrated: with f = |F|/N the variable w = ln(v_0 theta/D) + c f/b has no rate of the
    stress in its own rate, and (1 + c) f = mu + a ln(v/v_0) + b w. A step of the velocity changes f at once
    by a ln(v_2/v_1)/(1 + c), and a contact is renewed over (1 + c) D; so a and b are several times those that
    another law of evolution has for the same steps. The stress is F/N, as in tests at a constant
    normal force. The age at touch-down is that under f = mu. The rest is as in `rate_and_state`, c = 0.
    """

    name = "nagata"
    equation = (
        "F = -N a/(1 + c) asinh(v/(2 v_0) exp((mu + b w)/a)), w = ln(v_0 theta/D) + c |F|/(b N), "
        "dtheta/dt = 1 - |v| theta/D - (c theta/b) d(|F|/N)/dt"
    )
    source = "Nagata, Nakatani and Yoshida (2012), J. Geophys. Res. 117, B02314"

    direct_effect: Annotated[float, positive("a", "1", "d(F/N)/d ln v at constant theta")] = 0.03
    evolution_effect: Annotated[float, positive("b", "1", "d(F/N)/d ln theta")] = 0.035
    stress_weakening: Annotated[float, not_negative("c", "1", "loss of b ln theta over gain of F/N")] = 2.0

    @dependent
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        """Age and stress, whose sum has no rate of the stress."""
        fresh = log(self.reference_velocity * self.fresh_age / self.renewal_distance)
        fresh += self.stress_weakening * self.friction_coefficient / self.evolution_effect
        return (InternalVariable("state", "w", "1", "ln(v_0 theta/D) + c |F|/(b N)", fresh),)

    @staticmethod
    @kernel
    def state(
        normal,
        slip,
        state,
        friction_coefficient,
        direct_effect,
        evolution_effect,
        renewal_distance,
        reference_velocity,
        creep_velocity,
        stress_weakening,
    ):
        strength = friction_coefficient + evolution_effect * state
        ratio = state_friction(slip, strength, direct_effect, reference_velocity, creep_velocity)
        ratio /= 1.0 + stress_weakening
        age = state - stress_weakening / evolution_effect * abs(ratio)
        ageing = (reference_velocity * exp(-age) - abs(slip)) / renewal_distance
        return -max(normal, 0.0) * ratio, ageing, 0.0, 0.0


@final
@dataclass(frozen=True)
class TwoState(StateFriction):
    """Two states that evolve over two distances, each by the slip law of `ruina`.

    Steady slip has F/N = mu + (a - b - b_2) ln(v/v_0). b_2 may be negative. The rest is as in `ruina`.
    """

    name = "two_state"
    equation = (
        "F = -N a asinh(v/(2 v_0) exp((mu + b z + b_2 z_2)/a)), "
        "dz/dt = -(|v|/D) (z + ln(|v|/v_0)), dz_2/dt = -(|v|/D_2) (z_2 + ln(|v|/v_0))"
    )
    source = "Ruina (1983), J. Geophys. Res. 88, 10359; Gu et al. (1984), J. Mech. Phys. Solids 32, 167"

    second_effect: Annotated[float, Parameter("b_2", "1", "d(F/N)/d ln theta_2")] = 0.005
    second_distance: Annotated[float, positive("D_2", "m", "slip that renews the second state")] = 1e-5

    @dependent
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        """Both ages, as logarithms."""
        fresh = log(self.reference_velocity * self.fresh_age / self.second_distance)
        second = InternalVariable("second_age", "z_2", "1", "ln(v_0 theta_2/D_2) of the age theta_2", fresh)
        return *super().internal_variables, second

    @property
    def friction_limit(self) -> float:
        """Largest |F|/N [1] of slips up to 10 m/s in contacts with z, z_2 < 0, with z_2 as of such slips."""
        younger = log(1.0 + FASTEST / self.reference_velocity)
        return super().friction_limit + max(-self.second_effect, 0.0) * younger

    @staticmethod
    @kernel
    def state(
        normal,
        slip,
        age,
        second_age,
        friction_coefficient,
        direct_effect,
        evolution_effect,
        reference_velocity,
        creep_velocity,
        second_effect,
    ):
        strength = friction_coefficient + evolution_effect * age + second_effect * second_age
        ratio = state_friction(slip, strength, direct_effect, reference_velocity, creep_velocity)
        return -max(normal, 0.0) * ratio, 0.0, 0.0

    @staticmethod
    @kernel
    def rate(which, slip, age, second_age, renewal_distance, reference_velocity, second_distance):
        if which == 0:
            return slip_evolution(slip, age, renewal_distance, reference_velocity)
        return slip_evolution(slip, second_age, second_distance, reference_velocity)
