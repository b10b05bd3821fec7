"""Exudyn's answers: friction of a coordinate spring-damper, contact of two spheres."""

from math import sqrt
from typing import Any, NamedTuple

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


class Spheres(NamedTuple):
    """Contact of spheres: its stiffness [N/m^1.5], the solver and the coordinates of rotation."""

    stiffness: float
    solver: Any
    nodes: Any


IMPLICIT = Spheres(1e7, exudyn.DynamicSolverType.GeneralizedAlpha, exudyn.NodeType.RotationEulerParameters)
"""With 1e8 N/m^1.5 this solver stops at 10 m/s and at rest."""
EXPLICIT = Spheres(1e8, exudyn.DynamicSolverType.RK44, exudyn.NodeType.RotationRotationVector)
"""Explicit solvers need coordinates without constraints."""


class Setting(NamedTuple):
    """Friction and step of blocks [s]; contacts of spheres have a tenth of the step."""

    friction: dict[str, float]
    step: float
    spheres: Spheres


SETTINGS = {
    "friction proportional below 1 mm/s, 1 ms": Setting(REGULARISED, 1e-3, IMPLICIT),
    "bristles of 0.1 N/um, 1 ms": Setting(BRISTLES, 1e-3, IMPLICIT),
    "bristles of 0.1 N/um, 0.1 ms": Setting(BRISTLES, 1e-4, IMPLICIT),
    "bristles of 0.1 N/um, 0.1 ms, spheres by RK44": Setting(BRISTLES, 1e-4, EXPLICIT),
}

PLATE = 100.0
"""Radius of the sphere that is the plate [m]."""

COORDINATE = exudyn.OutputVariableType.Coordinates


def solve(system: Any, duration: float, step: float, solver: Any = IMPLICIT.solver) -> None:
    """Run for a duration [s] in steps of a length [s], and record sensors at each."""
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(duration / step)
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 0.5 * step
    system.SolveDynamic(settings, solverType=solver)


def block(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a mass with one coordinate: its normal force is the weight."""
    friction, step, _ = setting
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

    if entrant.is_constant(numbers):
        system.AddLoad(LoadCoordinate(markerNumber=markers[1], load=entrant.push_at(numbers, 0.0, 0.0)))
    else:
        system.AddLoad(LoadCoordinate(markerNumber=markers[1], load=1.0, loadUserFunction=load))
    sensor = system.AddSensor(SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=COORDINATE))
    solve(system, numbers["duration"], step)
    time, way = np.transpose(system.GetSensorStoredData(sensor))
    velocity = system.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates_t)
    return entrant.of_block(numbers, time, way, float(velocity))


def over_plate(
    spheres: Spheres, numbers: Numbers, start: dict[str, Any], end: list[float], gravity: float
) -> tuple[Any, Any]:
    """Return a system and its body, which has a sphere at its end over the plate."""
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.CreateGround(referencePosition=[0.0, 0.0, -PLATE])
    inertia = RigidBodyInertia(mass=numbers["mass"], inertiaTensor=np.eye(3) * numbers.get("inertia", 1e-3))
    body = system.CreateRigidBody(
        inertia=inertia, gravity=[0.0, 0.0, -gravity], nodeType=spheres.nodes, **start
    )
    system.CreateSphereSphereContact(
        itemNumbers=[body, ground],
        localPosition0=end,
        spheresRadii=[numbers["radius"], PLATE],
        dynamicFriction=numbers["friction"],
        contactStiffness=spheres.stiffness,
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
    system, body = over_plate(setting.spheres, numbers, start, end, 0.0)
    solve(system, height / numbers["down"] + 0.02, 0.1 * setting.step, setting.spheres.solver)
    kinds = exudyn.OutputVariableType
    along, _, up = system.GetObjectOutputBody(body, kinds.Velocity)
    _, about_y, _ = system.GetObjectOutputBody(body, kinds.AngularVelocity)
    return entrant.of_impact(numbers, up - about_y * numbers["lever_x"], along, up, about_y)


def bounce(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a ball that falls onto the plate."""
    start = {"referencePosition": [0.0, 0.0, numbers["height"] + numbers["radius"]]}
    system, body = over_plate(setting.spheres, numbers, start, [0.0, 0.0, 0.0], numbers["gravity"])
    kinds = exudyn.OutputVariableType
    sensor = system.AddSensor(
        SensorBody(bodyNumber=body, storeInternal=True, outputVariableType=kinds.Position)
    )
    solve(system, numbers["duration"], 0.1 * setting.step, setting.spheres.solver)
    time, _, _, height = np.transpose(system.GetSensorStoredData(sensor))
    return entrant.of_bounce(
        numbers, time, height, float(system.GetObjectOutputBody(body, kinds.Velocity)[2])
    )


if __name__ == "__main__":
    entrant.serve(SETTINGS, {"block": block, "impact": impact, "bounce": bounce})
