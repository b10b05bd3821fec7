"""The laws that are judged where none is named, and which of their numbers a fit can change anything with."""

from dataclasses import dataclass, replace
from time import process_time
from typing import Final, final

import numpy as np

from contactlab.inference.free_parameters import from_cube, label_of
from contactlab.inference.least_squares import starting_points
from contactlab.inference.models import TOLERANCE, LawModel, Model
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

Ranges = dict[str, tuple[float, float] | None]
"""What is free, each in a range or in its own."""

FREE_OF: Final[dict[str, tuple[str, ...]]] = {"johnson": ("friction_coefficient", "yield_strength")}
"""Laws whose numbers act through a product of them: which ones are free."""

_PROBED: Final = 12
"""Impacts by which it is told whether a number changes anything."""

_SHARES: Final = (0.1, 0.5, 0.9)
"""Places in its range at which a number is probed."""

_POINTS: Final = 8
"""Of the others meanwhile, of a Latin hypercube: with large friction all contacts stick, whatever else."""

_EXACT: Final = 1e-9
"""Relative change of a velocity of a rigid law that is one."""


def usual_laws() -> list[LawModel]:
    """Give the models of every rigid law that is installed and of compliant ones composed of common parts."""
    rigid = [name for name in law_names() if issubclass(class_of(name), MultiplierLaw)]
    return [*(usual_law(name) for name in rigid), *(LawModel.of(one, free) for one, free in _composed())]


def usual_law(name: str, **parts: str) -> LawModel:
    """Give the model of a law by its name and those of its parts: as among the usual ones if it is of them.

    Of any other all numbers are free.

    Raises:
        ValueError: there is no such law or part.
        TypeError: the law has no such part.
    """
    made = law(name, **parts)
    label = label_of(made)
    if not isinstance(made, MultiplierLaw):
        for one, free in _composed():
            if label_of(one) == label:
                return LawModel.of(one, free)
    return LawModel.of(made, dict.fromkeys(FREE_OF[name]) if name in FREE_OF else None)


def _composed() -> list[tuple[ContactLaw, Ranges]]:
    """Give composed laws and what is free of them: the absolute stiffness of a spring changes no impulse."""
    cone: Ranges = {"friction.friction_coefficient": None}
    lossy: Ranges = {"damping.restitution": None, **cone}
    # What Hunt and Crossley's loss can reach at its speed.
    slowing: Ranges = {"damping.restitution": (0.4, 1.0), **cone}
    yielding: Ranges = {"normal.unloading_stiffness": (1e7, 1e9), **cone}
    elastic, dent = HertzPoint(), WaltonBraun(loading_stiffness=1e7, unloading_stiffness=3e7)
    ratio: Ranges = {"friction.stiffness_ratio": None}
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


@final
@dataclass(frozen=True)
class Probed:
    """A model without the numbers that change nothing.

    Args:
        model: with what is left free.
        held: names of the numbers that are not.
        seconds: that the model takes for one impact.
    """

    model: Model
    held: tuple[str, ...]
    seconds: float


def probed(model: Model, impacts: MeasuredImpacts) -> Probed:
    """Find the numbers that change nothing of what a law predicts, and hold them at the law's own value.

    Each goes through its range while the others stay where they are, in several places, on a dozen impacts.
    """
    some = impacts.part(np.unique(np.linspace(0, len(impacts) - 1, _PROBED).astype(np.int64)))
    # What is compiled at the first call is no time of the law.
    middle = from_cube(model.free, np.full(len(model.free), 0.5))
    model.after(middle, some)
    began = process_time()
    model.after(middle, some)
    seconds = (process_time() - began) / len(some)
    if not isinstance(model, LawModel):
        return Probed(model, (), seconds)
    acting = [place for place in range(len(model.free)) if _acts(model, place, some)]
    held = tuple(one.name for place, one in enumerate(model.free) if place not in acting)
    return Probed(replace(model, free=tuple(model.free[place] for place in acting)), held, seconds)


def _acts(model: Model, place: int, impacts: MeasuredImpacts) -> bool:
    """Tell whether a number changes a velocity anywhere."""
    least = 10.0 * TOLERANCE if model.costly else _EXACT
    size = np.abs(impacts.velocity_before).max()
    for point in starting_points(len(model.free), _POINTS, seed=0):
        found = []
        for share in _SHARES:
            point[place] = share
            found.append(model.after(from_cube(model.free, point), impacts))
        for one in found[1:]:
            apart = np.abs(one - found[0])
            if (
                np.isnan(one).sum() != np.isnan(found[0]).sum()
                or np.nanmax(apart, initial=0.0) > least * size
            ):
                return True
    return False
