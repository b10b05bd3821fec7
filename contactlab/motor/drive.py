"""Harmonic electrode voltages as phasors: U_e(t) = Re sum_k phasor[e, k] exp(i omega_k t)."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from contactlab.checks import check_number, check_shape

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Drive:
    """Any number of tones on each electrode.

    Args:
        frequency: of each tone [Hz], shape (tone,), positive.
        phasors: complex amplitudes [V], shape (electrode, tone); U sin(w t + phi) has the phasor
            -i U exp(i phi).
    """

    frequency: Array
    phasors: NDArray[np.complex128]

    def __post_init__(self) -> None:
        check_shape("frequency", self.frequency, (-1,), "one number a tone")
        check_shape(
            "phasors",
            self.phasors,
            (2, self.frequency.size),
            "a row for each of two electrodes and a column a tone",
            "iufc",
        )
        if not np.all(self.frequency > 0.0):
            raise ValueError(f"The tones lie at {self.frequency} Hz; each must be positive.")

    @classmethod
    def two_mode(
        cls,
        voltage_1: float,
        voltage_2: float,
        frequency: float,
        frequency_ratio: float = 2.0,
        phase: float = 0.0,
    ) -> "Drive":
        """The paper's drive (eqs. 1 and 2), with w2 = frequency_ratio w1.

            U_A = U1 sin(w1 t + phase) + U2 sin(w2 t)
            U_B = U1 sin(w1 t + phase) - U2 sin(w2 t)

        Args:
            voltage_1, voltage_2: amplitudes U1, U2 [V].
            frequency: of the first tone [Hz].
            frequency_ratio: second over first [1].
            phase: of the first tone [rad].
        """
        for name, value in {
            "voltage_1": voltage_1,
            "voltage_2": voltage_2,
            "frequency": frequency,
            "frequency_ratio": frequency_ratio,
            "phase": phase,
        }.items():
            check_number(name, value)
        first = -1j * voltage_1 * np.exp(1j * phase)
        second = -1j * voltage_2
        return cls(
            frequency=np.array([frequency, frequency_ratio * frequency]),
            phasors=np.array([[first, second], [first, -second]], dtype=np.complex128),
        )

    @property
    def angular_frequency(self) -> Array:
        """omega_k [rad/s], shape (tone,)."""
        return np.asarray(2.0 * np.pi * self.frequency, dtype=np.float64)

    def voltage(self, time: Array | float) -> Array:
        """Voltages of both electrodes [V], shape (electrode, *time.shape)."""
        turns = np.exp(1j * np.multiply.outer(self.angular_frequency, time))
        return np.asarray(np.tensordot(self.phasors, turns, axes=1).real, dtype=np.float64)
