"""Prescribed motions of a table, a base or a tip beside a free body: harmonic, sawtooth, or any waveform."""

from dataclasses import dataclass, replace
from math import pi
from typing import Annotated, Final, TypeAlias, final

import numpy as np
import scipy

from contactlab.checks import Checked, check_shape
from contactlab.motor.drive import Drive
from contactlab.motor.waveform import MOST_DEGREE, Waveform
from contactlab.parameter import Parameter, positive

SMOOTH: Final = 1e-9
"""Jump of a displacement or a velocity, over its largest value, that is round-off [1]."""

FOREVER: Final = 1e9
"""Time for which a motion goes on as it ended [s]: longer than any run."""

_FREQUENCY: Final = positive("f", "Hz", "frequency")


@final
@dataclass(frozen=True)
class Vibration(Checked):
    """Harmonic displacement x = A cos(2 pi f t + phi), of the peak acceleration A (2 pi f)^2.

    >>> Vibration("0.1 mm", 50.0).drive().frequency.tolist()
    [50.0]
    """

    amplitude: Annotated[float, positive("A", "m", "amplitude")] = 1e-4
    frequency: Annotated[float, _FREQUENCY] = 50.0
    phase: Annotated[float, Parameter("phi", "rad", "phase", at_least=-1e6, at_most=1e6, usual=(-pi, pi))] = (
        0.0
    )

    def drive(self) -> Drive:
        """Return the displacement as a drive of one electrode."""
        phasor = self.amplitude * np.exp(1j * self.phase)
        return Drive(np.array([self.frequency]), np.array([[phasor]]))


@final
@dataclass(frozen=True)
class Sawtooth(Checked):
    """Displacement of two straight flanks, by S up over a share r of the period and down over the rest.

    The corners between the velocities S f / r and -S f / (1 - r) are parabolas over a share c of the period
    each, half of it on either side, so that the peak-to-peak value is S (1 - c): at a corner without them the
    acceleration is infinite. It begins in the middle of the first flank, at zero.

        >>> sawtooth = Sawtooth("1 um", "1 kHz", rise=0.9, corner=0.01).drive().waveform
        >>> sawtooth.voltage(0.0, order=1) * 0.9 / 1e3
        array([1.e-06])
    """

    stroke: Annotated[
        float, positive("S", "m", "height of the flanks, of which a corner cuts c S / (8 r (1 - r))")
    ] = 1e-6
    frequency: Annotated[float, _FREQUENCY] = 1e3
    rise: Annotated[float, positive("r", "1", "share of the period in the first flank", below=1.0)] = 0.9
    corner: Annotated[float, positive("c", "1", "share of the period in each corner", at_most=0.1)] = 0.01

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.corner >= min(self.rise, 1.0 - self.rise):
            raise ValueError(
                f"corner is {self.corner}; it must be less than rise, {self.rise}, and than the rest of the "
                "period, so that there are flanks between the corners."
            )

    def drive(self) -> Drive:
        """Return the displacement as a drive of one electrode."""
        # Piecewise linear velocities, from the middle of the rise on.
        up, down = self.stroke / self.rise, -self.stroke / (1.0 - self.rise)
        half = 0.5 * self.corner
        top, bottom = 0.5 * self.rise, 1.0 - 0.5 * self.rise
        edges = np.array([0.0, top - half, top + half, bottom - half, bottom + half, 1.0])
        velocity = np.array([up, up, down, down, up, up]) * self.frequency
        time = edges / self.frequency
        slope = np.diff(velocity) / np.diff(time)
        pieces = scipy.interpolate.PPoly(np.stack([slope, velocity[:-1]])[:, :, None], time)
        return Drive(
            phasors=np.zeros((1, 0), np.complex128), waveform=Waveform(pieces, periodic=True).integral()
        )


Motion: TypeAlias = Vibration | Sawtooth | Waveform
"""Displacement over time of what a body lies on; a `Waveform` of one row [m] goes on at its last velocity."""


