"""Prescribed motions of a law by itself, each with the numbers that it declares."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.checks import Checked
from contactlab.parameter import positive

PERIODS: Final = 2
"""Of a path, of which the last one is shown."""

SAMPLES: Final = 64
"""Of a path in a period."""

SPEEDS: Final = 60
"""Of impacts between the slowest and the fastest."""


@final
@dataclass(frozen=True)
class Rubbing(Checked):
    """A contact under a constant load that slips to and fro: x = A sin(2 pi f t)."""

    title: ClassVar[str] = "friction of a law over a path"

    amplitude: Annotated[float, positive("A", "m", "amplitude of the slip", usual=(1e-7, 1e-4))] = 1e-6
    frequency: Annotated[float, positive("f", "Hz", "cycles in a second", usual=(1.0, 1e4))] = 1e3
    load: Annotated[float, positive("N", "N", "normal force", usual=(0.1, 100.0))] = 5.0

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the samples [s]."""
        return np.linspace(0.0, PERIODS / self.frequency, PERIODS * SAMPLES + 1)

    @property
    def slip(self) -> NDArray[np.float64]:
        """Displacement at the times [m]."""
        return self.amplitude * np.sin(2.0 * np.pi * self.frequency * self.time)


@final
@dataclass(frozen=True)
class Dropping(Checked):
    """A body that meets a plate without slip, at speeds between two."""

    title: ClassVar[str] = "restitution of a law over speed"

    mass: Annotated[float, positive("m", "kg", "mass of the body", usual=(1e-4, 1e-1))] = 2e-3
    slowest: Annotated[float, positive("v_1", "m s-1", "slowest approach", usual=(1e-3, 0.1))] = 1e-2
    fastest: Annotated[float, positive("v_2", "m s-1", "fastest approach", usual=(0.1, 10.0))] = 1.0

    @property
    def speeds(self) -> NDArray[np.float64]:
        """Speeds of the approach [m/s]."""
        return np.geomspace(self.slowest, self.fastest, SPEEDS)
