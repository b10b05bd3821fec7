"""A steady state as lines of text and as a dataset of one orbit."""

import json
from operator import attrgetter, methodcaller
from typing import Any, Final

import numpy as np
import xarray

from contactlab.orbits.convergence import Converged
from contactlab.orbits.steady_state import CUMULATIVE, Steady
from contactlab.results.netcdf import TITLE, to_datatree
from contactlab.results.summary import prefixed
from contactlab.settling.statistics import Estimate

ROUGH: Final = 1e-2
"""Roughness from which on multipliers are told as rough ones."""

NEUTRAL: Final = 1e7
"""Periods of the orbit beyond which a settling time is none."""

LOSSES: Final = {
    "damping_loss": "damping",
    "friction_loss": "friction",
    "contact_loss": "contact",
    "load_work": "load",
}
"""Where the drive's power goes."""


def with_error(value: tuple[float, float], units: str) -> str:
    """Write a number with its error to two digits of that, as '-2.1911 +- 0.0021 rad/s'."""
    mean, error = value[0] + 0.0, value[1]
    digits = 9 if error <= 0.0 else int(np.clip(np.ceil(np.log10(max(abs(mean), error) / error)) + 2, 2, 9))
    return f"{mean:.{digits}g}{f' +- {error:.2g}' if error > 0.0 else ''} {units}"


def summary_of(found: Converged) -> dict[str, str]:
    """Give what one looks at first, by label; plain ASCII."""
    best = found.best
    rotor, rates = best.setup.motor.rotor, {name: best.average(name)[0] for name in CUMULATIVE}
    lines = {
        "law": best.setup.law.name,
        "steady state": _kind(best),
        "rotor": f"on a belt at {best.belt:.6g} rad/s"
        if best.belt is not None and best.kind != "standing"
        else f"load {rotor.load_torque:.6g} N m"
        if rotor.load_torque
        else "without load",
        "mean velocity": with_error(found.velocity, "rad/s"),
        "mean torque of contact": with_error(found.torque, "N m"),
        "power": f"drive {prefixed(rates['drive_work'], 'W')} = "
        + " + ".join(f"{word} {prefixed(rates[name], 'W')}" for name, word in LOSSES.items()),
        "contact": f"{best.contact_share.value:.3g} of the time, impulse {best.impulse[0]:.6g} N s a period, "
        f"peak force {best.peak_force.value:.4g} N",
    }
    if best.brake is not None:
        held = "holds the rotor" if best.kind == "standing" else "is overcome"
        lines["rotor"] = f"a brake of {best.brake:.6g} N m {held}"
    if best.orbit is not None:
        lines |= _stability(best)
    elif best.periods and best.kind == "periodic":
        lines["multipliers"] = (
            "none: the motion repeats itself, but at no section in free flight was a stable orbit found: the "
            "contact does not open, or nothing brings the velocity back"
        )
    kinds = [each.kind for each in found.steps]
    if len(set(kinds)) > 1:
        steps = ", ".join(f"{kind} at {value:.3g}" for kind, value in zip(kinds, found.values, strict=True))
        lines["caution"] = f"the kind depends on the {found.control.replace('_', ' ')}: {steps}"
    return {label: text.replace("\u00b5", "u") for label, text in lines.items()}


def _kind(steady: Steady) -> str:
    """Say what kind of motion it is."""
    period = prefixed(steady.period, "s")
    after = f"found after {steady.warm_up} periods of the drive, {period} each"
    if steady.periods:
        several = f" of {steady.periods} periods" if steady.periods > 1 else ""
        return f"{steady.kind}{several}, {after}"
    return f"{steady.kind}: means over {prefixed(float(np.ptp(steady.motion.time)), 's')}, {after}"


def _stability(steady: Steady) -> dict[str, str]:
    """Say how fast the motor settles, what a run of the configured duration lacks, and how sure that is."""
    assert steady.orbit is not None
    orbit, duration = steady.orbit, steady.setup.duration
    largest, settling = abs(orbit.multipliers[0]), orbit.settling_time
    lines = {"settling time": f"{prefixed(settling, 's')}, largest multiplier {largest:.6g}"}
    if steady.belt is None:
        left = f"{100.0 * np.exp(-duration / settling):.2g} %"
        lines[f"a run of {prefixed(duration, 's')}"] = f"still lacks {left} of the way to it"
    if settling > NEUTRAL * orbit.map.period:
        lines["caution"] = (
            "a multiplier is one: nothing brings the rotor to this velocity or away from it, it is that of "
            "the start"
        )
    if orbit.roughness > ROUGH:
        lines["caution"] = (
            f"the period map is not smooth here: derivatives over steps of 1e-6 and 1e-4 differ by "
            f"{orbit.roughness:.2g}, as where a contact grazes, and multipliers are rough"
        )
    return lines


def tree_of(found: Converged, records: int = 2000) -> xarray.DataTree:
    """Give one orbit, or one period of another motion, as a tree like that of a run.

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
    for name, ((value, error), units, words) in numbers.items():
        variables[name] = (), value, {"units": units, "long_name": words}
        variables[f"{name}_error"] = (), error, {"units": units, "long_name": f"error of the {words}"}
    attributes: dict[str, Any] = {"kind": best.kind, "periods": best.periods, "phase": best.phase}
    attributes["run_duration"] = best.setup.duration
    attributes |= {"warm_up": best.warm_up, found.control: json.dumps(found.values)}
    attributes |= {"belt": best.belt} if best.belt is not None else {}
    attributes |= {"brake": best.brake} if best.brake is not None else {}
    if best.orbit is not None:
        every = best.orbit.multipliers
        for part, values in (("real", every.real), ("imag", every.imag)):
            words = f"{part} part of the Floquet multipliers"
            variables[f"multiplier_{part}"] = "multiplier", values, {"units": "1", "long_name": words}
        attributes |= {"roughness": best.orbit.roughness, "settling_time": best.orbit.settling_time}
    else:
        for name in ("slip_velocity", "rotor_velocity"):
            said = {**tree[name].attrs, "long_name": f"{tree[name].attrs['long_name']}, once a period"}
            variables[f"stroboscopic_{name}"] = "sample", best.motion.series[name][1:], said
    tree["steady"] = xarray.DataTree(xarray.Dataset(variables, attrs=attributes))
    return tree
