"""Free and fixed numbers of the laws of setups, named by the keys of a configuration.

Numbers with a range are free; without any range every number of a law is free that is not known.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final, Literal

import numpy as np

from contactlab import laws
from contactlab.config import ConfigurationError, Setup
from contactlab.config.nesting import flat
from contactlab.config.schema import FRICTION, declared_in
from contactlab.driving import FRAME, Frame
from contactlab.force_curves import CURVE, Recording
from contactlab.laws import Composed, ContactLaw, MultiplierLaw, registry
from contactlab.laws.composed import label_of
from contactlab.laws.declaration import SHARED
from contactlab.parameter import Parameter
from contactlab.studies.study import Range
from contactlab.suggestion import suggestion
from contactlab_data.inference.free_parameters import FreeParameter, chosen_range, fields_of, free_parameters
from contactlab_data.inference.impact_problem import LawPredictor, Ranges
from contactlab_data.measured.bodies import CORRECTIONS
from contactlab_data.measured.series import MeasuredSeries

LAW: Final = "law."
DATA: Final = "data."

FREE_OF: Final[dict[str, tuple[str, ...]]] = {"johnson": ("friction_coefficient", "yield_strength")}
"""Free numbers of laws whose other numbers act through a product with these."""

Free = Mapping[str, Sequence[float | str]]
"""Ranges of free numbers by key, both ends in SI or as texts with units: {"law.restitution": (0.1, 0.9)}."""

FreeNumbers = Free | list[Range] | None
"""Ranges of free numbers as an option: by key in Python, KEY=LOW..HIGH in a command or file."""


def by_key(free: FreeNumbers, known: Sequence[str] | None) -> Free:
    """Return the ranges of free numbers by key.

    Raises:
        ConfigurationError: a number has two, or is known.
    """
    pairs = [(x.name, (x.start, x.end)) for x in free] if isinstance(free, list) else [*(free or {}).items()]
    keys = [*(key for key, _ in pairs), *(known or ())]
    if twice := sorted({key for key in keys if keys.count(key) > 1}):
        raise ConfigurationError([f"{key} occurs twice; it must occur once. Leave one out." for key in twice])
    return dict(pairs)


def key_of(field: str) -> str:
    """Return the key of a configuration for a field of a law."""
    return FRICTION if field.rpartition(".")[2] == SHARED else f"{LAW}{field}"


def corrections_in(free: Free) -> tuple[FreeParameter, ...]:
    """Return the free numbers of measured impacts, of keys data.NAME.

    Raises:
        ConfigurationError: an unknown name, or a range that is not admitted.
    """
    result = []
    for key in filter(is_of_data, free):
        name = key.removeprefix(DATA)
        if name not in CORRECTIONS:
            every = [f"{DATA}{name}" for name in CORRECTIONS]
            hint = suggestion(key, every, f"There are {', '.join(every)}.")
            raise ConfigurationError(f"There is no number {key} of the data. {hint}")
        result.append(chosen_range(key, free[key], CORRECTIONS[name], name))
    return tuple(result)


def frame_in(
    free: Free, stated: Mapping[str, float | None]
) -> tuple[Frame | None, tuple[FreeParameter, ...]]:
    """Return the frame of measured paths, None without, and its free numbers, in the middle of their ranges.

    Args:
        free: ranges by key, of `contactlab.driving.FRAME` and others.
        stated: values of numbers of the frame by the same keys; zero and None are none.

    Raises:
        ConfigurationError: a value or range is not admitted, or a number has both.
    """
    keys = tuple(chosen_range(name, free[name], FRAME[name], name) for name in FRAME if name in free)
    values = {name: x for name, x in stated.items() if x}
    if twice := [item.name for item in keys if item.name in values]:
        raise ConfigurationError([f"{name} has a value and a range; it must have one." for name in twice])
    values |= {item.name: item.from_unit(0.5) for item in keys}
    if not values:
        return None, ()
    try:
        return Frame(values.pop("frame_stiffness", None)).changed(values), keys
    except ValueError as error:
        raise ConfigurationError(str(error)) from error


def recording_in(
    free: Free, stated: Mapping[str, float | Literal["free"] | None], curves: Sequence[MeasuredSeries]
) -> tuple[Recording, tuple[FreeParameter, ...]]:
    """Return how force curves were recorded, and its free numbers, in the middle of their ranges.

    The range of a number that is free without one is that of the curves: of the contact point all positions,
    of the baseline all forces and as much below and above, of the tilt up to that of all forces over all
    positions.

    Args:
        free: ranges by key, of `contactlab.force_curves.CURVE` and others.
        stated: values by the same keys, or that they are free; zero and None are none.
        curves: measured force curves.

    Raises:
        ConfigurationError: there is no curve, a value or range is not admitted, or a number has both.
    """
    values = {name: x for name, x in stated.items() if x and x != "free"}
    ranges = {name: free[name] for name in CURVE if name in free}
    wide = [name for name, x in stated.items() if x == "free"]
    if twice := [name for name in ranges if name in (*values, *wide)]:
        raise ConfigurationError([f"{name} has a value and a range; it must have one." for name in twice])
    if not curves:
        if odd := [*values, *wide, *ranges]:
            raise ConfigurationError(f"{', '.join(odd)} is of force curves; the data have none.")
        return Recording(), ()
    z = np.concatenate([x.path["z"] for x in curves])
    force = np.concatenate([x.values["normal_force"] for x in curves])
    low, high, span = float(np.nanmin(force)), float(np.nanmax(force)), float(np.ptp(z))
    reach = high - low
    known = {
        "contact_point": (float(z.min()), float(z.max())),
        "baseline": (low - reach, high + reach),
        "tilt": (-reach / (span or 1.0), reach / (span or 1.0)),
    }
    ranges = {**ranges, **{name: known[name] for name in wide}}
    keys = tuple(chosen_range(name, ends, CURVE[name], name) for name, ends in ranges.items())
    try:
        return Recording().changed({**values, **{item.name: item.from_unit(0.5) for item in keys}}), keys
    except ValueError as error:
        raise ConfigurationError(str(error)) from error


def is_of_data(key: str) -> bool:
    """Return whether a free number is one of the measured impacts."""
    return key.startswith(DATA)


def free_numbers(
    setups: Mapping[str, Setup], free: Free, known: Collection[str] = ()
) -> dict[str, tuple[FreeParameter, ...]]:
    """Return the free numbers of law and motor of each setup by full keys; those of the law with their field.

    Without ranges these are the numbers of its law that are not known, each in its declared range; of several
    setups, whose laws have numbers of their own, besides the ranges too.

    Args:
        setups: of the laws by label.
        free: ranges by key.
        known: keys of numbers that have the values of the setups.

    Raises:
        ConfigurationError: no setup has a number, or a range is not admitted.
    """
    ranges = {
        key: ends for key, ends in free.items() if not (is_of_data(key) or key in FRAME or key in CURVE)
    }
    result, every = {}, dict[str, Parameter]()
    for label, setup in setups.items():
        declared = declared_in(setup.configuration)
        every |= declared
        own = {key_of(item.name): item for item in free_parameters(setup.law)}
        fields = {key_of(name): name for name in fields_of(setup.law)}
        chosen = [
            chosen_range(key, ends, declared[key], fields.get(key, ""))
            for key, ends in ranges.items()
            if key in declared
        ]
        if len(setups) > 1 or not (ranges or {*free} & {*FRAME}):
            chosen += [
                replace(x, name=key, field=x.name) for key, x in own.items() if key not in {*ranges, *known}
            ]
        result[label] = tuple(chosen)
    if unknown := {*ranges, *known} - {*every}:
        hint = {key: suggestion(key, every, "contactlab --help lists the keys.") for key in sorted(unknown)}
        raise ConfigurationError(
            [f"There is no free number {key} here. {text}" for key, text in hint.items()]
        )
    return result


def numbers_of(
    setup: Setup,
    free: Sequence[FreeParameter],
    keys: Collection[str],
    beside: Frame | Recording | None = None,
) -> str:
    """Return a sentence on free and fixed numbers of law and what is beside it, and on keys that it lacks."""
    names = {item.name for item in free}
    every = {key_of(name): value for name, value in setup.law.describe().items()}
    every |= beside.numbers if beside else {}
    fixed = {key: value for key, value in every.items() if key not in names}
    absent = [key for key in keys if key.startswith(LAW) and key not in {*flat(setup.configuration)}]
    return " ".join(
        [
            f"Free: {'; '.join(map(str, free)) or 'nothing'}.",
            f"Fixed: {', '.join(f'{key} = {value:.6g}' for key, value in fixed.items()) or 'nothing'}.",
            *([f"Not a number of this law: {', '.join(absent)}."] if absent else []),
        ]
    )


def law_predictors(
    setups: Mapping[str, Setup], free: Free, known: Collection[str] = ()
) -> list[LawPredictor]:
    """Return predictors of impacts under the laws of setups, of the usual laws without any.

    Ranges free numbers of every law that has them. Others that are not known are free besides, of a
    usual law only those that are free usually.

    Raises:
        ConfigurationError: no law has a number, or a range is not admitted.
    """
    chosen = [LawPredictor.of(setup.law, usual_ranges(setup.law)) for setup in setups.values()]
    result = chosen or usual_laws()
    every = sorted({key_of(name) for predictor in result for name in predictor.law.describe()})
    for key in [*known, *free]:
        if not (is_of_data(key) or key in every):
            hint = suggestion(key, every, f"They have {', '.join(every) or 'none'}.")
            raise ConfigurationError(f"None of these laws has a number {key}. {hint}")
        result = [_changed(predictor, key, free.get(key)) for predictor in result]
    return result


def _changed(predictor: LawPredictor, key: str, ends: Sequence[float | str] | None) -> LawPredictor:
    """Return a predictor with a number free in a range, or known without, if its law has it."""
    for name, _, declared in predictor.law.effective():
        if declared is not None and key == key_of(name):
            ranges: dict[str, Any] = {x.name: (x.low, x.high) for x in predictor.free if x.name != name}
            if ends is not None:
                free = chosen_range(key, ends, declared)
                ranges[name] = free.low, free.high
            return replace(predictor, free=free_parameters(predictor.law, ranges))
    return predictor


def usual_laws() -> list[LawPredictor]:
    """Return predictors of every installed rigid law and of compliant ones composed of common parts.

    A law with microslip is not among them: its impacts take 25 times as long as those of `mindlin`.
    """
    names = [name for name in registry.law_names() if issubclass(registry.class_of(name), MultiplierLaw)]
    rigid = [LawPredictor.of(law, usual_ranges(law)) for law in map(registry.law, names)]
    compliant = [LawPredictor.of(*item) for item in _compliant_laws()]
    return [*rigid, *(item for item in compliant if "microslip" not in item.label)]


def usual_ranges(law: ContactLaw) -> Ranges | None:
    """Return what is free of a law usually; None where that is all."""
    if isinstance(law, MultiplierLaw):
        return dict.fromkeys(FREE_OF[law.name]) if law.name in FREE_OF else None
    return next((ranges for item, ranges in _compliant_laws() if label_of(item) == label_of(law)), None)


def _compliant_laws() -> list[tuple[ContactLaw, Ranges]]:
    """Return compliant laws and what is free of them; the absolute stiffness of a spring has no effect."""
    cone: dict[str, tuple[float, float] | None] = {"friction.friction_coefficient": None}
    lossy = {"damping.restitution": None, **cone}
    # The range of the loss of Hunt and Crossley at this speed.
    slowing = {"damping.restitution": (0.4, 1.0), **cone}
    yielding = {"normal.unloading_stiffness": (1e7, 1e9), **cone}
    elastic, dent = laws.HertzPoint(), laws.WaltonBraun(loading_stiffness=1e7, unloading_stiffness=3e7)
    ratio = {"friction.stiffness_ratio": None}
    return [
        (registry.law("hertz_penalty"), {"friction_coefficient": None}),
        (Composed(elastic, laws.Flores()), lossy),
        (Composed(elastic, laws.HuntCrossley(0.8, impact_speed=1.0)), slowing),
        (Composed(laws.Thornton()), {"normal.yield_pressure": None, **cone}),
        (Composed(dent), yielding),
        (Composed(elastic, laws.Flores(), laws.Mindlin()), lossy | ratio),
        (Composed(elastic, laws.Flores(), laws.Microslip()), lossy | ratio),
        (
            Composed(elastic, laws.Flores(), laws.Regularised()),
            lossy | {"friction.creep_velocity": (1e-2, 3.0)},
        ),
        (Composed(elastic, laws.Flores(), laws.LuGre()), lossy | {"friction.bristle_stiffness": (1e3, 1e7)}),
        (
            Composed(elastic, laws.Flores(), laws.Stribeck()),
            lossy | {"friction.static_ratio": (1.0, 4.0), "friction.stribeck_velocity": (3e-2, 3.0)},
        ),
        (Composed(dent, friction=laws.Mindlin()), yielding | ratio),
    ]
