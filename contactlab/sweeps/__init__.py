"""Many runs: what became of each, and their metrics in one dataset over the parameters."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from contactlab.sweeps.collecting import collect
    from contactlab.sweeps.grid import MotorGrid, simulate_many

__all__ = ["MotorGrid", "collect", "simulate_many"]

_MODULES = {"MotorGrid": "grid", "collect": "collecting", "simulate_many": "grid"}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: what a job says of itself needs no xarray."""
    if name in _MODULES:
        return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
