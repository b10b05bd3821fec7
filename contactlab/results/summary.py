"""A run in a few lines of text, and its numbers in units that are handy to read."""

import json
import re
from collections.abc import Mapping
from math import isnan
from typing import TYPE_CHECKING, Any

import numpy as np

from contactlab.motor.motor import lever_of
from contactlab.results.netcdf import (
    TITLE,
    Column,
    Group,
    Groups,
    configuration_of,
    contacts_in,
    groups_of,
    lasting_in,
    reached_end,
    settling_in,
)
from contactlab.settling.criterion import PRECISION, STEADY
from contactlab.settling.verdict import Settling
from contactlab.variables import INTERNAL

if TYPE_CHECKING:
    import xarray

ROUND_OFF = 1e-9
"""Part of a clearance that is no motion of the tip."""

PREFIXES = ("G", 1e9), ("M", 1e6), ("k", 1e3), ("", 1.0), ("m", 1e-3), ("µ", 1e-6), ("n", 1e-9), ("p", 1e-12)
LARGEST = 1e12
"""Prefixes of units with their factors, and the size from which on a power of ten is read more easily."""

MOST = {"s": 1.0, "rad": 1.0, "deg": 1.0, "g": 1e3}
"""Largest factors of prefixes of units that are not read with a larger one."""

FIRST_UNIT = re.compile(r"([A-Za-z]*(?![A-Za-z0-9^-]))?(.*)")
"""The first unit of a product or quotient, empty if it has an exponent, and the rest."""

MOST_REMEMBERED = 4
"""Internal variables that are shown."""


def summarise(run: "xarray.DataTree | Groups", wall_time: float | None = None) -> str:
    """Return the numbers of a run that one looks at first, a line each.

    Args:
        run: the tree or the groups of a run, see `contactlab.results.netcdf`; one that was cut short is
            summed up to where it came.
        wall_time: what the simulation alone took [s], where that is known.

    Returns:
        Lines of a label and its value, aligned, without a newline at the end; plain ASCII, which
        every terminal and every log can show.
    """
    lines = summary_of(run, wall_time)
    width = max(map(len, lines)) + 2
    return "\n".join(f"{label:<{width}}{value}" for label, value in lines.items())


def summary_of(run: "xarray.DataTree | Groups", wall_time: float | None = None) -> dict[str, str]:
    """Return the values of `summarise` by their labels."""
    groups = groups_of(run)
    (root, attributes), contacts = groups["/"], contacts_in(groups)
    configuration = configuration_of(attributes)
    start, end = root["time"].values[[0, -1]].tolist()
    settling = settling_in(groups)
    lines = {"law": _law(attributes), "contacts": _contacts(groups["/"], configuration, contacts)}
    if "prescribed" in attributes:
        energies = ("drive_work", "contact_energy", "contact_loss", "friction_loss")
        texts = (f"{name.replace('_', ' ')} {float(root[name].values[-1]):.6g} J" for name in energies)
        lines["prescribed path"] = f"{prefixed(end - start, 's')}; {', '.join(texts)}"
    else:
        lines |= _rotor(root, configuration, end)
        lines["steady state"] = f"{settling.sentence}. {settling.way_out(end)}".rstrip()
    lines["peak normal force"] = _peak(contacts)
    if ended := _ended(configuration.get("solver"), end - start, settling):
        lines["ended"] = ended
    work, loaded = float(root["load_work"].values[-1]), bool(root["load_work"].values.any())
    if "preloaded" in attributes:
        # The ledger adds up what the torque takes and what the preload takes.
        by_torque = float(configuration["rotor"]["load_torque"]) * float(root["rotor_angle"].values[-1])
        lines["preload"] = f"has done {by_torque - work:.4g} J of work on the motor"
        work, loaded = by_torque, by_torque != 0.0
    if loaded:
        what = "drives the motor and works on it" if work < 0.0 else "brakes the motor and takes"
        lines["load"] = f"{what}: {abs(work):.4g} J"
    impulse = float(np.sum(contacts["normal_impulse"]))
    lines["normal impulse"] = f"{impulse:.6g} N s in all"
    if remembered := _remembered(root):
        lines["remembered"] = remembered
    if created := _created(contacts):
        lines["energy created"] = created
    residual, turned = float(root["energy_residual"].values[-1]), abs(float(root["drive_work"].values[-1]))
    share = f"{abs(residual) / turned:.2g} of the drive work" if turned > 0.0 else "no drive work"
    lines["ledger residual"] = f"{residual:.2g} J, {share}"
    lines["error of steps"] = _error_of_steps(attributes)
    if wall_time is not None:
        pace = f", {(end - start) / wall_time:.3g} times real time" if wall_time > 0.0 else ""
        lines["speed"] = f"{prefixed(end - start, 's')} of motor in {prefixed(wall_time, 's')}{pace}"
    if wedged := json.loads(attributes["solver_statistics"]).get("wedged_steps", 0):
        lines["Painleve's paradox"] = (
            f"{wedged} steps in contact with several solutions: what slid was released, what stuck was held"
        )
    if not attributes["complete"]:
        label = attributes["ending"] if reached_end(attributes) else "incomplete"
        lines[label] = attributes["message"] or attributes["ending"]
    return {label: value.replace("µ", "u") for label, value in lines.items()}


