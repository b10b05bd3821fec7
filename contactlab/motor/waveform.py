"""Voltages that are no sum of tones: samples, bursts and chirps, as polynomials in pieces."""

from dataclasses import dataclass, replace
from math import factorial
from typing import TYPE_CHECKING, Any, Final, final

import numpy as np
import scipy

from contactlab.arrays import Array
from contactlab.checks import check_kind, check_shape, checked_arguments
from contactlab.immutable import Immutable, read_only

if TYPE_CHECKING:
    # Not by its whole name: the dataclasses of Python 3.15 would import the module to look it up.
    from scipy.interpolate import PPoly

MOST_DEGREE: Final = 7
"""Highest degree of a piece; the engine has room for so many powers of time."""

MOST_SAMPLES: Final = 2_000_000
"""Samples of a waveform; each takes some 700 bytes with the polynomials through it."""

MEAN: Final = 1e-12
"""Mean over the largest value of a waveform that counts as none [1]."""

SAMPLED_TURN: Final = 0.3
"""Angle between samples of a formula [rad]: a spline of degree 7 misses a sine by 1e-10 of its amplitude."""


@final
@dataclass(frozen=True, eq=False)
class Waveform(Immutable):
    """Electrode voltages as polynomials in pieces.

        U_e(t) = sum_d c[d, i, e] (t' - x_i)^(D - d),  x_i <= t' < x_i+1,  t' = t + start

    The free motion under it is exact. Outside its pieces the voltage is zero, or it repeats itself. A jump
    from one piece to the next is allowed.

        >>> import contactlab as cl
        >>> import numpy as np
        >>> time = np.linspace(0.0, 1e-3, 201)
        >>> ramp = cl.Waveform.sampled(time, np.stack([1e5 * time, -1e5 * time]), degree=1)
        >>> ramp.voltage(np.array([0.5e-3, 2e-3])).tolist()
        [[50.0, 0.0], [-50.0, 0.0]]

    Args:
        pieces: coefficients c of shape (degree + 1, piece, electrode) and times x [s], increasing.
        periodic: whether it repeats itself after its last piece.
        start: time on its own clock at t = 0 [s].

    Raises:
        ValueError: shape, degree, or times that do not increase.
    """

    pieces: "PPoly"
    periodic: bool = False
    start: float = 0.0

    def __post_init__(self) -> None:
        check_kind("pieces", self.pieces, scipy.interpolate.PPoly)
        check_shape("pieces.c", self.pieces.c, (-1, -1, -1), "powers, pieces and electrodes")
        check_shape("pieces.x", self.pieces.x, (self.pieces.c.shape[1] + 1,), "one time more than pieces")
        if len(self.pieces.c) > MOST_DEGREE + 1:
            degree = len(self.pieces.c) - 1
            raise ValueError(f"The pieces have the degree {degree}; it must be at most {MOST_DEGREE}.")
        if not np.all(np.diff(self.pieces.x) > 0.0):
            raise ValueError("pieces.x does not increase; every piece must last longer than no time.")
        self.freeze()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Waveform):
            return NotImplemented
        mine, theirs = self.pieces, other.pieces
        same = np.array_equal(mine.c, theirs.c) and np.array_equal(mine.x, theirs.x)
        return same and (self.periodic, self.start) == (other.periodic, other.start)

    __hash__ = None

    def freeze(self) -> None:
        """Replace the pieces by some of their own, whose arrays are read-only."""
        c, x = read_only(self.pieces.c), read_only(self.pieces.x)
        pieces = scipy.interpolate.PPoly.construct_fast(c, x, extrapolate=self.pieces.extrapolate)
        object.__setattr__(self, "pieces", pieces)

    @classmethod
    @checked_arguments(period="s")
    def sampled(cls, time: Array, voltage: Array, degree: int = 3, period: float | None = None) -> "Waveform":
        """Return the interpolating spline of samples.

        Args:
            time: [s], increasing, shape (sample,).
            voltage: [V], shape (electrode, sample).
            degree: 1 joins them by lines; 3, 5 or 7 is smooth, with an error of the fourth, sixth or eighth
                order in the time between samples.
            period: after which the samples repeat themselves [s], later than the last of them; None is once.
        """
        check_shape("time", time, (-1,), "one number a sample")
        check_shape("voltage", voltage, (-1, time.size), "a row an electrode and a column a sample")
        if degree not in (1, 3, 5, MOST_DEGREE):
            raise ValueError(f"degree is {degree}; it must be 1, 3, 5 or {MOST_DEGREE}.")
        check_samples(time.size)
        if time.size <= degree:
            raise ValueError(
                f"degree is {degree}; it must be less than the number of samples, which is {time.size}."
            )
        if not np.all(np.diff(time) > 0.0):
            raise ValueError("The times of the samples do not increase; they must.")
        if period is not None:
            if not period > time[-1] - time[0]:
                raise ValueError(
                    f"period is {period} s; it must be longer than the samples, {time[-1] - time[0]} s."
                )
            time, voltage = np.append(time, time[0] + period), np.hstack([voltage, voltage[:, :1]])
        ends = "periodic" if period is not None and degree > 1 else None
        spline = scipy.interpolate.make_interp_spline(time, voltage.T, degree, bc_type=ends)
        edges = np.unique(spline.t[degree : len(spline.t) - degree])
        powers = [spline(edges[:-1], nu) / factorial(nu) for nu in range(degree, -1, -1)]
        return cls(scipy.interpolate.PPoly(np.stack(powers), edges), period is not None)

    @property
    def period(self) -> float:
        """Time after which it repeats itself [s]; infinite where it does not."""
        return float(self.pieces.x[-1] - self.pieces.x[0]) if self.periodic else np.inf

    def voltage(self, time: Array | float, order: int = 0) -> Array:
        """Return the voltages or a derivative [V s^-order], shape (electrode, *time.shape)."""
        first, last = self.pieces.x[[0, -1]]
        clock = np.asarray(time, np.float64) + self.start
        if self.periodic:
            clock = first + (clock - first) % self.period
        values = np.moveaxis(self.pieces(clock, order), -1, 0)
        return np.where((clock >= first) & (clock <= last), values, 0.0)

    def delayed(self, time: float) -> "Waveform":
        """Return the waveform whose clock is ahead by a time [s]."""
        start = self.start + time
        return replace(self, start=start % self.period if self.periodic else start)

    def integral(self) -> "Waveform":
        """Return the waveform of the integral: a velocity's displacement, an acceleration's velocity.

        It begins at zero; of one that repeats itself, whose mean must be zero, so is its own mean.

            >>> ramp = Waveform.sampled(np.array([0.0, 2.0]), np.array([[0.0, 4.0]]), degree=1)
            >>> ramp.integral().voltage(2.0).tolist()
            [4.0]

        Raises:
            ValueError: the mean over a period is not zero, or the degree is the highest already.
        """
        pieces: Any = self.pieces.antiderivative()
        if self.periodic:
            first, last = self.pieces.x[[0, -1]]
            drift = np.abs(pieces(last) - pieces(first))
            scale = self.period * np.abs(self.pieces(self.pieces.x[:-1])).max()
            if (drift > MEAN * scale).any():
                raise ValueError(
                    f"The mean over a period is {drift.max() / self.period:.6g}; it must be zero for the "
                    "integral to repeat itself."
                )
            pieces.c[-1] -= pieces.antiderivative()(last) / self.period
        return Waveform(pieces, self.periodic, self.start)

    def table(self) -> Array:
        """Return rows of the time at which a piece begins and its derivatives there, electrode by electrode.

        Without a period, pieces of zero voltage come before and after.
        """
        c, x = self.pieces.c, self.pieces.x
        derivatives = np.zeros((c.shape[1], c.shape[2], MOST_DEGREE + 1))
        for power, values in enumerate(c[::-1]):
            derivatives[:, :, power] = factorial(power) * values
        rows = np.column_stack([x[:-1], derivatives.reshape(len(derivatives), -1)])
        if not self.periodic:
            silent: Any = np.zeros((1, rows.shape[1]))
            rows = np.vstack([silent, rows, silent])
            rows[0, 0], rows[-1, 0] = -np.inf, x[-1]
        return rows


def check_samples(count: float) -> None:
    """Refuse more samples than a waveform may have by a ValueError."""
    if count > MOST_SAMPLES:
        raise ValueError(f"There are {count:.4g} samples; a waveform has at most {MOST_SAMPLES:.0e}.")
