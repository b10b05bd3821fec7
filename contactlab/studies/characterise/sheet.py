"""The data sheet of a motor as a dataset: quantities, speed-torque curve and numbers of the motor."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, Final

import numpy as np
import xarray

from contactlab.config import Setup
from contactlab.estimate import Estimate
from contactlab.progress import part_of_progress
from contactlab.results.netcdf import cf_attributes
from contactlab.steady_state.period_map import contact_at_end, memory_at_end, variables_in
from contactlab.studies.characterise.operation import UNKNOWN, Point, operate
from contactlab.studies.characterise.transients import holding_torque, start_time, stop_time
from contactlab.studies.study import Part
from contactlab.variables import Variable

FIRST: Final = (-0.25, 0.0, 0.25, 0.5, 0.75, 1.0, 1.25)
"""Velocities over that without load on which a curve begins."""

MOST: Final = 12
"""Prescribed speeds that show the shape of a curve."""

STRAIGHT: Final = 0.04
"""Distance of a point from the line between its neighbours, over the largest torque, below which the
curve is straight."""

CLOSEST: Final = 2e-3
"""Smallest distance of two prescribed speeds over the velocity without load."""

ZERO: Final = 1e-4
"""Torque over the largest that counts as zero."""

BEST: Final = ("output_power", "electrical_efficiency")
"""Quantities whose greatest value a curve contains."""

QUADRANTS: Final = {(1, 1): "brakes", (-1, 1): "turns the motor back", (1, -1): "drives the motor on"}
"""What the load does, by the signs of velocity and torque."""


class Curve:
    """A speed-torque curve in the making.

    Args:
        setup: motor and law.
        velocity: of the rotor without load [rad/s]; its sign is the motor's sense.
    """

    def __init__(self, setup: Setup, velocity: float) -> None:
        self._setup, self._velocity = setup, velocity
        self._points: dict[float, Point] = {}
        for share in FIRST:
            self._add(share)
        while len(self._points) < MOST and self._add(self._bend()):
            pass
        for name in BEST:
            self._add(self._top(name))
        while self._add(self._crossing()):
            pass

    @property
    def points(self) -> list[Point]:
        """The points in the order of their velocities, which are in the motor's sense."""
        return [self._points[share] for share in sorted(self._points)]

    def _add(self, share: float | None) -> bool:
        """Add the point at a share of the velocity unless one is close; return whether it was added."""
        if share is None or any(abs(share - other) < CLOSEST for other in self._points):
            return False
        count = len(self._points)
        # How many there will be depends on the curve.
        begin, end = (min(each / MOST, 1.0) for each in (count, count + 1))
        with part_of_progress(begin, end, f"operating point {count + 1}: "):
            point = operate(self._setup, self._velocity * share)
        self._points[share] = point.turned(float(np.sign(self._velocity)))
        return True

    def _known(self, name: str) -> tuple[list[float], list[float]]:
        """Return shares and values of a quantity where it is known."""
        values = {share: self._points[share].value(name) for share in sorted(self._points)}
        known = [share for share, value in values.items() if np.isfinite(value)]
        return known, [values[share] for share in known]

    def _bend(self) -> float | None:
        """Return the middle of the longer interval at the sharpest bend; None where there is no sharp one."""
        known, torques = self._known("torque")
        rows = zip(known, known[1:], known[2:], torques, torques[1:], torques[2:], strict=False)
        worst, result = STRAIGHT * max(map(abs, torques), default=0.0), None
        for a, b, c, at_a, at_b, at_c in rows:
            distance = abs(at_b - at_a - (at_c - at_a) * (b - a) / (c - a))
            if distance > worst and max(b - a, c - b) > 0.05:
                worst, result = distance, 0.5 * (a + b if b - a > c - b else b + c)
        return result

    def _top(self, name: str) -> float | None:
        """Return where the parabola through a quantity's greatest value and its neighbours has its top."""
        known, values = self._known(name)
        place = int(np.argmax(values)) if values else 0
        if not 0 < place < len(known) - 1:
            return None
        near = slice(place - 1, place + 2)
        a, b, _ = np.polyfit(known[near], values[near], 2)
        return float(np.clip(-0.5 * b / a, known[near][0], known[near][2])) if a < 0.0 else None

    def _crossing(self) -> float | None:
        """Return where the linear interpolant of the torque falls through zero, unless a point is close."""
        known, torques = self._known("torque")
        limit = ZERO * max(map(abs, torques), default=0.0)
        rows = [*zip(pairwise(known), pairwise(torques), strict=True)]
        for (a, b), (at_a, at_b) in reversed(rows):
            if at_a > 0.0 >= at_b:
                near = min(abs(at_a), abs(at_b)) <= limit or b - a < 3.0 * CLOSEST
                return None if near else a + (b - a) * at_a / (at_a - at_b)
        return None


