"""Runs that claims are made about: of any motor, and those that the contract of a law is checked on."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, final

from scipy.optimize import brentq

from contactlab.engine import simulate
from contactlab.engine.simulation import take_in
from contactlab.laws import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.motor.motor import Motor
from contactlab.testing.plants import block, paper_motor
from contactlab.trajectory import Trajectory

MOTOR_DURATION = 1.5e-3
"""Of the run of the motor [s]: five contacts of the paper's."""

MASS, BELT_MASS, WEIGHT = 2e-3, 1e-2, 5.0
"""Of the skipping block [kg], [kg], [N]: about a motor's tip, and a rotor as light as to answer."""

NUDGE = 0.4
"""Push over what friction can hold."""


def attempt(
    motor: Motor,
    law: ContactLaw,
    duration: float,
    contact_step: float | None = None,
    record_interval: float | None = None,
    tolerance: float | None = None,
) -> Trajectory:
    """Make a run, whatever becomes of it; without a record interval it is recorded at its ends only."""
    return simulate(
        motor,
        law,
        duration=duration,
        record_interval=duration if record_interval is None else record_interval,
        contact_step=contact_step,
        tolerance=tolerance,
    )


def completed(trajectory: Trajectory) -> Trajectory:
    """Give a run back that has reached its end.

    Raises:
        RuntimeError: it has not.
    """
    if not trajectory.ending.reached_end:
        raise RuntimeError(f"{trajectory.law.name}: {trajectory.message}")
    return trajectory


def run(*of_attempt: Any, **named: Any) -> Trajectory:
    """Make a run as `attempt` does that must reach its end, or raise a RuntimeError."""
    return completed(attempt(*of_attempt, **named))


def first(trajectory: Trajectory, name: str) -> float:
    """Give a column of the first contact."""
    return float(trajectory.contacts[name][0])


def last(trajectory: Trajectory, name: str) -> float:
    """Give the last record of a series."""
    return float(trajectory.series[name][-1])


@final
@dataclass(frozen=True)
class Bench:
    """Hold a law and the runs that its contract is checked on, each made once.

    Args:
        law: under test.
        make_motor: gives a motor that the law can drive, at its default contact step.
    """

    law: ContactLaw
    make_motor: Callable[[], Motor] = field(default=paper_motor)

    @cached_property
    def rigid(self) -> bool:
        """Whether the law is a `MultiplierLaw`."""
        return isinstance(self.law, MultiplierLaw)

    @cached_property
    def balance(self) -> float:
        """What energy and momentum may miss, as a share, at default steps: the order-one laws more."""
        return 1e-3 if self.rigid else 1e-6

    @cached_property
    def motor(self) -> Motor:
        """The motor."""
        return self.make_motor()

    @property
    def motor_run(self) -> Trajectory:
        """The law in the motor, recorded finely."""
        return completed(self._motor_run)

    @property
    def skipping(self) -> Trajectory:
        """A block that is thrown onto a moving belt at a slant and pressed on by its weight."""
        return completed(self._skipping)

    @property
    def runs(self) -> tuple[tuple[str, Trajectory], ...]:
        """Both with a word for each."""
        return (("motor", self.motor_run), ("block", self.skipping))

    def attempt_motor(self, law: ContactLaw, motor: Motor) -> Trajectory:
        """Make a run as `motor_run` of another law or motor, whatever becomes of it."""
        step = self.law.default_contact_step
        # Finer than the steps of a rigid law, fine against a contact of a compliant one.
        interval = 0.4 * step if self.rigid else 1e-7
        return attempt(motor, law, MOTOR_DURATION, step, interval)

    # A run that fails may take long to do so: it is made once, and every property told of it.
    @cached_property
    def _motor_run(self) -> Trajectory:
        return self.attempt_motor(self.law, self.motor)

    @cached_property
    def _skipping(self) -> Trajectory:
        thrown = {"height": 1e-6, "gap_rate": -0.1, "velocity": 0.05, "belt_velocity": -0.02}
        motor = block(MASS, weight=WEIGHT, belt_mass=BELT_MASS, **thrown)
        return attempt(motor, self.law, 1e-3, record_interval=1e-6)

    @cached_property
    def nudged(self) -> Trajectory:
        """A block that lies on a belt at rest and is pushed with less than friction can hold."""
        push = NUDGE * self.law.friction_limit * WEIGHT
        motor = block(MASS, height=self._balanced_gap(), weight=WEIGHT, push=push)
        # An interval that no number of steps fills, or a chatter of two steps could hide in it.
        return run(motor, self.law, 2e-3, record_interval=1.03e-6)

    def _balanced_gap(self) -> float:
        """Gap [m] at which the law carries the weight without motion; a rigid one at zero."""
        law = self.law
        if not isinstance(law, PenaltyLaw):
            return 0.0
        # A law that reads beyond its parameters answers with what happens to lie there.
        parameters, (force, *_), law_errors = take_in(law)

        def missing(exponent: float) -> float:
            with law_errors():
                normal: float = force(-(10.0**exponent), 0.0, 0.0, 0.0, parameters)[0]
            return normal - WEIGHT

        # From shallow to deep: how deep the law is valid is not known.
        depths = (0.5 * k for k in range(-30, 1))
        enough = next((e for e in depths if not missing(e) < 0.0), 0.0)
        if not missing(enough) >= 0.0:
            raise RuntimeError(
                f"{law.name}: its normal force does not carry {WEIGHT:g} N at any penetration."
            )
        exponent: float = brentq(missing, -15.0, enough, xtol=1e-15)
        return float(-(10.0**exponent))

    def converging(self) -> tuple[list[float], list[Trajectory]]:
        """Give tolerances or contact steps [s], and their runs with a much finer one at the end.

        Raises:
            RuntimeError: one of them does not reach its end, or not even `motor_run`.
        """
        completed(self._motor_run)
        motor, step, end = self.motor, self.law.default_contact_step, MOTOR_DURATION
        if self.rigid:
            sizes = [step * 2.0**k for k in range(5, -1, -1)]
            return sizes, [run(motor, self.law, end, size) for size in (*sizes, step / 16.0)]
        sizes = [10.0**-k for k in range(2, 7)]
        runs = [run(motor, self.law, end, 2.0 * step, tolerance=size) for size in sizes]
        return sizes, [*runs, run(motor, self.law, end, 0.5 * step, tolerance=1e-10)]
