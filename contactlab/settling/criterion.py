"""When a run until steady ends: its options, and what drive and records must allow."""

from typing import Final, Literal

from contactlab.motor import Drive
from contactlab.motor.drive import period_of
from contactlab.settling.verdict import COARSEST

Until = Literal["duration", "steady"]
"""End of a run: after its duration, or earlier once the motor has settled."""

STEADY: Final = "steady"

PRECISION: Final = 1e-3
"""Default relative error of the velocity at which a run ends."""

LONGEST: Final = 1.0
"""Default duration of a run until steady [s]: some tens of a usual motor's settling times."""


def check_until_steady(drive: Drive, record_interval: float) -> None:
    """Refuse a drive without a period, and records too far apart, by a ValueError."""
    most = COARSEST * period_of(drive)
    if record_interval > most:
        raise ValueError(
            f"record.interval is {record_interval:.6g} s; with solver.until=steady it must be at most "
            f"{most:.6g} s, an eighth of the drive's period. Record more often."
        )
