"""PyBullet's answers. A velocity after an impact is that of the first step without a contact."""

from math import sqrt
from typing import Any

import entrant
import pybullet as bullet
from entrant import Numbers, Values

DEFAULTS = {"numSolverIterations": 50, "restitutionVelocityThreshold": 0.2}
TUNED = {"numSolverIterations": 200, "restitutionVelocityThreshold": 0.0}
UNLIMITED = 1e18
"""Distance below which contacts are solved ahead of touching, by default."""

SETTINGS = {
    "defaults, 1/240 s": (1.0 / 240.0, DEFAULTS, UNLIMITED),
    "defaults, 1/4800 s": (1.0 / 4800.0, DEFAULTS, UNLIMITED),
    "thresholds 0, 200 iterations, 1/240 s": (1.0 / 240.0, TUNED, 0.0),
    "thresholds 0, 200 iterations, 1/4800 s": (1.0 / 4800.0, TUNED, 0.0),
}

Setting = tuple[float, dict[str, Any], float]


def world(setting: Setting, numbers: Numbers, gravity: float, height: float, **shape: Any) -> int:
    """Return a body over a plane; coefficients of a contact are products of those of the two surfaces."""
    step, parameters, ahead = setting
    bullet.resetSimulation()
    bullet.setPhysicsEngineParameter(fixedTimeStep=step, **parameters)
    bullet.setGravity(0.0, 0.0, -gravity)
    plane = bullet.createMultiBody(0.0, bullet.createCollisionShape(bullet.GEOM_PLANE))
    body = bullet.createMultiBody(
        numbers["mass"], bullet.createCollisionShape(**shape), basePosition=[0.0, 0.0, height]
    )
    surface = {
        "lateralFriction": sqrt(numbers["friction"]),
        "restitution": sqrt(numbers.get("restitution", 0.0)),
        "linearDamping": 0.0,
        "angularDamping": 0.0,
        "contactProcessingThreshold": ahead,
    }
    for each in (plane, body):
        bullet.changeDynamics(each, -1, **surface)
    return int(body)


def block(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a block of 20 cm on a plane, loaded in the plane."""
    thick, step = 0.01, setting[0]
    shape = {"shapeType": bullet.GEOM_BOX, "halfExtents": [0.1, 0.1, thick]}
    body = world(setting, numbers, numbers["gravity"], thick, **shape)
    for _ in range(round(entrant.SETTLING / step)):
        bullet.stepSimulation()
    place = bullet.getBasePositionAndOrientation(body)[0][0]
    time, way = [0.0], [0.0]
    for i in range(round(numbers["duration"] / step)):
        push = entrant.push_at(numbers, time[-1], way[-1])
        bullet.applyExternalForce(body, -1, [push, 0.0, 0.0], [place + way[-1], 0.0, 0.0], bullet.WORLD_FRAME)
        bullet.stepSimulation()
        time.append((i + 1) * step)
        way.append(bullet.getBasePositionAndOrientation(body)[0][0] - place)
    return entrant.of_block(numbers, time, way, bullet.getBaseVelocity(body)[0][0])


def impact(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a body with a sphere at its end that is thrown onto the plane."""
    height = 1e-3
    end = [numbers["lever_x"], 0.0, numbers["lever_z"] + numbers["radius"]]
    shape = {"shapeType": bullet.GEOM_SPHERE, "radius": numbers["radius"], "collisionFramePosition": end}
    body = world(setting, numbers, 0.0, height - numbers["lever_z"], **shape)
    bullet.changeDynamics(body, -1, localInertiaDiagonal=[numbers["inertia"]] * 3)
    bullet.resetBaseVelocity(body, [numbers["along"], 0.0, -numbers["down"]], [0.0, 0.0, 0.0])
    touched, steps = False, round(1.0 / setting[0])
    for _ in range(steps):
        bullet.stepSimulation()
        (along, _, up), (_, about_y, _) = bullet.getBaseVelocity(body)
        # About y, x turns towards -z. An impact is over once the contact point moves off.
        gap_rate = up - about_y * numbers["lever_x"]
        touched |= bool(bullet.getContactPoints(bodyA=body))
        if touched and gap_rate > 0.0 and not bullet.getContactPoints(bodyA=body):
            break
    return entrant.of_impact(numbers, gap_rate, along, up, about_y)


def bounce(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a ball that falls onto the plane."""
    radius, step = numbers["radius"], setting[0]
    shape = {"shapeType": bullet.GEOM_SPHERE, "radius": radius}
    body = world(setting, numbers, numbers["gravity"], numbers["height"] + radius, **shape)
    time, height = [], []
    for i in range(round(numbers["duration"] / step)):
        bullet.stepSimulation()
        time.append((i + 1) * step)
        height.append(bullet.getBasePositionAndOrientation(body)[0][2])
    return entrant.of_bounce(numbers, time, height, bullet.getBaseVelocity(body)[0][2])


if __name__ == "__main__":
    bullet.connect(bullet.DIRECT)
    entrant.serve(SETTINGS, {"block": block, "impact": impact, "bounce": bounce})
