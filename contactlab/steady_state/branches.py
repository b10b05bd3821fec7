"""Periodic orbits of a motor over one number of its configuration, or over the velocity of a belt."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import Final, final

import numpy as np
import xarray

from contactlab.config import ConfigurationError, Setup, build
from contactlab.config.made_in_python import variable_numbers, with_number
from contactlab.config.nesting import flat, nested
from contactlab.config.schema import declared_in
from contactlab.laws import ContactLaw
from contactlab.motor import Motor
from contactlab.parameter import Parameter, from_cf
from contactlab.settling.statistics import WITHOUT_CONTACT
from contactlab.steady_state.arrival import NotSettledError, settled
from contactlab.steady_state.continuation import BranchPoint, MapAt, Mark, follow
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap
from contactlab.steady_state.search import LONGEST, steady, steady_setup
from contactlab.steady_state.shooting import NoOrbitError, orbit_from
from contactlab.steady_state.state import attributes_of, flags
from contactlab.suggestion import suggestion

BELT: Final = "belt"
"""The parameter that is no key: the velocity at which the rotor is held [rad/s]."""


OF_RUN: Final = ("solver", "record")
"""Groups on whose numbers no orbit depends but by its numerical error."""

ASIDE: Final = 1e-9
"""Change of a number, over that, by which it is seen whether the motor takes another one."""


class NoBranchError(ValueError):
    """There is no orbit to begin with; the message is a sentence."""


@final
@dataclass(frozen=True)
class Branch:
    """A branch of periodic orbits.

    Args:
        setup: at the start of the branch.
        parameter, unit, meaning: what changes along it: a key, its SI unit and what it is.
        points: the orbits in the order in which they were met, events among them.
        end: why it goes no further, in a sentence.
    """

    setup: Setup
    parameter: str
    unit: str
    meaning: str
    points: tuple[BranchPoint, ...]
    end: str

    def __repr__(self) -> str:
        first, last = self.points[0].value, self.points[-1].value
        span = f"from {first:.6g} to {last:.6g} {self.unit}"
        return f"<Branch: {len(self.points)} orbits over {self.parameter}, {span}; {len(self.events)} events>"

    @property
    def events(self) -> tuple[BranchPoint, ...]:
        """The points at which something happens, see `Mark`."""
        return tuple(point for point in self.points if point.mark)

    def to_xarray(self) -> xarray.Dataset:
        """Return a dataset over `point`, the multipliers over `multiplier`, the largest first."""
        each = [point.orbit.multipliers for point in self.points]
        # In contact the state has the internal variables of the contact, too.
        most = max(values.size for values in each)
        multipliers = np.array([np.append(v, np.full(most - v.size, np.nan)) for v in each])
        columns: dict[str, tuple[str, str, Callable[[BranchPoint], float]]] = {
            "value": (self.unit, f"{self.parameter}, {self.meaning}", lambda p: p.value),
            "rotor_velocity": ("rad s-1", "mean angular velocity of the rotor", lambda p: p.velocity),
            "rotor_velocity_error": ("rad s-1", "error of the mean velocity", lambda p: p.velocity_error),
            "torque": ("N m", "mean torque of the contact on the rotor", lambda p: p.torque),
            "friction_force": ("N", "mean friction force on the tip", lambda p: p.friction_force),
            "settling_time": ("s", "time to fall by e, of small deviations", lambda p: p.orbit.settling_time),
            "roughness": ("1", "change of the map's derivative nearby", lambda p: p.orbit.roughness),
            "contacts": ("1", "contacts in a period of the orbit", lambda p: p.contacts),
            "softest_approach": ("m s-1", "smallest speed of a touch-down", lambda p: p.softest),
        }
        data = xarray.Dataset(
            {
                name: ("point", [get(p) for p in self.points], {"units": unit, "long_name": text})
                for name, (unit, text, get) in columns.items()
            }
        )
        for name, part in {"real": multipliers.real, "imaginary": multipliers.imag}.items():
            text = f"{name} part of the Floquet multipliers"
            data[f"multiplier_{name}"] = (("point", "multiplier"), part, {"units": "1", "long_name": text})
        largest = {"units": "1", "long_name": "largest modulus of a multiplier"}
        data["largest_multiplier"] = ("point", np.abs(multipliers[:, 0]), largest)
        stable = np.array([point.orbit.stable for point in self.points], dtype=np.int8)
        data["stable"] = ("point", stable, flags("whether the orbit is stable", ("unstable", "stable")))
        marks = np.array([point.mark for point in self.points], dtype=np.int8)
        data["mark"] = ("point", marks, flags("what happens there", [mark.name.lower() for mark in Mark]))
        data.attrs = {
            "title": f"Periodic orbits over {self.parameter}, {self.setup.law.title}",
            "parameter": self.parameter,
            "drive_periods": self.points[0].orbit.map.periods,
            "end": self.end,
            **attributes_of(self.setup),
        }
        if self.parameter != BELT and (belt := self.points[0].orbit.map.belt) is not None:
            data.attrs["belt"] = belt
        return data


def branch(
    motor: Motor | Setup,
    parameter: str,
    start: float,
    end: float,
    *,
    law: ContactLaw | None = None,
    belt: float | None = None,
    step: float = 0.02,
) -> Branch:
    """Follow the periodic orbits of a motor while one number changes; arguments as of `contactlab.branch`.

    The branch begins with the orbit in which the motor settles at the start, and continues through folds and
    along unstable orbits until the number leaves its range or no orbit continues it (`Branch.end`).
    """
    if start == end:
        raise NoBranchError(f"The range begins and ends at {start:g}; it must have two ends that differ.")
    setup = steady_setup(motor, law)
    unit, meaning = _declared(setup, parameter)
    at = family(setup, parameter, belt)
    # G(y) = P(z; parameter) - z needs one state z all along.
    sizes = [len(at(value).setup.law.lasting) for value in (start, end)]
    if sizes[0] != sizes[1]:
        raise NoBranchError(
            f"The law has {sizes[0]} internal variables of the run at {parameter}={start:g} and {sizes[1]} "
            f"at {end:g}; a branch needs the same state all along. Choose a range within which they stay."
        )
    # The first orbit is the one that the motor settles in; continuation needs it closed, and its own.
    first = steady(at(start).setup, belt=start if parameter == BELT else belt)
    orbit = first.orbit
    if first.kind == WITHOUT_CONTACT:
        # Free vibration is an orbit, too.
        section = replace(at(start), phase=first.phase)
        with suppress(NoOrbitError, BrokenOffError):
            orbit = orbit_from(section, section.end_of(first.motion))
    if orbit is None:
        raise NoBranchError(
            f"At {parameter}={start:g} the motion of the motor is {first.kind}, and no closed orbit was "
            "found next to it; a branch begins with one. Choose another start."
        )
    if orbit.neutral.any():
        raise NoBranchError(
            f"At {parameter}={start:g} nothing brings the motion back along {orbit.neutral.sum()} of "
            "its directions, as the velocity of a rotor without friction: a branch follows single orbits. "
            "Hold the rotor by `belt`, or give it friction or damping."
        )
    followed = follow(at, orbit, start, end, step)
    # Where the branch ends within its range, see what the motor itself does a hundredth of the range on.
    beyond = "" if followed.points[-1].value == end else _beyond(at, followed.points, 0.01 * abs(end - start))
    return Branch(first.setup, parameter, unit, meaning, followed.points, followed.end + beyond)


def _beyond(at: MapAt, points: tuple[BranchPoint, ...], ahead: float) -> str:
    """Return what the motor comes to a little beyond a branch that ends in its range, in a sentence."""
    last, section = points[-1], points[-1].orbit.map
    # The parameter goes on as at the end, which may be backwards.
    heading = np.sign(last.value - points[-2].value) if len(points) > 1 else 0.0
    value = float(last.value + heading * ahead)
    if not heading:
        return ""
    try:
        # The motor starts in the branch's last orbit, with the parameter a little beyond it.
        begins = section.phase, *section.parts_of(last.orbit.state), section.contact
        state = settled(at(value).setup, at(value).belt, begins, LONGEST)
        assert state is not None
    except (NotSettledError, BrokenOffError, ValueError) as fault:
        return f" From there the motor comes to no steady state at {value:.7g}: {fault}"
    text = state.velocity.text() if state.belt is None else f"{state.belt:.6g}"
    return (
        f" From there the motor comes to another motion at {value:.7g}, which is {state.kind} and has "
        f"{text} rad/s; begin a branch with it to follow it."
    )


def family(setup: Setup, parameter: str, belt: float | None = None) -> MapAt:
    """Return the function from a value of a parameter to the period map of the motor that has it."""
    if parameter == BELT:
        return lambda value: PeriodMap(setup, belt=value)
    values = flat(setup.configuration)
    made_in_python = "resonator" not in setup.configuration

    # Continuation evaluates the same value several times in a row.
    @lru_cache(maxsize=4)
    def map_at(value: float) -> PeriodMap:
        if made_in_python:
            return PeriodMap(with_number(setup, parameter, value), belt=belt)
        return PeriodMap(build(nested(values | {parameter: value})), belt=belt)

    return map_at


def unit_of(setup: Setup, parameter: str) -> str:
    """Return the unit in which a parameter is written; a ConfigurationError says that it is none."""
    return from_cf(_declared(setup, parameter)[0])


def numbers_of(setup: Setup) -> dict[str, Parameter]:
    """Return the declarations of the numbers of a motor and a law, by the keys that a branch takes."""
    if "resonator" not in setup.configuration:
        numbers = variable_numbers(setup).items()
        return {key: field.parameter for key, (_, field) in numbers if field.parameter}
    declared = declared_in(setup.configuration).items()
    return {key: each for key, each in declared if key.partition(".")[0] not in OF_RUN}


def _declared(setup: Setup, parameter: str) -> tuple[str, str]:
    """Return unit and meaning of a parameter that takes real numbers."""
    if parameter == BELT:
        return "rad s-1", "velocity at which the rotor is held"
    numbers = numbers_of(setup)
    if parameter not in numbers:
        names = [BELT, *filter(partial(_has, setup), numbers)]
        known = suggestion(parameter, [BELT, *numbers], f"It must be one of {', '.join(names)}.")
        raise ConfigurationError([f"{parameter} is no number that a branch follows. {known}"])
    if isinstance(flat(setup.configuration).get(parameter), int):
        raise NoBranchError(
            f"{parameter} is a whole number; a branch follows one that changes continuously, such as "
            "contact.clearance. `contactlab -m` runs whole numbers one by one."
        )
    result = numbers[parameter]
    return result.units, result.meaning


def _has(setup: Setup, key: str) -> bool:
    """Return whether a motor has a number, and may have another one beside it."""
    value = flat(setup.configuration).get(key)
    if value is None or isinstance(value, int):
        return False
    # A number at a bound has a neighbour on one side.
    for near in (value - ASIDE * (abs(value) or 1.0), value + ASIDE * (abs(value) or 1.0)):
        with suppress(ValueError):
            family(setup, key, None)(near)
            return True
    return False
