"""Hertz's closed forms: stiffness, tip radius and the duration of an impact."""

from contextlib import suppress
from math import sqrt

import numpy as np

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, build
from contactlab.laws import hertz_stiffness
from contactlab.metrics.run import NotApplicableError, Run, positive
from contactlab.parameter import parameters_of


def stiffness(run: Run) -> float:
    """Give K of N = K depth^1.5 [N m^-3/2], where the law that ran is installed here and declares one."""
    for family, owner in run.law_classes.items():
        for name, parameter in parameters_of(owner).items():
            value = run.law_parameters.get(f"{family}.{name}".removeprefix("."), 0.0)
            if parameter.units == "N m-1.5" and value > 0.0:
                return float(value)
    raise NotApplicableError


def effective_mass(run: Run) -> float:
    """Give the mass that a normal impact meets, 1/D_nn of the undeformed motor [kg]."""
    # The mass is the motor's: a law that is not installed here shall not stand in its way, nor a
    # tolerance that belongs to it.
    solver = run.configuration.get("solver")
    if not isinstance(solver, dict):
        raise NotApplicableError
    changes = {"law": {"name": "lagrange_stick"}, "solver": {**solver, "tolerance": None}}
    try:
        modes = build({**run.configuration, **changes}).motor.modes
    except ConfigurationError as fault:
        raise NotApplicableError from fault
    # At rest the normal is (0, -1) and the slope moves the tip end along the tangent alone.
    return 1.0 / positive(float(modes.tip_displacement @ modes.tip_displacement))


def hertz_duration(mass: float, stiffness: float, velocity: Array) -> Array:
    """Give the duration of a free impact [s], T = 2.94 d/v with the depth d = (5/4 m v^2 / K)^(2/5).

    In one: T = 3.21 (m^2 / (K^2 v))^(1/5), of the mass m [kg], K [N m^-3/2] and the positive velocity v of
    the approach [m/s]. 2.94 is 2 int_0^1 dx / sqrt(1 - x^(5/2)) (Johnson 1985, eq. 11.24).
    """
    deepest = (1.25 * mass * velocity**2 / stiffness) ** 0.4
    return np.asarray(2.94 * deepest / velocity)


def tip_radius(run: Run) -> float:
    """Give the radius of the tip [m]: as configured, or of a spherical steel tip with the law's stiffness.

    K = 4/3 E* sqrt(R_e), R_e = [(1/r) (1/r + 1/R)]^(-1/2), solved for 1/r.
    """
    with suppress(NotApplicableError):
        return run.setting("law.tip_radius")
    radius = run.setting("rotor.radius")
    # K goes with sqrt(R_e): a relative radius of one metre gives the constant.
    flat = hertz_stiffness(1.0, float("inf"))
    product = (flat / stiffness(run)) ** 4
    return 1.0 / positive(0.5 * (sqrt(1.0 / radius**2 + 4.0 * product) - 1.0 / radius))
