"""Contact laws over clearance, phase and friction coefficient: where they differ, and what they break.

python experiments/law_comparison.py [LAW ...] [output=DIR] [KEY=VALUE ...]

The paper's three laws, and those that are named, run from rest at three steps each, so that every
difference between laws stands beside the numerical error of both.
"""

import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import xarray
from harness import REFUSED, changed, laws_of, main
from matplotlib.figure import Figure
from tqdm import tqdm

import contactlab as cl
from contactlab.config import compose
from contactlab.engine.preparation import DEFAULT_TOLERANCE
from contactlab.metrics import FAIL, METRICS, STEP_METRICS, assess, assess_steps
from contactlab.metrics.convergence import FINER, richardson

SAYS = (
    "Three contact laws are tried on one motor, each at a clearance, a phase and a step of its own, and "
    "compared by eye."
)
PAPER = ("lagrange_slip", "lagrange_stick", "hertz_penalty")
NAMED: list[str] = []
"""Laws that the command line adds."""

SWEEPS = {
    "contact.clearance": np.linspace(0.25e-6, 2.5e-6, 19),
    "drive.phase": np.linspace(-np.pi, np.pi, 25),
    "contact.friction_coefficient": np.linspace(0.05, 0.8, 16),
}
"""One key at a time, the others as configured."""

AXES = {
    "contact.clearance": ("clearance (\u00b5m)", 1e6),
    "drive.phase": ("phase of the first tone (rad)", 1.0),
    "contact.friction_coefficient": ("friction coefficient", 1.0),
}
CLEAR = 3.0
"""A range of this many numerical errors is a difference between laws."""


def laws_with(setup: cl.Setup, named: Sequence[str]) -> dict[str, cl.ContactLaw]:
    """The paper's laws and those named, with the configured friction and rotor."""
    solver = {**setup.configuration["solver"], "contact_step": None, "tolerance": None}
    given = {**setup.configuration, "solver": solver}
    return laws_of(setup) | {name: cl.build({**given, "law": section(name)}).law for name in named}


@cache
def section(name: str) -> dict[str, Any]:
    """The parameters of a law where nothing is said of them."""
    chosen: dict[str, Any] = compose([f"law={name}"])["law"]
    return chosen


def measured(setup: cl.Setup, law: cl.ContactLaw) -> tuple[float, float, float, list[str]]:
    """Final rotor velocity and its numerical error, share of stick, and the thresholds that fail."""
    rigid = isinstance(law, cl.MultiplierLaw)
    control, coarsest = (
        ("contact_step", law.default_contact_step) if rigid else ("tolerance", DEFAULT_TOLERANCE)
    )
    plain = replace(setup, law=law, contact_step=None, tolerance=None)
    steps = []
    for divisor in FINER[control]:
        run = cl.simulate(plain, **{control: coarsest / divisor})
        if not run.complete:
            return np.nan, np.nan, np.nan, []
        steps.append((coarsest / divisor, run.tree))
    velocities = [np.asarray(tree["rotor_velocity"].values[-1]) for _, tree in steps]
    values = assess(steps[-1][1]) | assess_steps(steps)
    judged = {**METRICS, **STEP_METRICS}
    broken = [key for key, metric in judged.items() if metric.verdict(values[key]) == FAIL]
    error = float(richardson(velocities, FINER[control][1], law.convergence_order))
    return float(velocities[-1]), error, values["stick_share"], broken


def study(setup: cl.Setup, short: bool = False) -> xarray.Dataset:
    """Every law at every point of every sweep; the short form is two points each."""
    points = [
        (key, float(value))
        for key, values in SWEEPS.items()
        for value in (values[[4, 10]] if short else values)
    ]
    names = list(laws_with(setup, NAMED))
    judged = [key for key, metric in {**METRICS, **STEP_METRICS}.items() if metric.threshold]
    shape = (len(names), len(points))
    velocity, error, stick = np.full(shape, np.nan), np.full(shape, np.nan), np.full(shape, np.nan)
    fails = np.zeros((*shape, len(judged)), dtype=np.int8)
    for j, (key, value) in enumerate(tqdm(points, unit=" points", disable=None)):
        there = changed(setup, {key: value})
        for i, law in enumerate(laws_with(there, NAMED).values()):
            velocity[i, j], error[i, j], stick[i, j], broken = measured(there, law)
            fails[i, j] = [metric in broken for metric in judged]
    both = ("law", "point")
    return xarray.Dataset(
        {
            "rotor_velocity": (both, velocity, {"units": "rad s-1"}),
            "numerical_error": (both, error, {"units": "rad s-1"}),
            "stick_share": (both, stick, {"units": "1"}),
            "fails": ((*both, "metric"), fails, {"units": "1"}),
        },
        coords={
            "law": names,
            "metric": judged,
            "key": ("point", [key for key, _ in points]),
            "value": ("point", [value for _, value in points]),
        },
    )


