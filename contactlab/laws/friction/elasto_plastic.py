"""Bristles that hold before they drag: the elasto-plastic law."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sin
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.base import RATE_DEPENDENT
from contactlab.laws.friction.coulomb import STATIC_RATIO
from contactlab.laws.friction.lugre import (
    BRISTLE_DAMPING,
    BRISTLE_STIFFNESS,
    BRISTLE_VIOLATIONS,
    STRIBECK_VELOCITY,
    stribeck,
)
from contactlab.laws.parameter import FRICTION_COEFFICIENT
from contactlab.laws.part import Friction, StateKernel
from contactlab.parameter import Parameter

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class ElastoPlastic(Friction):
    """LuGre with a range of deflections in which nothing drags, so that a small load does not drift.

        F = -N (sigma_0 z + sigma_1 dz/dt),  dz/dt = v (1 - alpha(z) sigma_0 |z| / g(v))

    alpha is 0 for |z| below z_ba or while the slip lets z return, 1 above z_ss = g/sigma_0, and half a
    sine in between.

    Source: Dupont, Hayward, Armstrong and Altpeter (2002), IEEE Trans. Autom. Control 47, 787.

    Args:
        friction_coefficient: mu of fast slip [1].
        static_ratio: mu_s / mu [1].
        bristle_stiffness: sigma_0 [1/m].
        bristle_damping: sigma_1 [s/m].
        stribeck_velocity: v_s [m/s].
        breakaway_ratio: z_ba / z_ss [1].
    """

    name: ClassVar[str] = "elasto_plastic"
    equation: ClassVar[str] = (
        "F = -N (sigma_0 z + sigma_1 dz/dt), dz/dt = v (1 - alpha(z) sigma_0 |z| / g(v))"
    )
    source: ClassVar[str] = "Dupont et al. (2002), IEEE Trans. Autom. Control 47, 787"
    friction_kind: ClassVar[int] = RATE_DEPENDENT
    exact_stick: ClassVar[bool] = False
    # The bristles have a kink where the slip reverses, and no step ends there.
    convergence_order: ClassVar[float] = 0.5
    internal_variables: ClassVar[tuple[str, ...]] = ("deflection of the bristles [m]",)
    violations: ClassVar[Mapping[str, str]] = BRISTLE_VIOLATIONS

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    static_ratio: Annotated[float, STATIC_RATIO] = 1.0
    bristle_stiffness: Annotated[float, BRISTLE_STIFFNESS] = 1e6
    bristle_damping: Annotated[float, BRISTLE_DAMPING] = 0.1
    stribeck_velocity: Annotated[float, STRIBECK_VELOCITY] = 1e-2
    breakaway_ratio: Annotated[
        float, Parameter("z_ba/z_ss", "1", "deflection at which it drags", above=0.0, below=1.0)
    ] = 0.7

    @property
    def state(self) -> StateKernel:
        """The kernel; see `Friction.state`."""
        return elasto_plastic_state


@kernel
def elasto_plastic_state(
    normal: float,
    stiffness: float,
    stiffness_rate: float,
    slip: float,
    memory: float,
    parameters: Array,
    at: int,
) -> tuple[float, float, float, float]:
    """Friction [N], rate of the deflection [m/s], stored energy [J]."""
    pressed = max(normal, 0.0)
    sigma = parameters[at + 2]
    drag = stribeck(slip, parameters, at)
    bent = sigma * abs(memory) / drag if drag > 0.0 else 1.0
    away = parameters[at + 5]
    alpha = 0.0
    if slip * memory > 0.0 and bent > away:
        alpha = 1.0 if bent >= 1.0 else 0.5 + 0.5 * sin(pi * ((bent - away) / (1.0 - away) - 0.5))
    rate = slip * (1.0 - alpha * bent) if drag > 0.0 else 0.0
    force = -pressed * (sigma * memory + parameters[at + 3] * rate)
    return force, rate, 0.5 * pressed * sigma * memory * memory, 0.0
