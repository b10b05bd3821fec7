"""Laws that are judged by default, and which of their numbers have an effect on impacts."""

from dataclasses import replace
from typing import Final

import numpy as np

from contactlab.inference.free_parameters import from_cube, label_of
from contactlab.inference.impact_problem import ROUGH_TOLERANCE, LawPredictor, Ranges
from contactlab.inference.least_squares import starting_points
from contactlab.laws import (
    Composed,
    ContactLaw,
    Flores,
    HertzPoint,
    HuntCrossley,
    LuGre,
    Mindlin,
    MultiplierLaw,
    Regularised,
    Stribeck,
    Thornton,
    WaltonBraun,
)
from contactlab.laws.registry import class_of, law, law_names
from contactlab.measured.impacts import MeasuredImpacts

FREE_OF: Final[dict[str, tuple[str, ...]]] = {"johnson": ("friction_coefficient", "yield_strength")}
"""Free numbers of laws whose other numbers act through a product with these."""

IMPACTS: Final = 12
"""Impacts in a test for sensitivity."""

SHARES: Final = (0.1, 0.5, 0.9)
"""Places in its range at which a number is tested."""

POINTS: Final = 8
"""Latin-hypercube samples of the other numbers: under large friction all contacts stick."""

EXACT: Final = 1e-9
"""Relative change of a velocity under a rigid law above round-off."""


def usual_laws() -> list[LawPredictor]:
    """Return predictors of every installed rigid law and of compliant ones composed of common parts."""
    rigid = [name for name in law_names() if issubclass(class_of(name), MultiplierLaw)]
    return [*(usual_law(name) for name in rigid), *(LawPredictor.of(*item) for item in _compliant_laws())]


def usual_law(name: str, **parts: str) -> LawPredictor:
    """Return the predictor of a law by its name and those of its parts, with the free numbers as usual.

    All numbers of a law that is not among the usual ones are free.

    Raises:
        ValueError: there is no such law or part.
        TypeError: the law has no such part.
    """
    made = law(name, **parts)
    if not isinstance(made, MultiplierLaw):
        for item, ranges in _compliant_laws():
            if label_of(item) == label_of(made):
                return LawPredictor.of(item, ranges)
    return LawPredictor.of(made, dict.fromkeys(FREE_OF[name]) if name in FREE_OF else None)


def _compliant_laws() -> list[tuple[ContactLaw, Ranges]]:
    """Return compliant laws and what is free of them; the absolute stiffness of a spring has no effect."""
    cone: dict[str, tuple[float, float] | None] = {"friction.friction_coefficient": None}
    lossy = {"damping.restitution": None, **cone}
    # The range of the loss of Hunt and Crossley at this speed.
    slowing = {"damping.restitution": (0.4, 1.0), **cone}
    yielding = {"normal.unloading_stiffness": (1e7, 1e9), **cone}
    elastic, dent = HertzPoint(), WaltonBraun(loading_stiffness=1e7, unloading_stiffness=3e7)
    ratio = {"friction.stiffness_ratio": None}
    return [
        (law("hertz_penalty"), {"friction_coefficient": None}),
        (Composed(elastic, Flores()), lossy),
        (Composed(elastic, HuntCrossley(0.8, impact_speed=1.0)), slowing),
        (Composed(Thornton()), {"normal.yield_pressure": None, **cone}),
        (Composed(dent), yielding),
        (Composed(elastic, Flores(), Mindlin()), lossy | ratio),
        (Composed(elastic, Flores(), Regularised()), lossy | {"friction.creep_velocity": (1e-2, 3.0)}),
        (Composed(elastic, Flores(), LuGre()), lossy | {"friction.bristle_stiffness": (1e3, 1e7)}),
        (
            Composed(elastic, Flores(), Stribeck()),
            lossy | {"friction.static_ratio": (1.0, 4.0), "friction.stribeck_velocity": (3e-2, 3.0)},
        ),
        (Composed(dent, friction=Mindlin()), yielding | ratio),
    ]


def without_idle(predictor: LawPredictor, impacts: MeasuredImpacts) -> LawPredictor:
    """Fix the numbers of a law that have no effect on impacts at their values.

    Each runs through its range, with several samples of the others, on a dozen of the impacts.
    """
    some = impacts.part(np.unique(np.linspace(0, len(impacts) - 1, IMPACTS).astype(np.int64)))
    acts = [_acts(predictor, place, some) for place in range(len(predictor.free))]
    idle = tuple(item.name for item, act in zip(predictor.free, acts, strict=True) if not act)
    free = tuple(item for item, act in zip(predictor.free, acts, strict=True) if act)
    return replace(predictor, free=free, idle=idle)


def _acts(predictor: LawPredictor, place: int, impacts: MeasuredImpacts) -> bool:
    """Return whether a number changes any velocity."""
    threshold = 10.0 * ROUGH_TOLERANCE if predictor.integrated else EXACT
    size = np.abs(impacts.velocity_before).max()
    for point in starting_points(len(predictor.free), POINTS, seed=0):
        after = []
        for share in SHARES:
            point[place] = share
            after.append(predictor.velocities_after(from_cube(predictor.free, point), impacts))
        for other in after[1:]:
            changed = np.nanmax(np.abs(other - after[0]), initial=0.0) > threshold * size
            if changed or np.isnan(other).sum() != np.isnan(after[0]).sum():
                return True
    return False
