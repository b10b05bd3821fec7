"""When an energy ledger counts as closed: the one limit, and the one scale, of all that judge one."""

from typing import Final

LEDGER_LIMIT: Final = 1e-2
"""Residual of a ledger over the energy turned over, beyond which its run is not balanced [1]."""

SCALE: Final = "max(|W_d|, |W_L|, E_0)"
"""The energy turned over, in symbols: see `openness`."""


def openness(residual: float, drive_work: float, load_work: float, start: float) -> float:
    """Share of the energy turned over that a ledger cannot account for [1].

        max|r| / max(max|W_d|, max|W_L|, E_0)

    What a run turns over has come in by the drive, by the load where it drives, or was there at the start;
    losses and stored energy are where it went, so that a law that makes energy is not excused by its size.

    Args:
        residual: largest |r| [J].
        drive_work, load_work: largest magnitude of the work of drive and of load [J].
        start: kinetic, strain and contact energy at the start [J].

    Returns:
        The share; zero where nothing is turned over and nothing is left, infinite where something is.
    """
    turned_over = max(abs(drive_work), abs(load_work), abs(start))
    if turned_over > 0.0:
        return residual / turned_over
    return 0.0 if residual == 0.0 else float("inf")
