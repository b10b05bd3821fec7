"""A search for motors with optuna: what is varied, in which ranges, and a study that can be resumed.

Every trial draws from a random stream of its own, which follows from the seed and from the number of
trials finished before. So a study that was killed and resumed is the one that was never interrupted: the
trial that was cut is given up and drawn again, the same.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import optuna
from harness import changed
from motor_performance import NoMotorError, performance
from optimum_placement import SHORTEST
from optuna.distributions import FloatDistribution
from optuna.trial import FrozenTrial, Trial, TrialState
from study_file import study_in
from tqdm import tqdm

import contactlab as cl

NAME = "optimise_motor"
OWN = ("trials", "seed", "objective", "study")
"""Arguments that are no keys of the configuration."""

OBJECTIVES = {
    "all": {"velocity": "maximize", "stall_torque": "maximize", "peak_force": "minimize"},
    "velocity": {"velocity": "maximize"},
}
"""What is searched for, and in which direction."""

KEYS = {
    "drive.phase": ("phase",),
    "drive.frequency": ("relative_frequency",),
    "placement": ("patch_start", "patch_share"),
    "contact.clearance": ("clearance",),
}
"""The variables that belong to a key of the configuration."""

RELATIVE_FREQUENCY = (0.7, 1.4)
"""First tone over the placement's first natural frequency f1. The frequency itself would be no variable:
f1 goes from 1.4 to 3.4 kHz with the placement. The first tone works best at f1 and the second, twice as
high, at f2, that is a first tone at half of f2: 0.85 to 1.34 f1 for f2/f1 of 1.71 to 2.67 as in Table 1.
All are damped so heavily that a resonance is as wide as a tenth of that."""

CLEARANCE = (0.0, 4e-6)
"""[m]. The paper tries 0, 1 and 2 um; the strongest placements lift the free tip 7 um."""

POPULATION = 30
"""Motors in a generation. The first is drawn at random, and nothing in it is pruned for being slow."""

KEPT = 75.0
"""Share of motors that are not pruned for being slow [%]. It spares a sixth of the runs, and over three
seeds the fastest motor was 7 % slower than without: a generation needs its number of whole trials. Where
the median decides, a third is spared and 11 % of the velocity lost."""

FINISHED = (TrialState.COMPLETE, TrialState.PRUNED)


@dataclass(frozen=True)
class Search:
    """What is asked for.

    Args:
        trials: how many, those of earlier runs included.
        seed: of all random numbers.
        objective: one of OBJECTIVES.
        held: keys of KEYS whose variables stay as configured.
        file: where the study is kept; None keeps it in memory.
    """

    trials: int = 600
    seed: int = 0
    objective: str = "all"
    held: frozenset[str] = frozenset()
    file: Path | None = None


def search_of(words: Sequence[str]) -> tuple[Search, list[str]]:
    """What the arguments ask of the search, and the arguments that remain.

    Raises:
        ConfigurationError: with every fault, a sentence each.
    """
    given = dict(word.split("=", 1) for word in words if "=" in word)
    folder = Path(given.get("output", Path("outputs") / "experiments" / NAME))
    faults, numbers = [], {}
    for key, least in (("trials", 1), ("seed", 0)):
        text = given.get(key, str(getattr(Search(), key)))
        if not text.isdecimal() or int(text) < least:
            faults.append(f"{key} is {text}; it must be a whole number, at least {least}.")
        else:
            numbers[key] = int(text)
    objective = given.get("objective", "all")
    if objective not in OBJECTIVES:
        faults.append(f"objective is {objective}; it must be one of {', '.join(OBJECTIVES)}.")
    if faults:
        raise cl.ConfigurationError(faults)
    groups = {key.split(".")[0] if key.startswith("placement.") else key for key in given}
    # Without a number, a frequency is that of the resonance, about which is searched anyhow.
    held = frozenset(key for key in groups & set(KEYS) if key != "drive.frequency" or given[key] != "null")
    file = Path(given.get("study", folder / "study.db"))
    rest = [word for word in words if word.partition("=")[0] not in OWN]
    return Search(**numbers, objective=objective, held=held, file=file), rest


def ranges_of(setup: cl.Setup, held: frozenset[str] = frozenset()) -> dict[str, tuple[float, float]]:
    """Least and largest value of every variable that is not held.

    phase               of the first tone [rad]. Half a period of the second tone later, pi/ratio in the
                        phase of the first, the electrodes have changed places: the same motor in the
                        mirror. Longer ranges would hold every motor twice.
    relative_frequency  first tone over the first natural frequency [1]
    patch_start         from the clamp [m]
    patch_share         length beyond the shortest patch over all that is left up to mid-beam [1]: every
                        pair of numbers is a placement
    clearance           [m]
    """
    settings = setup.configuration
    half = 0.5 * settings["resonator"]["length"]
    everything = {
        "phase": (-np.pi / settings["drive"]["frequency_ratio"], 0.0),
        "relative_frequency": RELATIVE_FREQUENCY,
        "patch_start": (0.0, half - SHORTEST),
        "patch_share": (0.0, 1.0),
        "clearance": CLEARANCE,
    }
    kept = {name for key in held for name in KEYS[key]}
    if kept == set(everything):
        raise cl.ConfigurationError(
            [f"{', '.join(KEYS)} are all given; at least one must be left to be searched."]
        )
    return {name: bounds for name, bounds in everything.items() if name not in kept}


def designed(setup: cl.Setup, values: Mapping[str, float]) -> cl.Setup:
    """The motor with the variables set; those that are not there stay as configured."""
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


def searched(setup: cl.Setup, search: Search) -> list[FrozenTrial]:
    """The finished trials, in order; what a study file holds already is not run again.

    Raises:
        ConfigurationError: the study file is another search's, in use, or no study.
        KeyboardInterrupt: as it comes; the study file holds what was finished.
    """
    bounds = ranges_of(setup, search.held)
    distributions = {name: FloatDistribution(*bound) for name, bound in bounds.items()}
    settings = {
        "objective": search.objective,
        "seed": search.seed,
        "population": POPULATION,
        "kept": KEPT,
        "optuna": optuna.__version__,
        "range": {name: list(bound) for name, bound in bounds.items()},
        **setup.configuration,
    }
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    pruner = optuna.pruners.PercentilePruner(KEPT, n_startup_trials=POPULATION)
    directions = list(OBJECTIVES[search.objective].values())
    with study_in(search.file, settings, directions, pruner) as study:
        for trial in study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
            study.tell(trial.number, state=TrialState.FAIL)
        done = len(study.get_trials(deepcopy=False, states=FINISHED))
        for index in tqdm(
            range(done, search.trials),
            initial=min(done, search.trials),
            total=search.trials,
            unit=" trials",
            disable=None,
        ):
            stream = np.random.SeedSequence([search.seed, index])
            study.sampler = sampler(int(stream.generate_state(1)[0]))
            attempt(study, study.ask(distributions), setup)
        return study.get_trials(deepcopy=False, states=FINISHED)[: search.trials]


def sampler(seed: int) -> optuna.samplers.BaseSampler:
    """NSGA-II: what it goes on from stands in the study, so that it has no state but its random stream.

    Good motors come in two families, patches at the clamps and long ones in the middle. Estimators of
    density, optuna's default, settle in one of them within the first hundred trials, whichever it is.
    """
    return optuna.samplers.NSGAIISampler(seed=seed, population_size=POPULATION)


def attempt(study: optuna.Study, trial: Trial, setup: cl.Setup) -> None:
    """Measure one motor and tell the study, which keeps the numbers with the trial.

    A motor without contact, steady vibration or torque is pruned after the run at rest that shows it. If the
    velocity is all that counts, one that promises less than most before it is pruned as well; optuna has no
    such comparison for several objectives.
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
        found = performance(designed(setup, trial.params), watch)
    except (NoMotorError, optuna.TrialPruned) as reason:
        trial.set_user_attr("measured", {"reason": str(reason), "runs": runs})
        study.tell(trial, state=TrialState.PRUNED)
        return
    trial.set_user_attr("measured", vars(found))
    names = OBJECTIVES["velocity" if single else "all"]
    study.tell(trial, [getattr(found, name) for name in names])
