"""What may drive the electrodes: the options of `drive`, and their keys."""

from dataclasses import dataclass
from typing import Annotated, Final, Literal, final

from contactlab.checks import Checked
from contactlab.motor import Chirp, TwoMode, TwoPhase
from contactlab.parameter import Parameter, positive

Interpolation = Literal["linear", "cubic", "quintic", "septic"]

_FILE: Final = Parameter("", "1", "CSV or netCDF file")
_DIGEST: Final = Parameter("", "1", "digest of the file", hint="null takes the file as it is.")
_PERIOD: Final = positive("T", "s", "time after which the samples repeat themselves", hint="null is once.")
_INTERPOLATION: Final = Parameter("", "1", "spline through the samples")


@final
@dataclass(frozen=True)
class Tones(Checked):
    """Tones of a file: frequency, and voltage_1, phase_1, voltage_2 ..., U_e = V_e sin(2 pi f t + phi_e)."""

    file: Annotated[str, _FILE]
    digest: Annotated[str | None, _DIGEST] = None


@final
@dataclass(frozen=True)
class Sampled(Checked):
    """Samples of a file: time, and voltage_1, voltage_2 ... of every electrode; zero before and after."""

    file: Annotated[str, _FILE]
    digest: Annotated[str | None, _DIGEST] = None
    interpolation: Annotated[Interpolation, _INTERPOLATION] = "cubic"
    period: Annotated[float | None, _PERIOD] = None


SIGNALS: Final[dict[str, type]] = {
    "two_mode": TwoMode,
    "two_phase": TwoPhase,
    "tones": Tones,
    "sampled": Sampled,
    "chirp": Chirp,
}
"""What drives the electrodes, by the names of the options."""
