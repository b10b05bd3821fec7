"""A search for better motors: phase, frequency, placement, clearance; velocity, torque, peak force.

python experiments/optimise_motor.py [trials=600] [seed=0] [objective=all] [file=FILE] [output=DIR]
                                     [KEY=VALUE ...]

With objective=all, velocity without load and stall torque shall be high and the peak normal force, which
wears the tip, low: the result is the front of motors that nothing beats in all three. With
objective=velocity it is the fastest, and motors that promise less than others are pruned. A key of what is
searched, drive.phase, drive.frequency, placement or contact.clearance, holds it at its value.

The trials are kept in OUTPUT/study.db. Every trial draws from a random stream of its own, which follows from
the seed and from the number of trials finished before: killed at any moment, the same command goes on to the
same result; more trials continue it.
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import OUTPUTS, REFUSED, Experiment, main
from matplotlib.figure import Figure
from motor_performance import NoMotorError, performance, refuse_unfit
from optimum_placement import SHORTEST
from scipy.stats import spearmanr
from tqdm import tqdm
from variations import changed, laws_of

import contactlab as cl
from contactlab.config.nesting import flat
from contactlab.laws.base import MultiplierLaw
from contactlab.studies.study import option

try:
    import optuna
    from optuna.distributions import FloatDistribution
    from optuna.trial import FrozenTrial, Trial, TrialState
except ModuleNotFoundError as missing:
    print(f"{missing.name} is not installed; pip install 'contactlab[design]' installs it.", file=sys.stderr)
    sys.exit(REFUSED)

OBJECTIVES = {
    "all": {"velocity": "maximize", "stall_torque": "maximize", "peak_force": "minimize"},
    "velocity": {"velocity": "maximize"},
}
"""Quantities of the search and their directions."""

GOALS = OBJECTIVES["all"]
UNITS = ("rad s-1", "N m", "N")

KEYS = {
    "drive.phase": ("phase",),
    "drive.frequency": ("relative_frequency",),
    "placement": ("patch_start", "patch_share"),
    "contact.clearance": ("clearance",),
}
"""The variables that belong to a key of the configuration."""

RELATIVE_FREQUENCY = (0.7, 1.4)
"""First tone over the placement's first natural frequency f1, which goes from 1.4 to 3.4 kHz with the
placement. The first tone works best at f1 and the second, twice as high, at f2, that is a first tone at half
of f2: 0.85 to 1.34 f1 for f2/f1 of 1.71 to 2.67 as in Table 1. All are damped so heavily that a resonance is
as wide as a tenth of that."""

CLEARANCE = (0.0, 4e-6)
"""[m]. The paper tries 0, 1 and 2 um; the strongest placements lift the free tip 7 um."""

POPULATION = 30
"""Motors in a generation. The first is drawn at random, and nothing in it is pruned for being slow."""

KEPT = 75.0
"""Share of motors that are not pruned for being slow [%]. It spares a sixth of the runs, and over three
seeds the fastest motor was 7 % slower than without: a generation needs its number of whole trials. Where
the median decides, a third is spared and 11 % of the velocity lost."""

FINISHED = (TrialState.COMPLETE, TrialState.PRUNED)

CONFIGURED = -1
"""Number of the configured motor among the trials."""

FEW = 10
"""Motors below which no rank correlations are stated."""

FORCE = ("peak normal force (N)", "peak normal impulse (N s)")


def ranges_of(setup: cl.Setup, blocked: Sequence[str] = ()) -> dict[str, tuple[float, float]]:
    """Return least and largest value of every variable that is not held.

    phase               of the first tone [rad]. Half a period of the second tone later, pi/ratio in the
                        phase of the first, the electrodes have changed places: the same motor in the
                        mirror. Longer ranges would hold every motor twice.
    relative_frequency  first tone over the first natural frequency [1]
    patch_start         from the clamp [m]
    patch_share         length beyond the shortest patch over all that is left up to mid-beam [1]: every
                        pair of numbers is a placement
    clearance           [m]

    Raises:
        ValueError: all are held.
    """
    settings = setup.configuration
    half = 0.5 * settings["resonator"]["length"]
    every = {
        "phase": (-np.pi / settings["drive"]["frequency_ratio"], 0.0),
        "relative_frequency": RELATIVE_FREQUENCY,
        "patch_start": (0.0, half - SHORTEST),
        "patch_share": (0.0, 1.0),
        "clearance": CLEARANCE,
    }
    kept = {name for key in blocked for name in KEYS[key]}
    if kept == set(every):
        raise ValueError(
            f"fixed is {', '.join(blocked)}; at least one of {', '.join(KEYS)} must be searched."
        )
    return {name: bounds for name, bounds in every.items() if name not in kept}


def designed(setup: cl.Setup, values: Mapping[str, float]) -> cl.Setup:
    """Return the motor with some variables set."""
    changes: dict[str, object] = {}
    if "phase" in values:
        changes["drive.phase"] = values["phase"]
    if "clearance" in values:
        changes["contact.clearance"] = values["clearance"]
    if "patch_start" in values:
        start = values["patch_start"]
        left = 0.5 * setup.configuration["resonator"]["length"] - start - SHORTEST
        changes |= {
            "placement.start": start,
            "placement.end": start + SHORTEST + values["patch_share"] * left,
        }
    placed = changed(setup, changes)
    if "relative_frequency" not in values:
        return placed
    natural = float(placed.motor.modes.natural_frequency[0])
    return changed(placed, {"drive.frequency": values["relative_frequency"] * natural})


@contextmanager
def study_in(
    file: str | None, settings: Mapping[str, object], directions: Sequence[str]
) -> Iterator[optuna.Study]:
    """Open the study of a database, new or as it was left; None keeps it in memory.

    Raises:
        ValueError: its trials were made with other settings.
    """
    if file is not None:
        Path(file).parent.mkdir(parents=True, exist_ok=True)
    storage = None if file is None else optuna.storages.RDBStorage(f"sqlite:///{file}")
    try:
        pruner = optuna.pruners.PercentilePruner(KEPT, n_startup_trials=POPULATION)
        study = optuna.create_study(
            study_name="contactlab",
            storage=storage,
            directions=directions,
            pruner=pruner,
            load_if_exists=True,
        )
        # Without trials nothing depends on settings: the process was killed before they were written.
        if not study.get_trials(deepcopy=False):
            study.set_user_attr("settings", settings)
        before, now = flat(study.user_attrs.get("settings", {})), flat(settings)
        if differ := [key for key in {**now, **before} if before.get(key) != now.get(key)]:
            raise ValueError(
                f"{file} has trials with another {', '.join(differ)}; choose another by file=FILE."
            )
        for trial in study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
            study.tell(trial.number, state=TrialState.FAIL)
        yield study
    finally:
        if storage is not None:
            storage.remove_session()
            storage.engine.dispose()


def attempt(study: optuna.Study, trial: Trial, setup: cl.Setup) -> None:
    """Measure one motor and pass the numbers to the study, which keeps them with the trial.

    A motor without contact, steady vibration or torque is pruned after the run at rest that shows it, and,
    where velocity is the only objective, one that promises less than most before it.
    """
    single = len(study.directions) == 1
    runs = 1

    def watch(velocity: float, so_far: int) -> None:
        nonlocal runs
        runs = so_far
        if single:
            trial.report(velocity, runs)
            if trial.should_prune():
                raise optuna.TrialPruned(f"Slower than most after {runs} runs.")

    try:
        result = performance(designed(setup, trial.params), watch)
    except (NoMotorError, optuna.TrialPruned) as reason:
        trial.set_user_attr("measured", {"reason": str(reason), "runs": runs})
        study.tell(trial, state=TrialState.PRUNED)
        return
    trial.set_user_attr("measured", vars(result))
    names = OBJECTIVES["velocity" if single else "all"]
    study.tell(trial, [getattr(result, name) for name in names])


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


def _gains(configured: xarray.Dataset, result: xarray.Dataset) -> str:
    fastest = result.isel(motor=int(result.velocity.argmax("motor")))
    texts = (
        f"The fastest motor makes {float(fastest.velocity):.2f} rad/s, "
        f"{float(fastest.velocity / configured.velocity):.2f} times the configured one, with patches from "
        f"{1e3 * float(fastest.patch_start):.2f} to {1e3 * float(fastest.patch_end):.2f} mm, at "
        f"{float(fastest.relative_frequency):.2f} times the first natural frequency and a clearance of "
        f"{1e6 * float(fastest.clearance):.2f} um"
    )
    if result.sizes["motor"] == 1:
        return f"{texts}."
    strongest = result.isel(motor=int(result.stall_torque.argmax("motor")))
    return (
        f"{texts}; the strongest holds {1e3 * float(strongest.stall_torque):.2f} mN m, "
        f"{float(strongest.stall_torque / configured.stall_torque):.2f} times, with patches from "
        f"{1e3 * float(strongest.patch_start):.2f} to {1e3 * float(strongest.patch_end):.2f} mm."
    )


def _trade(result: xarray.Dataset) -> str:
    """What goes with what along the front, by rank."""
    if result.sizes["motor"] < FEW:
        return ""
    ranks = {
        pair: float(spearmanr(result[pair[0]], result[pair[1]]).statistic)
        for pair in (("velocity", "stall_torque"), ("velocity", "peak_force"), ("stall_torque", "peak_force"))
    }
    text = [f"{a.replace('_', ' ')} and {b.replace('_', ' ')} {rho:.2f}" for (a, b), rho in ranks.items()]
    return f"Rank correlations along the front: {', '.join(text)}."


def _rival(data: xarray.Dataset, result: xarray.Dataset) -> str:
    """Whether the other law would have chosen so."""
    both = result.where(np.isfinite(result.velocity_under_rival), drop=True)
    if both.sizes["motor"] == 0:
        return f"Under {data.rival} none of them turns."
    change = both.velocity_under_rival / both.velocity
    if both.sizes["motor"] == 1:
        return f"Under {data.rival} its velocity is {float(change[0]):.2f} times that."
    same = int(both.velocity.argmax("motor")) == int(both.velocity_under_rival.argmax("motor"))
    return (
        f"Under {data.rival} their velocities are {float(change.min()):.2f} to {float(change.max()):.2f} "
        f"times those under {data.law}, and the fastest of them is {'the same' if same else 'another'} motor."
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


@dataclass(frozen=True, kw_only=True)
class OptimiseMotor(Experiment):
    """Which phase, frequency, placement and clearance make a better motor than the configured one?"""

    says = (
        "Placement, phase and clearance are tried at a few values, one at a time. The smallest clearance is "
        "called the best, and the phase was found by trial."
    )

    trials: Annotated[int, option("motors to try, those of earlier runs included", at_least=1)] = 600
    seed: Annotated[int, option("seed of the search", at_least=0)] = 0
    objective: Annotated[Literal["all", "velocity"], option("all three quantities or one")] = "all"
    fixed: Annotated[list[str] | None, option("keys that stay as configured")] = None
    file: Annotated[str | None, option("database of the trials")] = None

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Search, and measure the best once more under another law."""
        refuse_unfit(setup)
        bounds = ranges_of(setup, self.fixed or [])
        try:
            configured = performance(setup)
        except NoMotorError as error:
            raise ValueError(f"The configured motor cannot be compared with: {error}") from error
        trials = self.searched(setup, bounds)
        motors = [setup, *(designed(setup, trial.params) for trial in trials)]
        result = [vars(configured), *(trial.user_attrs["measured"] for trial in trials)]
        goals = np.array([[float(item.get(name, np.nan)) for name in GOALS] for item in result])
        best = among_the_best(goals, self.objective)
        rival, law = next(
            (name, law)
            for name, law in laws_of(setup).items()
            if name in ("hertz_penalty", "lagrange_stick") and name != setup.law.name
        )
        under_rival = np.full(best.size, np.nan)
        again = [0, *np.flatnonzero(best)]
        for k in tqdm(again, unit=f" motors under {rival}", disable=None):
            own = cl.Setup.of(motors[k].motor, law, setup.duration, setup.record_interval)
            under_rival[k] = _velocity(own)
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
                "runs": ("motor", [int(item["runs"]) for item in result], {"units": "1"}),
                "pruned_for": ("motor", [str(item.get("reason", "")) for item in result]),
                "best": ("motor", best.astype(np.int8), {"units": "1"}),
            },
            coords={"motor": [CONFIGURED, *range(len(trials))]},
            attrs={
                "law": setup.law.name,
                "rival": rival,
                "objective": self.objective,
                "force": FORCE[isinstance(setup.law, MultiplierLaw)],
            },
        )

    def searched(self, setup: cl.Setup, bounds: Mapping[str, tuple[float, float]]) -> list[FrozenTrial]:
        """Return the finished trials, in order; those of the database are not run again."""
        distributions = {name: FloatDistribution(*bound) for name, bound in bounds.items()}
        settings = {
            "objective": self.objective,
            "seed": self.seed,
            "population": POPULATION,
            "kept": KEPT,
            "optuna": optuna.__version__,
            "range": {name: list(bound) for name, bound in bounds.items()},
            **setup.configuration,
        }
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        count = 6 if self.short else self.trials
        with study_in(self.file, settings, list(OBJECTIVES[self.objective].values())) as study:
            done = len(study.get_trials(deepcopy=False, states=FINISHED))
            for index in tqdm(range(done, count), initial=done, total=count, unit=" trials", disable=None):
                stream = np.random.SeedSequence([self.seed, index])
                # NSGA-II has no state but its random stream. Estimators of density, optuna's default, settle
                # in one of the two families of good motors within the first hundred trials.
                study.sampler = optuna.samplers.NSGAIISampler(
                    seed=int(stream.generate_state(1)[0]), population_size=POPULATION
                )
                attempt(study, study.ask(distributions), setup)
            return study.get_trials(deepcopy=False, states=FINISHED)[:count]

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
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

    def draw(self, data: xarray.Dataset) -> Figure:
        """What the motors can do, and where their patches lie; the best have an edge."""
        figure, panels = plt.subplots(1, 2, figsize=(7.2, 3.1), layout="constrained")
        result = data.isel(motor=slice(1, None))
        trials = result.where(np.isfinite(result.velocity), drop=True).sortby("velocity")
        for ax, x, y, colour, texts in (
            (panels[0], 1e3 * data.stall_torque, data.velocity, "peak_force", data.force),
            (panels[1], 1e3 * data.patch_start, 1e3 * data.patch_end, "velocity", "velocity (rad/s)"),
        ):
            scale = {"vmin": 0.0, "vmax": float(trials[colour].max()), "linewidths": 0.6}
            for k, (label, size, edge) in enumerate((("other trials", 8, "none"), ("best", 20, "k"))):
                drawn = trials.where(trials.best == k, drop=True)
                at = (x.sel(motor=drawn.motor), y.sel(motor=drawn.motor))
                dots = ax.scatter(*at, size, drawn[colour], edgecolors=edge, label=label, **scale)
            ax.plot(x[0], y[0], "r*", label="configured")
            figure.colorbar(dots, ax=ax, label=texts)
        panels[0].set(xlabel="stall torque (mN m)", ylabel="velocity without load (rad/s)")
        panels[0].set(xlim=(0.0, None), ylim=(0.0, None))
        panels[0].legend()
        panels[1].set(xlabel="start of the patch (mm)", ylabel="end of the patch (mm)")
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """How much better than the configured motor, at what price, and whether another law agrees."""
        configured, result = data.isel(motor=0), data.where(data.best == 1, drop=True)
        if result.sizes["motor"] == 0:
            return f"None of {data.sizes['motor'] - 1} trials is a motor.", False
        parts = [_gains(configured, result)]
        holds = float(result.velocity.max()) > float(configured.velocity)
        if data.objective == "all":
            better = (
                (result.velocity > configured.velocity)
                & (result.stall_torque > configured.stall_torque)
                & (result.peak_force < configured.peak_force)
            )
            holds = bool(better.any())
            parts.append(
                f"Better than the configured motor in all three: {int(better.sum())} of "
                f"{result.sizes['motor']} on the front."
            )
        parts += [_trade(result), _rival(data, result), _pruned(data)]
        return " ".join(part for part in parts if part), holds


def fixed_by(texts: Sequence[str]) -> list[str]:
    """Return the keys of `KEYS` that arguments set."""
    options = dict(word.split("=", 1) for word in texts if "=" in word)
    groups = {key.split(".")[0] if key.startswith("placement.") else key for key in options}
    # Without a number, a frequency is that of the resonance, about which is searched anyhow.
    return [key for key in KEYS if key in groups and (key != "drive.frequency" or options[key] != "null")]


if __name__ == "__main__":
    folders = [word.removeprefix("output=") for word in sys.argv if word.startswith("output=")]
    database = Path([str(OUTPUTS / OptimiseMotor.name), *folders][-1]) / "study.db"
    sys.argv[1:1] = [f"file={database}", f"fixed=[{','.join(fixed_by(sys.argv[1:]))}]"]
    main(__file__)
