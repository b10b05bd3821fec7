"""Motors drawn one by one, each the same under every law, and what is not known of a motor.

Motor n is drawn from the seed (`SEED`, n), so that a population grows without changing. Half of the motors
are pressed by a bearing without a spring, the others have a clearance; half of the legs are tilted; a third
each is the beam of four shapes, that of finite elements, and a structure whose every mode is another's. Laws
have one coefficient of restitution at one speed, and compliant ones one elastic force.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from math import pi
from typing import Any, Final, NamedTuple

import numpy as np
from variations import tip_phasors

import contactlab as cl
from contactlab.arrays import Array
from contactlab.studies.compare.laws import delassus_at_rest
from contactlab_data.inference.calibration import Datum, calibrated

SEED: Final = 60

FAMILIES: Final = ("four shapes", "finite elements", "other modes")
"""Resonators: the last one's modes are those of the second, each with numbers of its own."""

OTHER: Final = 0.2
"""Standard deviation of the logarithms of frequency, lever and coupling of each of the other modes."""

RANGES: Final[dict[str, tuple[float, float, bool]]] = {
    "friction coefficient": (0.1, 0.6, False),
    "restitution": (0.2, 0.9, False),
    "stiffness": (1e9, 1e11, True),
    "damping ratio": (0.003, 0.1, True),
    "clearance over amplitude": (0.0, 0.8, False),
    "preload over closed force": (0.03, 1.0, True),
    "bearing mass": (5e-3, 0.2, True),
    "bearing damping": (1.0, 100.0, True),
    "phase": (-pi, pi, False),
    "detuning": (0.97, 1.03, False),
    "voltage 1": (30.0, 300.0, True),
    "voltage 2": (30.0, 300.0, True),
    "angle": (0.0, 0.6, False),
    "tip length": (12e-3, 24e-3, False),
    "rotor radius": (15e-3, 40e-3, False),
    "inertia": (1e-6, 1e-4, True),
}
"""Least and largest value [SI], and whether the logarithm is drawn evenly. The stiffness is Hertz's K, and
the preload is over the amplitude of the contact force where nothing opens the contact, `closed_force`: a
rotor that is pressed harder never leaves the tip, which then drives it nowhere."""


class Known(NamedTuple):
    """How well an input is known: standard deviations of its logarithm, or of itself where it may be zero.

    Args:
        catalogue: of a motor whose drawing and materials are known.
        bench: of one that has been measured part by part.
    """

    catalogue: float
    bench: float


KNOWN: Final = {
    "friction coefficient": Known(0.3, 0.1),
    "restitution": Known(0.3, 0.1),
    "damping ratio": Known(0.5, 0.1),
    "clearance over amplitude": Known(0.3, 0.1),
    "preload over closed force": Known(0.2, 0.05),
    "phase": Known(0.1, 0.02),
    "detuning": Known(0.01, 0.002),
    "voltage 1": Known(0.1, 0.02),
    "voltage 2": Known(0.1, 0.02),
    "angle": Known(0.05, 0.01),
}
"""What is not known of a motor, the same for every law; phase and angle in rad."""

ABSOLUTE: Final = ("phase", "angle")
"""Inputs that are known to within a distance, not to within a share."""


def drawn(number: int) -> dict[str, Any]:
    """Return motor `number` by the names of `RANGES`, with its family and whether it is pressed."""
    rng = np.random.default_rng([SEED, number])
    motor: dict[str, Any] = {}
    for name, (low, high, logarithmic) in RANGES.items():
        at = rng.random()
        motor[name] = float(low * (high / low) ** at if logarithmic else low + (high - low) * at)
    motor["pressed"], tilted = (bool(x) for x in rng.random(2) < 0.5)
    motor["angle"] *= tilted
    motor["family"] = FAMILIES[int(rng.integers(len(FAMILIES)))]
    motor["modes"] = number
    return motor


@cache
def _beam(basis: str, damping_ratio: float, tip_length: float) -> cl.NormalModes:
    keys = [f"resonator.damping_ratio={damping_ratio!r}", f"contact.tip_length={tip_length!r}"]
    return cl.build([f"resonator={basis}", *keys]).motor.modes


def modes_of(motor: Mapping[str, Any]) -> cl.NormalModes:
    """Return the modes of a motor's resonator."""
    basis = "ritz" if motor["family"] == "four shapes" else "finite_element"
    modes = _beam(basis, motor["damping ratio"], motor["tip length"])
    if motor["family"] != "other modes":
        return modes
    rng = np.random.default_rng([SEED, motor["modes"], 1])
    pitch, lever, slope, volts = np.exp(OTHER * rng.standard_normal((4, modes.stiffness.size)))
    return cl.NormalModes(
        stiffness=modes.stiffness * pitch**2,
        damping=modes.damping * pitch,
        coupling=modes.coupling * volts[:, None],
        tip_displacement=modes.tip_displacement * lever,
        tip_slope=modes.tip_slope * slope,
    )


def closed_force(modes: cl.NormalModes, drive: cl.Drive, mass: float) -> float:
    """Return the amplitude of the force between a tip and a mass that it never leaves [N].

        N = |u / (H - 1/(m w^2))|,   H = sum_j u_j^2 / (k_j - w^2 + i c_j w)

    summed over the tones, with the phasors u of the free tip.
    """
    w = drive.angular_frequency
    dynamic = modes.stiffness[:, None] - w**2 + 1j * modes.damping[:, None] * w
    receptance = (modes.tip_displacement[:, None] ** 2 / dynamic).sum(axis=0) - 1.0 / (mass * w**2)
    return float(np.abs(tip_phasors(modes, drive)[0] / receptance).sum())


