"""Where the work of the drive goes, law by law."""

from typing import Final

import numpy as np
import xarray

from contactlab.comparison.arrays import holds, series

ENERGY_TERMS: Final = {
    "damping_loss": "viscous damping",
    "friction_loss": "friction",
    "contact_loss": "contact losses",
    "load_work": "load work",
    "stored_energy": "change of stored energy",
    "unaccounted": "unaccounted",
}
"""In the order of the figure; the words are those of figure and table."""

_LOSSES: Final = ("damping_loss", "friction_loss", "contact_loss", "load_work")
_STORED: Final = ("kinetic_energy", "strain_energy", "contact_energy")


def energy_flow(tree: xarray.DataTree) -> dict[str, float]:
    """Where the work of the drive has gone by the end of a run [J]; the terms add up to it.

    The ledger is E(t) - E(0) = drive_work - losses - load_work + energy_residual, so that the residual
    counts as energy that has gone nowhere with its sign turned. A run that lacks a series of the ledger
    has no flow: NaN.
    """
    names = (*_LOSSES, *_STORED, "energy_residual", "drive_work")
    if not holds(tree, *names):
        return dict.fromkeys(ENERGY_TERMS, np.nan)
    terms = {name: _gain(tree, name) for name in _LOSSES}
    terms["stored_energy"] = sum(_gain(tree, name) for name in _STORED)
    terms["unaccounted"] = -_gain(tree, "energy_residual")
    return terms


def drive_work(tree: xarray.DataTree) -> float:
    """Work of the drive on the resonator [J]; NaN where it is not recorded."""
    return _gain(tree, "drive_work") if holds(tree, "drive_work") else np.nan


def _gain(tree: xarray.DataTree, name: str) -> float:
    values = series(tree, name)
    return float(values[-1] - values[0])
