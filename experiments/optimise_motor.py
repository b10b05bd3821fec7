"""A search for better motors: phase, frequency, placement, clearance; velocity, torque, peak force.

python experiments/optimise_motor.py [trials=600] [seed=0] [objective=all] [study=FILE] [output=DIR]
                                     [KEY=VALUE ...]

With objective=all, velocity without load and stall torque shall be high and the peak normal force, which
wears the tip, low: the result is the front of motors that nothing beats in all three. With
objective=velocity it is the fastest, and motors that promise less than others are pruned. A key of what is
searched, drive.phase, drive.frequency, placement or contact.clearance, holds it at its value.

The study is kept in a file, OUTPUT/study.db. Killed at any moment, the same command goes on to the same
result; more trials continue it.
"""

import sys
from collections.abc import Sequence
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import xarray
from harness import REFUSED, laws_of, main
from matplotlib.figure import Figure
from motor_performance import NoMotorError, performance, refuse_unfit
from scipy.stats import spearmanr
from tqdm import tqdm

import contactlab as cl
from contactlab.laws.base import MultiplierLaw

try:
    from motor_search import OBJECTIVES, Search, designed, ranges_of, search_of, searched
except ModuleNotFoundError as missing:
    print(
        f"The search needs the package {missing.name}, which is not installed. Install it with: "
        "pip install 'contactlab[design]' (in a clone: pip install -e '.[design]').",
        file=sys.stderr,
    )
    sys.exit(REFUSED)

SAYS = (
    "Placement, phase and clearance are tried at a few values, one at a time. The smallest clearance is "
    "called the best, and the phase was found by trial."
)
ASKED = [Search()]
"""What the command line asks for."""

CONFIGURED = -1
"""Number of the configured motor among the trials."""

FEW = 10
"""Motors too few to speak of what goes with what."""

GOALS = OBJECTIVES["all"]
UNITS = ("rad s-1", "N m", "N")
FORCE = ("peak normal force", "peak impulse over contact step")
INTERRUPTED = 130


def study(setup: cl.Setup, short: bool = False) -> xarray.Dataset:
    """Search, and measure the best once more under another law; the short form has six trials."""
    refuse_unfit(setup)
    search = replace(ASKED[0], trials=6) if short else ASKED[0]
    ranges_of(setup, search.held)
    try:
        configured = performance(setup)
    except NoMotorError as error:
        raise cl.ConfigurationError(
            [f"The configured motor is none to compare with: {error} Change its configuration."]
        ) from error
    trials = searched(setup, search)
    motors = [setup, *(designed(setup, trial.params) for trial in trials)]
    found = [vars(configured), *(trial.user_attrs["measured"] for trial in trials)]
    goals = np.array([[float(one.get(name, np.nan)) for name in GOALS] for one in found])
    best = among_the_best(goals, search.objective)
    rival, law = next(
        (name, law)
        for name, law in laws_of(setup).items()
        if name in ("hertz_penalty", "lagrange_stick") and name != setup.law.name
    )
    under_rival = np.full(best.size, np.nan)
    again = [0, *np.flatnonzero(best)]
    for k in tqdm(again, unit=f" motors under {rival}", disable=None):
        step = min(law.default_contact_step, setup.duration)
        under_rival[k] = _velocity(replace(motors[k], law=law, contact_step=step, tolerance=None))
    settings = [motor.configuration for motor in motors]
    first = [motor.motor.modes.natural_frequency[0] for motor in motors]
    frequency = np.array([s["drive"]["frequency"] for s in settings])
    return xarray.Dataset(
        {
            "phase": ("motor", [s["drive"]["phase"] for s in settings], {"units": "rad"}),
            "frequency": ("motor", frequency, {"units": "Hz"}),
            "relative_frequency": ("motor", frequency / first, {"units": "1"}),
            "patch_start": ("motor", [s["placement"]["start"] for s in settings], {"units": "m"}),
            "patch_end": ("motor", [s["placement"]["end"] for s in settings], {"units": "m"}),
            "clearance": ("motor", [s["contact"]["clearance"] for s in settings], {"units": "m"}),
            **{
                name: ("motor", column, {"units": unit})
                for name, column, unit in zip(GOALS, goals.T, UNITS, strict=True)
            },
            "velocity_under_rival": ("motor", under_rival, {"units": "rad s-1"}),
            "runs": ("motor", [int(one["runs"]) for one in found], {"units": "1"}),
            "pruned_for": ("motor", [str(one.get("reason", "")) for one in found]),
            "best": ("motor", best.astype(np.int8), {"units": "1"}),
        },
        coords={"motor": [CONFIGURED, *range(len(trials))]},
        attrs={
            "law": setup.law.name,
            "rival": rival,
            "objective": search.objective,
            "force": FORCE[isinstance(setup.law, MultiplierLaw)],
        },
    )


