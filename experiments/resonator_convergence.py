"""How many modes a contact needs: the paper's basis and finite elements against many corrected modes.

    python experiments/resonator_convergence.py [--placement 1|2] [--frequency HZ] [--csv FILE]

Every row is one resonator in the same motor: 5 ms from rest, `hertz_penalty` at 1e10 N/m^1.5, friction 0.3,
clearance 1 um, 100 V at the frequency and its double. Without --frequency it is the converged first
natural frequency. The effective mass is what a force of infinite frequency moves at the tip.
"""

import argparse
import csv
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from math import pi
from pathlib import Path
from typing import final

import numpy as np

from contactlab.drive import Drive
from contactlab.engine import simulate
from contactlab.laws import HertzPenalty
from contactlab.motor import Motor
from contactlab.resonator import FiniteElementResonator, NormalModes, RitzResonator

PLACEMENTS = {
    1: {"patch_start": 15.968e-3, "patch_end": 25.065e-3},
    2: {"patch_start": 0.914e-3, "patch_end": 10.146e-3},
}
SHAPES = (4, 8, 16, 40)
KEPT = (1, 2, 4, 6, 8, 12, 24)


@final
@dataclass(frozen=True)
class Row:
    """One resonator and what its motor does; SI units."""

    resonator: str
    oscillators: int
    first_frequency: float
    second_frequency: float
    tip_compliance: float
    effective_mass: float
    peak_normal_force: float
    normal_impulse: float
    rotor_velocity: float


def resonators(placement: int) -> Iterator[tuple[str, NormalModes]]:
    """Every resonator that is compared, the reference last."""
    patches = PLACEMENTS[placement]
    for shapes in SHAPES:
        yield f"ritz {shapes}", RitzResonator(shapes=shapes, **patches).modes
    for kept in KEPT:
        for correction, word in ((False, "truncated"), (True, "corrected")):
            resonator = FiniteElementResonator(
                kept_modes=kept, static_correction=correction, **patches
            )
            yield f"finite_element {kept} {word}", resonator.modes


def measure(name: str, modes: NormalModes, frequency: float, duration: float = 5e-3) -> Row:
    """Run the motor on one resonator."""
    drive = Drive.two_mode(100.0, 100.0, frequency, 2.0, -pi / 5.0)
    law = HertzPenalty(stiffness=1e10, friction_coefficient=0.3)
    run = simulate(Motor(modes, drive), law, duration=duration, record_interval=1e-5)
    natural = np.append(modes.natural_frequency, np.nan)
    return Row(
        resonator=name,
        oscillators=modes.stiffness.size,
        first_frequency=float(natural[0]),
        second_frequency=float(natural[1]),
        tip_compliance=float(np.sum(modes.tip_displacement**2 / modes.stiffness)),
        effective_mass=float(1.0 / np.sum(modes.tip_displacement**2)),
        peak_normal_force=float(run.contacts["peak_normal_force"].max(initial=0.0)),
        normal_impulse=float(run.contacts["normal_impulse"].sum()),
        rotor_velocity=float(run.series["rotor_velocity"][-1]),
    )


def show(rows: Sequence[Row]) -> None:
    """Print one row a resonator."""
    print(
        f"{'':28s}{'f1 Hz':>10s}{'f2 Hz':>10s}{'um/N':>10s}{'mass g':>9s}"
        f"{'peak N':>10s}{'mN s':>11s}{'rad/s':>12s}"
    )
    for row in rows:
        print(
            f"{row.resonator:28s}{row.first_frequency:10.2f}{row.second_frequency:10.2f}"
            f"{1e6 * row.tip_compliance:10.6f}{1e3 * row.effective_mass:9.4f}"
            f"{row.peak_normal_force:10.5f}{1e3 * row.normal_impulse:11.6f}"
            f"{row.rotor_velocity:12.7f}"
        )


def main(arguments: Sequence[str]) -> int:
    """Measure and print; the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--placement", type=int, choices=sorted(PLACEMENTS), default=2)
    parser.add_argument("--frequency", type=float, help="first tone [Hz]")
    parser.add_argument("--csv", type=Path, help="write the table to this file as well")
    options = parser.parse_args(arguments)
    converged = FiniteElementResonator(**PLACEMENTS[options.placement]).modes
    frequency = options.frequency or float(converged.natural_frequency[0])
    rows = [measure(name, modes, frequency) for name, modes in resonators(options.placement)]
    show(rows)
    if options.csv is not None:
        with options.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, [field.name for field in fields(Row)])
            writer.writeheader()
            writer.writerows(asdict(row) for row in rows)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
