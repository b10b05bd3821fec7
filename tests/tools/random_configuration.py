"""Random configurations of the command: what a number gives, the same on every machine and in every run.

Everything that a user can set is drawn, far wider than what a workshop would build: most of all where laws
and engine have edges (no friction, no clearance, one tone only, no damping, a point mass at the tip,
tolerances to 1e-12). Laws and the parts of a composed law follow each other by number: each gets its share.
"""

from collections.abc import Mapping
from itertools import product
from math import isfinite
from typing import Any, Final

import numpy as np

from contactlab.laws import LAWS, PARTS, PenaltyLaw, law_class
from contactlab.laws.declaration import SHARED, members_of

COMPOSED: Final = "composed"
HALF_BEAM: Final = 28.5e-3
"""Half the length of the beam [m]: each set of patches lies on its own half."""


def law_groups() -> list[dict[str, str]]:
    """The choices that make every law, and every combination of the parts of a composed one."""
    whole = [{"law": name} for name in LAWS if name != COMPOSED]
    families = list(PARTS)
    parts = [
        {"law": COMPOSED} | {f"law/{f}": name for f, name in zip(families, names, strict=True)}
        for names in product(*PARTS.values())
    ]
    return [*whole * max(1, len(parts) // len(whole)), *parts]


def random_configuration(number: int, seed: int = 0) -> tuple[dict[str, str], dict[str, Any]]:
    """The configuration with this number: options of groups, and values of keys in SI units."""
    rng = np.random.default_rng([seed, number])
    choices = law_groups()
    groups = dict(choices[number % len(choices)])
    refined = rng.random() < 0.2
    groups["resonator"] = "finite_element" if refined else "ritz"

    def logarithmic(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def sometimes(edge: float | None, value: float, share: float = 0.1) -> float | None:
        return edge if rng.random() < share else value

    start = rng.uniform(0.2e-3, 18e-3)
    values: dict[str, Any] = {
        "placement.start": float(start),
        "placement.end": float(rng.uniform(start + 4e-3, min(start + 14e-3, HALF_BEAM - 1e-3))),
        "resonator.tip_mass": logarithmic(1e-4, 5e-3),
        "resonator.tip_inertia": sometimes(0.0, logarithmic(1e-8, 1e-6)),
        "resonator.mass_damping": sometimes(0.0, logarithmic(1e-2, 300.0)),
        "resonator.stiffness_damping": sometimes(0.0, logarithmic(1e-9, 1e-4)),
        "drive.voltage_1": sometimes(0.0, logarithmic(20.0, 2000.0)),
        "drive.voltage_2": sometimes(0.0, logarithmic(20.0, 2000.0)),
        "drive.frequency": sometimes(None, float(rng.uniform(500.0, 8000.0)), 0.5),
        "drive.frequency_ratio": sometimes(
            float(rng.choice([1.0, 1.5, 2.0, 3.0])), logarithmic(0.01, 10.0), 0.5
        ),
        "drive.phase": float(rng.uniform(-np.pi, np.pi)),
        "contact.tip_length": float(rng.uniform(5e-3, 30e-3)),
        "contact.clearance": sometimes(0.0, logarithmic(1e-9, 2e-6)),
        "contact.friction_coefficient": sometimes(0.0, float(rng.uniform(0.0, 2.0))),
        "rotor.radius": logarithmic(3e-3, 50e-3),
        "rotor.inertia": logarithmic(1e-7, 1e-3),
        "rotor.damping": sometimes(0.0, logarithmic(1e-7, 1e-2), 0.5),
        "rotor.load_torque": sometimes(0.0, float(rng.uniform(-1e-2, 1e-2)), 0.5),
        "rotor.initial_velocity": sometimes(0.0, float(rng.uniform(-5.0, 5.0)), 0.5),
        "solver.duration": logarithmic(1e-3, 4e-3),
        "record.interval": logarithmic(2e-7, 5e-6),
    }
    if refined:
        values["resonator.kept_modes"] = int(rng.integers(2, 17))
    else:
        values["resonator.shapes"] = int(logarithmic(2.0, 41.0))
    if issubclass(law_class(groups["law"]), PenaltyLaw):
        values["solver.tolerance"] = sometimes(None, logarithmic(1e-12, 1e-5), 0.5)
    return groups, values | _law_values(groups, rng)


def _law_values(groups: Mapping[str, str], rng: np.random.Generator) -> dict[str, float]:
    """Every parameter of the law by its key: near its default, or anywhere in a finite range."""
    owners: dict[str, Any] = {"law": law_class(groups["law"])}
    owners |= {
        f"law.{family}": parts[groups[f"law/{family}"]]
        for family, parts in PARTS.items()
        if f"law/{family}" in groups
    }
    values = {}
    for key, owner in owners.items():
        for name, member in members_of(owner).items():
            text = member.parameter
            if text is None or name == SHARED or member.default is None:
                continue
            low, high = max(text.above, text.at_least), min(text.below, text.at_most)
            if isfinite(low) and isfinite(high):
                value = low + (high - low) * rng.uniform(0.02, 0.98)
            else:
                value = member.default * 10.0 ** rng.uniform(-1.0, 1.0)
                value = max(value, low if text.admits(low) else value)
            # A number of elements is a whole one.
            values[f"{key}.{name}"] = float(value) if float in member.kinds else round(value)
    return values
