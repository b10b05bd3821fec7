"""Motors of the tests: one dictionary of parameters, given or drawn, builds the package's and the oracle's.

The parameters are the oracle's words, SI units; by default the paper's motor, placement 2 of Table 1.
"""

from dataclasses import asdict, replace

import numpy as np
from oracle.motor import OracleMotor
from oracle.stepped_beam import SteppedBeam
from references import PLACEMENTS

from contactlab.engine import simulate
from contactlab.laws import ContactLaw, HertzPenalty, LagrangeSlip, LagrangeStick
from contactlab.motor import Bearing, FiniteElementResonator, RitzResonator, on_bearing
from contactlab.motor.drive import Drive
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, Motor, Rotor
from contactlab.motor.patched_beam import Piezoceramic, Steel
from contactlab.testing.plants import last
from contactlab.trajectory import Trajectory

DEFAULTS: dict[str, float] = asdict(OracleMotor()) | {"frequency": 3210.0}
"""Case A but for the law: the drive's first tone is given, not the first natural frequency."""

PLACEMENT_1, PLACEMENT_2 = ({"patch_start": start, "patch_end": end} for start, end in PLACEMENTS.values())

final = last

STIFFNESS = 1e10
"""Hertz stiffness of case A [N m^-3/2]."""


def parameters_with(**changes: float) -> dict[str, float]:
    """The default parameters with some of them changed; an unknown name is an error."""
    unknown = changes.keys() - DEFAULTS.keys()
    if unknown:
        raise KeyError(f"The motor has no {sorted(unknown)}; it has {sorted(DEFAULTS)}.")
    return DEFAULTS | changes


def default_resonator(**changes: float) -> RitzResonator:
    """The package's resonator with some parameters changed."""
    p = parameters_with(**changes)
    return RitzResonator(
        length=p["length"],
        width=p["width"],
        beam_thickness=p["beam_thickness"],
        patch_thickness=p["piezo_thickness"],
        patch_start=p["patch_start"],
        patch_end=p["patch_end"],
        tip_mass=p["tip_mass"],
        tip_inertia=p["tip_inertia"],
        steel=Steel(p["steel_modulus"], p["steel_poisson"], p["steel_density"]),
        piezoceramic=Piezoceramic(
            p["piezo_bending_modulus"], p["piezo_bending_coupling"], p["piezo_density"]
        ),
        shapes=int(p["shapes"]),
        mass_damping=p["mass_damping"],
        stiffness_damping=p["stiffness_damping"],
    )


def default_motor(**changes: float) -> Motor:
    """The package's motor with some parameters changed."""
    p = parameters_with(**changes)
    drive = Drive.two_mode(p["voltage_1"], p["voltage_2"], p["frequency"], p["frequency_ratio"], p["phase"])
    motor = Motor(
        modes=default_resonator(**changes).modes,
        drive=drive,
        geometry=ContactGeometry(p["tip_length"], p["rotor_radius"], p["clearance"], p["angle"]),
        rotor=Rotor(p["rotor_inertia"], p["rotor_damping"], p["load_torque"], p["initial_velocity"]),
    )
    if not p["rotor_mass"]:
        return motor
    bearing = Bearing(p["rotor_mass"], p["preload"], p["bearing_stiffness"], p["bearing_damping"])
    motor = on_bearing(motor, bearing)
    start = np.zeros(motor.modes.stiffness.size)
    start[-1] = p["rotor_start"] / motor.modes.rotor_displacement[-1]
    return replace(motor, start=ModalState(start, np.zeros_like(start)))


def oracle_motor(**changes: float) -> OracleMotor:
    """The oracle's motor with some parameters changed."""
    p = parameters_with(**changes)
    return OracleMotor(**(p | {"shapes": int(p["shapes"])}))  # type: ignore[arg-type]


def case_a() -> Motor:
    """The reference case: placement 2, 1 um clearance, 100 V at 3210 and 6420 Hz, phase -pi/5."""
    return default_motor()


def hertz(friction_coefficient: float = 0.3, stiffness: float = STIFFNESS) -> HertzPenalty:
    """The compliant law of case A."""
    return HertzPenalty(stiffness=stiffness, friction_coefficient=friction_coefficient)


def every_law(friction_coefficient: float = 0.3) -> list[ContactLaw]:
    """One of each law."""
    return [
        hertz(friction_coefficient),
        LagrangeStick(friction_coefficient),
        LagrangeSlip(friction_coefficient),
    ]


