"""What the kernels of the engine are given: the run, the law, and where to write."""

from typing import Any, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.engine.state import SAMPLE
from contactlab.laws.base import Kernel
from contactlab.laws.intake import HEAD as HEAD

STEP, IMPACT, TILT, SPIN, SPEED = range(HEAD)
"""Places in a law's row of what the engine writes there; internal variables begin at HEAD."""


class Run(NamedTuple):
    """The context of every kernel: the motor, its step responses, the state and the scratch of a step."""

    plant: Any
    propagator: Any
    state: Any
    step: Any


class Memory(NamedTuple):
    """The kernels of a law that is not plain, see `contactlab.engine.binding`."""

    rate: Kernel
    guard: Kernel
    jump: Kernel
    limits: Kernel
    moment: Kernel


class Law(NamedTuple):
    """The bound kernels of a law, None those that its family has not, and what they read.

    The engine writes to `row`, which is the same memory as `parameters`. Of a law that is plain the memory is
    None, and code that is about it is compiled to nothing: functions that take a memory ask whether it is
    None before all else.
    """

    force: Kernel
    friction: Kernel
    solve: Any
    parameters: Array
    row: Array
    memory: Memory | None


@final
class Impacts(NamedTuple):
    """Impacts to integrate, see `contactlab.engine.impact`.

    Args:
        contacts: u_n, u_t [m/s], D_nn, D_nt, D_tt [1/kg], shape (impact, 5).
        outcomes: records of `OUTCOME`, shape (impact,).
        histories: records of `MOMENT`, shape (impact, record); of no record where none is kept.
        silent: room for the records of a run that keeps no history.
    """

    contacts: Array
    outcomes: Any
    histories: Any
    silent: Any


@final
class Records(NamedTuple):
    """What a run writes: its series, and the internal variables at records and at the ends of contacts."""

    series: Any
    traces: Array
    ends: Array

    @classmethod
    def of(cls, records: int, contacts: int, variables: int) -> "Records":
        """Give room for so many of each."""
        return cls(np.zeros(records, SAMPLE), np.zeros((records, variables)), np.zeros((contacts, variables)))
