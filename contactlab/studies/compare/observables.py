"""Quantities of a settled motor, each with its statistical error."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import isnan, nan
from typing import Final

import numpy as np
import xarray

from contactlab.config import Setup
from contactlab.config.faults import failure_of
from contactlab.estimate import Estimate
from contactlab.motor.motor import lever_of
from contactlab.steady_state import Steady, steady
from contactlab.steady_state.means import LONGEST, motion_of, settled
from contactlab.studies.characterise.transients import start_time
from contactlab.studies.compare.motors import Drawn
from contactlab.studies.study import Part
from contactlab.variables import Variable

OBSERVABLES: Final = {name: Variable(name, (), *rest) for name, *rest in (
    ("rotor_velocity", "rad s-1", "Omega", "settled rotor velocity"),
    ("stall_torque", "N m", "M_0", "mean torque of the contact on a rotor held at rest"),
    ("start_time", "s", "t_90", "time from the start to 90 % of the settled velocity"),
    ("tip_normal_amplitude", "m", "a_n", "normal amplitude of the tip, half its range"),
    ("tip_tangential_amplitude", "m", "a_t", "tangential amplitude of the tip, half its range"),
    ("rms_current", "A", "I_rms", "current of the electrodes, root mean square over both and time"),
    ("normal_impulse", "N s", "P_n", "normal impulse of the contact in a period of the drive"),
)}  # fmt: skip
"""Quantities of a settled motor; the first one decides when sampling ends."""

OBSERVED: Final = tuple(name for name in OBSERVABLES if name not in ("start_time", "normal_impulse"))
"""Those that are compared by default: a start takes as long as three steady states."""

ORBIT: Final = {"tip_normal_amplitude", "tip_tangential_amplitude", "rms_current"}


def do_draw(motor: Drawn, names: Sequence[str]) -> Part:
    """Return the quantities of one motor under every law, with statistical errors."""

    def of_law(law: str) -> dict[str, Estimate]:
        return observed(motor.under(law), names)[1]

    rows = [observation(names, partial(of_law, law)) for law in motor.laws]
    return Part(xarray.DataTree(xarray.concat(rows, "law")))


def observation(
    names: Sequence[str], observe: Callable[[], Mapping[str, Estimate]] | None = None, failure: str = ""
) -> xarray.Dataset:
    """Return the quantities of a motor over the dimension `quantity`, NaN with the reason where they fail.

    Args:
        names: of the quantities.
        observe: returns them; None where the motor fails.
        failure: of the motor.
    """
    numbers: Mapping[str, Estimate] = dict.fromkeys(names, Estimate(nan, nan))
    if observe is not None:
        try:
            numbers = observe()
        # A law of another package may fail in any way, and must not stop the others.
        except Exception as error:
            failure = failure_of(error)
    values, errors = np.transpose([numbers[name] for name in names])
    data = {"value": ("quantity", values), "error": ("quantity", errors), "failure": ((), failure)}
    return xarray.Dataset(data)


def observed(setup: Setup, names: Sequence[str]) -> tuple[str, dict[str, Estimate]]:
    """Return the kind of the steady state and its quantities.

    Raises:
        BrokenOffError, NotSettledError: there is none.
    """
    state = settled(setup)
    return state.kind, quantities_of(state, names)


def quantities_of(state: Steady, names: Sequence[str]) -> dict[str, Estimate]:
    """Return the quantities of a motor whose steady state is known.

    Raises:
        BrokenOffError, NotSettledError: there is none of the motor at rest.
    """
    result = {"rotor_velocity": state.velocity}
    if ORBIT & set(names):
        run = motion_of(state)
        for name in ("normal", "tangential"):
            values = run.series[f"tip_{name}_displacement"]
            # Of a motion of many periods, the difference of both halves.
            ends = [float(np.ptp(part)) for part in np.array_split(values, 2)]
            error = 0.0 if state.periods > 0 else 0.5 * abs(ends[0] - ends[1])
            result[f"tip_{name}_amplitude"] = Estimate(0.5 * float(np.ptp(values)), error)
        square = float(np.mean(run.currents[:, 1:] ** 2))
        result["rms_current"] = Estimate(float(np.sqrt(square)), 0.0)
    if "normal_impulse" in names:
        force = state.average("normal_force")
        result["normal_impulse"] = Estimate(state.period * force.value, state.period * force.error)
    if "stall_torque" in names and isnan(lever_of(state.setup.motor.geometry.rotor_radius)):
        result["stall_torque"] = Estimate(nan, nan)
    elif "stall_torque" in names:
        result["stall_torque"] = steady(state.setup, belt=0.0, start=state, longest=LONGEST).torque
    if "start_time" in names:
        result["start_time"] = start_time(state.setup, state.velocity.value)
    return result
