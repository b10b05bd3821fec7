"""Properties that compare runs: the same twice, asked more often, mirrored, and with smaller steps."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import fleeting_kernel
from contactlab.laws import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.base import FrictionKernel, MultiplierKernel, PenaltyKernel
from contactlab.testing.claim import Claim, at_least, at_most
from contactlab.testing.contract.bench import Bench, mirrored
from contactlab.trajectory import Trajectory

ORDER_SCATTER = 0.3
"""An order fitted to a few runs is uncertain by this much."""

MIRRORED = (
    "tip_tangential_displacement",
    "tip_slope",
    "slip_velocity",
    "rotor_velocity",
    "rotor_angle",
    "friction_force",
    "friction_impulse",
)
"""What changes its sign in a mirror."""


def repeats_bit_for_bit(bench: Bench) -> Iterator[Claim]:
    """The same run twice."""
    first = bench.motor_run
    again = bench.run_motor(bench.law)
    yield at_most("numbers that differ when run again", _differing(first, again), 0)


def calls_leave_no_trace(bench: Bench) -> Iterator[Claim]:
    """A run in which the law is asked two more times, elsewhere, before every answer."""
    first = bench.motor_run
    asked = bench.run_motor(_often_asked(bench.law))
    yield at_most("numbers that differ when asked more often", _differing(first, asked), 0)


def mirrors(bench: Bench) -> Iterator[Claim]:
    """Left and right exchanged."""
    first = bench.motor_run
    seen = bench.run_motor(bench.law, mirrored(bench.motor))
    turned = _differing(first, seen, mirror=True)
    yield at_most("numbers that differ in the mirror", turned, 0)


def converges(bench: Bench) -> Iterator[Claim]:
    """The error against a much finer run, fitted over step or tolerance in logarithms."""
    sizes, (*runs, reference) = bench.converging()
    errors = [_distance(trajectory, reference) for trajectory in runs]
    order = float(np.polyfit(np.log(sizes), np.log(np.maximum(errors, 1e-300)), 1)[0])
    declared = bench.law.convergence_order
    word = "step" if bench.rigid else "tolerance"
    yield at_least(f"order of convergence with the {word}", order, declared - ORDER_SCATTER)


def _distance(trajectory: Trajectory, reference: Trajectory) -> float:
    """How far two runs are apart: their ends and their impulses, relative, as a root mean square."""
    parts = []
    for name in ("rotor_velocity", "tip_slope", "tip_normal_displacement"):
        expected = reference.series[name][-1]
        parts.append((trajectory.series[name][-1] - expected) / (abs(expected) or 1.0))
    for name in ("normal_impulse", "friction_impulse"):
        scale = np.abs(reference.contacts[name]).sum() or 1.0
        change = trajectory.contacts[name].sum() - reference.contacts[name].sum()
        parts.append(change / scale)
    return float(np.sqrt(np.mean(np.square(parts))))


def _differing(first: Trajectory, second: Trajectory, mirror: bool = False) -> int:
    """How many recorded numbers are not the same; an equal NaN is."""
    count = 0
    for columns, others in ((first.series, second.series), (first.contacts, second.contacts)):
        for name, column in columns.items():
            sign = -1.0 if mirror and name in MIRRORED else 1.0
            if column.shape != others[name].shape:
                return max(column.size, others[name].size)
            same = (column == sign * others[name]) | (np.isnan(column) & np.isnan(others[name]))
            count += int(np.count_nonzero(~same))
    return count + int(np.count_nonzero(first.contact_mode != second.contact_mode))


def _often_asked(law: ContactLaw) -> ContactLaw:
    if isinstance(law, PenaltyLaw):
        return _OftenAskedPenalty(law)
    if isinstance(law, MultiplierLaw):
        return _OftenAskedMultiplier(law)
    raise TypeError(f"{type(law).__name__} is neither a PenaltyLaw nor a MultiplierLaw.")


@final
@dataclass(frozen=True)
class _OftenAskedPenalty(PenaltyLaw):
    """A law that is asked about other states before it is asked about the one that counts."""

    name: ClassVar[str] = "often_asked"
    equation: ClassVar[str] = "that of the law inside"
    source: ClassVar[str] = "this check"
    default_contact_step: ClassVar[float] = 4e-6

    law: PenaltyLaw

    def parameters(self) -> Array:
        """Those of the law inside."""
        return self.law.parameters()

    @property
    def force(self) -> PenaltyKernel:
        """The kernel around the kernel."""
        inner: Any = self.law.force

        def asked(
            gap: float, gap_rate: float, slip: float, approach: float, parameters: Array
        ) -> tuple[float, float, float, float]:
            inner(1.5 * gap, -gap_rate, -slip, approach, parameters)
            inner(0.5 * gap, 2.0 * gap_rate, 0.0, approach, parameters)
            return inner(gap, gap_rate, slip, approach, parameters)  # type: ignore[no-any-return]

        return fleeting_kernel(asked)

    @property
    def friction_kind(self) -> int:  # type: ignore[override]
        """That of the law inside."""
        return self.law.friction_kind

    @property
    def internal_variables(self) -> tuple[str, ...]:  # type: ignore[override]
        """That of the law inside."""
        return self.law.internal_variables

    @property
    def internal_parity(self) -> int:  # type: ignore[override]
        """That of the law inside."""
        return self.law.internal_parity

    @property
    def friction_force(self) -> FrictionKernel | None:
        """The kernel around the kernel, where there is one."""
        inner: Any = self.law.friction_force
        if inner is None:
            return None

        def asked(
            gap: float,
            gap_rate: float,
            slip: float,
            normal: float,
            memory: float,
            parameters: Array,
        ) -> tuple[float, float, float, float]:
            inner(1.5 * gap, -gap_rate, -slip, 2.0 * normal, -memory, parameters)
            return inner(gap, gap_rate, slip, normal, memory, parameters)  # type: ignore[no-any-return]

        return fleeting_kernel(asked)


@final
@dataclass(frozen=True)
class _OftenAskedMultiplier(MultiplierLaw):
    """A law that is asked about other states before it is asked about the one that counts."""

    name: ClassVar[str] = "often_asked"
    equation: ClassVar[str] = "that of the law inside"
    source: ClassVar[str] = "this check"
    default_contact_step: ClassVar[float] = 5e-8

    law: MultiplierLaw

    def __post_init__(self) -> None:
        """Stepped, and excused, as the law inside."""
        object.__setattr__(self, "projects", self.law.projects)
        object.__setattr__(self, "violations", self.law.violations)

    def parameters(self) -> Array:
        """Those of the law inside."""
        return self.law.parameters()

    @property
    def solve(self) -> MultiplierKernel:
        """The kernel around the kernel."""
        inner: Any = self.law.solve

        def asked(
            normal_rate: float,
            tangential_rate: float,
            gap_rate: float,
            slip: float,
            d_nn: float,
            d_nt: float,
            d_tt: float,
            parameters: Array,
        ) -> tuple[float, float, int]:
            inner(-normal_rate, -tangential_rate, gap_rate, -slip, d_nn, d_nt, d_tt, parameters)
            inner(2.0 * normal_rate, tangential_rate, gap_rate, 0.0, d_nn, d_nt, d_tt, parameters)
            return inner(  # type: ignore[no-any-return]
                normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, parameters
            )

        return fleeting_kernel(asked)