def _velocity(setup: cl.Setup) -> float:
    try:
        return performance(setup).velocity
    except NoMotorError:
        return float("nan")


def among_the_best(goals: np.ndarray, objective: str) -> np.ndarray:
    """Which motors the search has found: those that no other beats in every goal, or the fastest.

    Args:
        goals: shape (motor, goal), the configured motor first, which is not found; nan is pruned.
        objective: one of OBJECTIVES.
    """
    names = list(OBJECTIVES[objective])
    signs = np.array([1.0 if GOALS[name] == "maximize" else -1.0 for name in names])
    merit = signs * goals[:, [list(GOALS).index(name) for name in names]]
    merit[0] = np.nan
    best = np.isfinite(merit).all(axis=1)
    for k in np.flatnonzero(best):
        no_worse, better = (merit >= merit[k]).all(axis=1), (merit > merit[k]).any(axis=1)
        # What was drawn twice is found once.
        best[k] = not np.any(no_worse & (better | (np.arange(best.size) < k)))
    return best


def table(data: xarray.Dataset) -> list[dict[str, object]]:
    """The configured motor, then the best, the fastest first."""
    best = np.flatnonzero(data.best.values)
    order = best[np.argsort(-data.velocity.values[best], kind="stable")]
    return [
        {
            "motor": "configured" if motor.motor == CONFIGURED else f"trial {int(motor.motor)}",
            "phase [rad]": float(motor.phase),
            "frequency [Hz]": float(motor.frequency),
            "over f1": float(motor.relative_frequency),
            "start [mm]": 1e3 * float(motor.patch_start),
            "end [mm]": 1e3 * float(motor.patch_end),
            "clearance [um]": 1e6 * float(motor.clearance),
            "velocity [rad/s]": float(motor.velocity),
            f"under {data.rival} [rad/s]": float(motor.velocity_under_rival),
            "stall torque [mN m]": 1e3 * float(motor.stall_torque),
            "peak force [N]": float(motor.peak_force),
        }
        for motor in (data.isel(motor=k) for k in (0, *order))
    ]


def draw(data: xarray.Dataset) -> Figure:
    """What the motors can do, and where their patches lie; the best have an edge."""
    figure, panels = plt.subplots(1, 2, figsize=(7.2, 3.1), layout="constrained")
    found = data.isel(motor=slice(1, None))
    trials = found.where(np.isfinite(found.velocity), drop=True).sortby("velocity")
    for ax, x, y, colour, words in (
        (panels[0], 1e3 * data.stall_torque, data.velocity, "peak_force", f"{data.force} (N)"),
        (panels[1], 1e3 * data.patch_start, 1e3 * data.patch_end, "velocity", "velocity (rad/s)"),
    ):
        scale = {"vmin": 0.0, "vmax": float(trials[colour].max()), "linewidths": 0.6}
        for k, (label, size, edge) in enumerate((("other trials", 8, "none"), ("best", 20, "k"))):
            drawn = trials.where(trials.best == k, drop=True)
            at = (x.sel(motor=drawn.motor), y.sel(motor=drawn.motor))
            dots = ax.scatter(*at, size, drawn[colour], edgecolors=edge, label=label, **scale)
        ax.plot(x[0], y[0], "r*", label="configured")
        figure.colorbar(dots, ax=ax, label=words)
    panels[0].set(xlabel="stall torque (mN m)", ylabel="velocity without load (rad/s)")
    panels[0].set(xlim=(0.0, None), ylim=(0.0, None))
    panels[0].legend()
    panels[1].set(xlabel="start of the patch (mm)", ylabel="end of the patch (mm)")
    return figure


