"""Laws against measured impacts: cross-validated, weighed against each other, baselines and floors."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import xarray

from contactlab.inference import outcome
from contactlab.inference.candidates import Probed, probed, usual_laws
from contactlab.inference.cross_validation_data import assembled
from contactlab.inference.folds import folds_of
from contactlab.inference.models import ConstantImpulse, LawModel, Model, frictionless
from contactlab.inference.prediction import COSTLY_STARTS, LOOKED, SEARCH, STARTS, SUBSET, Held
from contactlab.inference.work import perform
from contactlab.measured.floors import best_admissible_impulses, best_impulses, velocities_after
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.repeats import measurements
from contactlab.processes import processors

FOLDS: Final = 5
ADMISSIBLE: Final = "best admissible impulse"
FREE_IMPULSE: Final = "best impulse"
KEPT: Final = "laws"
"""Folder of the outcomes of single laws, from which an interrupted study goes on."""

OVERHEAD: Final = 2e-3
"""Of the residuals of a rigid law, once [s]; for the bar alone."""

Progress = Callable[[float], object]
"""Told the share of the work that is done, 0 to 1."""


class ValidationError(ValueError):
    """What was measured cannot judge the laws; the message is a sentence."""


def study(
    impacts: MeasuredImpacts,
    models: Sequence[Model] | None = None,
    *,
    folds: int = FOLDS,
    seed: int = 0,
    workers: int | None = None,
    keep: Path | None = None,
    progress: Progress = bool,
    announce: Callable[[str], object] = bool,
) -> xarray.Dataset:
    """Judge laws by impacts that they were not fitted to.

    Every impact is held out once, equal rows and repeats of one measurement together. A law is fitted to
    the other folds and predicts it; its error is that of `MeasuredImpacts.errors`. The frictionless law and
    the best constant impulse are treated alike. The floors are the errors of the best impulse of each
    impact, admissible or any.

    Args:
        impacts: what was measured.
        models: of the laws; None is every rigid law and some composed compliant ones.
        folds: parts that are held out in turn, two at least.
        seed: of the folds, of the starts of every fit, of the impacts that costly laws are fitted on and of
            the bootstrap. The same seed gives the same bits, whatever the workers.
        workers: processes; None is one a processor.
        keep: folder for what single laws give, from which the same study goes on after an interruption.
        progress: told the share that is done.
        announce: told what takes long, and what is taken from an earlier start, a sentence each.

    Returns:
        See `contactlab.inference.cross_validation_data`.

    Raises:
        ValidationError: there are too few impacts, or two laws of one label.
        OSError: the folder cannot be written to.
    """
    asked = usual_laws() if models is None else list(models)
    every = [*asked, frictionless(), ConstantImpulse.of(impacts)]
    _check(every, folds)
    known = [probed(model, impacts) for model in every]
    _check_count(impacts, [one.model for one in known], folds)
    paths = [_place(keep, one, impacts, folds, seed) for one in known]
    found = {at: kept for at, path in enumerate(paths) if path and (kept := outcome.read(path)) is not None}
    if found:
        announce(f"{len(found)} of {len(known)} laws are taken from an earlier start.")
    left = [at for at in range(len(known)) if at not in found]
    weights = [_weight(known[at], len(impacts), folds) for at in left]
    done_of, whole = [0.0], folds * sum(weights) or 1.0

    def advance(place: int) -> None:
        done_of[0] += weights[place]
        progress(done_of[0] / whole)

    def done(place: int, held: list[Held]) -> None:
        at = left[place]
        found[at] = outcome.outcome_of(known[at].model, impacts, held, known[at].held)
        if path := paths[at]:
            outcome.write(found[at], path)

    fold = folds_of(measurements(impacts), folds, seed)
    chosen = [known[at].model for at in left]
    perform(chosen, impacts, fold, seed, workers or processors(), done, advance)
    best = {ADMISSIBLE: best_admissible_impulses(impacts), FREE_IMPULSE: best_impulses(impacts)}
    floors = [
        outcome.floor(label, impacts, velocities_after(impacts, impulse)) for label, impulse in best.items()
    ]
    return assembled([found[at] for at in range(len(known))], floors, impacts, fold, seed)


def _check(models: Sequence[Model], folds: int) -> None:
    """Refuse what cannot be studied, whatever was measured."""
    if folds < 2:
        raise ValidationError(f"folds is {folds}; it must be at least 2.")
    if not any(isinstance(model, LawModel) and not model.baseline for model in models):
        raise ValidationError("There is no law to judge; give one at least.")
    labels = [model.label for model in models]
    if twice := sorted({label for label in labels if labels.count(label) > 1}):
        raise ValidationError(f"{', '.join(twice)} is there twice; every law must be one of its own.")


def _check_count(impacts: MeasuredImpacts, models: Sequence[Model], folds: int) -> None:
    """Refuse too few impacts."""
    most = max(models, key=lambda model: len(model.free))
    least = folds * max(len(most.free), 1)
    count = int(measurements(impacts).max(initial=-1)) + 1
    if count < least:
        kind = "impacts" if count == len(impacts) else f"different measurements among {len(impacts)} impacts"
        raise ValidationError(
            f"There are {count} {kind}; {folds} folds and the {len(most.free)} free parameters of "
            f"{most.label} need {least} at least. Measure more, hold parameters by law.NAME=VALUE, or take "
            "fewer folds."
        )


def _place(keep: Path | None, one: Probed, impacts: MeasuredImpacts, folds: int, seed: int) -> Path | None:
    return keep and keep / KEPT / f"{outcome.key_of(one.model, impacts, folds, seed)}.nc"


def _weight(one: Probed, impacts: int, folds: int) -> float:
    """Estimate what a fold of a model costs [s]: the points that are looked at and a dozen steps a start."""
    around = 1 + len(one.model.free)
    if not one.model.costly:
        return OVERHEAD * STARTS * (LOOKED + 12 * around)
    used = impacts - impacts // folds
    searched = COSTLY_STARTS * (LOOKED + 3 * around) * min(used, SEARCH)
    return one.seconds * (searched + 4 * around * min(used, SUBSET) + impacts / folds)
