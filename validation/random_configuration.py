"""Random configurations of the command: what a number gives, the same on every machine and in every run.

Everything that a user can set is drawn, far wider than what a workshop would build: most of all where laws
and engine have edges (no friction, no clearance, one tone only, no damping, a point mass at the tip,
tolerances to 1e-12). Resonators are beams or modes of a file, drives any signal, rotors have an axle or a
bearing, and a run may have changes. Laws and the parts of a composed law follow each other by number: each
gets its share.
"""

import os
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from pathlib import Path
from tempfile import gettempdir
from typing import Any, Final

import numpy as np

from contactlab.laws import LAWS, PARTS, MultiplierLaw, law_class
from contactlab.laws.declaration import SHARED, members_of

COMPOSED: Final = "composed"
HALF_BEAM: Final = 28.5e-3
"""Half the length of the beam [m]: each set of patches lies on its own half."""

FILES: Final = Path(gettempdir()) / "contactlab_random_configurations"
"""Folder of the files that configurations name: their content is the number's."""

ACHIEVED: Final = {"law.damping.restitution": {"lankarani_nikravesh": 0.663, "hunt_crossley": 0.488}}
"""Smallest values of a key that its part achieves."""

Values = dict[str, Any]


class Dice(np.random.Generator):
    """A random generator with the distributions of the numbers of a motor."""

    def __init__(self, seed: Sequence[int]) -> None:
        super().__init__(np.random.PCG64(list(seed)))

    def between(self, low: float, high: float) -> float:
        """Uniform."""
        return float(self.uniform(low, high))

    def log(self, low: float, high: float) -> float:
        """Uniform in the logarithm."""
        return float(np.exp(self.uniform(np.log(low), np.log(high))))

    def sometimes(self, edge: float | None, value: float, share: float = 0.1) -> float | None:
        """An edge with this share, else the value."""
        return edge if self.random() < share else value

    def choose(self, shares: Mapping[str, float]) -> str:
        """A key by its share; the shares add up to one."""
        return str(self.choice([*shares], p=[*shares.values()]))


