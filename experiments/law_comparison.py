"""Contact laws over clearance, phase and friction coefficient: where they differ, and what they break.

Each law in the motor once it has settled: at three steps, so that every difference between laws stands beside
the numerical error of both, and on the converged basis.
"""

import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, ClassVar

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main, part_of
from matplotlib.figure import Figure
from variations import changed, laws_of

import contactlab as cl
from contactlab.config import compose
from contactlab.engine.preparation import DEFAULT_TOLERANCE
from contactlab.metrics import FAIL, METRICS, STEP_METRICS, Run, assess, assess_steps
from contactlab.metrics.convergence import FINER, richardson
from contactlab.steady_state import BrokenOffError, NotSettledError
from contactlab.steady_state.means import means_of, motion_of, settled
from contactlab.studies.compare_draws import on_other_basis
from contactlab.studies.study import Part, Setups, Task, option

PAPER = ("lagrange_slip", "lagrange_stick", "hertz_penalty")
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
NUMBERS = {
    "rotor_velocity": {"units": "rad s-1", "long_name": "settled rotor velocity"},
    "numerical_error": {"units": "rad s-1"},
    "basis_change": {"units": "rad s-1", "long_name": "its change on the converged basis"},
    "stick_share": {"units": "1"},
}
JUDGED = [key for key, metric in {**METRICS, **STEP_METRICS}.items() if metric.judges_law]
"""Metrics with a threshold for laws."""

WITHOUT_ORBIT = ("lagrange_slip",)
"""Laws whose means take long runs."""

CLEAR = 3.0
"""A range of this many numerical errors is a difference between laws."""


@cache
def section(name: str) -> dict[str, Any]:
    """The parameters of a law where nothing is said of them."""
    chosen: dict[str, Any] = compose([f"law={name}"])["law"]
    return chosen


def laws_with(setup: cl.Setup, others: Sequence[str]) -> dict[str, cl.ContactLaw]:
    """Return the paper's laws and others with the configured friction and rotor.

    Raises:
        ValueError: there is no law of a name.
    """
    if unknown := {*others} - {*cl.law_names()}:
        names = ", ".join(cl.law_names())
        raise ValueError(f"others is {', '.join(sorted(unknown))}; it must be among {names}.")
    solver = {**setup.configuration["solver"], "contact_step": None, "tolerance": None}
    options = {**setup.configuration, "solver": solver}
    own = {name: cl.build({**options, "law": section(name)}).law for name in others if name not in PAPER}
    return laws_of(setup) | own


def measured(setup: cl.Setup, law: cl.ContactLaw) -> tuple[float, float, float, float, list[str]]:
    """Settled velocity, its error, its change on the other basis, share of stick, failed thresholds."""
    rigid = isinstance(law, cl.MultiplierLaw)
    control, coarsest = (
        ("contact_step", law.default_contact_step) if rigid else ("tolerance", DEFAULT_TOLERANCE)
    )
    plain = replace(setup, law=law, contact_step=law.default_contact_step, tolerance=None)
    steps, means = [], []
    try:
        for divisor in FINER[control]:
            state = settled(replace(plain, **{control: coarsest / divisor}))
            run = Run.of_trajectory(motion_of(state), state.setup.configuration)
            steps.append((coarsest / divisor, run))
            means.append(means_of(state))
        there = replace(plain, motor=cl.build(on_other_basis(setup)[0]).motor)
        elsewhere = means_of(settled(there)).values[0]
    # A rigid law refuses to go on from a motion that a period's end has cut in contact.
    except (BrokenOffError, NotSettledError, ValueError) as error:
        print(f"{law.name}: {error}", file=sys.stderr)
        return np.nan, np.nan, np.nan, np.nan, []
    values = assess(steps[-1][1]) | assess_steps(steps)
    judged = {**METRICS, **STEP_METRICS}
    broken = [key for key, metric in judged.items() if metric.verdict(values[key]) == FAIL]
    velocities = np.array([each.values[0] for each in means])
    error = float(richardson(velocities, FINER[control][1], law.convergence_order)) + means[-1].errors[0]
    change = abs(elsewhere - velocities[0])
    return float(velocities[-1]), float(error), float(change), float(means[-1].values[2]), broken


