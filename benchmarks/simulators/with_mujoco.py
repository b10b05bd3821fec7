"""MuJoCo's answers. A velocity after an impact is that of the first step without a contact."""

from math import log, pi, sqrt
from typing import Any

import entrant
import mujoco
from entrant import Numbers, Values

RECOMMENDED = 'cone="elliptic" impratio="100"'
NO_SLIP = f'{RECOMMENDED} noslip_iterations="10"'
SETTINGS = {
    "defaults, 2 ms": ("", 2e-3),
    "defaults, 0.1 ms": ("", 1e-4),
    "elliptic, impratio 100, 2 ms": (RECOMMENDED, 2e-3),
    "elliptic, impratio 100, 0.1 ms": (RECOMMENDED, 1e-4),
    "elliptic, impratio 100, 10 no-slip iterations, 2 ms": (NO_SLIP, 2e-3),
    "elliptic, impratio 100, 10 no-slip iterations, 0.1 ms": (NO_SLIP, 1e-4),
}

Setting = tuple[str, float]


def model(
    setting: Setting, numbers: Numbers, gravity: float, body: str, contact: str = ""
) -> tuple[Any, Any]:
    """Return model and data of a free body, whose geom is called "body", over a plane."""
    options, step = setting
    mu = numbers["friction"]
    text = f"""<mujoco><option timestep="{step}" gravity="0 0 {-gravity}" {options}/><worldbody>
    <geom name="plane" type="plane" size="50 50 1"/>{body}</worldbody><contact>
    <pair geom1="plane" geom2="body" condim="3" friction="{mu} {mu} 0 0 0" {contact}/></contact></mujoco>"""
    made = mujoco.MjModel.from_xml_string(text)
    return made, mujoco.MjData(made)


def reference(numbers: Numbers, step: float) -> str:
    """Return the contact's reference: a linear spring with the damping ratio of the restitution.

    A contact lasts six steps or more. Elliptic cones have a reference of their own for friction: it is damped
    critically with the same time constant, the best of four choices tried. Pyramidal cones have none.
    """
    e = numbers["restitution"]
    ratio = -log(e) / sqrt(pi**2 + log(e) ** 2)
    constant = max(2.0 * step, 1e-3)
    spring = f"{-1.0 / constant**2} {-2.0 * ratio / constant}"
    return f'solref="{spring}" solimp="0.99 0.99 0.001" solreffriction="{constant} 1"'


def block(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a block of 20 cm on a plane, loaded in the plane."""
    thick = 0.01
    body = f"""<body pos="0 0 {thick}"><freejoint/><geom name="body" type="box" size="0.1 0.1 {thick}"
    mass="{numbers["mass"]}"/></body>"""
    made, data = model(setting, numbers, numbers["gravity"], body)
    for _ in range(round(entrant.SETTLING / setting[1])):
        mujoco.mj_step(made, data)
    began, place = data.time, data.qpos[0]
    time, way = [0.0], [0.0]
    for _ in range(round(numbers["duration"] / setting[1])):
        push = entrant.push_at(numbers, time[-1], way[-1])
        data.xfrc_applied[1] = [push, 0.0, 0.0, 0.0, -data.qpos[2] * push, 0.0]
        mujoco.mj_step(made, data)
        time.append(data.time - began)
        way.append(data.qpos[0] - place)
    return entrant.of_block(numbers, time, way, data.qvel[0])


def impact(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a body with a sphere at its end that is thrown onto the plane."""
    height = 1e-3
    inertia = f'diaginertia="{numbers["inertia"]} {numbers["inertia"]} {numbers["inertia"]}"'
    centre = f"{numbers['lever_x']} 0 {numbers['lever_z'] + numbers['radius']}"
    body = f"""<body pos="0 0 {height - numbers["lever_z"]}"><freejoint/>
    <inertial pos="0 0 0" mass="{numbers["mass"]}" {inertia}/>
    <geom name="body" type="sphere" size="{numbers["radius"]}" pos="{centre}"/></body>"""
    made, data = model(setting, numbers, 0.0, body, reference(numbers, setting[1]))
    data.qvel[0], data.qvel[2] = numbers["along"], -numbers["down"]
    touched = False
    while data.time < 1.0 and not (touched and not data.ncon):
        mujoco.mj_step(made, data)
        touched |= bool(data.ncon)
    along, _, up, _, about_y, _ = data.qvel
    # About y, x turns towards -z.
    return entrant.of_impact(numbers, up - about_y * numbers["lever_x"], along, up, about_y)


def bounce(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a ball that falls onto the plane."""
    radius = numbers["radius"]
    body = f"""<body pos="0 0 {numbers["height"] + radius}"><freejoint/>
    <geom name="body" type="sphere" size="{radius}" mass="{numbers["mass"]}"/></body>"""
    made, data = model(setting, numbers, numbers["gravity"], body, reference(numbers, setting[1]))
    time, height = [], []
    for _ in range(round(numbers["duration"] / setting[1])):
        mujoco.mj_step(made, data)
        time.append(data.time)
        height.append(data.qpos[2])
    return entrant.of_bounce(numbers, time, height, data.qvel[2])


if __name__ == "__main__":
    entrant.serve(SETTINGS, {"block": block, "impact": impact, "bounce": bounce})