def greatest(points: Iterable[Point], name: str) -> Point | None:
    """Return the point at which a quantity is greatest; None where it is nowhere known."""
    known = [point for point in points if np.isfinite(point.value(name))]
    return max(known, key=lambda point: point.value(name), default=None)


def root(points: Iterable[Point]) -> Estimate:
    """Return the greatest velocity at which the torque falls through zero [rad/s], by linear interpolation.

    Its error is that of the torque over the slope, and that of the interpolation: the distance from the
    nearer point, or what the slopes of the intervals beside would make of it, where that is more. The root
    lies between the two points.
    """
    known = [point for point in points if point.belt is not None and np.isfinite(point.value("torque"))]
    speeds, torques = (np.array([point.value(name) for point in known]) for name in ("velocity", "torque"))
    slopes = -np.diff(torques) / np.diff(speeds)
    for i in reversed(range(slopes.size)):
        if torques[i] > 0.0 >= torques[i + 1]:
            value = float(speeds[i] + torques[i] / slopes[i])
            near = i if value - speeds[i] <= speeds[i + 1] - value else i + 1
            beside = slopes[max(i - 1, 0) : i + 2]
            others = speeds[near] + torques[near] / beside[beside > 0.0]
            missed = max(abs(value - speeds[near]), np.abs(others - value).max())
            within = max(value - speeds[i], speeds[i + 1] - value)
            spread = max(known[i]["torque"].error, known[i + 1]["torque"].error) / slopes[i]
            return Estimate(value, float(min(missed, within) + spread))
    return UNKNOWN


POINT: Final = {name: Variable(name, ("point",), *rest) for name, *rest in (
    ("velocity", "rad s-1", "Omega", "velocity in the motor's own sense of rotation"),
    ("velocity_ripple", "rad s-1", "", "largest less smallest velocity of a free rotor, else zero"),
    ("torque", "N m", "M", "load that the rotor carries, -R F - C_r Omega in the motor's sense: a load that "
     "brakes is positive, one that drives it negative"),
    ("output_power", "W", "P_out", "M Omega, to the load; negative where the load puts power in"),
    ("drive_power", "W", "P_d", "work of the drive on the resonator over time"),
    ("damping_power", "W", "P_c", "loss in the resonator's and the rotor's viscous damping"),
    ("friction_power", "W", "P_f", "loss in friction"),
    ("contact_power", "W", "P_n", "loss in normal damping and impacts"),
    ("dielectric_power", "W", "P_e", "loss in the dielectric of the patches"),
    ("balance", "W", "r", "electrical input less output, losses and stored power; the energy balance error"),
    ("mechanical_efficiency", "1", "eta_m", "output power over the power of the drive"),
    ("electrical_efficiency", "1", "eta_e", "output power over active electrical power"),
    ("active_power", "W", "P", "electrical input: power of the drive and of the dielectric loss"),
    ("apparent_power", "V A", "S", "sum over the electrodes of U_rms I_rms, all tones together"),
    ("power_factor", "1", "P/S", "active over apparent power"),
    ("rms_voltage", "V", "U_rms", "voltage, root mean square over time and electrodes"),
    ("rms_current", "A", "I_rms", "current, root mean square over time and electrodes"),
    ("peak_force", "N", "N_max", "largest normal force"),
    ("contact_share", "1", "t_c/T", "share of the time in contact"),
    ("stick_share", "1", "t_st/t_c", "share of the time in contact that sticks"),
    ("friction_work_per_slip", "J m-1", "W_f/s", "friction work per metre of slip"),
    ("friction_work_per_travel", "J m-1", "W_f/x", "friction work per metre that the rotor's rim travels"),
)}  # fmt: skip
"""Quantities of each point of the speed-torque curve."""