def apart(data: xarray.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Range of the laws at every point, errors of the two outermost, what the basis changes [rad/s]."""
    velocity, error, basis = (
        data[name].values for name in ("rotor_velocity", "numerical_error", "basis_change")
    )
    points = np.arange(velocity.shape[1])
    sound = np.isfinite(velocity).all(axis=0)
    filled = np.where(np.isfinite(velocity), velocity, 0.0)
    ends = filled.argmin(axis=0), filled.argmax(axis=0)
    spread = np.where(sound, filled[ends[1], points] - filled[ends[0], points], np.nan)
    errors = np.where(sound, error[ends[0], points] + error[ends[1], points], np.nan)
    most = np.where(sound, np.maximum(basis[ends[0], points], basis[ends[1], points]), np.nan)
    return spread, errors, most


def at_point(setup: cl.Setup, names: Sequence[str], others: Sequence[str], key: str, value: float) -> Part:
    """Compute every law at one point."""
    there = changed(setup, {key: value})
    laws = laws_with(there, others)
    result = [measured(there, laws[name]) for name in names]
    numbers = dict(zip(NUMBERS, np.array([law[:4] for law in result]).T, strict=True))
    fails = np.array([[metric in law[4] for metric in JUDGED] for law in result], dtype=np.int8)
    return part_of(
        xarray.Dataset(
            {name: ("law", column, NUMBERS[name]) for name, column in numbers.items()}
            | {"fails": (("law", "metric"), fails, {"units": "1"})},
            coords={"law": [*names], "metric": JUDGED, "key": key, "value": value},
        )
    )


@dataclass(frozen=True, kw_only=True)
class LawComparison(Experiment):
    """Where do contact laws differ in the settled motor, and which thresholds do they fail?

    Over clearance, phase and friction coefficient, one at a time; LAW ... adds laws to the paper's three.
    """

    says = (
        "Three contact laws are tried on one motor, each at a clearance, a phase and a step of its own, and "
        "compared by eye."
    )
    patterns: ClassVar[Mapping[str, re.Pattern[str]]] = {"others": re.compile(r"[a-z_]+")}

    others: Annotated[list[str] | None, option("further laws")] = None

    def tasks(self, setups: Setups) -> Iterator[Task]:
        """Yield a task a point; the short form has one of each sweep, without the laws that take long."""
        (setup,) = setups.values()
        others = self.others or []
        names = [name for name in laws_with(setup, others) if not self.short or name not in WITHOUT_ORBIT]
        for key, values in SWEEPS.items():
            for value in map(float, values[[4]] if self.short else values):
                yield Task(f"{key}={value!r}", at_point, (setup, names, others, key, value))

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return all points."""
        return xarray.concat(parts, "point").transpose("law", "point", "metric")

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """One row a point: velocities, their range and numerical errors, thresholds that fail."""
        spread, error, basis = apart(data)
        return [
            {"key": str(data.key.values[j]), "value": float(data.value[j])}
            | {f"{law} [rad/s]": float(data.rotor_velocity.sel(law=law)[j]) for law in data.law.values}
            | {"range [rad/s]": float(spread[j]), "numerical errors [rad/s]": float(error[j])}
            | {"change by the basis [rad/s]": float(basis[j])}
            | {f"{law} fails": int(data.fails.sel(law=law)[j].sum()) for law in data.law.values}
            for j in range(data.sizes["point"])
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Velocities above; below how far the laws are apart, against numerical errors and basis."""
        figure, panels = plt.subplots(
            2, len(SWEEPS), figsize=(7.0, 4.2), sharey="row", sharex="col", layout="constrained"
        )
        spread, error, basis = apart(data)
        for column, key in enumerate(SWEEPS):
            texts, scale = AXES[key]
            here = data.key.values == key
            x = data.value.values[here] * scale
            above, below = panels[:, column]
            for i, law in enumerate(data.law.values):
                mark = "os^Dv<>P"[i % 8] + "-"
                above.plot(x, data.rotor_velocity.values[i, here], mark, label=str(law))
            below.semilogy(x, spread[here], "o-", color="black", label="range of the laws")
            below.semilogy(x, basis[here], "^:", color="#a33c00", label="change by the basis")
            below.semilogy(x, error[here], "s--", color="0.5", label="numerical errors")
            below.set_xlabel(texts)
        panels[0, 0].set_ylabel("settled velocity (rad/s)")
        panels[1, 0].set_ylabel("difference (rad/s)")
        handles = [*panels[0, 0].get_lines(), *panels[1, 0].get_lines()]
        figure.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 5))
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Where the laws differ beyond numerical errors and basis, and what each of them breaks."""
        spread, error, basis = apart(data)
        sound = np.isfinite(spread)
        clear = spread[sound] > CLEAR * error[sound]
        beyond = clear & (spread[sound] > basis[sound])
        opposite = np.ptp(np.sign(data.rotor_velocity.values[:, sound]), axis=0) > 1.0
        mean = np.abs(data.rotor_velocity.values).mean(axis=0)[sound]
        share = np.median(spread[sound] / np.maximum(mean, 1e-300))
        widest = int(np.nanargmax(spread))
        parts = [
            f"Settled, at {np.count_nonzero(clear)} of {data.sizes['point']} points the laws differ by more "
            f"than {CLEAR:.0f} times their numerical errors; in the median by {100.0 * share:.0f} % of their "
            f"mean speed, most, {spread[widest]:.2g} rad/s, at {data.key.values[widest]} "
            f"{float(data.value[widest]):.3g}. At {np.count_nonzero(beyond)} they differ by more than the "
            f"converged basis changes either, and at {np.count_nonzero(opposite)} they turn in opposite "
            "directions."
        ]
        if lost := np.count_nonzero(~sound):
            parts.append(f"At {lost} some law is not brought to a steady state.")
        for law in data.law.values:
            counts = data.fails.sel(law=law).sum("point")
            broken = [f"{m} at {int(n)}" for m, n in zip(data.metric.values, counts, strict=True) if n]
            text = f"fails {', '.join(broken)}" if broken else "fails no threshold at any"
            parts.append(f"{law} {text}.")
        return " ".join(parts), bool(2 * np.count_nonzero(clear) > data.sizes["point"])


if __name__ == "__main__":
    main(__file__)