def law_groups() -> list[dict[str, str]]:
    """The choices that make every law, and every normal force with every friction in a composed one.

    Dampings take turns, among those that are defined for the normal force. maugis takes turns with jkr, in
    `random_configuration`, so that all other numbers are the motors that they were without it; table, which
    without a file is a sphere, is left out for the same reason.
    """
    whole = [{"law": name} for name in LAWS if name != COMPOSED]
    normals, dampings, frictions = (dict(PARTS[family]) for family in ("normal", "damping", "friction"))
    del normals["maugis"], normals["table"]
    parts = []
    for i, (name, normal) in enumerate(normals.items()):
        elastic = not (normal.elastic is None or normal.allows_tension)
        fit = [damping for damping, part in dampings.items() if part.any_force or elastic]
        for j, friction in enumerate(frictions):
            choice = {"law/normal": name, "law/damping": fit[(i + j) % len(fit)], "law/friction": friction}
            parts.append({"law": COMPOSED} | choice)
    return [*whole * max(1, len(parts) // len(whole)), *parts]


def random_configuration(number: int, seed: int = 0, folder: Path = FILES) -> tuple[dict[str, str], Values]:
    """The configuration with this number: options of groups, and values of keys in SI units.

    The files that it names are written into the folder.
    """
    dice = Dice([seed, number])
    choices = law_groups()
    turn, place = divmod(number, len(choices))
    groups = dict(choices[place])
    if groups.get("law/normal") == "jkr" and turn % 2:
        groups["law/normal"] = "maugis"
    values: Values = {
        "contact.tip_length": dice.between(5e-3, 30e-3),
        "contact.clearance": dice.sometimes(0.0, dice.log(1e-9, 2e-6)),
        "contact.friction_coefficient": dice.sometimes(0.0, dice.between(0.0, 2.0)),
        "rotor.radius": dice.log(3e-3, 50e-3),
        "rotor.inertia": dice.log(1e-7, 1e-3),
        "rotor.damping": dice.sometimes(0.0, dice.log(1e-7, 1e-2), 0.5),
        "rotor.load_torque": dice.sometimes(0.0, dice.between(-1e-2, 1e-2), 0.5),
        "rotor.initial_velocity": dice.sometimes(0.0, dice.between(-5.0, 5.0), 0.5),
        "solver.duration": dice.log(*DURATION),
        "record.interval": dice.log(2e-7, 5e-6),
    }
    groups["resonator"] = dice.choose({"ritz": 0.5, "finite_element": 0.15, "modal": 0.35})
    files = folder / f"{seed}_{number}"
    electrodes = 2
    if groups["resonator"] == "modal":
        electrodes = int(dice.integers(1, 4))
        values["resonator.file"] = _written(Path(f"{files}_modes.csv"), _modes(dice, electrodes))
    else:
        values |= _beam(dice, groups["resonator"])
    signals = {"tones": 0.2, "sampled": 0.2, "two_mode": 0.4, "two_phase": 0.1, "chirp": 0.1}
    if electrodes != 2:
        signals = {"tones": 0.5, "sampled": 0.5}
    groups["drive"] = signal = dice.choose(signals)
    drive, table = _drive(dice, signal, electrodes, values["solver.duration"])
    values |= drive
    if table:
        values["drive.file"] = _written(Path(f"{files}_{signal}.csv"), table)
    if dice.random() < 0.3:
        values |= {
            "contact.preload": dice.log(0.05, 50.0),
            "rotor.mass": dice.sometimes(None, dice.log(1e-3, 1.0), 0.3),
            "rotor.bearing_stiffness": dice.sometimes(0.0, dice.log(1e2, 1e7), 0.5),
            "rotor.bearing_damping": dice.sometimes(0.0, dice.log(0.1, 1e3), 0.3),
        }
    if dice.random() < 0.25:
        values["solver.changes"] = [*_changes(dice, values)]
    # Rigid laws run in their limit, unless they are stepped.
    if issubclass(law_class(groups["law"]), MultiplierLaw) and dice.random() < 0.3:
        values["solver.contact_step"] = dice.log(2e-8, 3e-7)
    else:
        values["solver.tolerance"] = dice.sometimes(None, dice.log(1e-12, 1e-5), 0.5)
    return groups, values | _law_values(groups, dice)


DURATION: Final = (5e-4, 2e-3)
"""Range of the durations [s]."""


def _beam(dice: Dice, basis: str) -> Values:
    """The numbers of a beam with patches."""
    start = dice.between(0.2e-3, 18e-3)
    values: Values = {
        "placement.start": start,
        "placement.end": dice.between(start + 4e-3, min(start + 14e-3, HALF_BEAM - 1e-3)),
        "resonator.tip_mass": dice.log(1e-4, 5e-3),
        "resonator.tip_inertia": dice.sometimes(0.0, dice.log(1e-8, 1e-6)),
        "resonator.mass_damping": dice.sometimes(0.0, dice.log(1e-2, 300.0)),
        "resonator.stiffness_damping": dice.sometimes(0.0, dice.log(1e-9, 1e-4)),
    }
    if basis == "finite_element":
        return values | {"resonator.kept_modes": int(dice.integers(2, 17))}
    return values | {"resonator.shapes": int(dice.log(2.0, 41.0))}


Table = dict[str, np.ndarray]
"""Columns by their heads, with units."""


def _modes(dice: Dice, electrodes: int) -> Table:
    """Modes of a file, some a rigid body's, some overdamped, with every way to write them."""
    count = int(dice.integers(1, 9))
    frequency = np.sort(np.exp(dice.uniform(np.log(500.0), np.log(6e4), count)))
    ratio = np.exp(dice.uniform(np.log(1e-4), np.log(1.5), count)) * (dice.random(count) > 0.1)
    mass = np.exp(dice.uniform(np.log(1e-3), np.log(5e-2), count))
    omega = 2.0 * np.pi * frequency
    scale = np.ones(count) if dice.random() < 0.5 else 1.0 / np.sqrt(mass)
    if dice.random() < 0.5:
        table = {"frequency [Hz]": frequency, "damping_ratio": ratio}
    else:
        stiff = omega**2 * (1.0 if count == 1 else (np.arange(count) >= (dice.random() < 0.2)))
        table = {
            "stiffness [N/m]": stiff * mass * scale**2,
            "damping [N*s/m]": 2.0 * ratio * omega * mass * scale**2,
        }
    if np.all(scale == 1.0):
        table["modal_mass [kg]"] = mass
    table["uy"] = dice.normal(size=count) * scale
    if dice.random() < 0.5:
        table["ux"] = dice.normal(size=count) * scale
    else:
        table["rotation [rad/m]"] = 50.0 * dice.normal(size=count) * scale
    for e in range(electrodes):
        table[f"coupling_{e + 1} [N/V]"] = dice.log(0.01, 1.0) * dice.normal(size=count) * scale
    if dice.random() < 0.2:
        table["point_end"] = dice.normal(size=count) * scale
    return table


def _drive(dice: Dice, signal: str, electrodes: int, duration: float) -> tuple[Values, Table]:
    """The numbers of a drive and its file's table, empty where it has none."""
    frequency = dice.sometimes(None, dice.log(500.0, 2e4), 0.4)
    phase = dice.between(-np.pi, np.pi)
    volts = [dice.sometimes(0.0, dice.log(20.0, 2000.0)) for _ in range(electrodes)]
    if signal == "sampled":
        degree = {"linear": 1, "cubic": 3, "quintic": 5, "septic": 7}
        name = dice.choose(dict.fromkeys(degree, 0.25))
        count, length = int(dice.log(degree[name] + 1.0, 200.0)) + 1, duration * dice.log(0.1, 1.5)
        time = length * np.sort(np.append([0.0, 1.0], dice.random(count - 2)))
        if degree[name] > 3 or dice.random() < 0.5:
            # Splines of a high degree through uneven samples overshoot without bounds.
            time = np.linspace(0.0, length, count)
        period = dice.sometimes(None, length * dice.between(1.05, 1.5), 0.5)
        table = {"time [s]": time}
        table |= {f"voltage_{e + 1} [V]": 0.3 * u * dice.normal(size=count) for e, u in enumerate(volts)}
        return {"drive.interpolation": name, "drive.period": period}, table
    if signal == "tones":
        count = int(dice.integers(1, 6))
        table = {"frequency [Hz]": np.exp(dice.uniform(np.log(500.0), np.log(2e4), count))}
        for e, u in enumerate(volts):
            table[f"voltage_{e + 1} [V]"] = u / count * dice.random(count)
            table[f"phase_{e + 1} [rad]"] = dice.uniform(-np.pi, np.pi, count)
        return {}, table
    values: Values = {"drive.voltage_1": volts[0], "drive.voltage_2": volts[1], "drive.phase": phase}
    if signal == "chirp":
        values |= {f"drive.{which}_frequency": dice.log(200.0, 2e4) for which in ("first", "last")}
        return values | {"drive.duration": duration * dice.log(0.2, 2.0)}, {}
    values["drive.frequency"] = frequency
    if signal == "two_mode":
        ratio = float(dice.choice([1.0, 1.5, 2.0, 3.0]))
        values["drive.frequency_ratio"] = dice.sometimes(ratio, dice.log(0.01, 10.0), 0.5)
    return values, {}


def _changes(dice: Dice, values: Values) -> Iterator[str]:
    """One to three changes of what may change, of one to three keys each."""
    drawn: dict[str, tuple[float, float]] = {
        "drive.voltage_1": (0.0, 1000.0),
        "drive.voltage_2": (0.0, 1000.0),
        "drive.phase": (-3.0, 3.0),
        "drive.frequency": (500.0, 8000.0),
        "contact.preload": (0.0, 30.0),
    }
    drawn = {key: span for key, span in drawn.items() if key in values}
    drawn |= {"rotor.load_torque": (-1e-2, 1e-2), "rotor.damping": (0.0, 1e-3)}
    for time in np.sort(dice.uniform(0.05, 0.95, dice.integers(1, 4))).tolist():
        keys = dice.choice([*drawn], size=min(int(dice.integers(1, 4)), len(drawn)), replace=False)
        pairs = [f"{key}={dice.between(*drawn[str(key)])!r}" for key in keys]
        yield "; ".join([repr(time * values["solver.duration"]), *pairs])


def _written(path: Path, table: Table) -> str:
    """Write a table where it is not there yet, whole or not at all, and return its path."""
    rows = zip(*(column.tolist() for column in table.values()), strict=True)
    text = "\n".join([",".join(table), *(",".join(map(repr, row)) for row in rows), ""])
    if not path.is_file() or path.read_text() != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(f".{os.getpid()}")
        part.write_text(text)
        part.replace(path)
    return str(path)


def _law_values(groups: Mapping[str, str], dice: Dice) -> Values:
    """Every parameter of the law by its key: near its default, or anywhere in a finite range.

    One that is none by default stays so: viscous friction, a dashpot along a spring.
    """
    owners: dict[str, Any] = {"law": law_class(groups["law"])}
    owners |= {
        f"law.{family}": parts[groups[f"law/{family}"]]
        for family, parts in PARTS.items()
        if f"law/{family}" in groups
    }
    values: Values = {}
    for prefix, owner in owners.items():
        for name, member in members_of(owner).items():
            text, key = member.parameter, f"{prefix}.{name}"
            if text is None or name == SHARED or member.default is None:
                continue
            low, high = max(text.above, text.at_least), min(text.below, text.at_most)
            low = ACHIEVED.get(key, {}).get(owner.name, low)
            if isfinite(low) and isfinite(high):
                value = low + (high - low) * dice.between(0.02, 0.98)
            else:
                value = member.default * 10.0 ** dice.between(-1.0, 1.0)
                value = max(value, low if text.admits(low) else value)
            # A number of elements is a whole one.
            values[key] = float(value) if float in member.kinds else round(value)
    if "law.normal.unloading_stiffness" in values:
        # Unloading is the stiffer one.
        values["law.normal.unloading_stiffness"] = values["law.normal.loading_stiffness"] * dice.log(
            1.0, 10.0
        )
    return values
