"""What a page draws of a state under one law, as lists of numbers; computed by a process of the pool."""

import io
import tempfile
from collections.abc import Callable, Mapping
from math import inf
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import contactlab as cl
from contactlab_explorer.motions import SAMPLES
from contactlab_explorer.state import PLANT, State, has_period

RECORDS: Final = 300
"""Of a period, and of the way to the steady state."""

HUNDREDTH: Final = 4.6
"""Settling times until a hundredth is left."""

LONGEST: Final = 1.0
"""Way to the steady state that is still run [s]."""

ALONG: Final = "belt", "block"
"""Small plants whose position is along the contact where nothing moves what they lie on."""

Stop = Callable[[], object]
Points = list[list[float | None]]
Series = Mapping[str, NDArray[np.float64]]


def points(x: NDArray[np.float64], y: NDArray[np.float64]) -> Points:
    """Return pairs of finite numbers; a pair that is not is a gap."""
    pairs = np.column_stack([x, y])
    return [[float(a), float(b)] if np.isfinite(a + b) else [None, None] for a, b in pairs]


def stems(x: NDArray[np.float64], height: NDArray[np.float64]) -> Points:
    """Return lines from zero to each height."""
    lines: Points = []
    for at, top in zip(x.tolist(), height.tolist(), strict=True):
        lines += [[at, 0.0], [at, top], [None, None]]
    return lines


