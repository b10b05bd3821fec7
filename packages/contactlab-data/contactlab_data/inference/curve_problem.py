"""A force curve as an inference problem: forces over the position of a cantilever's base, without a time.

Rows are in the order in which they were measured: of one approach, one retraction, or the one and then the
other. Where a law has two equilibria at a position, free and in contact, jumps in the data tell in which of
them the tip was: it is free before a drop of the force on approach and in contact after it, in contact before
a rise on retraction and free after it. Without such a jump the law tells. Beyond the end of the law's contact
the force is that at its end. So predictions are continuous in the numbers, and a jump that thermal motion
brings before the law's contact ends is no misfit.

A jump is a change from row to row of more than `STEEP` times that of its neighbours, and of more than `HIGH`
times the usual one. When between two rows it happens is not measured, and an instrument takes some time for
it: rows within two intervals of it are not compared.

Source: `contactlab.force_curves`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf
from typing import Final, final

import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from contactlab.arrays import Array
from contactlab.config import ConfigurationError
from contactlab.force_curves import BY_LAW, CURVE, FREE, TOUCHING, LawOnCantilever, Recording
from contactlab.laws import ContactLaw, LawError
from contactlab_data.inference.free_parameters import FreeParameter, with_values
from contactlab_data.inference.motor_problem import OverTime, check_noise
from contactlab_data.inference.path_problem import CORRELATED
from contactlab_data.measured.series import MEASURABLE, MeasuredSeries

NORMAL: Final = "normal_force"

NEIGHBOURS: Final = 7
"""Changes from row to row about a jump."""

STEEP: Final = 3.0
HIGH: Final = 6.0
"""Change of a jump over the median of these, and over that of all."""

BESIDE: Final = 2
"""Rows on either side of a jump that are left out."""

BACK: Final = 0.1
"""Share of the range of positions by which an approach or a retraction may go back."""

STEP: Final = 1e-6
"""Step of finite differences in the unit cube."""


@final
@dataclass(frozen=True, eq=False, kw_only=True)
class CurveProblem(OverTime):
    """Forces of a law at the end of a cantilever; see `Problem`.

    Args:
        base: the law with the values of what is not free.
        recording: with the values of what is not free.
        position: of the base in every row [m], shape (row,).
        state: of the tip in every row, see `contactlab.force_curves.BY_LAW`.
        places: rows that are compared, those of `measured`.
    """

    base: ContactLaw
    recording: Recording
    position: Array
    state: NDArray[np.int8]
    places: NDArray[np.int64]

    @property
    def law(self) -> str:
        """Name of the law."""
        return self.base.name

    @property
    def step(self) -> float:
        """Step of differences."""
        return STEP

    def spread(self, values: Array) -> float:
        """Return zero: nothing but the base moves the contact."""
        del values
        return 0.0

    @cached_property
    def data(self) -> xarray.Dataset:
        """The force over the position of the base."""
        force = "row", self.measured.values[NORMAL], {"units": MEASURABLE[NORMAL].units}
        return xarray.Dataset({NORMAL: force}, {"z": ("row", self.measured.path["z"], {"units": "m"})})

    def predict(self, values: Array) -> dict[str, Array] | None:
        """Return the measured force in the rows that are compared; None where the law has no equilibrium."""
        numbers = [*zip(self.keys, values, strict=False)]
        of_law = [(item, x) for item, x in numbers if item.name not in CURVE]
        try:
            law = with_values(self.base, [item for item, _ in of_law], [x for _, x in of_law])
            recording = self.recording.changed({x.name: y for x, y in numbers if x.name in CURVE})
            force = prepared(self).forces(law, self.position, recording, self.state)
        # Values that are admitted one by one need not be so together.
        except (LawError, ValueError):
            return None
        return {NORMAL: recording.measured(self.position, force)[self.places]}


@lru_cache(maxsize=16)
def prepared(problem: CurveProblem) -> LawOnCantilever:
    """Return the law of a problem, made ready for any numbers."""
    return LawOnCantilever(problem.base)


def jumps_of(position: Array, force: Array) -> NDArray[np.int64]:
    """Return the row before the largest drop on approach, and that before the largest rise on retraction.

    Either may be missing. Approach is up to the least position, retraction from there on.
    """
    change = np.diff(force)
    size = np.abs(change)
    jumps = (size > STEEP * median_filter(size, NEIGHBOURS, mode="nearest")) & (size > HIGH * np.median(size))
    turn, row = int(np.argmin(position)), np.arange(size.size)
    ways = (jumps & (change < 0.0) & (row < turn), jumps & (change > 0.0) & (row >= turn))
    return np.array([np.argmax(size * way) for way in ways if way.any()], np.int64)


def jump_notes(measured: MeasuredSeries) -> Iterator[str]:
    """Yield a sentence for each jump of a force curve."""
    seen = np.isfinite(measured.values[NORMAL])
    force, position = measured.values[NORMAL][seen], measured.path["z"][seen]
    for jump in jumps_of(position, force):
        step, way = force[jump + 1] - force[jump], "approach" if jump < np.argmin(position) else "retraction"
        yield (
            f"On {way} the force jumps by {step:.3g} N at z = {position[jump]:.6g} m; the {2 * BESIDE} rows "
            "next to it are not compared."
        )


def states_of(position: Array, jumps: NDArray[np.int64]) -> NDArray[np.int8]:
    """Return the state of the tip in each row as far as the jumps tell, shape (row,)."""
    state, row, turn = np.full(position.size, BY_LAW, np.int8), np.arange(position.size), np.argmin(position)
    for jump in jumps:
        way = row <= turn if jump < turn else row >= turn
        inside = row > jump if jump < turn else row <= jump
        state[way] = np.where(inside[way], TOUCHING, FREE)
    return state


def check_one_cycle(position: Array) -> None:
    """Raise a ConfigurationError for more than an approach and a retraction."""
    turn, most = int(np.argmin(position)), BACK * float(np.ptp(position))
    for way in (position[: turn + 1], position[turn:][::-1]):
        if float((way - np.minimum.accumulate(way)).max()) > most:
            raise ConfigurationError(
                "z goes down and up more than once; it must have one approach and one retraction at most. "
                "Put others into files of their own."
            )


def curve_problem(
    measured: MeasuredSeries,
    law: ContactLaw,
    keys: Sequence[FreeParameter],
    recording: Recording,
    *,
    discrepancy: bool,
    degrees_of_freedom: float | None = inf,
) -> CurveProblem:
    """Return the problem of a force curve.

    Args:
        measured: forces and positions of the base.
        law: with the values of what is not free.
        keys: free numbers of the law and of the recording.
        recording: with the values of what is not free.
        discrepancy: whether the law may be wrong, by a process that a twentieth of the rows correlates.
        degrees_of_freedom: of Student-t noise; infinite is the normal distribution, None is free.

    Raises:
        ConfigurationError: the law is no law of a force curve, the curve has several cycles, or a discrepancy
            has Student-t noise, whose likelihood has no closed form.
    """
    check_noise(discrepancy, degrees_of_freedom)
    force = measured.values[NORMAL]
    position, seen = measured.path["z"], np.isfinite(force)
    check_one_cycle(position)
    rows = np.flatnonzero(seen)
    jumps = rows[jumps_of(position[seen], force[seen])]
    for jump in jumps:
        seen[max(jump + 1 - BESIDE, 0) : jump + 1 + BESIDE] = False
    try:
        LawOnCantilever(law)
    except ValueError as error:
        raise ConfigurationError(f"law={law.name}: {error}") from error
    span = float(measured.time[-1] - measured.time[0])
    return CurveProblem(
        measured=measured.rows(seen),
        configuration={},
        keys=tuple(keys),
        base=law,
        recording=recording,
        position=position,
        state=states_of(position, jumps),
        places=np.flatnonzero(seen),
        correlation=CORRELATED * span if discrepancy else 0.0,
        degrees_of_freedom=degrees_of_freedom,
    )
