"""Electrode voltages: tones as phasors, U_e(t) = Re sum_k phasor[e, k] exp(i omega_k t), and a waveform."""

from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, partial
from math import ceil, pi
from typing import Annotated, Final, final

import numpy as np
import scipy
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.checks import Checked, check_shape, checked_arguments
from contactlab.immutable import Immutable
from contactlab.motor.waveform import MOST_DEGREE, SAMPLED_TURN, Waveform, check_samples
from contactlab.parameter import Parameter, positive

# Over patches of a millimetre; ceramics break down at some 1e3 V.
_voltage = partial(Parameter, units="V", at_least=-1e5, at_most=1e5, usual=(0.0, 200.0))
# Between the tones, and between a tone and a second, which a double tells apart within a run.
_scale = partial(Parameter, at_least=1e-9, at_most=1e9)
# Beyond it, a double has fewer than ten digits of the angle within a turn.
_PHASE = Parameter("phi", "rad", "phase of the first tone", at_least=-1e6, at_most=1e6, usual=(-pi, pi))
_PHASE_2 = replace(_PHASE, meaning="lead of the second electrode")
_FIRST = _scale("f1", "Hz", "first tone", hint="Leave it out for the first natural frequency.")

MOST_PERIODS: Final = 100
"""Periods of the first tone after which a drive must repeat itself."""

SAME: Final = 1e-9
"""Relative distance from a ratio of whole numbers that counts as none."""


@final
@dataclass(frozen=True)
class TwoMode(Checked):
    """The paper's drive: both electrodes in phase at the first tone, in opposition at the second."""

    voltage_1: Annotated[float, _voltage("U1", meaning="amplitude of the first tone")] = 100.0
    voltage_2: Annotated[float, _voltage("U2", meaning="amplitude of the second tone")] = 100.0
    frequency: Annotated[float | None, _FIRST] = None
    frequency_ratio: Annotated[float, _scale("f2/f1", "1", "second tone over first")] = 2.0
    phase: Annotated[float, _PHASE] = -pi / 5.0

    def drive(self) -> "Drive":
        """Return the drive; the frequency must be a number."""
        assert self.frequency is not None
        first = -1j * self.voltage_1 * np.exp(1j * self.phase)
        second = -1j * self.voltage_2
        tones = np.array([self.frequency, self.frequency_ratio * self.frequency])
        return Drive(tones, np.array([[first, second], [first, -second]], dtype=np.complex128))


@final
@dataclass(frozen=True)
class TwoPhase(Checked):
    """One tone on both electrodes: U_1 = V_1 sin(w t), U_2 = V_2 sin(w t + phase)."""

    voltage_1: Annotated[float, _voltage("V1", meaning="amplitude of the first electrode")] = 100.0
    voltage_2: Annotated[float, _voltage("V2", meaning="amplitude of the second electrode")] = 100.0
    frequency: Annotated[float | None, _FIRST] = None
    phase: Annotated[float, _PHASE_2] = 0.5 * pi

    def drive(self) -> "Drive":
        """Return the drive; the frequency must be a number."""
        phasors = np.array([[-1j * self.voltage_1], [-1j * self.voltage_2 * np.exp(1j * self.phase)]])
        return Drive(np.array([self.frequency], dtype=np.float64), phasors)


