"""Plants of tests and benches, and runs of them; a `block` is that of `contactlab.motor.bodies`."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi
from typing import Any, final

import numpy as np

from contactlab.engine import simulate
from contactlab.laws import ContactLaw, MultiplierLaw
from contactlab.laws.base import is_stepped
from contactlab.motor import RitzResonator
from contactlab.motor.bodies import FLAT as FLAT, HEAVY as HEAVY, block as block, way_of as way_of
from contactlab.motor.drive import Drive
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, Motor, Rotor
from contactlab.trajectory import Trajectory


def paper_motor() -> Motor:
    """Return the paper's motor: placement 2, 1 um clearance, 100 V at 3210 and 6420 Hz, phase -pi/5."""
    return Motor(RitzResonator().modes, Drive.two_mode(100.0, 100.0, 3210.0, 2.0, -pi / 5.0))


def coupled_body(seed: int, approach: float = 0.3) -> Motor:
    """Draw a body whose modes couple both directions, about to touch a rotor at a gap rate [m/s]."""
    rng, modes = np.random.default_rng(seed), RitzResonator().modes
    tip, slope, velocity = rng.normal(size=(3, modes.stiffness.size)) * [[20.0], [1e3], [1e-3]]
    # Along u the tip approaches as wanted, and the modes keep the rest of what was drawn.
    along = tip / (tip @ tip)
    start = ModalState(-1e-12 * along, velocity + (approach - tip @ velocity) * along)
    body = replace(modes, tip_displacement=tip, tip_slope=slope)
    rotor = Rotor(float(rng.uniform(1e-6, 1e-4)), initial_velocity=2.0)
    return Motor(body, Drive(), ContactGeometry(clearance=0.0), rotor, start=start)


def attempt(
    motor: Motor,
    law: ContactLaw,
    duration: float,
    contact_step: float | None = None,
    record_interval: float | None = None,
    tolerance: float | None = None,
) -> Trajectory:
    """Make a run, whatever becomes of it; without a record interval it is recorded at its ends only."""
    steps: dict[str, Any] = {"contact_step": contact_step, "tolerance": tolerance}
    interval = record_interval or duration
    return simulate(motor, law, duration=duration, record_interval=interval, **steps)


def completed(trajectory: Trajectory) -> Trajectory:
    """Return a run back that has reached its end, or raise a RuntimeError with the reason why it has not."""
    if not trajectory.ending.reached_end:
        raise RuntimeError(f"{trajectory.law.name}: {trajectory.message}")
    return trajectory


def run(*of_attempt: Any, **named: Any) -> Trajectory:
    """Make a run as `attempt` does that must reach its end, or raise a RuntimeError."""
    return completed(attempt(*of_attempt, **named))


def first(trajectory: Trajectory, name: str) -> float:
    """Return a column of the first contact."""
    return float(trajectory.contacts[name][0])


def last(trajectory: Trajectory, name: str) -> float:
    """Return the last record of a series."""
    return float(trajectory.series[name][-1])


MOTOR_DURATION = 1.5e-3
"""Of the run of a bench's motor [s]: five contacts of the paper's."""

MASS, BELT_MASS, WEIGHT = 2e-3, 1e-2, 5.0
"""Of the skipping block [kg], [kg], [N]: about a motor's tip, and a rotor as light as to answer."""


@final
@dataclass(frozen=True, eq=False)
class Bench:
    """Hold a law and the runs that its contract is checked on, each made once, even where it fails.

    The motor is one that the law can drive at its default contact step.
    """

    law: ContactLaw
    make_motor: Callable[[], Motor] = paper_motor

    @property
    def rigid(self) -> bool:
        """Whether the law is a `MultiplierLaw`."""
        return isinstance(self.law, MultiplierLaw)

    @property
    def balance(self) -> float:
        """What energy and momentum may miss by default, as a share: time stepping more."""
        return 1e-3 if is_stepped(self.law, self.step) else 1e-6

    @property
    def step(self) -> float | None:
        """Contact step of the runs in the motor [s]; None of a rigid law in its limit of no step."""
        return None if self.rigid else self.law.default_contact_step

    @cached_property
    def motor(self) -> Motor:
        """The motor that the law drives."""
        return self.make_motor()

    def attempt_motor(self, motor: Motor) -> Trajectory:
        """Make a finely recorded run of a motor with the law, whatever becomes of it."""
        # Finer than the steps of time stepping, fine against a contact.
        interval = 0.4 * self.law.default_contact_step if self.rigid else 1e-7
        return attempt(motor, self.law, MOTOR_DURATION, self.step, interval)

    @cached_property
    def motor_run(self) -> Trajectory:
        """The law in the motor."""
        return self.attempt_motor(self.motor)

    @cached_property
    def skipping(self) -> Trajectory:
        """A block that is thrown onto a moving belt at a slant and pressed on by its weight."""
        thrown = {"height": 1e-6, "gap_rate": -0.1, "velocity": 0.05, "belt_velocity": -0.02}
        motor = block(MASS, weight=WEIGHT, belt_mass=BELT_MASS, **thrown)
        return attempt(motor, self.law, 1e-3, record_interval=1e-6)

    @property
    def runs(self) -> dict[str, Trajectory]:
        """Both, once they have reached their ends."""
        return {"motor": completed(self.motor_run), "block": completed(self.skipping)}


def impulses_of(law: MultiplierLaw, gap_rate: float, slip: float, delassus: tuple[float, ...]) -> Any:
    """Return normal and friction impulse [N s] of an impact at a gap rate and a slip [m/s].

    The Delassus matrix is given by D_nn, D_nt, D_tt [1/kg].
    """
    d_nn, d_nt, d_tt = delassus
    return law.evaluate("impact", approach=gap_rate, slip=slip, d_nn=d_nn, d_nt=d_nt, d_tt=d_tt)
