"""Many runs: what became of each, and their metrics in one dataset over the parameters."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from contactlab.sweep.collecting import collect

__all__ = ["collect"]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: what a job says of itself needs no xarray."""
    if name in __all__:
        from contactlab.sweep import collecting

        return getattr(collecting, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
