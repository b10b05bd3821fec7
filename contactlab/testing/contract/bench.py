"""The runs that the contract of a law is checked on, each made once."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import pi
from typing import final

from scipy.optimize import brentq

from contactlab.laws import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.motor import RitzResonator
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.testing.plants import block
from contactlab.testing.runs import attempt, completed, run
from contactlab.trajectory import Trajectory

MOTOR_DURATION = 1.5e-3
"""Of the run of the motor [s]: five contacts of the paper's."""

MASS, BELT_MASS, WEIGHT = 2e-3, 1e-2, 5.0
"""Of the skipping block [kg], [kg], [N]: about a motor's tip, and a rotor as light as to answer."""

DEPTHS = tuple(0.5 * k for k in range(-30, 1))
"""Logarithms of penetrations at which a law may carry the weight."""

NUDGE = 0.4
"""Push over what friction can hold."""


def paper_motor() -> Motor:
    """Placement 2, 1 um clearance, 100 V at 3210 and 6420 Hz, phase -pi/5."""
    return Motor(RitzResonator().modes, Drive.two_mode(100.0, 100.0, 3210.0, 2.0, -pi / 5.0))


def mirrored(motor: Motor) -> Motor:
    """The same motor seen in a mirror that exchanges left and right."""
    rotor = replace(
        motor.rotor,
        initial_velocity=-motor.rotor.initial_velocity,
        load_torque=-motor.rotor.load_torque,
    )
    return replace(motor, modes=replace(motor.modes, tip_slope=-motor.modes.tip_slope), rotor=rotor)


@final
@dataclass(frozen=True)
class Bench:
    """A law and the runs that claims are made about.

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

    @cached_property
    def record_interval(self) -> float:
        """Finer than the steps of a rigid law, fine against a contact of a compliant one [s]."""
        return 0.4 * self.law.default_contact_step if self.rigid else 1e-7

    @property
    def motor_run(self) -> Trajectory:
        """The law in the motor, recorded finely."""
        return completed(self._motor_run)

    def run_motor(self, law: ContactLaw, motor: Motor | None = None) -> Trajectory:
        """A run as `motor_run` of another law or motor."""
        return completed(self._attempt(law, self.motor if motor is None else motor))

    @property
    def skipping(self) -> Trajectory:
        """A block that is thrown onto a moving belt at a slant and pressed on by its weight."""
        return completed(self._skipping)

    # A run that fails may take long to do so: it is made once, and every property told of it.
    @cached_property
    def _motor_run(self) -> Trajectory:
        return self._attempt(self.law, self.motor)

    def _attempt(self, law: ContactLaw, motor: Motor) -> Trajectory:
        step = self.law.default_contact_step
        return attempt(motor, law, MOTOR_DURATION, step, self.record_interval)

    @cached_property
    def _skipping(self) -> Trajectory:
        motor = block(
            MASS,
            height=1e-6,
            gap_rate=-0.1,
            velocity=0.05,
            weight=WEIGHT,
            belt_mass=BELT_MASS,
            belt_velocity=-0.02,
        )
        return attempt(motor, self.law, 1e-3, record_interval=1e-6)

    @cached_property
    def nudged(self) -> Trajectory:
        """A block that lies on a belt at rest and is pushed with less than friction can hold."""
        push = NUDGE * self.law.friction_limit * WEIGHT
        motor = block(MASS, height=self._balance(), weight=WEIGHT, push=push)
        # An interval that no number of steps fills, or a chatter of two steps could hide in it.
        return run(motor, self.law, 2e-3, record_interval=1.03e-6)

    def _balance(self) -> float:
        """Gap [m] at which the law carries the weight without motion; a rigid one at zero."""
        law = self.law
        if not isinstance(law, PenaltyLaw):
            return 0.0
        force, parameters = law.force, law.parameters()

        def missing(exponent: float) -> float:
            return force(-(10.0**exponent), 0.0, 0.0, 0.0, parameters)[0] - WEIGHT

        # From shallow to deep: how deep the law is valid is not known.
        enough = next((e for e in DEPTHS if not missing(e) < 0.0), 0.0)
        if not missing(enough) >= 0.0:
            raise RuntimeError(
                f"{law.name}: its normal force does not carry {WEIGHT:g} N at any penetration."
            )
        exponent: float = brentq(missing, -15.0, enough, xtol=1e-15)
        return float(-(10.0**exponent))

    def converging(self) -> tuple[list[float], list[Trajectory]]:
        """Tolerances or contact steps [s], and their runs with a much finer one at the end.

        Raises:
            RuntimeError: one of them does not reach its end, or not even `motor_run`.
        """
        completed(self._motor_run)
        motor, step, end = self.motor, self.law.default_contact_step, MOTOR_DURATION
        if self.rigid:
            sizes = [step * 2.0**k for k in range(5, -1, -1)]
            runs = [run(motor, self.law, end, size) for size in sizes]
            return sizes, [*runs, run(motor, self.law, end, step / 16.0)]
        sizes = [10.0**-k for k in range(2, 7)]
        runs = [run(motor, self.law, end, 2.0 * step, tolerance=size) for size in sizes]
        return sizes, [*runs, run(motor, self.law, end, 0.5 * step, tolerance=1e-10)]
