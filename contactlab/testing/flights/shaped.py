"""Flights that are made to pass an instant in a given way: the drive is solved for."""

import numpy as np
from numpy.typing import NDArray

from contactlab.motor import NormalModes
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.testing.flights.closed import Flight, flight_of

Array = NDArray[np.float64]
Phasors = NDArray[np.complex128]


def drive_through(modes: NormalModes, frequency: Array, when: float, u: Array, th: Array) -> Drive:
    """The weakest drive whose tip, from rest, has these derivatives at an instant.

    The motion is linear in the phasors, so that they follow from a linear system of least norm.

    Args:
        modes: the resonator.
        frequency: of the tones [Hz], shape (tone,); there are four real unknowns to each.
        when: the instant [s].
        u, th: derivatives of order 0, 1, ... [m/s^n], [rad/s^n], equally many; NaN leaves one free.
    """
    order = np.arange(u.size)
    units: Phasors = np.eye(2 * frequency.size, dtype=np.complex128)
    units = np.concatenate([units, 1j * units]).reshape(-1, 2, frequency.size)
    answers = []
    for unit in units:
        flight = flight_of(Motor(modes, Drive(frequency, unit)))
        waves = np.exp(flight.exponents * when)[:, None] * flight.exponents[:, None] ** order
        answers.append(np.concatenate([(flight.u @ waves).real, (flight.th @ waves).real]))
    # Derivatives in the time of the fastest tone, so that all are of one size.
    scale = np.tile((2.0 * np.pi * frequency.max()) ** -order.astype(np.float64), 2)
    wanted = np.concatenate([u, th])
    given = ~np.isnan(wanted)
    system = (np.array(answers).T * scale[:, None])[given]
    sizes = np.linalg.lstsq(system, (wanted * scale)[given], rcond=None)[0]
    phasors: Phasors = np.tensordot(sizes, units, axes=1)
    return Drive(frequency, phasors)


def double_well(
    modes: NormalModes, frequency: Array, when: float, half: float, barrier: float, tilt: float
) -> Flight:
    """A flight whose gap has two minima, `half` before and after an instant, that stand at zero.

        g(when + x) = barrier ((x/half)^2 - 1)^2 + tilt x / half

    to the fifth order, and the slope th stays zero as long. Between the minima the gap bends down;
    steps that see only its ends see nothing of it.

    Args:
        modes: the resonator.
        frequency: of the tones [Hz], three and more.
        when, half: [s], half a small part of the fastest period.
        barrier, tilt: [m]; the second minimum lies above the first by twice the tilt.
    """
    shape = np.array([0.0, tilt, -4.0 * barrier, 0.0, 24.0 * barrier, 0.0])
    u = -shape / half ** np.arange(6.0)
    u[0] = np.nan
    drive = drive_through(modes, frequency, when, u, np.zeros(6))
    return flight_of(Motor(modes, drive)).with_clearance(1e-4).lowered_to(barrier, when)