def motor_of(motor: Mapping[str, Any], scale: float = 1.0) -> cl.Motor:
    """Return a drawn motor with its voltages times a scale, which changes neither clearance nor preload."""
    modes = modes_of(motor)
    frequency = motor["detuning"] * float(modes.natural_frequency[0])
    drive, scaled = (
        cl.Drive.two_mode(
            by * motor["voltage 1"], by * motor["voltage 2"], frequency=frequency, phase=motor["phase"]
        )
        for by in (1.0, scale)
    )
    amplitude = float(np.abs(tip_phasors(modes, drive)[0]).sum())
    clearance = 0.0 if motor["pressed"] else motor["clearance over amplitude"] * amplitude
    geometry = cl.ContactGeometry(
        tip_length=motor["tip length"],
        rotor_radius=motor["rotor radius"],
        clearance=clearance,
        angle=motor["angle"],
    )
    made = cl.Motor(modes, scaled, geometry, cl.Rotor(inertia=motor["inertia"]))
    if not motor["pressed"]:
        return made
    preload = motor["preload over closed force"] * closed_force(modes, drive, motor["bearing mass"])
    bearing = cl.Bearing(mass=motor["bearing mass"], preload=preload, damping=motor["bearing damping"])
    return cl.on_bearing(made, bearing)


RIGID: Final[dict[str, Callable[[float], cl.ContactLaw]]] = {
    "lagrange_slip": cl.LagrangeSlip,
    "lagrange_stick": cl.LagrangeStick,
    "newton": cl.Newton,
    "poisson": cl.Poisson,
    "stronge": cl.Stronge,
    "johnson": cl.Johnson,
}
"""Laws by friction coefficient, before they are calibrated."""

COMPLIANT: Final[dict[str, tuple[Any, Any]]] = {
    "flores": (cl.Flores, cl.Coulomb),
    "tsuji": (cl.Tsuji, cl.Coulomb),
    "flores, mindlin": (cl.Flores, cl.Mindlin),
}
"""Damping and friction of laws whose elastic force is Hertz's."""

LAWS: Final = (*RIGID, *COMPLIANT)


def law_of(name: str, motor: Mapping[str, Any], made: cl.Motor, speed: float) -> cl.ContactLaw:
    """Return a law with the motor's restitution, if it has one, in a straight impact at a speed [m/s].

    Contacts with a restitution are as stiff as drawn, under every damping: what a speed changes of the
    contact time is left to the damping.

    Raises:
        ValueError: the law cannot have it.
    """
    mu = motor["friction coefficient"]
    if name in RIGID:
        law = RIGID[name](mu)
    else:
        damping, friction = COMPLIANT[name]
        law = cl.Composed(cl.HertzPoint(motor["stiffness"]), damping(), friction(mu))
    if name.startswith("lagrange"):
        return law
    # A bench measures it in a straight impact.
    straight = np.diag(np.diag(delassus_at_rest(made)))
    numbers = calibrated(law, Datum("restitution", motor["restitution"], speed), straight)
    if not numbers:
        raise ValueError(f"{name} has no restitution of {motor['restitution']:.3f} at {speed:.4g} m/s.")
    for number, value in numbers.items():
        law = law.changed(number, value)
    return law


def begun(made: cl.Motor, law: cl.ContactLaw, velocity: float = 0.0) -> cl.Motor:
    """Return a motor that begins as the command's do, a pressed one in equilibrium, at a rotor velocity."""
    made = replace(made, rotor=replace(made.rotor, initial_velocity=velocity))
    return cl.at_rest(made, law) if made.modes.rotor_displacement is not None else made


GROUPS: Final = (
    "friction coefficient",
    "restitution",
    "damping ratio",
    "contact time over period",
    "approach over tangential speed",
    "clearance over amplitude",
    "preload over closed force",
    "preload over stiffness",
    "pressed",
    "coupling",
    "inertia over tip's",
    "detuning",
    "phase",
)
"""Dimensionless: the time of an impact at the motor's own speed over the period of the first tone; amplitudes
of the free tip's velocity; |D_nt| / sqrt(D_nn D_tt); J D_tt' / R^2 with the tip's own mobility D_tt' along
the rotor; the preload over `closed_force`, and over K a^1.5 with the amplitude a of the free tip. A motor
with a clearance has no preload, and one that is pressed no clearance: these are 0 there."""


def groups_of(motor: Mapping[str, Any], made: cl.Motor, law: cl.ContactLaw, speed: float) -> Array:
    """Return the dimensionless groups of a motor, of its compliant law, in the order of `GROUPS`."""
    d = delassus_at_rest(made)
    approach, lean = (
        float(np.abs(made.drive.angular_frequency * x).sum()) for x in tip_phasors(made.modes, made.drive)
    )
    time = Datum("contact_time", 1.0, speed).measured(law, np.diag(np.diag(d)))
    tangential = made.rows_at_rest[1]
    amplitude = float(np.abs(tip_phasors(made.modes, made.drive)[0]).sum())
    force = motor["preload over closed force"] * closed_force(made.modes, made.drive, motor["bearing mass"])
    derived = {
        "contact time over period": time * float(made.drive.frequency[0]),
        "approach over tangential speed": approach / (made.geometry.tip_length * lean),
        "coupling": abs(d[0, 1]) / np.sqrt(d[0, 0] * d[1, 1]),
        "inertia over tip's": made.rotor.inertia
        * float(tangential @ tangential)
        / made.geometry.rotor_radius**2,
        "clearance over amplitude": 0.0 if motor["pressed"] else motor["clearance over amplitude"],
        "preload over closed force": motor["preload over closed force"] if motor["pressed"] else 0.0,
        "preload over stiffness": force / (motor["stiffness"] * amplitude**1.5) if motor["pressed"] else 0.0,
    }
    return np.array([float({**motor, **derived}[name]) for name in GROUPS])