@final
@dataclass(frozen=True)
class Chirp(Checked):
    """A tone whose frequency passes linearly from one to another, then silence.

    U_1 = V_1 sin(phi), U_2 = V_2 sin(phi + phase), phi = 2 pi (f_1 t + (f_2 - f_1) t^2 / (2 T)).
    """

    voltage_1: Annotated[float, _voltage("V1", meaning="amplitude of the first electrode")] = 100.0
    voltage_2: Annotated[float, _voltage("V2", meaning="amplitude of the second electrode")] = 100.0
    first_frequency: Annotated[float, _scale("f1", "Hz", "frequency at the start")] = 1000.0
    last_frequency: Annotated[float, _scale("f2", "Hz", "frequency at the end")] = 10000.0
    duration: Annotated[float, positive("T", "s", "time from start to end")] = 0.02
    phase: Annotated[float, _PHASE_2] = 0.5 * pi

    def drive(self) -> "Drive":
        """Return the drive, whose samples lie at most `SAMPLED_TURN` of the tone apart."""
        first, last, duration = self.first_frequency, self.last_frequency, self.duration
        check_samples(turns := samples_of_chirp(first, last, duration))
        count = ceil(turns) + MOST_DEGREE + 1
        time = np.linspace(0.0, duration, count)
        phi = 2.0 * pi * (first + 0.5 * (last - first) * time / duration) * time
        voltage = np.stack([self.voltage_1 * np.sin(phi), self.voltage_2 * np.sin(phi + self.phase)])
        return Drive(waveform=Waveform.sampled(time, voltage, MOST_DEGREE))


def samples_of_chirp(first: float, last: float, duration: float) -> float:
    """Return the number of samples of a chirp between two frequencies [Hz] over a duration [s]."""
    return 2.0 * pi * max(first, last) * duration / SAMPLED_TURN


