"""Exudyn's answers: friction of a coordinate spring-damper, contact of two spheres, implicit solver."""

from math import sqrt
from typing import Any

import entrant
import exudyn
import numpy as np
from entrant import Numbers, Values
from exudyn.itemInterface import (
    CoordinateSpringDamperExt,
    LoadCoordinate,
    MarkerNodeCoordinate,
    Node1D,
    NodeGenericData,
    NodePointGround,
    ObjectMass1D,
    SensorBody,
    SensorNode,
)
from exudyn.utilities import RigidBodyInertia

BRISTLE = 1e5
"""Stiffness of bristles [N/m]; the block of 1 kg is damped critically on them."""

REGULARISED = {"frictionProportionalZone": 1e-3}
BRISTLES = {"stickingStiffness": BRISTLE, "stickingDamping": 2.0 * sqrt(BRISTLE)}
SETTINGS = {
    "friction proportional below 1 mm/s, 1 ms": (REGULARISED, 1e-3),
    "bristles of 0.1 N/um, 1 ms": (BRISTLES, 1e-3),
    "bristles of 0.1 N/um, 0.1 ms": (BRISTLES, 1e-4),
}
"""Friction and step of blocks [s]; contacts of spheres have a tenth of the step."""

STIFFNESS = 1e7
"""Of the contact of spheres [N/m^1.5]: with 1e8 the solver stops at 10 m/s and at rest."""

PLATE = 100.0
"""Radius of the sphere that is the plate [m]."""

COORDINATE = exudyn.OutputVariableType.Coordinates

Setting = tuple[dict[str, float], float]


def solve(system: Any, duration: float, step: float) -> None:
    """Run for a duration [s] in steps of a length [s], and record sensors at each."""
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(duration / step)
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 0.5 * step
    system.SolveDynamic(settings)


def block(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a mass with one coordinate: its normal force is the weight."""
    friction, step = setting
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    node = system.AddNode(Node1D(referenceCoordinates=[0.0]))
    system.AddObject(ObjectMass1D(nodeNumber=node, mass=numbers["mass"]))
    ground = system.AddNode(NodePointGround())
    markers = [
        system.AddMarker(MarkerNodeCoordinate(nodeNumber=each, coordinate=0)) for each in (ground, node)
    ]
    if friction is BRISTLES:
        memory = NodeGenericData(initialCoordinates=[0.0] * 3, numberOfDataCoordinates=3)
        friction = friction | {"nodeNumber": system.AddNode(memory)}
    cone = numbers["friction"] * numbers["mass"] * numbers["gravity"]
    system.AddObject(CoordinateSpringDamperExt(markerNumbers=markers, dynamicFrictionForce=cone, **friction))

    def load(system: Any, time: float, _: float) -> float:
        return entrant.push_at(numbers, time, float(system.GetNodeOutput(node, COORDINATE)))

    system.AddLoad(LoadCoordinate(markerNumber=markers[1], load=1.0, loadUserFunction=load))
    sensor = system.AddSensor(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=COORDINATE))
    solve(system, numbers["duration"], step)
    time, way = np.transpose(system.GetSensorStoredData(sensor))
    velocity = system.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates_t)
    return entrant.of_block(numbers, time, way, float(velocity))


def over_plate(numbers: Numbers, start: dict[str, Any], end: list[float], gravity: float) -> tuple[Any, Any]:
    """Return a system and its body, which has a sphere at its end over the plate."""
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.CreateGround(referencePosition=[0.0, 0.0, -PLATE])
    inertia = RigidBodyInertia(mass=numbers["mass"], inertiaTensor=np.eye(3) * numbers.get("inertia", 1e-3))
    body = system.CreateRigidBody(inertia=inertia, gravity=[0.0, 0.0, -gravity], **start)
    system.CreateSphereSphereContact(
        itemNumbers=[body, ground],
        localPosition0=end,
        spheresRadii=[numbers["radius"], PLATE],
        dynamicFriction=numbers["friction"],
        contactStiffness=STIFFNESS,
        contactStiffnessExponent=1.5,
        restitutionCoefficient=numbers["restitution"],
        # The one that the documentation calls the most accurate in the restitution.
        impactModel=2,
    )
    return system, body


def impact(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a body with a sphere at its end that is thrown onto the plate."""
    height = 1e-3
    start = {
        "referencePosition": [0.0, 0.0, height - numbers["lever_z"]],
        "initialVelocity": [numbers["along"], 0.0, -numbers["down"]],
    }
    end = [numbers["lever_x"], 0.0, numbers["lever_z"] + numbers["radius"]]
    system, body = over_plate(numbers, start, end, 0.0)
    solve(system, height / numbers["down"] + 0.02, 0.1 * setting[1])
    kinds = exudyn.OutputVariableType
    along, _, up = system.GetObjectOutputBody(body, kinds.Velocity)
    _, about_y, _ = system.GetObjectOutputBody(body, kinds.AngularVelocity)
    return entrant.of_impact(numbers, up - about_y * numbers["lever_x"], along, up, about_y)


def bounce(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a ball that falls onto the plate."""
    start = {"referencePosition": [0.0, 0.0, numbers["height"] + numbers["radius"]]}
    system, body = over_plate(numbers, start, [0.0, 0.0, 0.0], numbers["gravity"])
    kinds = exudyn.OutputVariableType
    sensor = system.AddSensor(
        SensorBody(bodyNumber=body, storeInternal=True, outputVariableType=kinds.Position)
    )
    solve(system, numbers["duration"], 0.1 * setting[1])
    time, _, _, height = np.transpose(system.GetSensorStoredData(sensor))
    return entrant.of_bounce(
        numbers, time, height, float(system.GetObjectOutputBody(body, kinds.Velocity)[2])
    )


if __name__ == "__main__":
    entrant.serve(SETTINGS, {"block": block, "impact": impact, "bounce": bounce})
