"""A steady state as a dataset of one orbit."""

import json
from operator import attrgetter, methodcaller
from typing import Any, Final

import xarray

from contactlab.estimate import Estimate
from contactlab.results.netcdf import TITLE, to_datatree
from contactlab.steady_state.convergence import Converged
from contactlab.steady_state.state import CUMULATIVE

ROUGH: Final = 1e-2
"""Roughness from which on multipliers are told as rough ones."""

NEUTRAL: Final = 1e7
"""Periods of the orbit beyond which a settling time is none."""


def tree_of(found: Converged, records: int = 2000) -> xarray.DataTree:
    """Return one orbit, or one period of another motion, as a tree like that of a run.

    The group `steady` holds means with their errors, the Floquet multipliers where there is an orbit, and
    kind and section as attributes.
    """
    best = found.best
    tree = to_datatree(best.curves(records), best.setup.configuration)
    del tree["state"]
    law = str(tree.attrs["title"]).removeprefix(TITLE)
    tree.attrs["title"] = f"Steady state of a standing-wave piezoelectric motor with the contact law {law}"
    tree["time"].attrs["long_name"] = f"time since the drive's phase of {best.phase:.9g} periods"
    numbers: dict[str, tuple[Estimate, str, str]] = {
        "rotor_velocity": (found.velocity, "rad s-1", "mean rotor velocity"),
        "torque": (found.torque, "N m", "mean torque of the contact on the rotor"),
        "normal_impulse": (found.value(lambda each: each.impulse), "N s", "normal impulse of a period"),
        "peak_normal_force": (found.value(attrgetter("peak_force")), "N", "largest normal force"),
        "contact_share": (found.value(attrgetter("contact_share")), "1", "share of time in contact"),
    }
    for name in CUMULATIVE[1:]:
        rate = found.value(methodcaller("average", name))
        numbers[f"{name}_rate"] = rate, "W", f"mean rate of {name.replace('_', ' ')}"
    variables: dict[str, Any] = {}
    for name, ((value, error), units, names) in numbers.items():
        variables[name] = (), value, {"units": units, "long_name": names}
        variables[f"{name}_error"] = (), error, {"units": units, "long_name": f"error of the {names}"}
    attributes: dict[str, Any] = {"kind": best.kind, "periods": best.periods, "phase": best.phase}
    attributes["run_duration"] = best.setup.duration
    attributes |= {"warm_up": best.warm_up, found.control: json.dumps(found.values)}
    attributes |= {"belt": best.belt} if best.belt is not None else {}
    attributes |= {"brake": best.brake} if best.brake is not None else {}
    if best.orbit is not None:
        every = best.orbit.multipliers
        for part, values in (("real", every.real), ("imag", every.imag)):
            names = f"{part} part of the Floquet multipliers"
            variables[f"multiplier_{part}"] = "multiplier", values, {"units": "1", "long_name": names}
        attributes |= {"roughness": best.orbit.roughness, "settling_time": best.orbit.settling_time}
    else:
        for name in ("slip_velocity", "rotor_velocity"):
            text = {**tree[name].attrs, "long_name": f"{tree[name].attrs['long_name']}, once a period"}
            variables[f"stroboscopic_{name}"] = "sample", best.motion.series[name][1:], text
    tree["steady"] = xarray.DataTree(xarray.Dataset(variables, attrs=attributes))
    return tree
