"""contactlab's answers: rigid laws solved in their limit of no step, and a Hertzian contact."""

from collections.abc import Callable

import entrant
import numpy as np
from entrant import Numbers, Values

import contactlab as cl
from contactlab.motor.bodies import way_of

STIFFNESS = 1e10
"""Of the Hertzian contact [N/m^1.5]: steel, some millimetres of radius."""


def newton(numbers: Numbers) -> cl.ContactLaw:
    """Return Newton's rigid law."""
    return cl.Newton(friction_coefficient=numbers["friction"], restitution=numbers.get("restitution", 0.0))


def poisson(numbers: Numbers) -> cl.ContactLaw:
    """Return Poisson's rigid law."""
    return cl.Poisson(friction_coefficient=numbers["friction"], restitution=numbers.get("restitution", 0.0))


def lagrange_stick(numbers: Numbers) -> cl.ContactLaw:
    """Return the paper's rigid law, which has no restitution.

    Raises:
        ValueError: the question needs one.
    """
    if "restitution" in numbers:
        raise ValueError("lagrange_stick has no restitution.")
    return cl.LagrangeStick(friction_coefficient=numbers["friction"])


def hertz(numbers: Numbers) -> cl.ContactLaw:
    """Return a Hertzian contact with Flores' damping, where something bounces, and Coulomb's friction."""
    e = numbers.get("restitution", 1.0)
    return cl.Composed(
        normal=cl.HertzPoint(stiffness=STIFFNESS),
        damping=cl.Undamped() if e == 1.0 else cl.Flores(restitution=e),
        friction=cl.Coulomb(friction_coefficient=numbers["friction"]),
    )


Make = Callable[[Numbers], cl.ContactLaw]
SETTINGS: dict[str, Make] = {
    "newton": newton,
    "poisson": poisson,
    "lagrange_stick": lagrange_stick,
    "hertz_point + flores + coulomb": hertz,
}


def block(make: Make, numbers: Numbers) -> Values:
    """Answer for a block on a plane."""
    law, weight = make(numbers), numbers["mass"] * numbers["gravity"]
    cone = numbers["friction"] * weight
    belt = numbers.get("belt_velocity", 0.0)
    motor = cl.motor.block(
        numbers["mass"],
        height=0.0 if isinstance(law, cl.MultiplierLaw) else -((weight / STIFFNESS) ** (2.0 / 3.0)),
        weight=weight,
        push=numbers["push"] * cone,
        push_amplitude=numbers.get("amplitude", 0.0) * cone,
        push_frequency=numbers.get("frequency", 1.0),
        stiffness=numbers.get("stiffness", 0.0),
        velocity=belt,
        belt_velocity=belt,
    )
    run = cl.simulate(motor, law, duration=numbers["duration"], record_interval=1e-3)
    time = run["time"].values
    # On the belt, which friction does not brake.
    way = way_of(run["tip_slope"].values) - belt * time
    return entrant.of_block(numbers, time, way, float(run["slip_velocity"][-1]))


def impact(make: Make, numbers: Numbers) -> Values:
    """Answer by the law itself, on the Delassus matrix of the body."""
    thrown, m, inertia = entrant.thrown(numbers), numbers["mass"], numbers["inertia"]
    # Gap rate and slip of a unit rotation, x towards -z, and of the centre.
    jacobian = np.array([[0.0, 1.0, -thrown["lever_x"]], [1.0, 0.0, thrown["lever_z"]]])
    before = np.array([thrown["along"], -thrown["down"], 0.0])
    inverse = np.diag([1.0 / m, 1.0 / m, 1.0 / inertia])
    made = cl.impact(make(numbers), jacobian @ inverse @ jacobian.T, jacobian @ before)
    after = before + inverse @ jacobian.T @ made.impulse.values[0]
    return entrant.of_impact(numbers, float(jacobian[0] @ after), *after)


def bounce(make: Make, numbers: Numbers) -> Values:
    """Answer for a ball that falls onto the plane."""
    motor = cl.ball(numbers["mass"], height=numbers["height"], gravity=numbers["gravity"])
    run = cl.simulate(motor, make(numbers), duration=numbers["duration"], record_interval=1e-5)
    speed = (run["gap"].values[-1] - run["gap"].values[-2]) / 1e-5
    return entrant.of_bounce(numbers, run["time"].values, run["gap"].values, speed)


KINDS = {"block": block, "impact": impact, "bounce": bounce}

if __name__ == "__main__":
    entrant.serve(SETTINGS, KINDS)
