"""Response of a motor along a branch of orbits: mean, amplitude and phase of a recorded quantity.

Of a quantity x of an orbit they are those of x_0 + Re X exp(i omega t), its mean and its part at the drive's
first tone, by the discrete Fourier transform of its samples. The phase is that of X over the tone's.
"""

from typing import Any, Final

import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, Setup
from contactlab.motor.drive import Drive
from contactlab.steady_state.branches import Branch
from contactlab.steady_state.continuation import BranchPoint
from contactlab.steady_state.period_map import period_of
from contactlab.steady_state.state import CUMULATIVE, OF_INTERVALS
from contactlab.suggestion import suggestion
from contactlab.variables import SERIES

SAMPLES: Final = 512
"""Records in a period of the drive's first tone. Harmonics of a motion with kinks of its acceleration fall as
1/k^3, so that what is folded onto the first is some 1e-8 of it."""

READ: Final = {
    each.name: each for each in SERIES if each.name not in (*CUMULATIVE, "contact_mode", "energy_residual")
}
"""Recorded quantities that a response may be of, by name."""

PARTS: Final = {"mean": "mean", "amplitude": "amplitude at the first tone", "phase": "phase over the drive's"}


def check_quantity(name: str) -> None:
    """Refuse a quantity that has no response.

    Raises:
        ConfigurationError: it is not recorded, or it adds up over a run.
    """
    if name not in READ:
        known = suggestion(name, READ, f"It must be one of {', '.join(READ)}.")
        raise ConfigurationError(f"study.quantity is {name!r}, of which there is no response. {known}")


def first_tone(drive: Drive) -> tuple[float, complex]:
    """Return angular frequency [rad/s] and unit phasor of the first tone that a drive has.

    The phasor is that of the first electrode on which the tone is.

    Raises:
        ConfigurationError: there is none.
    """
    heard = np.argwhere((drive.phasors != 0.0).T)
    if not len(heard):
        raise ConfigurationError(
            "The drive has no tone; amplitude and phase are those at its first one. Give it a voltage."
        )
    tone, electrode = heard[0]
    phasor = drive.phasors[electrode, tone]
    return float(drive.angular_frequency[tone]), complex(phasor / abs(phasor))


def harmonic(point: BranchPoint, quantity: str, samples: int = SAMPLES) -> tuple[float, complex]:
    """Return the mean of a quantity over an orbit, and its part at the first tone over the tone's phasor.

    Args:
        point: the orbit.
        quantity: one of `READ`.
        samples: in a period of the first tone.
    """
    section = point.orbit.map
    drive = section.setup.motor.drive
    omega, tone = first_tone(drive)
    turns = round(omega * section.period / (2.0 * np.pi))
    run = section.run(point.orbit.state, 1.0, records=samples * turns)
    values = run.series[quantity]
    # From the section on; the last record is the first of the period that follows.
    time = run.time + section.phase * period_of(drive)
    if quantity in OF_INTERVALS:
        # Means over intervals are less than the value in their middle by the sinc of half of one.
        step = run.time[1] - run.time[0]
        values, time = values[1:] * (0.5 * omega * step / np.sin(0.5 * omega * step)), time[1:] - 0.5 * step
        mean = float(run.series[quantity][1:].mean())
    else:
        values, time = values[:-1], time[:-1]
        mean = float(values.mean())
    return mean, complex(2.0 * np.mean(values * np.exp(-1j * omega * time)) / tone)


def with_response(branch: Branch, quantity: str) -> xarray.Dataset:
    """Return a branch as a dataset, with mean, amplitude and phase of a quantity at each orbit.

    The phase is continuous along the branch and begins within half a turn.
    """
    check_quantity(quantity)
    data, units = branch.to_xarray(), READ[quantity].units
    means, parts = map(np.array, zip(*(harmonic(point, quantity) for point in branch.points), strict=True))
    _write(data, "point", quantity, units, means, parts)
    return data


def linear_response(setup: Setup, quantity: str) -> complex | None:
    """Return the part at the first tone of a quantity of the free motor, over the tone's phasor.

    None where the quantity is not one of the tip's motion, and where an undamped mode is in resonance.
    """
    motor = setup.motor
    (omega, tone), (normal, along) = first_tone(motor.drive), motor.rows_at_rest
    # What makes the quantity of small normal coordinates.
    rows: dict[str, NDArray[Any]] = {
        "tip_normal_displacement": motor.modes.approach,
        "tip_tangential_displacement": -motor.geometry.tip_length * motor.modes.tip_slope,
        "tip_slope": motor.modes.tip_slope,
        "gap": normal,
        "slip_velocity": 1j * omega * along,
    }
    if quantity not in rows:
        return None
    modes, number = motor.modes, int(np.argmin(np.abs(motor.drive.angular_frequency - omega)))
    stiffness = modes.stiffness - omega**2 + 1j * modes.damping * omega
    force = motor.force_phasors[:, number]
    # A mode without a force does not move, be it rigid or in resonance.
    moved = force != 0.0
    if not np.all(stiffness[moved] != 0.0):
        return None
    return complex(rows[quantity][moved] @ (force[moved] / stiffness[moved]) / tone)


def linear_dataset(
    setups: list[Setup], values: Array, quantity: str, about: dict[str, str]
) -> xarray.Dataset:
    """Return amplitude and phase of the free motors of a parameter's values, where they are known."""
    parts = [linear_response(setup, quantity) for setup in setups]
    known = np.array([part is not None for part in parts], dtype=bool)
    data = xarray.Dataset({"value": ("sample", values[known], about)})
    _write(
        data, "sample", quantity, READ[quantity].units, None, np.array([p for p in parts if p is not None])
    )
    return data


def _write(
    data: xarray.Dataset, over: str, quantity: str, units: str, means: Array | None, parts: Array
) -> None:
    """Write mean, amplitude and phase of a quantity into a dataset."""
    values = {"amplitude": np.abs(parts), "phase": np.unwrap(np.angle(parts))}
    values = values if means is None else {"mean": means, **values}
    for name, each in values.items():
        text = f"{PARTS[name]} of the {quantity.replace('_', ' ')}"
        data[name] = (over, each, {"units": "rad" if name == "phase" else units, "long_name": text})
    data.attrs["quantity"] = quantity
