"""Two stiffnesses: a loading line, and a steeper one on which a dented contact goes back and forth."""

from dataclasses import dataclass
from typing import Annotated, final

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import NormalForce
from contactlab.laws.memory import AT_TOUCH, InternalVariable
from contactlab.parameter import not_negative, positive

LOADS = 0
"""Place of `loads` among the internal variables."""

BEGINS, STOPS = 0, 1
"""Guards: it loads on where the depth is again its largest, and no longer where it does not grow."""


@inner_kernel
def steeper(largest_depth, loading_stiffness, unloading_stiffness, hardening):
    """Return the stiffness k_2 of unloading [N/m] from a largest depth, and the dent that this leaves [m]."""
    stiffness = unloading_stiffness + hardening * loading_stiffness * largest_depth
    return stiffness, largest_depth * (stiffness - loading_stiffness) / stiffness


@final
@dataclass(frozen=True)
class WaltonBraun(NormalForce):
    """A disk that yields from the start: it loads along k_1, and unloads and reloads along k_2 >= k_1.

    With S = 0 a free impact has the restitution sqrt(k_1/k_2) at every speed. With S > 0 it has
    sqrt(k_1/(k_2 + S N*)), N* = v sqrt(m k_1), which falls with the speed v of the impact. What is stored
    is what unloading gives back, N^2/(2 k_2). A contact makes one dent, N* (1/k_1 - 1/k_2) deep, and the
    next begins on fresh material once the gap is clear of it.
    """

    name = "walton_braun"
    equation = "N = k_1 d as it loads, (k_2 + S N*) (d - d_p) below its largest force N*"
    source = "Walton and Braun (1986), J. Rheol. 30, 949"
    validity = "contacts that yield from the first touch"

    loading_stiffness: Annotated[float, positive("k_1", "N m-1", "stiffness of loading")] = 1e7
    unloading_stiffness: Annotated[float, positive("k_2", "N m-1", "stiffness of unloading from N* = 0")] = (
        1.5e7
    )
    hardening: Annotated[float, not_negative("S", "m-1", "growth of k_2 with the largest force")] = 0.0

    internal_variables = (
        InternalVariable("loads", "", "1", "whether the contact loads along k_1", 1.0, discrete=True),
        InternalVariable("largest_depth", "d*", "m", "largest depth before"),
    )
    guards = 2

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.unloading_stiffness < self.loading_stiffness:
            raise ValueError(
                f"{self.name}: unloading_stiffness is {self.unloading_stiffness:g} N/m; it must be at least "
                f"loading_stiffness, {self.loading_stiffness:g} N/m, or unloading would give energy."
            )

    @staticmethod
    @kernel
    def force(depth, depth_rate, loads, largest_depth, loading_stiffness, unloading_stiffness, hardening):
        if loads == 0.0:
            stiffness, dent = steeper(largest_depth, loading_stiffness, unloading_stiffness, hardening)
            left = max(depth - dent, 0.0)
            force = stiffness * left
            return force, 0.5 * force * left, stiffness, 0.0, 0.0
        force = loading_stiffness * depth
        stiffness, _ = steeper(depth, loading_stiffness, unloading_stiffness, hardening)
        elastic = force / stiffness
        # d(N^2/2 k_2)/dd, of which k_2 takes a part as it grows.
        released = loading_stiffness * elastic * (1.0 - 0.5 * hardening * elastic)
        return force, 0.5 * force * elastic, loading_stiffness, 0.0, (force - released) * depth_rate

    @staticmethod
    @kernel
    def guard(which, depth, depth_rate, loads, largest_depth):
        if which == BEGINS:
            return largest_depth - depth if loads == 0.0 else 1.0
        return depth_rate if loads != 0.0 else 1.0

    @staticmethod
    @kernel
    def jump(which, event, depth, depth_rate, loads, largest_depth):
        if event == BEGINS:
            return 1.0 if which == LOADS else largest_depth
        # A contact that begins under load, at rest or opening, has been loaded.
        pressed = event == AT_TOUCH and loads != 0.0 and depth_rate <= 0.0
        if event == STOPS or pressed:
            return 0.0 if which == LOADS else max(depth, largest_depth)
        return loads if which == LOADS else largest_depth

    @staticmethod
    @kernel
    def limits(loads, largest_depth, loading_stiffness, unloading_stiffness, hardening):
        if loads != 0.0:
            return 0.0, 0.0
        _, dent = steeper(largest_depth, loading_stiffness, unloading_stiffness, hardening)
        return -dent, -dent
