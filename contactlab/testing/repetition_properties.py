"""Properties of what a law's run has in common with another: the same again, cut, recorded or in a mirror."""

from dataclasses import replace
from typing import Any

import numpy as np

from contactlab.engine import simulate
from contactlab.laws.base import FREE
from contactlab.laws.memory import ODD
from contactlab.motor.motor import Motor
from contactlab.testing.claim import Claims, at_most
from contactlab.testing.flow_properties import image_of
from contactlab.testing.plants import MOTOR_DURATION, Bench, completed
from contactlab.trajectory import Trajectory

RECORDS = 150
"""Intervals of a run that is cut, or recorded coarsely."""


def repeats_bit_for_bit(bench: Bench) -> Claims:
    """A run that is repeated has the same bits."""
    result = _differing(bench, bench.motor)
    yield at_most(f"quantities that differ when run again {result}", len(result), 0)


def goes_on(bench: Bench) -> Claims:
    """A run that is cut within a contact and goes on is the one that was not, in all that is recorded."""
    whole, interval = _coarsely(bench), MOTOR_DURATION / RECORDS
    touching = np.flatnonzero(whole.contact_mode[:-1] != FREE)
    at = int(touching[2 * touching.size // 3]) if touching.size else RECORDS // 2
    first = _coarsely(bench, max(at, 1) * interval)
    second = _coarsely(bench, MOTOR_DURATION - max(at, 1) * interval, first.state)
    records = len(second.time)
    unlike = [n for n, x in second.series.items() if not np.array_equal(x, whole.series[n][-records:])]
    ended = int(np.isfinite(first.contacts["separation_velocity"]).sum())
    for name, values in whole.contacts.items():
        parts = np.append(first.contacts[name][:ended], second.contacts[name])
        unlike += [] if np.array_equal(parts, values, equal_nan=True) else [f"{name} of the contacts"]
    yield at_most(f"quantities that differ when a run is cut {unlike}", len(unlike), 0)


def records_change_nothing(bench: Bench) -> Claims:
    """Two runs that are recorded at other intervals have the same contacts and the same end."""
    fine, coarse = completed(bench.motor_run), _coarsely(bench)
    unlike = [
        name
        for name, values in fine.contacts.items()
        if not np.array_equal(values, coarse.contacts[name], equal_nan=True)
    ]
    for name in ("displacement", "velocity"):
        if not np.array_equal(getattr(fine.final, name), getattr(coarse.final, name)):
            unlike.append(name)
    yield at_most(f"quantities that differ with the record interval {unlike}", len(unlike), 0)


def _coarsely(bench: Bench, duration: float = MOTOR_DURATION, start: Any = None) -> Trajectory:
    """Run a bench's motor with few records, from a state that it goes on from where there is one."""
    steps: dict[str, Any] = {"contact_step": bench.step, "record_interval": MOTOR_DURATION / RECORDS}
    return completed(simulate(bench.motor, bench.law, duration=duration, start=start, **steps))


def mirrors(bench: Bench) -> Claims:
    """Left and right exchanged, and with them the sign of what is along the rotor and of odd variables."""
    yield from image_of(bench).values()
    motor, rotor = bench.motor, bench.motor.rotor
    velocity, torque = -rotor.initial_velocity, -rotor.load_torque
    modes = replace(motor.modes, tip_slope=-motor.modes.tip_slope)
    turned = replace(rotor, initial_velocity=velocity, load_torque=torque)
    geometry = replace(motor.geometry, angle=-motor.geometry.angle)
    moving = ("tip_tangential_displacement", "tip_slope", "rotor_velocity", "rotor_angle")
    odd = [f"internal_{each.name}" for each in bench.law.internal_variables if each.parity == ODD]
    signed = (*moving, "slip_velocity", "friction_force", "friction_impulse", *odd)
    result = _differing(bench, replace(motor, modes=modes, rotor=turned, geometry=geometry), signed)
    yield at_most(f"quantities that differ in the mirror {result}", len(result), 0)


def _differing(bench: Bench, motor: Motor, mirrored: tuple[str, ...] = ()) -> list[str]:
    """Name what another motor's run has otherwise, but for the sign of some."""
    made, other = (
        {"contact_mode": each.contact_mode.astype(np.float64), **each.series, **each.contacts}
        for each in (completed(bench.motor_run), completed(bench.attempt_motor(motor)))
    )
    signs = {name: -1.0 if name in mirrored else 1.0 for name in made}
    return [n for n in made if not np.array_equal(made[n], signs[n] * other[n], equal_nan=True)]
