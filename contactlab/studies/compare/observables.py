"""What can be measured of a settled motor, to distinguish laws by."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, Setup, build
from contactlab.config.faults import failure_of
from contactlab.estimate import Estimate
from contactlab.steady_state import BrokenOffError, NotSettledError, steady
from contactlab.steady_state.means import LONGEST, motion_of, settled
from contactlab.studies.characterise.transients import start_time
from contactlab.studies.study import Part
from contactlab.variables import Variable

OBSERVABLES: Final = {name: Variable(name, (), *rest) for name, *rest in (
    ("rotor_velocity", "rad s-1", "Omega", "settled rotor velocity"),
    ("stall_torque", "N m", "M_0", "mean torque of the contact on a rotor held at rest"),
    ("start_time", "s", "t_90", "time from the start to 90 % of the settled velocity"),
    ("tip_normal_amplitude", "m", "a_n", "normal amplitude of the tip, half its range"),
    ("tip_tangential_amplitude", "m", "a_t", "tangential amplitude of the tip, half its range"),
    ("rms_current", "A", "I_rms", "current of the electrodes, root mean square over both and time"),
)}  # fmt: skip
"""Quantities of a settled motor; the first one decides when sampling ends."""

USUAL: Final = tuple(name for name in OBSERVABLES if name != "start_time")
"""Those that are compared by default: a start takes as long as three steady states."""

ORBIT: Final = {"tip_normal_amplitude", "tip_tangential_amplitude", "rms_current"}


def do_draw(configurations: Mapping[str, Mapping[str, Any] | Setup], names: Sequence[str]) -> Part:
    """Return the quantities of one motor under every law, with statistical errors."""
    values, errors = np.full((2, len(configurations), len(names)), np.nan)
    kinds, failures = [], []
    for row, each in enumerate(configurations.values()):
        kind = failure = ""
        try:
            setup = each if isinstance(each, Setup) else build(each)
            kind, numbers = observed(setup, names)
            values[row], errors[row] = np.transpose([numbers[name] for name in names])
        except (BrokenOffError, NotSettledError, ConfigurationError) as error:
            failure = str(error)
        # A law of another package may fail in any way, and must not stop the others.
        except Exception as error:
            failure = failure_of(error)
        kinds.append(kind)
        failures.append(failure)
    both = ("law", "quantity")
    data = xarray.Dataset({"value": (both, values), "error": (both, errors)}).assign_coords(
        kind=("law", kinds), failure=("law", failures)
    )
    return Part(xarray.DataTree(data))


def observed(setup: Setup, names: Sequence[str]) -> tuple[str, dict[str, Estimate]]:
    """Return the kind of the steady state and its quantities.

    Raises:
        BrokenOffError, NotSettledError: there is none.
    """
    state = settled(setup)
    result = {"rotor_velocity": state.velocity}
    if ORBIT & set(names):
        run = motion_of(state)
        for name in ("normal", "tangential"):
            amplitude = _amplitude(run.series[f"tip_{name}_displacement"])
            repeats = state.periods > 0
            result[f"tip_{name}_amplitude"] = amplitude._replace(error=0.0) if repeats else amplitude
        square = float(np.mean(run.currents[:, 1:] ** 2))
        result["rms_current"] = Estimate(float(np.sqrt(square)), 0.0)
    if "stall_torque" in names:
        result["stall_torque"] = steady(setup, belt=0.0, longest=LONGEST).torque
    if "start_time" in names:
        result["start_time"] = start_time(setup, state.velocity.value)
    return state.kind, result


def _amplitude(values: Array) -> Estimate:
    """Return half the range, and half the difference of both halves of a motion of many periods."""
    ends = [float(np.ptp(part)) for part in np.array_split(values, 2)]
    return Estimate(0.5 * float(np.ptp(values)), 0.5 * abs(ends[0] - ends[1]))
