"""The laws that are fitted to measurements, each with its inference problem."""

import json
from collections import ChainMap
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import inf
from types import MappingProxyType
from typing import Any, Final, Literal, final

from contactlab.config import ConfigurationError, Setup
from contactlab.driving import DEGREE, FRAME, Frame
from contactlab.force_curves import CURVE, Recording
from contactlab.laws.composed import label_of
from contactlab.results.yaml_text import write_yaml
from contactlab.studies.law_study import NO_LAW
from contactlab_data.inference.curve_problem import curve_problem, jump_notes
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.impact_problem import ImpactProblem, LawPredictor
from contactlab_data.inference.influence import without_influence
from contactlab_data.inference.joint_problem import JointProblem
from contactlab_data.inference.law_numbers import (
    Free,
    corrections_in,
    frame_in,
    free_numbers,
    numbers_of,
    recording_in,
)
from contactlab_data.inference.motor_problem import points_problem, series_problem
from contactlab_data.inference.path_records import record_problem
from contactlab_data.inference.problem import Problem
from contactlab_data.inference.synthetic import truth_in
from contactlab_data.measured.impacts import MeasuredImpacts
from contactlab_data.measured.series import FORCES, POSITION, MeasuredPoints, MeasuredSeries

FEWEST: Final = 3
"""Least number of impacts to which a law is fitted."""

Discrepancy = Literal["off", "on", "both"]
Data = MeasuredSeries | MeasuredImpacts | MeasuredPoints


@final
@dataclass(frozen=True, eq=False)
class Candidate:
    """A law that is to be fitted.

    Args:
        label: of the law, and of the discrepancy where the law is fitted with and without.
        problem: data, law, free numbers and noise.
        truth: values of free numbers of synthetic data, by name.
        origin: attributes of the result: data, digest, configuration, likelihood.
        numbers: sentence on free and fixed numbers.
    """

    label: str
    problem: Problem
    truth: Mapping[str, float]
    origin: Mapping[str, str]
    numbers: str