def prefixed_unit(size: float, symbol: str, smallest: float = 1.0) -> tuple[str, float]:
    """Find the unit in which a quantity is a handy number, from giga to pico.

    Beyond these, and for a unit that begins with a power or a reciprocal, it is the unit itself.

    Args:
        size: of the quantity in the unit without a prefix.
        symbol: of the unit without a prefix; kg is a thousand g.
        smallest: number that the quantity shall have at least.

    Returns:
        The symbol with its prefix, and its size in the unit without one.
    """
    first, rest = FIRST_UNIT.findall(symbol)[0]
    base = 1.0
    if first == "kg":
        first, base = "g", 1e-3
    if first and size < LARGEST * base:
        for prefix, scale in PREFIXES:
            # A hair below counts, so that a round-off does not turn 1 ms into 1000 µs.
            if size >= 0.999 * smallest * scale * base and scale <= MOST.get(first, LARGEST):
                return f"{prefix}{first}{rest}", scale * base
    return symbol, 1.0


def prefixed(size: float, symbol: str) -> str:
    """Write a quantity to four digits with a handy unit, e.g. `248.3 µs`; zero keeps the plain unit."""
    unit, scale = prefixed_unit(abs(size), symbol) if size else (symbol, 1.0)
    return f"{size / scale:.4g} {unit}"


def _law(attributes: Mapping[Any, Any]) -> str:
    """Return the law's name and its effective parameters."""
    parameters = json.loads(attributes["law_parameters"])
    texts = [f"{name} {value:.6g}" for name, value in parameters.items()]
    if step := float(attributes["contact_step"]):
        texts.append(f"contact step {prefixed(step, 's')}")
    return f"{attributes['title'].removeprefix(TITLE)} ({', '.join(texts)})"


def _rotor(root: Mapping[Any, Column], configuration: Mapping[str, Any], end: float) -> dict[str, str]:
    """Return the rotor's velocity at the end [s] of a run; nothing of a flat contact, which turns none."""
    if isnan(lever_of(float(configuration["rotor"]["radius"]))):
        return {}
    # Plus nothing: a rotor at rest has no sign.
    velocity = float(root["rotor_velocity"].values[-1]) + 0.0
    return {"rotor velocity": f"{velocity:.6g} rad/s after {prefixed(end, 's')}"}


def _error_of_steps(attributes: Mapping[Any, Any]) -> str:
    """Return what the steps in contact have missed in all, as impulse and as velocity of the rotor."""
    names = "impulse_error", "rotor_velocity_error"
    impulse, velocity = (float(attributes.get(name, np.nan)) for name in names)
    if np.isnan(impulse):
        return "not estimated; of time stepping, halve solver.contact_step to see it"
    rotor = "" if "prescribed" in attributes else f", {velocity:.2g} rad/s of the rotor"
    kept = attributes.get("keeps_tolerance", 1)
    more = "before the motion amplifies it" if kept else "and more: the law does not keep its tolerance"
    return f"{impulse:.2g} N s in all{rotor}, {more}"


