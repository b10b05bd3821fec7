"""A fit from data and words to answers: models posed, least squares, posteriors, and what is left of it."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from math import inf
from pathlib import Path
from typing import Final, Literal, final

import xarray
import yaml

from contactlab.config import ConfigurationError, Setup
from contactlab.inference.free_parameters import Free, label_of
from contactlab.inference.impact_problem import ImpactModel
from contactlab.inference.law_choice import Words, free_keys, numbers_of, refuse_unknown, setups_of
from contactlab.inference.least_squares import Fit, best_fit
from contactlab.inference.nested_sampling import POINTS, Posterior, sample
from contactlab.inference.problem import Model
from contactlab.inference.result import Answer
from contactlab.inference.series_problem import series_model
from contactlab.inference.synthetic import truth_in
from contactlab.laws import PenaltyLaw
from contactlab.measured.files import read_impacts
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.repeats import copies_warning
from contactlab.measured.series import MEASURABLE, MeasuredSeries, read_series, text_names
from contactlab.results.files import digest_of_file
from contactlab.results.provenance import UNKNOWN, code_digest

STARTS: Final = 16
"""Of least squares, where nothing is said."""

STEP: Final = 3e-4
"""Of differences in the unit cube, where a law is integrated to a tolerance."""

LEAST: Final = 3
"""Impacts that something can be found from."""

Discrepancy = Literal["off", "on", "both"]
Data = MeasuredSeries | MeasuredImpacts
Advance = Callable[[float], object]


@final
@dataclass(frozen=True, eq=False)
class Question:
    """A model that is ready to be fitted, with what its answer is to tell of its origin."""

    label: str
    model: Model
    step: float | None
    truth: dict[str, float]
    origin: dict[str, str]
    numbers: str

    def key(self, points: int, seed: int) -> str:
        """Tell this question from all others, code included: only what was begun of it is gone on with."""
        try:
            sampler = version("dynesty")
        except PackageNotFoundError:
            sampler = UNKNOWN
        free = [str(one) for one in self.model.free]
        said = [self.label, self.origin, free, points, seed, code_digest(), sampler]
        return sha256(json.dumps(said).encode()).hexdigest()[:16]


def read(path: Path) -> Data:
    """Read measured series, or impacts, whatever the file holds.

    Raises:
        OSError: it cannot be read.
        ValueError: it holds neither; a sentence for each fault.
    """
    try:
        with xarray.open_dataset(path, engine="netcdf4", decode_times=False) as data:
            names = {str(name) for name in data.variables}
    # What is no netCDF may be a table in CSV.
    except (OSError, ValueError, RuntimeError) as error:
        if isinstance(error, FileNotFoundError | PermissionError | IsADirectoryError):
            raise
        names = text_names(path)
        if any(name.startswith(("before_", "after_")) for name in names):
            return read_impacts(path)
    return read_series(path) if names & {"time", *MEASURABLE} else read_impacts(path)


def pose(
    data: Data,
    words: Words,
    discrepancy: Discrepancy,
    name: str,
    digest: str = "",
    degrees_of_freedom: float | None = inf,
) -> list[Question]:
    """Pose the questions of a fit: a model for each law, twice where it is to be seen if the law suffices.

    Args:
        data: what was measured.
        words: of the fit.
        discrepancy: whether the laws may be wrong.
        name: of the data.
        digest: of their file.
        degrees_of_freedom: of the Student-t distribution of the noise; infinite is the normal one, None is
            free.

    Raises:
        ConfigurationError: with every fault.
    """
    told = data.configuration if isinstance(data, MeasuredSeries) else {}
    setups = setups_of(words, told)
    if len(setups) > 1:
        refuse_unknown(setups, words)
    if isinstance(data, MeasuredImpacts):
        _refuse_impacts(data, words, discrepancy)
    questions, faults = [], []
    for setup in setups:
        for may_err in {"off": (False,), "on": (True,), "both": (False, True)}[discrepancy]:
            try:
                keys, fields = free_keys(setup, words, race=len(setups) > 1)
                model, step = _model(data, setup, keys, fields, degrees_of_freedom, may_err=may_err)
                known = truth_in(data, setup.configuration)
                said = yaml.safe_dump(setup.configuration, sort_keys=False, allow_unicode=True)
                origin = {"data": name, "digest": digest, "configuration": said}
                origin["likelihood"] = _likelihood(degrees_of_freedom)
                if isinstance(data, MeasuredImpacts) and (copies := copies_warning(data)):
                    origin["duplicates"] = copies
                label = label_of(setup.law) + (" + discrepancy" if may_err and discrepancy == "both" else "")
                truth = {one.name: known[one.name] for one in keys if one.name in known}
                questions.append(Question(label, model, step, truth, origin, numbers_of(setup, words, keys)))
            except ConfigurationError as error:
                faults += error.faults
    if faults:
        raise ConfigurationError(list(dict.fromkeys(faults)))
    return questions


def _likelihood(degrees_of_freedom: float | None) -> str:
    """Name the distribution of the noise."""
    if degrees_of_freedom == inf:
        return "normal"
    shown = "free" if degrees_of_freedom is None else f"{degrees_of_freedom:g}"
    return f"Student-t, degrees of freedom: {shown}"


def _model(
    data: Data,
    setup: Setup,
    keys: Sequence[Free],
    fields: Sequence[Free],
    degrees_of_freedom: float | None,
    *,
    may_err: bool,
) -> tuple[Model, float | None]:
    """Return the model of one law, and the step of its derivatives in the unit cube."""
    model: Model
    if isinstance(data, MeasuredSeries):
        model = series_model(
            data, setup.configuration, keys, discrepancy=may_err, degrees_of_freedom=degrees_of_freedom
        )
        step: float | None = STEP
    else:
        if len(fields) < len(keys):
            others = [one.name for one in keys if not one.name.startswith(("law.", "contact.f"))]
            sentence = f"{', '.join(others)} is of the motor, and impacts are of the law alone; leave it out."
            raise ConfigurationError([sentence])
        spread = may_err or data.covariance is None
        model = ImpactModel(data, setup.law, tuple(fields), tuple(keys), spread, degrees_of_freedom)
        step = STEP if isinstance(setup.law, PenaltyLaw) else None
    if not model.free:
        words_of = f"Nothing is free under law={setup.law.name}; give a range, KEY=LOW..HIGH."
        raise ConfigurationError([words_of])
    return model, step


def _refuse_impacts(data: MeasuredImpacts, words: Words, discrepancy: Discrepancy) -> None:
    faults = []
    if len(data) < LEAST:
        faults.append(f"There are {len(data)} impacts; there must be {LEAST} at the least to fit a law to.")
    if data.covariance is None and discrepancy != "off":
        faults.append(
            "The data state no error of their velocities, so that noise and discrepancy cannot be told "
            "apart: one level of both is fitted anyway. Leave --discrepancy out, or state it by --noise."
        )
    if not words.laws:
        faults.append("The data tell no law; name one, law=newton, or several, law=newton,poisson.")
    if faults:
        raise ConfigurationError(faults)


def fit(
    questions: Sequence[Question],
    folder: Path | None = None,
    *,
    points: int = POINTS,
    seed: int = 0,
    starts: int = STARTS,
    advance: Advance = bool,
    announce: Callable[[str], object] = bool,
) -> list[Answer]:
    """Answer questions one by one.

    Args:
        questions: as posed.
        folder: that exists, for checkpoints from which the same fit goes on; None leaves none.
        points: live points of nested sampling.
        seed: the same gives the same bits.
        starts: of least squares.
        advance: told how many questions are answered, parts of one included.
        announce: receives a sentence where a checkpoint is damaged and its fit begins anew.

    Raises:
        NoSamplerError: dynesty is not installed.
        ValueError: a law predicts nothing anywhere in the ranges.
    """
    answers = []
    for number, one in enumerate(questions):
        checkpoint = None if folder is None else checkpoint_of(folder, one, points, seed)

        def tell(share: float, number: int = number) -> None:
            advance(number + min(share, 1.0))

        best = _optimum(one, starts, seed)
        found = sample(
            one.model, points=points, seed=seed, checkpoint=checkpoint, advance=tell, announce=announce
        )
        answers.append(Answer(one.label, one.model, best, found, one.truth, one.origin, one.numbers))
    return answers


def _optimum(question: Question, starts: int, seed: int) -> Fit | None:
    """Give the least squares of what is free of law and motor; None where nothing is.

    A ValueError tells that the law predicts nothing at any of the starts: there is nothing to sample either.
    """
    model = question.model
    physical = model.free[: model.physical]
    if not physical:
        return None
    try:
        return best_fit(model.residuals, physical, starts, seed, step=question.step)
    except ValueError as error:
        raise ValueError(f"{question.label}: {error}") from error


def checkpoint_of(folder: Path, question: Question, points: int, seed: int) -> Path:
    """Give the file in which a fit that is stopped leaves how far it has come."""
    name = question.label.replace(" + ", "-")
    return folder / f".{name}-{question.key(points, seed)}.checkpoint"


def left_of_others(folder: Path, questions: Sequence[Question], points: int, seed: int) -> list[Path]:
    """Give the checkpoints in a folder that are of other questions."""
    mine = {checkpoint_of(folder, one, points, seed) for one in questions}
    return sorted(path for path in folder.glob(".*.checkpoint") if path not in mine)


def digest_told(data: Data, path: Path) -> str:
    """Give the digest of the file that data are from."""
    return data.digest if isinstance(data, MeasuredSeries) and data.digest else digest_of_file(path)


__all__ = ["Advance", "Posterior", "Question", "fit", "pose", "read"]
