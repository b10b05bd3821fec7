"""One operating point: the steady state on a belt or of a free rotor, all that it does, and its errors."""

from dataclasses import dataclass, field, replace
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.datasheet.measurement import UNKNOWN, Measurement, Number
from contactlab.engine.preparation import DEFAULT_TOLERANCE
from contactlab.laws.base import MultiplierLaw
from contactlab.metrics.convergence import FINER, richardson
from contactlab.orbits.period_map import BrokenOffError, PeriodMap
from contactlab.orbits.search import Steady, steady
from contactlab.orbits.shooting import CLOSED, NoOrbitError, orbit_from, updated
from contactlab.trajectory import Trajectory

LONGEST: Final = 480
"""Periods of the drive after which a motion without an orbit has its means."""

MEASURED: Final = 160
"""Periods over which these are taken, ten to each of the batches that tell their error."""

SETTLING: Final = 40
"""Periods before them at a finer step."""

RECORDS: Final = {True: 512, False: 128}
"""Of a period of an orbit, and of another motion."""

GROWS: Final = 1.5
"""Ratio of successive changes of a number that grows with every finer step, from which on it has no limit;
what goes with one over the step has a ratio of two."""

NOTABLE: Final = 0.1
"""Last of these changes over the number, below which it is one between steps and no growth."""

CORRECTIONS: Final = 12
"""Of an orbit that is taken to a finer step, before its derivative is taken anew."""


@final
@dataclass(frozen=True)
class Point:
    """An operating point.

    Args:
        belt: velocity at which the rotor is held [rad/s], in the model's sense; None for a free rotor.
        kind: as of `Steady`; 'periodic at some steps', or 'none' where a run breaks off.
        numbers: value and error of every name in `quantities.POINT`.
        message: why there is none.
        run: whole periods of it at the finest step.
    """

    belt: float | None
    kind: str
    numbers: dict[str, Number] = field(default_factory=dict)
    message: str = ""
    run: Trajectory | None = None

    def __getitem__(self, name: str) -> float:
        return self.numbers.get(name, UNKNOWN)[0]

    def error(self, name: str) -> float:
        """Give the error of a quantity."""
        return self.numbers.get(name, UNKNOWN)[1]

    def turned(self, sense: float) -> "Point":
        """Give the point with velocity and torque in the other sense, if that is negative."""
        signed = {name: (sense * self[name], self.error(name)) for name in ("velocity", "torque")}
        return replace(self, numbers=self.numbers and self.numbers | signed)


def ladder(setup: Setup) -> tuple[tuple[Setup, ...], float]:
    """Give a setup at its own and at two finer steps, and the factor between them."""
    if isinstance(setup.law, MultiplierLaw):
        divisors = FINER["contact_step"]
        return tuple(replace(setup, contact_step=setup.contact_step / d) for d in divisors), divisors[1]
    divisors, tolerance = FINER["tolerance"], setup.tolerance or DEFAULT_TOLERANCE
    return tuple(replace(setup, tolerance=tolerance / d) for d in divisors), divisors[1]


def operate(setup: Setup, belt: float | None = None) -> Point:
    """Find the steady state at an operating point, at three steps, and measure it at the finest.

    Args:
        setup: motor and law; its contact step or tolerance is the coarsest.
        belt: velocity at which the rotor is held [rad/s]; None for a free one.
    """
    steps, factor = ladder(setup)
    try:
        found = steady(setup, belt=belt, longest=LONGEST)
        # What does not touch is exact at any step.
        measured = _at(found, steps[:1] if found.kind == "without contact" else steps)
    except BrokenOffError as error:
        return Point(belt, "none", message=str(error))
    kinds = {each.closed for each in measured}
    kind = found.kind if len(kinds) == 1 else "periodic at some steps"
    levels = [each.numbers() for each in measured]
    order = setup.law.convergence_order
    numbers = {name: _converged([each[name] for each in levels], factor, order) for name in levels[0]}
    return Point(belt, kind, numbers, run=measured[-1].run)


def _at(found: Steady, steps: tuple[Setup, ...]) -> list[Measurement]:
    """Run a steady state at every step: one orbit, or many periods where there is none."""
    if found.orbit is not None:
        section, z = found.orbit.map, found.orbit.state
    else:
        section = PeriodMap(found.setup, belt=found.belt)
        z = section.end_of(found.motion)
    measured = []
    for i, setup in enumerate(steps):
        section = replace(section, setup=setup)
        closed = found.kind == "without contact"
        if found.orbit is not None:
            moved = _closed(section, z, found.orbit.jacobian) if i > 0 else z
            closed, z = moved is not None, z if moved is None else moved
        if i > 0 and not closed:
            z = section.end_of(section.run(z, SETTLING))
        run = section.run(z, 1 if closed else MEASURED, RECORDS[closed])
        measured.append(Measurement(section, run, RECORDS[closed], closed))
    return measured


def _closed(section: PeriodMap, z: Array, jacobian: Array) -> Array | None:
    """Close the orbit of a coarser step at a finer one; None where there is none that is stable."""
    near, left = z, section(z) - z
    for _ in range(CORRECTIONS):
        if np.linalg.norm(left) <= CLOSED * np.linalg.norm(z):
            return near
        move, before = np.asarray(np.linalg.solve(np.eye(z.size) - jacobian, left)), left
        near = near + move
        left = section(near) - near
        jacobian = updated(jacobian, move, left - before + move)
    try:
        orbit = orbit_from(section, z)
    except NoOrbitError:
        return None
    return orbit.state if orbit.stable else None


def _converged(levels: list[Number], factor: float, order: float) -> Number:
    """Give the finest of three numbers with its error; an infinite one where they grow without bound."""
    values = [value for value, _ in levels]
    value, error = levels[-1]
    if len(values) == 1 or not np.isfinite(values).all():
        return value, error
    before, last = np.diff(np.abs(values))
    if last > GROWS * before > 0.0 and last > NOTABLE * abs(value) + error:
        return value, np.inf
    return value, error + float(richardson(values, factor, order))