MOTOR: Final = {name: Variable(name, (), *rest) for name, *rest in (
    ("no_load_velocity", "rad s-1", "Omega_0", "velocity of the free rotor in the motor's sense"),
    ("curve_root", "rad s-1", "", "velocity at which a rotor without ripple has no torque, a check"),
    ("stall_torque", "N m", "M_0", "load that holds the rotor at rest"),
    ("holding_torque", "N m", "M_h", "load that moves the rotor when the drive is off"),
    ("start_time", "s", "t_90", "from the start to 90 % of the no-load velocity"),
    ("stop_time", "s", "t_10", "from the no-load velocity to 10 % of it, the drive switched off and short"),
    ("coasting_velocity", "rad s-1", "", "velocity at which the tip leaves the rotor after switching off"),
)}  # fmt: skip
"""Quantities of a motor."""


ROLES: Final = ("stall", "greatest power", "greatest efficiency", "no load")
"""Points of the curve that have a name."""


def data_sheet(setup: Setup) -> Part:
    """Return the data sheet of a motor.

    It has every quantity of `POINT` and `MOTOR` and its error, `NAME_error`, those
    of points over the dimension `point`: the prescribed rotor speeds of the speed-torque curve in ascending
    order, and the free rotor. `kind` is the kind of motion, `load` the direction of the load, `role` one of
    `ROLES` or empty. Velocities and torques are in the motor's own sense of rotation, whose sign in the
    model is `sense`.

    Raises:
        NoPeriodError: the drive does not repeat itself.
    """
    points, own, sense = _sheet(setup)
    values: dict[str, Any] = {}
    for name, quantity in POINT.items():
        values |= _with_error(quantity, np.transpose([p[name] for p in points]))
    for name, quantity in MOTOR.items():
        values |= _with_error(quantity, np.array(own.get(name, UNKNOWN)))
    signs = [(np.sign(p.value("velocity")), np.sign(p.value("torque"))) for p in points]
    texts = {
        "kind": [point.kind for point in points],
        "role": _roles(points),
        "load": [QUADRANTS.get(pair, "") if p.belt else "" for p, pair in zip(points, signs, strict=True)],
        "reason": [point.message for point in points],
    }
    values |= {name: ("point", np.array(column, dtype=object)) for name, column in texts.items()}
    about = {"units": "1", "long_name": "sign of the motor's sense in the model, 0 where it does not turn"}
    values["sense"] = (), sense, about
    return Part(xarray.DataTree(xarray.Dataset(values, {"point": np.arange(len(points))})))


def _sheet(setup: Setup) -> tuple[list[Point], dict[str, Estimate], float]:
    """Characterise one motor: the points of its curve, the free rotor's last, its own numbers, its sense."""
    free = operate(setup)
    velocity, error = free["velocity"]
    if free.run is None or not abs(velocity) > error:
        return [free], {}, 0.0
    sense = float(np.sign(velocity))
    points = Curve(setup, velocity).points
    run, contact = free.run, contact_at_end(free.run)
    rotor = replace(run.motor.rotor, initial_velocity=float(run.series["rotor_velocity"][-1]))
    settled = replace(run.motor, start=run.final, rotor=rotor)
    memory = memory_at_end(run, variables_in(run.law, contact))
    stop, coasting = stop_time(setup, settled, velocity, memory, contact)
    numbers = {
        "no_load_velocity": Estimate(abs(velocity), error),
        "curve_root": root(points),
        "stall_torque": next(point["torque"] for point in points if point.belt == 0.0),
        "holding_torque": holding_torque(setup, velocity),
        "start_time": start_time(setup, velocity),
        "stop_time": stop,
        "coasting_velocity": coasting,
    }
    return [*points, free.turned(sense)], numbers, sense


def _roles(points: Sequence[Point]) -> list[str]:
    """Name the points that have a role."""
    motoring = [point for point in points if point.value("output_power") > 0.0]
    role = {id(point): "stall" for point in points if point.belt == 0.0}
    role[id(points[-1])] = "no load"
    for name, quantity in zip(ROLES[1:3], BEST, strict=True):
        if (best := greatest(motoring, quantity)) is not None:
            role[id(best)] = f"{role[id(best)]} and efficiency" if id(best) in role else name
    return [role.get(id(point), "") for point in points]


def _with_error(quantity: Variable, numbers: np.ndarray) -> dict[str, Any]:
    """Return a quantity and its error as variables of a dataset."""
    name, attributes = quantity.name, cf_attributes(quantity)
    error = {"units": quantity.units, "long_name": f"error of the {name.replace('_', ' ')}"}
    return {
        name: (quantity.dims, numbers[0], attributes | {"ancillary_variables": f"{name}_error"}),
        f"{name}_error": (quantity.dims, numbers[1], error),
    }
