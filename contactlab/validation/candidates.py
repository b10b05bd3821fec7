"""The laws that are judged where none is named, and which of their numbers a fit can change anything with."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.fitting.parameters import from_cube
from contactlab.laws import (
    Composed,
    ContactLaw,
    Flores,
    Friction,
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
from contactlab.validation.models import TOLERANCE, LawModel, Model

FREE_OF: Final[Mapping[str, tuple[str, ...]]] = {"johnson": ("friction_coefficient", "yield_strength")}
"""Laws whose numbers act through a product of them: which ones are free."""

_PROBED: Final = 12
"""Impacts by which it is told whether a number changes anything."""

_SHARES: Final = (0.1, 0.5, 0.9)
_OTHERS: Final = (0.2, 0.5)
"""Places in its range at which a number is probed, and those at which the others are meanwhile."""

_EXACT: Final = 1e-9
"""Relative change of a velocity of a rigid law that is one."""


def usual_laws() -> list[LawModel]:
    """Give the models of every rigid law that is installed and of compliant ones composed of common parts."""
    rigid = [name for name in law_names() if issubclass(class_of(name), MultiplierLaw)]
    return [*map(usual_law, rigid), *(LawModel.of(one, dict.fromkeys(free)) for one, free in _composed())]


def usual_law(name: str) -> LawModel:
    """Give the model of a law by its name, its defaults where nothing is free.

    Raises:
        ValueError: there is no such law.
    """
    chosen = dict.fromkeys(FREE_OF[name]) if name in FREE_OF else None
    return LawModel.of(law(name), chosen)


def _composed() -> list[tuple[ContactLaw, tuple[str, ...]]]:
    """Give composed laws and what is free of them: the absolute stiffness of a spring changes no impulse."""
    cone, loss = "friction.friction_coefficient", "damping.restitution"
    frictions: list[tuple[Friction, tuple[str, ...]]] = [
        (Mindlin(), ("friction.stiffness_ratio",)),
        (Regularised(), ("friction.creep_velocity",)),
        (LuGre(), ("friction.bristle_stiffness",)),
        (Stribeck(), ("friction.static_ratio", "friction.stribeck_velocity")),
    ]
    yielding = WaltonBraun(), ("normal.unloading_stiffness",)
    return [
        (law("hertz_penalty"), ("friction_coefficient",)),
        (Composed(HertzPoint(), Flores()), (loss, cone)),
        (Composed(HertzPoint(), HuntCrossley(impact_speed=1.0)), (loss, cone)),
        (Composed(Thornton()), ("normal.yield_pressure", cone)),
        (Composed(yielding[0]), (*yielding[1], cone)),
        *((Composed(HertzPoint(), Flores(), part), (loss, cone, *free)) for part, free in frictions),
        (Composed(yielding[0], friction=Mindlin()), (*yielding[1], cone, "friction.stiffness_ratio")),
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

    Each goes through its range while the others stay in two places of theirs, on a dozen of the impacts.
    """
    some = impacts.part(np.unique(np.linspace(0, len(impacts) - 1, _PROBED).astype(np.int64)))
    # What is compiled at the first call is no time of the law.
    model.after(_at(model, 0.5), some)
    began = perf_counter()
    model.after(_at(model, 0.5), some)
    seconds = (perf_counter() - began) / len(some)
    if not isinstance(model, LawModel):
        return Probed(model, (), seconds)
    acting = [place for place in range(len(model.free)) if _acts(model, place, some)]
    held = tuple(one.name for place, one in enumerate(model.free) if place not in acting)
    return Probed(replace(model, free=tuple(model.free[place] for place in acting)), held, seconds)


def _at(model: Model, share: float, **others: float) -> Array:
    return from_cube(model.free, [others.get(one.name, share) for one in model.free])


def _acts(model: Model, place: int, impacts: MeasuredImpacts) -> bool:
    """Tell whether a number changes a velocity anywhere."""
    least = 10.0 * TOLERANCE if model.costly else _EXACT
    size = np.abs(impacts.velocity_before).max()
    name = model.free[place].name
    for other in _OTHERS:
        found: Sequence[Array] = [model.after(_at(model, other, **{name: x}), impacts) for x in _SHARES]
        for one in found[1:]:
            apart = np.abs(one - found[0])
            if (
                np.isnan(one).sum() != np.isnan(found[0]).sum()
                or np.nanmax(apart, initial=0.0) > least * size
            ):
                return True
    return False
