"""Random motors, each the same from run to run: what a seed gives.

Every parameter that a motor, its drive or its contact has is drawn, within what the equations allow and
wider than what a workshop would build; the choices that are edges of the model (no friction, no load, no
clearance, one tone only) come up now and then as themselves.
"""

import numpy as np

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
        "frequency_ratio": sometimes(
            float(rng.choice([1.0, 1.5, 2.0, 3.0])), rng.uniform(0.5, 3.0), 0.5
        ),
        "phase": rng.uniform(-np.pi, np.pi),
        "shapes": int(rng.integers(2, 7)),
        "mass_damping": logarithmic(1.0, 300.0),
        "stiffness_damping": logarithmic(2e-7, 5e-5),
    }


def random_stiffness(seed: int) -> float:
    """Hertz stiffness that goes with this seed [N m^-3/2], over three decades."""
    return float(10.0 ** np.random.default_rng([seed, 1]).uniform(8.0, 11.0))