def _peak(contacts: Mapping[str, np.ndarray]) -> str:
    """Return the largest normal force, and of impacts the largest impulse."""
    peak = float(np.max(contacts["peak_normal_force"], initial=0.0))
    if not np.isinf(peak):
        return f"{peak:.4g} N"
    text = "infinite: impacts take no time"
    if "largest_impact" in contacts:
        largest, lasting = (
            float(np.max(contacts[name])) for name in ("largest_impact", "peak_lasting_force")
        )
        text += f"; the largest has {largest:.4g} N s, and contacts that last up to {lasting:.4g} N"
    return text


def _created(contacts: Mapping[str, np.ndarray]) -> str:
    """Return the energy that impacts created; empty where it is none or round-off."""
    gains = contacts.get("impact_energy_gain", np.zeros(0))
    turned_over = np.nansum(np.abs(contacts["normal_impulse"] * contacts["approach_velocity"]))
    if not float(gains.sum()) > ROUND_OFF * float(turned_over):
        return ""
    count = np.count_nonzero(gains > ROUND_OFF * np.max(gains))
    return f"{gains.sum():.4g} J by the law in impacts of {count} contacts, which no passive bodies can have"


def _ended(solver: Any, length: float, settling: Settling) -> str:
    """Return what ended a run that was to last until its motor has settled; empty for another."""
    if not isinstance(solver, Mapping) or solver.get("until") != STEADY or "duration" not in solver:
        return ""
    precision, most = float(solver.get("precision", PRECISION)), float(solver["duration"])
    longest = f"solver.duration, {prefixed(most, 's')}"
    if settling.share <= precision:
        return f"once settled to {precision:g}, after {prefixed(length, 's')}; the longest was {longest}"
    if length < (1.0 - ROUND_OFF) * most:
        return ""
    return f"at the longest, {longest}, before it had settled to {precision:g}"


def _contacts(root: Group, configuration: Mapping[str, Any], contacts: Mapping[str, np.ndarray]) -> str:
    """Return number, duration and stick of the contacts, or how far away the tip stayed."""
    if count := contacts["duration"].size:
        touching = prefixed(float(np.sum(contacts["duration"])), "s")
        sticking = prefixed(float(np.sum(contacts["stick_duration"])), "s")
        return f"{count}, {touching} in contact, {sticking} of it sticking"
    clearance = float(configuration["contact"]["clearance"])
    bridged = max(clearance - float(np.min(root.variables["gap"].values)), 0.0)
    texts = f"the tip bridged at most {prefixed(bridged, 'm')}"
    way_out = "Lower contact.clearance or raise the drive's voltages."
    reach = float(root.attrs.get("free_reach", np.nan))
    if reach >= clearance:
        # It has not come to where it is going.
        texts += f" so far, and {prefixed(reach, 'm')} once it has settled"
        way_out = "Raise solver.duration."
    elif reach <= ROUND_OFF * abs(clearance):
        texts += ", and nothing moves it"
        way_out = "Raise the drive's voltages."
    elif reach < clearance:
        texts += f"; settled and free it reaches {prefixed(reach, 'm')} and never touches"
    return f"none: of the clearance, {prefixed(clearance, 'm')}, {texts}. {way_out}"


def _remembered(root: Mapping[Any, Column]) -> str:
    """Return what the law remembers beyond a contact, at the end of the run; empty where that is nothing."""
    lasting = {name.removeprefix(INTERNAL): root[name] for name in lasting_in(root)}
    texts = [f"{name} {float(x.values[-1]):.6g} {x.attrs['units']}" for name, x in lasting.items()]
    more = f", and {len(texts) - MOST_REMEMBERED} more" if len(texts) > MOST_REMEMBERED else ""
    return ", ".join(text.removesuffix(" 1") for text in texts[:MOST_REMEMBERED]) + more
