"""A trajectory that looks like a run of the paper's motor, from closed forms alone.

The tip end draws a figure of eight, touches the rotor once a drive period, and every contact
pushes with a half sine of 9 N and turns the rotor a step further: slip, stick, slip.
"""

import numpy as np
from numpy.typing import NDArray

from contactlab import variables
from contactlab.laws import HertzPenalty
from contactlab.motor import RitzResonator
from contactlab.motor.drive import Drive
from contactlab.motor.motor import ModalState, Motor
from contactlab.motor.outputs import output_series
from contactlab.trajectory import Ending, Trajectory

Array = NDArray[np.float64]

FREQUENCY = 3210.0
PEAK_FORCE = 9.0
CONTACT_DURATION = 60e-6
FINAL_VELOCITY = -0.45
STICK_SHARE = (0.35, 0.6)
"""Where within a contact the tip sticks, as shares of its duration."""

CONFIGURATION: dict[str, object] = {
    "law": {"name": "hertz_penalty", "stiffness": 1e10},
    "contact": {"clearance": 1e-6, "friction_coefficient": 0.3, "tip_length": 19e-3},
    "rotor": {"radius": 25e-3, "inertia": 4.8e-5},
    "drive": {"frequency": FREQUENCY, "voltage_1": 100.0, "voltage_2": 100.0},
    "solver": {"duration": 5e-3, "contact_step": 2e-6},
    "record": {"interval": 1e-6},
}


def synthetic_trajectory(
    duration: float = 5e-3,
    interval: float = 1e-6,
    contact: bool = True,
    ending: Ending = Ending.COMPLETE,
    message: str = "",
) -> Trajectory:
    """A run of `duration` [s], recorded every `interval` [s], with or without any contact."""
    records = int(np.ceil(duration / interval - 1e-9))
    time = np.minimum(np.arange(records + 1) * interval, duration)
    starts = np.arange(1, int(duration * FREQUENCY) + 1) / FREQUENCY - 120e-6
    starts = starts[starts + CONTACT_DURATION <= duration] if contact else starts[:0]
    kinematics = _kinematics(time, starts)
    series = kinematics | _forces(time, starts) | _energies(time)
    motor = Motor(RitzResonator().modes, Drive.two_mode(100.0, 100.0, FREQUENCY))
    outputs = output_series(motor, time, np.zeros((time.size, motor.modes.coupling.shape[1], 2)))
    return Trajectory(
        motor=motor,
        law=HertzPenalty(stiffness=1e10, friction_coefficient=0.3),
        duration=duration,
        contact_step=2e-6,
        record_interval=interval,
        time=time,
        series={variable.name: series[variable.name] for variable in variables.SERIES} | outputs,
        contact_mode=_modes(time, starts),
        contacts=_contacts(starts),
        statistics={"free_flights": starts.size + 1, "contact_steps": 30 * starts.size},
        ending=ending,
        message=message,
        final=ModalState(*np.zeros((2, 0))),
    )


def _share(time: Array, starts: Array) -> tuple[NDArray[np.intp], Array]:
    """Which contact a time follows, counted from 0 (-1: none yet), and its share gone by."""
    index = np.searchsorted(starts, time, side="right") - 1
    if not starts.size:
        return index, np.ones_like(time)
    return index, (time - starts[np.maximum(index, 0)]) / CONTACT_DURATION


def _rotor_velocity(time: Array, starts: Array) -> Array:
    index, share = _share(time, starts)
    levels = FINAL_VELOCITY * (1.0 - np.exp(-np.arange(starts.size + 1) / 4.0))
    before, after = levels[np.maximum(index, 0)], levels[index + 1]
    blend = 0.5 - 0.5 * np.cos(np.pi * np.clip(share, 0.0, 1.0))
    return np.where(index < 0, 0.0, before + (after - before) * blend)


