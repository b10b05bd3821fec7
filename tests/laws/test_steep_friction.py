"""Rate and state at plate rate: a friction far steeper in the slip than what a step of the motion resolves.

A slider on a spring creeps near its steady slip V, where a N/(V m) is 1e5 to 1e12 1/s. Its way is that of a
stiff integrator, whatever its forces, its mass and how its load is written.
"""

from dataclasses import dataclass, replace
from math import asinh, exp, log, pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PPoly

import contactlab as cl
from contactlab.checks import SMALLEST_STEP
from contactlab.engine import simulate
from contactlab.engine.defaults import default_contact_step
from contactlab.motor.bodies import way_of
from contactlab.trajectory import Trajectory

EPS = float(np.finfo(np.float64).eps)

GROUND = cl.RateAndState(0.6, 0.01, 0.014, 1e-3, 1e-6, creep_velocity=1e-18)
PLATE = cl.RateAndState(0.3, 0.01, 0.015, 1e-6, 1e-6, creep_velocity=1e-15)


@dataclass(frozen=True)
class Slider:
    """A body under a pressure, pulled at a speed by a spring; it rests on a bed, in units of SI.

    What holds the mean friction is a push, or else the stretch that the spring has at the start.
    """

    normal: float = 10.0
    mass: float = 1e-4
    dashpot: float = 0.5
    spring: float = 7e-7 * pi / 16.0 * 30e6
    bed: float = 1e3
    pushed: bool = True
    speed: float = 1e-9
    friction: cl.RateAndState = GROUND
    age: float = 0.9
    """Age of the contact at the start over that of steady slip [1]."""

    @property
    def first_age(self) -> float:
        return self.age * self.friction.renewal_distance / self.speed

    @property
    def resistance(self) -> float:
        """Friction of steady slip [N]."""
        effect = self.friction.direct_effect - self.friction.evolution_effect
        ratio = self.speed / self.friction.reference_velocity
        return self.normal * (self.friction.friction_coefficient + effect * log(ratio))

    def scaled(self, scale: float) -> "Slider":
        """This problem with all forces and masses times a scale."""
        names = "normal", "mass", "dashpot", "spring", "bed"
        return replace(self, **{name: scale * getattr(self, name) for name in names})

    def run(self, duration: float, step: float | None = None) -> Trajectory:
        motor = cl.block(
            self.mass,
            weight=self.normal,
            height=-self.normal / self.bed,
            stiffness=self.spring,
            load_velocity=cl.Waveform(PPoly(np.array([[[self.speed]]]), np.array([0.0, 1e12]))),
            velocity=self.speed,
            way=0.0 if self.pushed else -self.resistance / self.spring,
            push=self.resistance if self.pushed else 0.0,
        )
        braked = replace(motor.modes, damping=np.array([0.0, self.dashpot / self.mass]))
        friction = replace(self.friction, fresh_age=self.first_age)
        law = cl.Composed(cl.Linear(self.bed), cl.Undamped(), friction)
        times = {"duration": duration, "record_interval": duration, "contact_step": step}
        run = simulate(replace(motor, modes=braked), law, **times)
        assert run.complete, run.message
        return run

    def right_way(self, duration: float) -> float:
        """Way by Radau's method, seen from where it begins."""
        law = self.friction

        def rates(t: float, y: np.ndarray) -> tuple[float, float, float]:
            x, v, z = y
            exponent = (law.friction_coefficient + law.evolution_effect * z) / law.direct_effect
            risen = asinh(v / (2.0 * law.reference_velocity) * exp(exponent))
            force = self.spring * (self.speed * t - x) + self.resistance - self.dashpot * v
            force -= self.normal * law.direct_effect * risen
            return v, force / self.mass, (law.reference_velocity * exp(-z) - abs(v)) / law.renewal_distance

        start = 0.0, self.speed, log(law.reference_velocity * self.first_age / law.renewal_distance)
        least = 1e-11 * self.speed * duration, 1e-11 * self.speed, 1e-11
        return float(solve_ivp(rates, (0.0, duration), start, "Radau", rtol=1e-10, atol=least).y[0, -1])

    def digits(self, run: Trajectory, duration: float) -> float:
        """What round-off leaves of a way [1].

        A slip is the difference of what push and friction move in a step, some tens of terms; a way that of
        two stretches of the spring, to which every step adds.
        """
        steps = run.statistics["contact_steps"]
        moved = self.resistance * duration / steps / self.mass
        stretch = 0.0 if self.pushed else self.resistance / self.spring
        return EPS * (32.0 * moved / self.speed + stretch * steps / (self.speed * duration))


