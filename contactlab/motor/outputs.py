"""What a run records beside tip and rotor: charge and current of every electrode, and points by name.

    Q = C_p U + coupling' q,    I = dQ/dt,    x = row' q of a point

with C_p (1 - i tan delta) under tones: what the dielectric's loss takes is in phase with the voltage. It is
the transpose of the forces of the actuator equation, so that sum_e int U_e dQ_e is the work of the drive,
what the capacitance stores, and the dielectric's loss. Where a waveform jumps, the current has no value: the
one recorded is that of the piece which follows.

Source: Andersen, Blanke and Helbo (2001), eqs. 19, 20, 26 and 32.
"""

from itertools import chain

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.motor.motor import Motor, NormalModes
from contactlab.variables import Variable, of_electrode, of_point


def output_rows(motor: Motor) -> tuple[Array, NDArray[np.complex128]]:
    """Return what is read of the modes, (output, mode), and of the tones with its rate, (output, 2, tone).

    Electrodes of known capacitance come first, then points.
    """
    modes, drive = motor.modes, motor.drive
    electrodes = [] if modes.capacitance is None else list(modes.coupling.T)
    rows = [*electrodes, *modes.points.values()]
    phasors = np.zeros((len(rows), 2, drive.frequency.size), np.complex128)
    if modes.capacitance is not None and drive.voltages:
        charge = (1.0 - 1j * modes.loss_tangent) * (modes.capacitance @ drive.phasors)
        phasors[: len(electrodes), 0], phasors[: len(electrodes), 1] = (
            charge,
            1j * drive.angular_frequency * charge,
        )
    return np.array(rows).reshape(len(rows), modes.stiffness.size), phasors


def output_variables(modes: NormalModes) -> tuple[Variable, ...]:
    """Return the recorded variables, two for every row."""
    electrodes = 0 if modes.capacitance is None else modes.coupling.shape[1]
    pairs = [*map(of_electrode, range(1, electrodes + 1)), *map(of_point, modes.points)]
    return tuple(chain.from_iterable(pairs))


def output_series(motor: Motor, time: Array, read: Array) -> dict[str, Array]:
    """Return the recorded series by name, from what was read at the times.

    Args:
        motor: whose modes and voltages they are.
        time: [s], shape (time,).
        read: of modes and tones, and its rates, shape (time, output, 2); it becomes the series' memory.
    """
    modes, waveform = motor.modes, motor.drive.waveform
    columns = read.reshape(len(time), -1).T
    if modes.capacitance is not None and waveform is not None:
        for order in (0, 1):
            # Without a matrix product, whose last bits depend on how many times there are.
            for column, voltage in zip(modes.capacitance.T, waveform.voltage(time, order), strict=True):
                columns[order : 2 * column.size : 2] += np.multiply.outer(column, voltage)
    return dict(zip((each.name for each in output_variables(modes)), columns, strict=True))


def dielectric_loss(motor: Motor) -> float:
    """Return the power that heats the patches' dielectric, sum omega C_p tan(delta) U^2 / 2 [W].

    The sum runs over electrodes and frequencies; tones of one frequency are one tone.
    """
    modes, drive = motor.modes, motor.drive
    if modes.loss_tangent == 0.0:
        return 0.0
    if modes.capacitance is None:
        return float("nan")
    frequencies, which = np.unique(drive.frequency, return_inverse=True)
    phasors = np.zeros((len(drive.phasors), frequencies.size), dtype=complex)
    np.add.at(phasors.T, which, drive.phasors.T)
    energy = np.einsum("ek,ef,fk->k", phasors.conj(), modes.capacitance, phasors).real
    return float(np.pi * modes.loss_tangent * frequencies @ energy)