def _kinematics(time: Array, starts: Array) -> dict[str, Array]:
    envelope = 1.0 - np.exp(-time / 150e-6)
    # The crest of the tip's oscillation lies in the middle of every contact.
    phase = 2.0 * np.pi * FREQUENCY * (time + 90e-6)
    slope = envelope * 1.26e-4 * np.sin(2.0 * phase + 0.5)
    normal = envelope * (1.95e-6 * np.cos(phase) - 0.45e-6)
    index, share = _share(time, starts)
    touching = (index >= 0) & (share < 1.0)
    depth = 0.9e-6 * np.sin(np.pi * np.clip(share, 0.0, 1.0))
    gap = np.where(touching, -depth, np.maximum(1e-6 - normal, 1e-9))
    velocity = _rotor_velocity(time, starts)
    return {
        "tip_normal_displacement": np.where(touching, 1e-6 + depth, np.minimum(normal, 1e-6)),
        "tip_tangential_displacement": -19e-3 * np.sin(slope),
        "tip_slope": slope,
        "gap": gap,
        "slip_velocity": 0.05 * np.cos(2.0 * phase) - 25e-3 * velocity,
        "rotor_velocity": velocity,
        "rotor_angle": np.concatenate(
            ([0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time)))
        ),
    }


def _forces(time: Array, starts: Array) -> dict[str, Array]:
    """Means over the intervals of half-sine forces, exact at any interval."""
    index, share = _share(time, starts)
    done = np.maximum(index, 0) + 0.5 - 0.5 * np.cos(np.pi * np.clip(share, 0.0, 1.0))
    impulse = np.where(index < 0, 0.0, 2.0 / np.pi * PEAK_FORCE * CONTACT_DURATION * done)
    velocity = _rotor_velocity(time, starts)
    normal = np.diff(impulse) / np.diff(time) if starts.size else np.zeros(time.size - 1)
    friction = -4.8e-5 / 25e-3 * np.diff(velocity) / np.diff(time)
    return {
        "normal_force": np.concatenate(([0.0], normal)),
        "friction_force": np.concatenate(([0.0], friction)),
    }


def _energies(time: Array) -> dict[str, Array]:
    stored = 1e-3 * (1.0 - np.exp(-time / 150e-6))
    names = ("damping_loss", "friction_loss", "contact_loss", "load_work")
    losses = {name: rate * time for name, rate in zip(names, (2.0, 0.5, 0.0, 0.0), strict=True)}
    residual = 1e-13 * np.sin(1e3 * time)
    return {
        "kinetic_energy": 0.6 * stored,
        "strain_energy": 0.4 * stored,
        "contact_energy": np.zeros_like(time),
        "drive_work": stored + sum(losses.values()) - residual,
        "energy_residual": residual,
        **losses,
    }


def _modes(time: Array, starts: Array) -> NDArray[np.int8]:
    index, share = _share(time, starts)
    touching = (index >= 0) & (share < 1.0)
    sticking = touching & (share >= STICK_SHARE[0]) & (share < STICK_SHARE[1])
    return (touching.astype(np.int8) + sticking).astype(np.int8)


def _contacts(starts: Array) -> dict[str, Array]:
    every = np.ones_like(starts)
    velocity = _rotor_velocity(np.concatenate((starts, starts + CONTACT_DURATION)), starts)
    change = velocity[starts.size :] - velocity[: starts.size]
    separation = 0.05 * every
    # The run ends while the last contact lasts, for all that its table can say.
    separation[-1:] = np.nan
    return {
        "start_time": starts,
        "duration": CONTACT_DURATION * every,
        "stick_duration": (STICK_SHARE[1] - STICK_SHARE[0]) * CONTACT_DURATION * every,
        "normal_impulse": 2.0 / np.pi * PEAK_FORCE * CONTACT_DURATION * every,
        "friction_impulse": -4.8e-5 / 25e-3 * change,
        "peak_normal_force": PEAK_FORCE * every,
        "max_penetration": 0.9e-6 * every,
        "approach_velocity": -0.05 * every,
        "separation_velocity": separation,
        "energy_loss": 3e-7 * every,
    }