def drive_of(name: str, motion: Motion) -> Drive:
    """Return a prescribed displacement as a drive of one electrode; it goes on beyond the ends of a waveform.

    Raises:
        ValueError: a waveform has several rows, or displacement or velocity jump.
    """
    if not isinstance(motion, Waveform):
        return motion.drive()
    c, x = motion.pieces.c, motion.pieces.x
    check_shape(f"{name}.pieces.c", c, (-1, x.size - 1, 1), "one row")
    if not motion.periodic:
        # Lines before and after: place and velocity at either end.
        early = int(motion.start < x[0])
        edges = np.concatenate([[motion.start] if early else [], x, [x[-1] + FOREVER]])
        ends = np.stack([motion.pieces(x[[0, -1]], order)[:, 0] for order in (1, 0)])
        ends[1, 0] += ends[0, 0] * (edges[0] - x[0])
        lines = np.zeros((max(len(c), 2), edges.size - 1, 1))
        lines[-len(c) :, early:-1] = c
        lines[-2:, [0, -1] if early else [-1], 0] = ends if early else ends[:, 1:]
        motion = Waveform(scipy.interpolate.PPoly.construct_fast(lines, edges), start=motion.start)
    for what, pieces in {"displacement": motion.pieces, "velocity": motion.pieces.derivative()}.items():
        # Values where pieces end; of a motion that repeats itself, the first one follows the last.
        ends, lasts = np.zeros(pieces.x.size - 1), np.diff(pieces.x)
        for power in pieces.c[:, :, 0]:
            ends = ends * lasts + power
        counted = slice(None if motion.periodic else -1)
        starts = np.roll(pieces.c[-1, :, 0], -1)[counted]
        jumps = np.abs(starts - ends[counted])
        if (jumps > SMOOTH * np.abs(starts).max(initial=0.0)).any():
            at = pieces.x[1 + jumps.argmax()]
            raise ValueError(
                f"{name}: the {what} jumps by {jumps.max():.6g} at {at:.6g} s of the waveform; it must be "
                "continuous, as no force has a bound there. Join pieces by one of finite acceleration, as "
                "the corners of a Sawtooth."
            )
    return Drive(phasors=np.zeros((1, 0), np.complex128), waveform=motion)


def force_of(drive: Drive, stiffness: float, damping: float) -> Drive:
    """Return zdd + c zd + k z of a displacement z, with c [1/s] and k [1/s^2]."""
    rate = 1j * drive.angular_frequency
    phasors = drive.phasors * (rate**2 + damping * rate + stiffness)
    if (motion := drive.waveform) is None:
        return replace(drive, phasors=phasors)
    c = stiffness * motion.pieces.c
    for order, factor in ((1, damping), (2, 1.0)):
        if order < len(c):
            c[order:] += factor * motion.pieces.derivative(order).c
    return replace(drive, waveform=replace(motion, pieces=type(motion.pieces)(c, motion.pieces.x)))


def together(*drives: Drive) -> Drive:
    """Return a drive whose electrodes are those of several, in their order.

    Raises:
        ValueError: two waveforms have other times, or another period.
    """
    waveforms = [each.waveform for each in drives if each.waveform is not None]
    merged = waveforms[0] if waveforms else None
    if merged is not None:
        x, marks = merged.pieces.x, (merged.periodic, merged.start)
        same = ((w.periodic, w.start) == marks and np.array_equal(w.pieces.x, x) for w in waveforms)
        if not all(same):
            raise ValueError(
                "Two waveforms have pieces at other times; all that move a plant must have the same times, "
                "start and period. Sample them at the same times."
            )
        columns = np.zeros((MOST_DEGREE + 1, x.size - 1, sum(len(each.phasors) for each in drives)))
        first = 0
        for each in drives:
            if each.waveform is not None:
                c = each.waveform.pieces.c
                columns[-len(c) :, :, first : first + c.shape[2]] = c
            first += len(each.phasors)
        merged = replace(merged, pieces=scipy.interpolate.PPoly(columns, x))
    phasors = scipy.linalg.block_diag(*(each.phasors for each in drives)).astype(np.complex128)
    return Drive(np.concatenate([each.frequency for each in drives]), phasors, merged)