@final
@dataclass(frozen=True, eq=False)
class Drive(Immutable):
    """Any number of tones on each electrode, and a waveform beside them; `Drive()` has none.

        >>> import contactlab as cl
        >>> drive = cl.Drive.two_mode(100.0, 50.0, frequency=3000.0, frequency_ratio=2.0)
        >>> drive.frequency, drive.phasors.shape
        (array([3000., 6000.]), (2, 2))

    Args:
        frequency: of each tone [Hz], shape (tone,), positive.
        phasors: complex amplitudes [V], shape (electrode, tone); U sin(w t + phi) has the phasor
            -i U exp(i phi).
        waveform: voltages that are no tones, of as many electrodes; None is none.
    """

    frequency: Array = field(default_factory=lambda: np.empty(0))
    phasors: NDArray[np.complex128] = field(default_factory=lambda: np.empty((2, 0), np.complex128))
    waveform: Waveform | None = None

    def __post_init__(self) -> None:
        self.freeze()
        check_shape("frequency", self.frequency, (-1,), "one number a tone")
        meaning = "a row an electrode and a column a tone"
        check_shape("phasors", self.phasors, (-1, self.frequency.size), meaning, "iufc")
        if not np.all(self.frequency > 0.0):
            raise ValueError(f"The tones lie at {self.frequency} Hz; each must be positive.")
        electrodes = len(self.phasors)
        if self.waveform is not None and (count := self.waveform.pieces.c.shape[2]) != electrodes:
            raise ValueError(f"The waveform has {count} electrodes; it must have {electrodes}, as the tones.")

    @staticmethod
    @checked_arguments(voltage_1="V", voltage_2="V", frequency="Hz", frequency_ratio="1", phase="rad")
    def two_mode(
        voltage_1: float, voltage_2: float, frequency: float, frequency_ratio: float = 2.0, phase: float = 0.0
    ) -> "Drive":
        """Return the paper's drive (eqs. 1 and 2), with w2 = frequency_ratio w1; see `TwoMode`.

        U_A = U1 sin(w1 t + phase) + U2 sin(w2 t)
        U_B = U1 sin(w1 t + phase) - U2 sin(w2 t)

        >>> Drive.two_mode(100.0, 100.0, frequency=3210.0).frequency.tolist()
        [3210.0, 6420.0]
        """
        return TwoMode(voltage_1, voltage_2, frequency, frequency_ratio, phase).drive()

    @property
    def voltages(self) -> bool:
        """Whether there is a tone, be it silent, or a waveform; without, it is a drive of any electrodes."""
        return bool(self.frequency.size) or self.waveform is not None

    @property
    def angular_frequency(self) -> Array:
        """omega_k [rad/s], shape (tone,)."""
        return 2.0 * np.pi * self.frequency

    @cached_property
    def period(self) -> float:
        """Time after which all tones repeat themselves [s], see `period_of`."""
        heard = np.any(self.phasors != 0.0, axis=0)
        frequency = self.frequency[heard] if heard.any() else self.frequency
        if self.waveform is not None:
            if not self.waveform.periodic:
                raise NoPeriodError("The drive's waveform has no period; a steady state needs one.")
            frequency = np.append(1.0 / self.waveform.period, frequency if heard.any() else [])
        if not frequency.size:
            raise NoPeriodError("The drive has no tone; a steady state needs a period. Give it a frequency.")
        ratios = frequency / frequency[0]
        count = 1
        for ratio in ratios.tolist():
            near = Fraction(ratio).limit_denominator(MOST_PERIODS)
            if abs(ratio - near) <= SAME * ratio:
                count = int(np.lcm(count, near.denominator))
            else:
                count = MOST_PERIODS + 1
        if count > MOST_PERIODS:
            raise NoPeriodError(
                f"The tones at {', '.join(f'{f:.9g}' for f in frequency)} Hz do not repeat themselves "
                f"within {MOST_PERIODS} periods of the first; a steady state needs a drive that does. "
                "Choose a frequency_ratio of small whole numbers; the paper takes 2."
            )
        return count / float(frequency[0])

    def voltage(self, time: Array | float, order: int = 0) -> Array:
        """Return the electrodes' voltages or a derivative [V s^-order], shape (electrode, *time.shape)."""
        turns = np.exp(1j * np.multiply.outer(self.angular_frequency, time))
        phasors = self.phasors * (1j * self.angular_frequency) ** order
        tones = np.asarray(np.tensordot(phasors, turns, axes=1).real, dtype=np.float64)
        return tones if self.waveform is None else tones + self.waveform.voltage(time, order)

    def delayed(self, time: float) -> "Drive":
        """Return the drive whose clock is ahead by a time [s]."""
        waveform = None if self.waveform is None else self.waveform.delayed(time)
        turned = self.phasors * np.exp(1j * self.angular_frequency * time)
        return Drive(self.frequency, turned, waveform)

    def with_first_tone(self, frequency: float) -> "Drive":
        """Return the drive whose first tone has a frequency [Hz]; the others keep their ratios to it.

        >>> Drive.two_mode(100.0, 100.0, frequency=3210.0).with_first_tone(3000.0).frequency.tolist()
        [3000.0, 6000.0]
        """
        return replace(self, frequency=frequency / self.frequency[0] * self.frequency)

    @property
    def amplitude(self) -> float:
        """Largest amplitude of the first tone [V]."""
        return float(np.abs(self.phasors[:, 0]).max())

    def with_amplitude(self, amplitude: float) -> "Drive":
        """Return the drive whose first tone has a largest amplitude [V]; all others keep their ratios to it.

        >>> Drive.two_mode(100.0, 50.0, frequency=3210.0).with_amplitude(20.0).amplitude
        20.0
        """
        return replace(self, phasors=amplitude / self.amplitude * self.phasors)

    def silent(self) -> "Drive":
        """Return the drive without voltage, whose period is the same."""
        waveform = self.waveform
        if waveform is not None:
            c, x = np.zeros_like(waveform.pieces.c), waveform.pieces.x
            waveform = replace(waveform, pieces=scipy.interpolate.PPoly(c, x))
        return Drive(self.frequency, np.zeros_like(self.phasors), waveform)


class NoPeriodError(ValueError):
    """The drive does not repeat itself; the message is a sentence."""


def period_of(drive: Drive) -> float:
    """Return the time after which all tones of a drive repeat themselves [s]; silent ones count if all are.

    Raises:
        NoPeriodError: there is no tone, or no such time within `MOST_PERIODS` of the first.
    """
    return drive.period