def finding(data: xarray.Dataset) -> tuple[str, bool]:
    """How much better than the configured motor, at what price, and whether another law agrees."""
    configured, found = data.isel(motor=0), data.where(data.best == 1, drop=True)
    if found.sizes["motor"] == 0:
        return f"None of {data.sizes['motor'] - 1} trials is a motor.", False
    parts = [_gains(configured, found)]
    holds = float(found.velocity.max()) > float(configured.velocity)
    if data.objective == "all":
        better = (
            (found.velocity > configured.velocity)
            & (found.stall_torque > configured.stall_torque)
            & (found.peak_force < configured.peak_force)
        )
        holds = bool(better.any())
        parts.append(
            f"Better than the configured motor in all three: {int(better.sum())} of "
            f"{found.sizes['motor']} on the front."
        )
    parts += [_trade(found), _rival(data, found), _pruned(data)]
    return " ".join(part for part in parts if part), holds


def _gains(configured: xarray.Dataset, found: xarray.Dataset) -> str:
    fastest = found.isel(motor=int(found.velocity.argmax("motor")))
    words = (
        f"The fastest motor makes {float(fastest.velocity):.2f} rad/s, "
        f"{float(fastest.velocity / configured.velocity):.2f} times the configured one, with patches from "
        f"{1e3 * float(fastest.patch_start):.2f} to {1e3 * float(fastest.patch_end):.2f} mm, at "
        f"{float(fastest.relative_frequency):.2f} times the first natural frequency and a clearance of "
        f"{1e6 * float(fastest.clearance):.2f} um"
    )
    if found.sizes["motor"] == 1:
        return f"{words}."
    strongest = found.isel(motor=int(found.stall_torque.argmax("motor")))
    return (
        f"{words}; the strongest holds {1e3 * float(strongest.stall_torque):.2f} mN m, "
        f"{float(strongest.stall_torque / configured.stall_torque):.2f} times, with patches from "
        f"{1e3 * float(strongest.patch_start):.2f} to {1e3 * float(strongest.patch_end):.2f} mm."
    )


def _trade(found: xarray.Dataset) -> str:
    """What goes with what along the front, by rank."""
    if found.sizes["motor"] < FEW:
        return ""
    ranks = {
        pair: float(spearmanr(found[pair[0]], found[pair[1]]).statistic)
        for pair in (("velocity", "stall_torque"), ("velocity", "peak_force"), ("stall_torque", "peak_force"))
    }
    told = [f"{a.replace('_', ' ')} and {b.replace('_', ' ')} {rho:.2f}" for (a, b), rho in ranks.items()]
    return f"Rank correlations along the front: {', '.join(told)}."


def _rival(data: xarray.Dataset, found: xarray.Dataset) -> str:
    """Whether the other law would have chosen so."""
    both = found.where(np.isfinite(found.velocity_under_rival), drop=True)
    if both.sizes["motor"] == 0:
        return f"Under {data.rival} none of them turns."
    change = both.velocity_under_rival / both.velocity
    if both.sizes["motor"] == 1:
        return f"Under {data.rival} its velocity is {float(change[0]):.2f} times that."
    same = int(both.velocity.argmax("motor")) == int(both.velocity_under_rival.argmax("motor"))
    return (
        f"Under {data.rival} their velocities are {float(change.min()):.2f} to "
        f"{float(change.max()):.2f} times those under {data.law}, and the fastest of them is "
        f"{'the same' if same else 'another'} motor."
    )


def _pruned(data: xarray.Dataset) -> str:
    """What pruning has saved if the pruned trials would have taken as many runs as the others."""
    trials = data.isel(motor=slice(1, None))
    pruned = trials.pruned_for.values != ""
    if not pruned.any() or pruned.all():
        return ""
    runs = trials.runs.values
    spared = 1.0 - runs.sum() / (runs.size * runs[~pruned].mean())
    return (
        f"{int(pruned.sum())} of {pruned.size} trials were pruned, which spared {100.0 * spared:.0f} % of "
        "the runs that all of them would have taken."
    )


def run(words: Sequence[str]) -> int:
    """Take the search out of the arguments and run the experiment; returns the exit status."""
    try:
        search, rest = search_of(words)
    except cl.ConfigurationError as error:
        print(*error.faults, sep="\n", file=sys.stderr)
        return REFUSED
    ASKED[0] = search
    try:
        return main(__name__, rest)
    except KeyboardInterrupt:
        print(
            f"Interrupted; {search.file} holds the trials that are finished, and the same command goes on.",
            file=sys.stderr,
        )
        return INTERRUPTED


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