def run(
    motor: Motor,
    law: ContactLaw,
    duration: float = 5e-3,
    record_interval: float = 1e-5,
    contact_step: float | None = None,
) -> Trajectory:
    """A run that must reach its end."""
    trajectory = simulate(
        motor, law, duration=duration, record_interval=record_interval, contact_step=contact_step
    )
    assert trajectory.complete, trajectory.message
    return trajectory


def total(trajectory: Trajectory, name: str) -> float:
    """Sum of a column of the contacts."""
    return float(trajectory.contacts[name].sum())


HALF_BEAM = 28.5e-3
"""Half the length of the beam [m]: each set of patches lies on its own half."""


def random_motor(seed: int) -> dict[str, float]:
    """Parameters of the motor with this seed, named as in `motors.DEFAULTS`, SI units."""
    rng = np.random.default_rng(seed)

    def logarithmic(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def sometimes(edge: float, value: float, share: float = 0.1) -> float:
        return edge if rng.random() < share else value

    patch_start = rng.uniform(0.2e-3, 18e-3)
    first, second = (float(volts) for volts in rng.uniform(40.0, 400.0, 2))
    return {
        "patch_start": patch_start,
        "patch_end": rng.uniform(patch_start + 4e-3, min(patch_start + 14e-3, HALF_BEAM - 1e-3)),
        "tip_mass": logarithmic(0.3e-3, 3e-3),
        "tip_inertia": logarithmic(0.4e-7, 4e-7),
        "tip_length": rng.uniform(8e-3, 25e-3),
        "rotor_radius": rng.uniform(8e-3, 40e-3),
        "rotor_inertia": logarithmic(2e-6, 2e-4),
        "rotor_damping": sometimes(0.0, logarithmic(1e-6, 1e-2)),
        "load_torque": sometimes(0.0, rng.uniform(-8e-3, 8e-3)),
        "initial_velocity": sometimes(0.0, rng.uniform(-3.0, 3.0)),
        "clearance": sometimes(0.0, logarithmic(1e-8, 1.5e-6)),
        "friction_coefficient": sometimes(0.0, rng.uniform(0.0, 0.8)),
        "voltage_1": sometimes(0.0, first, 0.05),
        "voltage_2": sometimes(0.0, second, 0.05),
        "frequency": rng.uniform(1500.0, 5000.0),
        "frequency_ratio": sometimes(float(rng.choice([1.0, 1.5, 2.0, 3.0])), rng.uniform(0.5, 3.0), 0.5),
        "phase": rng.uniform(-np.pi, np.pi),
        "shapes": int(rng.integers(2, 7)),
        "mass_damping": logarithmic(1.0, 300.0),
        "stiffness_damping": logarithmic(2e-7, 5e-5),
    }


def random_stiffness(seed: int) -> float:
    """Hertz stiffness that goes with this seed [N m^-3/2], over three decades."""
    return float(10.0 ** np.random.default_rng([seed, 1]).uniform(8.0, 11.0))


def stepped_beam(resonator: FiniteElementResonator) -> SteppedBeam:
    """The beam of a resonator for the transfer matrices, from dimensions and materials alone."""
    r, w = resonator, resonator.width
    inner, outer = 0.5 * r.beam_thickness, 0.5 * r.beam_thickness + r.patch_thickness
    bare = r.steel.bending_modulus * w * 2.0 / 3.0 * inner**3
    patched = bare + r.piezoceramic.bending_modulus * w * 2.0 / 3.0 * (outer**3 - inner**3)
    light = r.steel.density * w * 2.0 * inner
    heavy = light + r.piezoceramic.density * w * 2.0 * (outer - inner)
    # Either layer pulls with w e_p per volt at its middle, (inner + outer) / 2 from the axis.
    moment = w * r.piezoceramic.bending_coupling * (inner + outer)
    return SteppedBeam(
        edges=np.array([0.0, r.patch_start, r.patch_end, 0.5 * r.length]),
        rigidity=np.array([bare, patched, bare]),
        mass=np.array([light, heavy, light]),
        moments=np.array([-moment, moment]),
        tip_mass=r.tip_mass,
        tip_inertia=r.tip_inertia,
        alpha=r.mass_damping,
        beta=r.stiffness_damping,
    )
