"""What the kernels of the engine are given: the run, the law, and where to write."""

from typing import Any, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.engine.state import SAMPLE
from contactlab.laws.base import Kernel

STEP, IMPACT, TILT, SPIN, SPEED, HEAD = range(6)
"""Places in a law's row of what the engine writes there, and where the internal variables begin."""


class Run(NamedTuple):
    """The context of every kernel: the motor, its step responses, the state and the scratch of a step."""

    plant: Any
    propagator: Any
    state: Any
    step: Any


class Memory(NamedTuple):
    """The kernels of a law with internal variables, limits or a moment, and what they read.

    `parameters` is the row of `Law`; `row` is the same memory, writable, from its head on.
    """

    rate: Any
    guard: Any
    jump: Any
    limits: Any
    moment: Any
    parameters: Array
    row: Array


class Law(NamedTuple):
    """The kernels of a law, idle ones for those that it lacks, and its parameters.

    Of a law that is plain the memory is None, and code that is about it is compiled to nothing: functions
    that take a memory ask whether it is None before all else.
    """

    force: Kernel
    friction: Kernel
    solve: Kernel
    parameters: Array
    memory: Memory | None


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