def candidates_of(
    data: Data | Mapping[str, Data],
    setups: Mapping[str, Setup],
    free: Free,
    known: Collection[str] = (),
    *,
    own: Collection[str] = (),
    discrepancy: Discrepancy = "off",
    degrees_of_freedom: float | None = inf,
    degree: int = DEGREE,
    frame: Mapping[str, float | None] = MappingProxyType({}),
    recording: Mapping[str, float | Literal["free"] | None] = MappingProxyType({}),
    name: str = "",
    digest: str = "",
) -> list[Candidate]:
    """Return the laws to be fitted, twice if with and without discrepancy.

    Args:
        data: measurements, or several by label.
        setups: of the laws by label, which names those that are not named by their laws alone.
        free: ranges by key.
        known: keys of numbers that have the values of the setups.
        own: keys of numbers that each of several measurements has of its own.
        discrepancy: whether the laws may be wrong.
        degrees_of_freedom: of Student-t noise; infinite is the normal distribution, None is free.
        degree: of the spline through the samples of a path.
        frame: values of its numbers, see `contactlab.driving.FRAME`, which ranges may free.
        recording: values of the numbers of force curves, see `contactlab.force_curves.CURVE`, or "free", with
            the range of the data; ranges may free them too.
        name: of the data.
        digest: of their file.

    Raises:
        ConfigurationError: with every fault.
    """
    sets = data if isinstance(data, Mapping) else {"": data}
    of_impacts = [each for each in sets.values() if isinstance(each, MeasuredImpacts)]
    for each in of_impacts:
        _check_impacts(each, discrepancy)
    if not setups:
        raise ConfigurationError(NO_LAW)
    if own and len(sets) == 1:
        raise ConfigurationError("study.own is set and there is one data set; leave it out.")
    every, corrections = free_numbers(setups, free, known), corrections_in(free)
    pulled, of_frame = frame_in(free, frame)
    curves = [each for each in sets.values() if isinstance(each, MeasuredSeries) and of_curve(each)]
    recorded, of_curves = recording_in(free, recording, curves)
    every = {label: (*keys, *of_frame, *of_curves) for label, keys in every.items()}
    if unknown := sorted({*own} - {item.name for keys in every.values() for item in keys}):
        raise ConfigurationError(
            [f"study.own has {key}, which is not free; leave it out." for key in unknown]
        )
    tails = "free" if degrees_of_freedom is None else f"{degrees_of_freedom:g}"
    likelihood = "normal" if degrees_of_freedom == inf else f"Student-t, degrees of freedom: {tails}"
    result, faults = list[Candidate](), list[str]()
    cases = {"off": (False,), "on": (True,), "both": (False, True)}[discrepancy]
    laws = {place: label_of(setup.law) for place, setup in setups.items()}
    if len({*laws.values()}) < len(laws):
        laws = {place: place.replace("/", ".") for place in laws}
    for (place, setup), may_err in product(setups.items(), cases):
        keys = every[place]
        try:
            problem = _problem_of(
                sets, setup, keys, corrections, own, degrees_of_freedom, degree, pulled, recorded, may_err
            )
            problem, idle = _with_influence(problem, keys)
        except ConfigurationError as error:
            faults += error.faults
            continue
        configuration = write_yaml(setup.configuration)
        origin = {"data": name, "digest": digest, "configuration": configuration, "likelihood": likelihood}
        notes = {
            "duplicates": [each.copies_warning() for each in of_impacts],
            "tracks": [each.tracks.attrs["findings"] for each in of_impacts if each.tracks is not None],
            "series": [
                *(text for each in sets.values() if isinstance(each, MeasuredSeries) for text in each.notes),
                *(text for each in curves for text in jump_notes(each)),
            ],
        }
        origin |= {"frame": json.dumps(pulled.numbers)} if pulled else {}
        origin |= {"recording": json.dumps(recorded.numbers)} if curves else {}
        origin |= {key: "\n".join(lines) for key, lines in notes.items() if any(lines)}
        label = laws[place] + (" + discrepancy" if may_err and discrepancy == "both" else "")
        numbers = dict(ChainMap(*(truth_in(each, setup.configuration) for each in sets.values())))
        truth = {item.name: numbers[item.name] for item in problem.parameters if item.name in numbers}
        acting = [item for item in keys if item.name not in idle]
        stated = numbers_of(setup, acting, [*free, *known], recorded if curves else pulled)
        if idle:
            stated += f" Not free, since they have no influence on these data: {', '.join(idle)}."
        result.append(Candidate(label, problem, truth, origin, stated))
    if faults:
        raise ConfigurationError(list(dict.fromkeys(faults)))
    return result


def _check_impacts(data: MeasuredImpacts, discrepancy: Discrepancy) -> None:
    """Raise a ConfigurationError for impacts to which no law can be fitted as asked."""
    faults = []
    if len(data) < FEWEST:
        faults.append(f"There are {len(data)} impacts; there must be at least {FEWEST}.")
    if data.covariance is None and discrepancy != "off":
        faults.append(
            "study.discrepancy must be off: the data state no noise, from which it could be distinguished. "
            "State it by noise."
        )
    if faults:
        raise ConfigurationError(faults)


def of_law(data: Data) -> bool:
    """Return whether measurements are of a law alone, without a motor."""
    return isinstance(data, MeasuredImpacts) or on_path(data)


def on_path(data: Data) -> bool:
    """Return whether measurements are forces on a prescribed path."""
    return isinstance(data, MeasuredSeries) and bool(data.path)


def of_curve(data: Data) -> bool:
    """Return whether measurements are a force curve."""
    return isinstance(data, MeasuredSeries) and POSITION in data.path


def of_frame(data: Data) -> bool:
    """Return whether a frame may pull what was measured, the slip of a path."""
    return on_path(data) and not of_curve(data)