def pictures(state: State, law: str, stop: Stop | None = None) -> dict[str, Any]:
    """Return the points of every chart of a view, and a sentence, under one law.

    A rigid impact is a stem of its impulse [uN s]; the force is drawn of compliant laws alone.

    Raises:
        ValueError, RuntimeError: a number is refused, or there is no such motion; a sentence.
    """
    setup = state.setup(law)
    if state.view == "path":
        motion = state.motion
        loop = cl.drive(setup.law, motion.time, normal=motion.load, slip=motion.slip)
        last = loop["time"].values >= motion.time[-1 - SAMPLES]
        # Forces are means over the interval before their record.
        slip = np.interp(loop["time"].values, motion.time, motion.slip)
        middle = 0.5 * (slip[1:] + slip[:-1])
        force = loop["friction_force"].values[1:]
        lost = float(np.ptp(loop["friction_loss"].values[last]))
        drawn = points(1e6 * middle[last[1:]], force[last[1:]])
        return {"loop": drawn, "said": f"{law}: {lost:.4g} J lost in a cycle"}
    if state.view == "impact":
        motion = state.motion
        table = cl.normal_impact(setup.law, motion.speeds, mass=motion.mass)
        speed = table["speed"].values
        middle = float(table["restitution"][speed.size // 2])
        return {
            "restitution": points(speed, table["restitution"].values),
            "contact_time": points(speed, 1e6 * table["contact_time"].values),
            "said": f"{law}: restitution {middle:.4g} at {speed[speed.size // 2]:.3g} m/s",
        }
    if state.scene == PLANT and not has_period(setup):
        return _of_run(setup, law, stop)
    orbit = cl.orbit(setup, stop=stop)
    series, impacts, powers = orbit.series(RECORDS), orbit.impacts, orbit.energy
    since, multipliers = impacts["phase"] - series["phase"][0], orbit.multipliers
    phase = series["phase"] - series["phase"][0]
    of_orbit: dict[str, Any] = {
        "multipliers": points(multipliers.real, multipliers.imag),
        "energy": [[name.replace("_", " "), 1e3 * power] for name, power in powers.items()],
    }
    if state.scene == PLANT:
        to_ms = 1e3 * orbit.period
        several = f" in {orbit.periods} periods" if orbit.periods > 1 else ""
        said = f"{law}: {orbit.kind}{several}"
        if "point_tip" in series:
            said += f", {orbit.velocity.value:.5g} m/s"
        return {
            **of_orbit,
            **_positions(setup, series, to_ms * phase),
            **_forces(setup, series, impacts, to_ms * phase, to_ms * since),
            "said": said,
        }
    return {
        **of_orbit,
        "tip": points(1e6 * series["tip_tangential_displacement"], 1e6 * series["tip_normal_displacement"]),
        "gap": points(phase, 1e6 * series["gap"]),
        **_forces(setup, series, impacts, phase, since),
        "said": f"{law}: {orbit.kind}, {orbit.velocity.value:.5g} rad/s",
    }


def _of_run(setup: cl.Setup, law: str, stop: Stop | None) -> dict[str, Any]:
    """Return the points of a small plant that nothing drives, over its run."""
    run = cl.simulate(setup, record_interval=setup.duration / RECORDS, stop=stop)
    if stop is not None and stop():
        raise cl.StoppedError(run.message)
    series = {
        str(name): values.values for name, values in run.tree.data_vars.items() if values.dims == ("time",)
    }
    series["time"] = time = run["time"].values
    impacts = {str(name): values.values for name, values in run.contacts.data_vars.items()}
    begins = 1e3 * (impacts["start_time"] - time[0])
    return {
        **_positions(setup, series, 1e3 * (time - time[0])),
        **_forces(setup, series, impacts, 1e3 * (time - time[0]), begins),
        "said": f"{law}: {begins.size} contacts in {1e3 * setup.duration:.4g} ms",
    }


def _positions(setup: cl.Setup, series: Series, time: NDArray[np.float64]) -> dict[str, Points]:
    """Return gap, position of the body, and that of what it lies on where this moves, all over a time [um].

    Across the contact the position is the height over the ground, along it the way.
    """
    assert setup.motor.plant is not None
    moved = (series[name] for name in ("point_table", "point_base", "point_tip") if name in series)
    under = next(moved, None)
    if "point_table" in series:
        body = series["gap"] + series["point_table"]
    elif "point_base" in series:
        body = series["point_body"]
    elif "point_tip" in series:
        # The slider's angle is its way, as its radius is a metre. One period later it is elsewhere.
        body = series["rotor_angle"] - series["rotor_angle"][0] + series["point_tip"][0]
    elif setup.motor.plant.name in ALONG:
        body = series["tip_tangential_displacement"]
    else:
        body = -series["tip_normal_displacement"]
    return {
        "position": points(time, 1e6 * body),
        "under": [] if under is None else points(time, 1e6 * under),
        "gap": points(time, 1e6 * series["gap"]),
    }


def _forces(
    setup: cl.Setup, series: Series, impacts: Series, at: NDArray[np.float64], since: NDArray[np.float64]
) -> dict[str, Points]:
    """Return normal force and impulses of a motion whose records lie at a time, and impacts at others."""
    rigid, force = isinstance(setup.law, cl.MultiplierLaw), series["normal_force"].copy()
    begins = np.searchsorted(at, since).clip(1, at.size - 1) if rigid else np.empty(0, int)
    # A rigid contact that lasts begins with an impact: the impulse of its first interval.
    first = force[begins] * np.diff(series["time"])[begins - 1]
    impulses = np.where(impacts["duration"] == 0.0, impacts["normal_impulse"], first) if rigid else first
    # That interval has no force, but an impulse over its length.
    force[begins] = np.nan
    lasting = not rigid or bool((impacts["duration"] > 0.0).any())
    return {
        "force": points(at, force) if lasting else [],
        "impulse": stems(since[: impulses.size], 1e6 * impulses),
    }


def approach(state: State, law: str, stop: Stop | None = None) -> dict[str, Any]:
    """Return the rotor's velocity from the start, until it is within a hundredth of the orbit [ms, rad/s].

    Of a motor without an orbit, and where that takes longer than a second, it is over the run's duration.
    """
    setup = state.setup(law)
    orbit = cl.orbit(setup, stop=stop).orbit
    settles = inf if orbit is None else HUNDREDTH * orbit.settling_time
    duration = settles if settles <= LONGEST else setup.duration
    run = cl.simulate(setup, duration=duration, record_interval=duration / RECORDS, stop=stop)
    if stop is not None and stop():
        raise cl.StoppedError(run.message)
    return {"approach": points(1e3 * run["time"].values, run["rotor_velocity"].values)}


def saved(state: State, law: str, kind: str, stop: Stop | None = None) -> bytes:
    """Return run.nc of what is seen under a law, or its figure, run.png.

    Raises:
        ValueError, RuntimeError: as of `pictures`; impacts have no run.
    """
    setup = state.setup(law)
    if state.view == "impact":
        raise ValueError("Impacts are no run; copy the Python of the table.")
    if state.view == "path":
        motion = state.motion
        run = cl.drive(setup.law, motion.time, normal=motion.load, slip=motion.slip)
    else:
        run = cl.simulate(setup, stop=stop)
    if kind == "run.nc":
        with tempfile.TemporaryDirectory() as folder:
            run.save(file := Path(folder) / kind)
            return file.read_bytes()
    picture = io.BytesIO()
    run.plot().savefig(picture, format="png", dpi=150)
    return picture.getvalue()