def apart(data: xarray.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Range of the laws at every point and the numerical errors of the two outermost [rad/s]."""
    velocity, error = data.rotor_velocity.values, data.numerical_error.values
    points = np.arange(velocity.shape[1])
    sound = np.isfinite(velocity).all(axis=0)
    filled = np.where(np.isfinite(velocity), velocity, 0.0)
    low, high = filled.argmin(axis=0), filled.argmax(axis=0)
    spread = np.where(sound, filled[high, points] - filled[low, points], np.nan)
    return spread, np.where(sound, error[high, points] + error[low, points], np.nan)


def table(data: xarray.Dataset) -> list[dict[str, object]]:
    """One row a point: velocities, their range and numerical errors, thresholds that fail."""
    spread, error = apart(data)
    return [
        {"key": str(data.key.values[j]), "value": float(data.value[j])}
        | {f"{law} [rad/s]": float(data.rotor_velocity.sel(law=law)[j]) for law in data.law.values}
        | {"range [rad/s]": float(spread[j]), "numerical errors [rad/s]": float(error[j])}
        | {f"{law} fails": int(data.fails.sel(law=law)[j].sum()) for law in data.law.values}
        for j in range(data.sizes["point"])
    ]


def draw(data: xarray.Dataset) -> Figure:
    """Velocities above, how far the laws are apart against their numerical errors below."""
    figure, panels = plt.subplots(
        2, len(SWEEPS), figsize=(7.0, 4.2), sharey="row", sharex="col", layout="constrained"
    )
    spread, error = apart(data)
    for column, key in enumerate(SWEEPS):
        words, scale = AXES[key]
        here = data.key.values == key
        x = data.value.values[here] * scale
        above, below = panels[:, column]
        for i, law in enumerate(data.law.values):
            mark = "os^Dv<>P"[i % 8] + "-"
            above.plot(x, data.rotor_velocity.values[i, here], mark, label=str(law))
        below.semilogy(x, spread[here], "o-", color="black", label="range of the laws")
        below.semilogy(x, error[here], "s--", color="0.5", label="numerical errors")
        below.set_xlabel(words)
    panels[0, 0].set_ylabel("rotor velocity (rad/s)")
    panels[1, 0].set_ylabel("difference (rad/s)")
    handles = [*panels[0, 0].get_lines(), *panels[1, 0].get_lines()]
    figure.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 5))
    return figure


def finding(data: xarray.Dataset) -> tuple[str, bool]:
    """Where the laws differ beyond their numerical errors, and what each of them breaks."""
    spread, error = apart(data)
    sound = np.isfinite(spread)
    clear = spread[sound] > CLEAR * error[sound]
    mean = np.abs(data.rotor_velocity.values).mean(axis=0)[sound]
    share = np.median(spread[sound] / np.maximum(mean, 1e-300))
    widest = int(np.nanargmax(spread))
    parts = [
        f"At {np.count_nonzero(clear)} of {data.sizes['point']} points the laws differ by more than "
        f"{CLEAR:.0f} times their numerical errors; in the median by {100.0 * share:.0f} % of their mean "
        f"speed, most, {spread[widest]:.2g} rad/s, at {data.key.values[widest]} "
        f"{float(data.value[widest]):.3g}."
    ]
    for law in data.law.values:
        counts = data.fails.sel(law=law).sum("point")
        broken = [f"{m} at {int(n)}" for m, n in zip(data.metric.values, counts, strict=True) if n]
        said = f"fails {', '.join(broken)}" if broken else "fails no threshold at any"
        parts.append(f"{law} {said}.")
    return " ".join(parts), bool(2 * np.count_nonzero(clear) > data.sizes["point"])


def run(words: Sequence[str]) -> int:
    """Take the laws out of the arguments and run the experiment; returns the exit status."""
    names = [word for word in words if "=" not in word and not word.startswith("-")]
    for name in names:
        if name not in cl.law_names():
            print(
                f"There is no law '{name}'; it must be one of {', '.join(cl.law_names())}. "
                "`contactlab laws` describes them.",
                file=sys.stderr,
            )
            return REFUSED
    NAMED[:] = [name for name in names if name not in PAPER]
    return main(__name__, [word for word in words if word not in names])


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