def _problem_of(
    sets: Mapping[str, Data],
    setup: Setup,
    keys: Sequence[FreeParameter],
    corrections: tuple[FreeParameter, ...],
    own: Collection[str],
    degrees_of_freedom: float | None,
    degree: int,
    frame: Frame | None,
    recording: Recording,
    discrepancy: bool,
) -> Problem:
    """Return the problem of one law."""
    of_laws, others = [*map(of_law, sets.values())], [item.name for item in keys if not item.field]
    if all(of_laws) and others:
        raise ConfigurationError(f"{', '.join(others)} is of the motor; these data depend on the law alone.")
    impacts = any(isinstance(data, MeasuredImpacts) for data in sets.values())
    if corrections and not impacts:
        raise ConfigurationError(f"{corrections[0].name} is of measured impacts; the data have none.")
    if frame and not any(map(of_frame, sets.values())):
        raise ConfigurationError(f"{', '.join(FRAME)} are of forces on a path; these data have none.")
    parts = {}
    for (label, data), alone in zip(sets.items(), of_laws, strict=True):
        chosen = [item for item in keys if of_curve(data) or item.name not in CURVE]
        chosen = [item for item in chosen if of_frame(data) or item.name not in FRAME]
        chosen = [item for item in chosen if item.field or not alone]
        of_data = corrections if isinstance(data, MeasuredImpacts) else ()
        parts[label] = _problem(
            data,
            setup,
            chosen,
            of_data,
            degrees_of_freedom,
            degree,
            frame,
            recording,
            discrepancy=discrepancy,
        )
    problem = parts[""] if [*parts] == [""] else JointProblem(parts, own)
    if not problem.free:
        raise ConfigurationError(f"No number of law={setup.law.name} is free; add a range, KEY=LOW..HIGH.")
    return problem


def _with_influence(problem: Problem, keys: Sequence[FreeParameter]) -> tuple[Problem, list[str]]:
    """Return the problem without the numbers that have no influence on its data, and their keys.

    Raises:
        ConfigurationError: no number has influence, and nothing else is free.
    """
    reduced = without_influence(problem)
    labels = [*problem.parts] if isinstance(problem, JointProblem) else [""]
    ends = {item.name.removeprefix(f"{label}.") for item in reduced.parameters for label in labels}
    idle = [item.name for item in keys if item.name not in ends]
    if not reduced.free:
        raise ConfigurationError(f"{', '.join(idle)} has no influence on these data; free another number.")
    return reduced, idle


def _problem(
    data: Data,
    setup: Setup,
    keys: Sequence[FreeParameter],
    corrections: tuple[FreeParameter, ...],
    degrees_of_freedom: float | None,
    degree: int,
    frame: Frame | None,
    recording: Recording,
    *,
    discrepancy: bool,
) -> Problem:
    """Return the problem of one law and one data set."""
    if isinstance(data, MeasuredImpacts):
        predictor = LawPredictor(setup.law, tuple(keys), label_of(setup.law), tolerance=None)
        unknown = discrepancy or data.covariance is None
        return ImpactProblem(data, predictor, unknown, degrees_of_freedom, corrections)
    if isinstance(data, MeasuredSeries) and data.path:
        noise: dict[str, Any] = {"discrepancy": discrepancy, "degrees_of_freedom": degrees_of_freedom}
        if of_curve(data):
            return curve_problem(data, setup.law, keys, recording, **noise)
        return record_problem(data, setup.law, keys, **noise, degree=degree, frame=frame)
    if "resonator" not in setup.configuration:
        raise ConfigurationError("A motor made in Python has no configuration, by which it is fitted.")
    if isinstance(data, MeasuredSeries):
        if not data.means and {*FORCES} & {*data.values}:
            raise ConfigurationError(
                "forces is values; those of a motor must be means. Leave them out by series."
            )
        return series_problem(
            data, setup.configuration, keys, discrepancy=discrepancy, degrees_of_freedom=degrees_of_freedom
        )
    if discrepancy:
        raise ConfigurationError("study.discrepancy must be off: operating points have no time.")
    return points_problem(data, setup.configuration, keys, degrees_of_freedom=degrees_of_freedom)
