"""MuJoCo's answers. A velocity after an impact is that of the first step without a contact."""

from math import atan2, exp, pi, sqrt
from typing import Any, NamedTuple

import entrant
import mujoco
from entrant import Numbers, Values
from scipy.optimize import brentq

RECOMMENDED = 'cone="elliptic" impratio="100"'
NO_SLIP = f'{RECOMMENDED} noslip_iterations="100" noslip_tolerance="0"'


class Setting(NamedTuple):
    """Options and step [s]."""

    options: str
    step: float


class Settings(NamedTuple):
    """Settings of blocks, and of impacts and bounces."""

    blocks: Setting
    impacts: Setting


def alike(options: str, step: float) -> Settings:
    """Return one setting for all questions."""
    return Settings(Setting(options, step), Setting(options, step))


SETTINGS = {
    "defaults, 2 ms": alike("", 2e-3),
    "defaults, 0.1 ms": alike("", 1e-4),
    "elliptic, impratio 100, 2 ms": alike(RECOMMENDED, 2e-3),
    "elliptic, impratio 100, 0.1 ms": alike(RECOMMENDED, 1e-4),
    "elliptic, impratio 100, 100 no-slip iterations, 2 ms; impacts by RK4, 20 us": Settings(
        Setting(NO_SLIP, 2e-3), Setting(f'{RECOMMENDED} integrator="RK4"', 2e-5)
    ),
}

IMPEDANCE = 0.99
"""Part of the reference's acceleration that a contact has, d in MuJoCo's documentation."""


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


def damping_ratio(restitution: float) -> float:
    """Return the damping ratio of a linear contact without tension, which ends where its force does.

    The force k x + c dx/dt vanishes at a phase of pi - atan2(2 z sqrt(1 - z^2), 1 - 2 z^2), and the velocity
    is then exp(-z phase / sqrt(1 - z^2)) of that before (Schwager and Poeschel 2007).
    """

    def rebound(ratio: float) -> float:
        root = sqrt(1.0 - ratio**2)
        return exp(-ratio / root * (pi - atan2(2.0 * ratio * root, 1.0 - 2.0 * ratio**2)))

    return float(brentq(lambda ratio: rebound(ratio) - restitution, 1e-6, 0.95))


def reference(numbers: Numbers, step: float) -> str:
    """Return the contact's reference: a linear spring with the damping ratio of the restitution.

    A contact lasts six steps or more. Elliptic cones have a reference of their own for friction: it is damped
    critically with the same time constant, the best of four choices tried. Pyramidal cones have none.
    """
    ratio, constant = damping_ratio(numbers["restitution"]), max(2.0 * step, 1e-3)
    spring = f"{-1.0 / constant**2 / IMPEDANCE} {-2.0 * ratio / constant / IMPEDANCE}"
    return f'solref="{spring}" solimp="{IMPEDANCE} {IMPEDANCE} 0.001" solreffriction="{constant} 1"'


def block(settings: Settings, numbers: Numbers) -> Values:
    """Answer for a block of 20 cm on a plane, loaded in the plane."""
    setting, thick = settings.blocks, 0.01
    body = f"""<body pos="0 0 {thick}"><freejoint/><geom name="body" type="box" size="0.1 0.1 {thick}"
    mass="{numbers["mass"]}"/></body>"""
    made, data = model(setting, numbers, numbers["gravity"], body)
    for _ in range(round(entrant.SETTLING / setting.step)):
        mujoco.mj_step(made, data)
    began, place = data.time, data.qpos[0]
    time, way = [0.0], [0.0]
    steps = round(numbers["duration"] / setting.step)
    # A load that stays is set once.
    at_once = steps if entrant.is_constant(numbers) else 1
    for _ in range(steps // at_once):
        push = entrant.push_at(numbers, time[-1], way[-1])
        data.xfrc_applied[1] = [push, 0.0, 0.0, 0.0, -data.qpos[2] * push, 0.0]
        mujoco.mj_step(made, data, at_once)
        time.append(data.time - began)
        way.append(data.qpos[0] - place)
    return entrant.of_block(numbers, time, way, data.qvel[0])


def impact(settings: Settings, numbers: Numbers) -> Values:
    """Answer for a body with a sphere at its end that is thrown onto the plane."""
    setting, height = settings.impacts, 1e-3
    inertia = f'diaginertia="{numbers["inertia"]} {numbers["inertia"]} {numbers["inertia"]}"'
    centre = f"{numbers['lever_x']} 0 {numbers['lever_z'] + numbers['radius']}"
    body = f"""<body pos="0 0 {height - numbers["lever_z"]}"><freejoint/>
    <inertial pos="0 0 0" mass="{numbers["mass"]}" {inertia}/>
    <geom name="body" type="sphere" size="{numbers["radius"]}" pos="{centre}"/></body>"""
    made, data = model(setting, numbers, 0.0, body, reference(numbers, setting.step))
    data.qvel[0], data.qvel[2] = numbers["along"], -numbers["down"]
    touched = False
    while data.time < 1.0 and not (touched and not data.ncon):
        mujoco.mj_step(made, data)
        touched |= bool(data.ncon)
    along, _, up, _, about_y, _ = data.qvel
    # About y, x turns towards -z.
    return entrant.of_impact(numbers, up - about_y * numbers["lever_x"], along, up, about_y)


def bounce(settings: Settings, numbers: Numbers) -> Values:
    """Answer for a ball that falls onto the plane."""
    setting, radius = settings.impacts, numbers["radius"]
    body = f"""<body pos="0 0 {numbers["height"] + radius}"><freejoint/>
    <geom name="body" type="sphere" size="{radius}" mass="{numbers["mass"]}"/></body>"""
    made, data = model(setting, numbers, numbers["gravity"], body, reference(numbers, setting.step))
    time, height = [], []
    for _ in range(round(numbers["duration"] / setting.step)):
        mujoco.mj_step(made, data)
        time.append(data.time)
        height.append(data.qpos[2])
    return entrant.of_bounce(numbers, time, height, data.qvel[2])


if __name__ == "__main__":
    entrant.serve(SETTINGS, {"block": block, "impact": impact, "bounce": bounce})
