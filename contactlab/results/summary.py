"""A run in a few lines of text."""

import numpy as np

from contactlab.results.prefixes import prefixed
from contactlab.trajectory import Trajectory


def summarise(trajectory: Trajectory, wall_time: float) -> str:
    """The numbers of a run that one looks at first, a line each.

    Args:
        trajectory: what the simulation gave back; a run cut short is summed up to where it came.
        wall_time: what the simulation alone took [s].

    Returns:
        Lines of a label and its value, aligned, without a newline at the end; plain ASCII, which
        every terminal and every log can show.
    """
    simulated = float(trajectory.time[-1])
    # Plus nothing: a rotor at rest has no sign.
    velocity = float(trajectory.series["rotor_velocity"][-1]) + 0.0
    peak = float(np.max(trajectory.contacts["peak_normal_force"], initial=0.0))
    lines = {
        "law": _law(trajectory),
        "contacts": _contacts(trajectory),
        "rotor velocity": f"{velocity:.6g} rad/s after {prefixed(simulated, 's')}",
        "peak normal force": f"{peak:.4g} N",
        **_load(trajectory),
        "normal impulse": f"{np.sum(trajectory.contacts['normal_impulse']):.6g} N s in all",
        "ledger residual": _residual(trajectory),
        "speed": _speed(simulated, wall_time),
    }
    if wedged := trajectory.statistics.get("wedged_steps", 0):
        lines["Painleve's paradox"] = (
            f"{wedged} steps in contact with several solutions: what slid was released, what stuck was held"
        )
    if not trajectory.complete:
        label = trajectory.ending.name.lower() if trajectory.ending.reached_end else "incomplete"
        lines[label] = trajectory.message or trajectory.ending.name.lower()
    width = max(map(len, lines)) + 2
    text = "\n".join(f"{label:<{width}}{value}" for label, value in lines.items())
    return text.replace("µ", "u")


def _law(trajectory: Trajectory) -> str:
    """The law's name and its effective parameters."""
    parameters = (f"{name} {value:.6g}" for name, value in trajectory.law.describe().items())
    step = prefixed(trajectory.contact_step, "s")
    return f"{trajectory.law.title} ({', '.join([*parameters, f'contact step {step}'])})"


def _contacts(trajectory: Trajectory) -> str:
    """How many contacts there were, and how long they lasted and stuck."""
    count = trajectory.contacts["duration"].size
    if not count:
        return f"none: {_out_of_reach(trajectory)}"
    touching = prefixed(float(np.sum(trajectory.contacts["duration"])), "s")
    sticking = prefixed(float(np.sum(trajectory.contacts["stick_duration"])), "s")
    return f"{count}, {touching} in contact, {sticking} of it sticking"


def _load(trajectory: Trajectory) -> dict[str, str]:
    """A line on the load where there is one: whether it brakes the motor or drives it."""
    if trajectory.motor.rotor.load_torque == 0.0:
        return {}
    work = float(trajectory.series["load_work"][-1])
    what = "drives the motor and works on it" if work < 0.0 else "brakes the motor and takes"
    return {"load": f"{what}: {abs(work):.4g} J"}


def _out_of_reach(trajectory: Trajectory) -> str:
    """How far the tip came of the way to the rotor, by the records."""
    clearance = trajectory.motor.geometry.clearance
    closest = float(np.min(trajectory.series["gap"]))
    return (
        f"of the clearance, {prefixed(clearance, 'm')}, the tip bridged at most "
        f"{prefixed(clearance - closest, 'm')}. Lower contact.clearance or raise the drive's voltages."
    )


def _residual(trajectory: Trajectory) -> str:
    """The energy that the ledger cannot account for, and its share of the work of the drive."""
    residual = float(trajectory.series["energy_residual"][-1])
    work = abs(float(trajectory.series["drive_work"][-1]))
    share = f"{abs(residual) / work:.2g} of the drive work" if work > 0.0 else "no drive work"
    return f"{residual:.2g} J, {share}"


def _speed(simulated: float, wall_time: float) -> str:
    """How fast the simulation was against the motor itself."""
    pace = f", {simulated / wall_time:.3g} times real time" if wall_time > 0.0 else ""
    return f"{prefixed(simulated, 's')} of motor in {prefixed(wall_time, 's')}{pace}"