def way(run: Trajectory) -> float:
    ways = way_of(run.series["tip_slope"])
    return float(ways[-1] - ways[0])


CREEPS = {
    "spring of a square metre": (Slider(pushed=False).scaled(1e7), 0.1, 1e-3),
    "push of a square metre": (Slider().scaled(1e7), 0.1, None),
    "spring": (Slider(pushed=False), 0.1, 1e-3),
    "push": (Slider(), 0.1, None),
    "heavy": (Slider(mass=1.0, dashpot=0.0, spring=1e3, bed=1e6), 0.1, None),
    "stiff bed": (Slider(bed=1e6), 0.01, None),
    "stiffest bed": (Slider(bed=1e9), 0.01, None),
    "ten grams": (Slider(mass=1e-2), 0.01, None),
    "a kilogram on a stiff bed": (Slider(mass=1.0, bed=1e6), 0.1, None),
    "plate": (Slider(mass=1.0, dashpot=0.0, spring=1e6, bed=1e9, friction=PLATE), 0.05, None),
    "plate, faster": (Slider(10.0, 1.0, 0.0, 1e6, 1e9, speed=1e-8, friction=PLATE), 0.05, None),
    "plate, a tonne": (Slider(10.0, 1e3, 0.0, 1e6, 1e9, friction=PLATE), 0.05, None),
    "at the reference velocity": (
        Slider(10.0, 1e-3, 0.0, 2.5e4, 10.0, speed=1e-6, friction=PLATE, age=1.0),
        0.05,
        1e-3,
    ),
}


@pytest.mark.parametrize("name", CREEPS)
def test_a_creep_has_the_way_of_a_stiff_integrator(name: str) -> None:
    slider, duration, step = CREEPS[name]
    run = slider.run(duration, step)
    assert way(run) == pytest.approx(slider.right_way(duration), rel=2e-10 + slider.digits(run, duration))
    done = run.series["friction_loss"][-1] / (slider.resistance * way(run))
    assert done == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("scale", [2.0**-24, 2.0**24])
def test_a_creep_does_not_hang_on_the_scale_of_forces(scale: float) -> None:
    slider = Slider()
    first, scaled = slider.run(0.01), slider.scaled(scale).run(0.01)
    assert way(scaled) == pytest.approx(way(first), rel=slider.digits(first, 0.01))
    assert first.statistics == scaled.statistics


def test_steep_friction_takes_the_steps_of_the_motion_and_few_sweeps() -> None:
    """A slider just stiffer than critical at ten times its reference velocity, m V/(a N) of a tenth of a us.

    The bed swings at 1e5 rad/s: each period costs a few steps and two dozen sweeps at most; a step
    that would not resolve it costs none.
    """
    normal, mass, bed, speed, duration = 10.0, 1e-3, 1e7, 1e-5, 0.02
    friction = cl.RateAndState(0.6, 0.01, 0.015, 1e-6, 1e-6, fresh_age=1e-6 / speed, creep_velocity=1e-12)
    spring = 1.02 * normal * 0.005 / 1e-6 * (1.0 + mass * speed**2 / (normal * 0.01 * 1e-6))
    resistance = normal * (0.6 - 0.005 * log(speed / 1e-6))
    motor = cl.block(
        mass,
        height=-normal / bed,
        weight=normal,
        stiffness=spring,
        way=-1.0005 * resistance / spring,
        belt_velocity=-speed,
    )
    law = cl.Composed(cl.Linear(bed), cl.Undamped(), friction)
    run = simulate(motor, law, duration=duration, record_interval=duration, contact_step=1e-3)
    assert run.complete, run.message
    period = 2.0 * pi * (mass / bed) ** 0.5
    assert run.statistics["contact_steps"] < 6.0 * duration / period
    assert run.statistics["sweeps"] < 24.0 * duration / period


def test_a_default_step_moves_the_clock_of_any_run() -> None:
    for duration in (1e-3, 1.0, 1e7, 1e10):
        step = default_contact_step(cl.oscillator(1.0, 1e4, gap=1e-3), cl.HertzPenalty(), duration)
        assert step is not None
        assert step >= SMALLEST_STEP * duration
