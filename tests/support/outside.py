"""Packages with laws and parts as others make them: the example, a broken one, and one of the same names."""

import re
from pathlib import Path

import pytest
import xarray
import yaml
from support.command_line import Elsewhere

SHORT = "solver.duration=0.2 ms"

BROKEN = {
    "law_of_a_module_that_is_not_there": ("nowhere:Law", "ModuleNotFoundError"),
    "law_of_a_module_that_fails": ("failing:Law", "ZeroDivisionError: division by zero"),
    "law_that_is_not_there": ("various:Missing", "AttributeError"),
    "law_that_is_a_number": ("various:NUMBER", "is no subclass of"),
    "law_of_another_name": ("various:Misnamed", "calls itself 'another'"),
    "law_without_kernel": ("various:Abstract", "lacks force"),
    "law_that_is_no_dataclass": ("various:Plain", "is no dataclass"),
    "law_that_is_undeclared": ("various:Undeclared", "field stiffness without a declaration"),
    "hertz_penalty": ("various:Thief", "takes the name of one of contactlab's own"),
    "two words": ("various:TwoWords", "it must be one word"),
}

BROKEN_PARTS = {
    "normal/part_of_a_module_that_fails": ("failing:Part", "ZeroDivisionError: division by zero"),
    "damping/part_that_is_a_law": ("various:Smooth", "is no subclass of contactlab.laws.Damping"),
    "friction/part_of_another_name": ("various:Grip", "calls itself 'grip'"),
    "friction/coulomb": ("various:Grip", "takes the name of one of contactlab's own"),
}

VARIOUS = """
from dataclasses import dataclass
from typing import Annotated
from contactlab.laws import Friction, HertzPenalty, PenaltyLaw
from contactlab.parameter import Parameter
NUMBER = 1
class Law(PenaltyLaw):
    equation = "N = k d"
    source = "a test"
    default_contact_step = 4e-6
@dataclass(frozen=True)
class Misnamed(Law):
    name = "another"
    @staticmethod
    def force(gap, gap_rate, slip, impact_speed, parameters):
        return -parameters[0] * gap, 0.0, 0.5 * parameters[0] * gap * gap, 0.0
@dataclass(frozen=True)
class Abstract(Law):
    name = "law_without_kernel"
class Plain(Law):
    name = "law_that_is_no_dataclass"
    force = Misnamed.force
@dataclass(frozen=True)
class Undeclared(Misnamed):
    name = "law_that_is_undeclared"
    stiffness: float = 1.0
@dataclass(frozen=True)
class Smooth(Misnamed):
    name = "smooth"
    stiffness: Annotated[float, Parameter("k", "N m-1", "contact stiffness", above=0.0)] = 1e7
@dataclass(frozen=True)
class Contradicting(Smooth):
    name = "contradicting"
    friction_kind = 2
@dataclass(frozen=True)
class NegativeBound(Smooth):
    name = "negative_bound"
    @staticmethod
    def force(gap, gap_rate, slip, impact_speed, parameters):
        return -1e7 * gap, 1e6 * gap, 5e6 * gap * gap, 0.0
@dataclass(frozen=True)
class PastTheEnd(Smooth):
    name = "past_the_end"
    @staticmethod
    def force(gap, gap_rate, slip, impact_speed, parameters):
        return -1e7 * gap, -parameters[1] * gap, 5e6 * gap * gap, 0.0
@dataclass(frozen=True)
class Raising(Smooth):
    name = "raising"
    @property
    def force(self):
        return {}["kernel"]
@dataclass(frozen=True)
class Leaving(Smooth):
    name = "leaving"
    @staticmethod
    def force(gap, gap_rate, slip, impact_speed, parameters):
        raise SystemExit(0)
@dataclass(frozen=True)
class WithoutDefault(Misnamed):
    name = "without_default"
    stiffness: Annotated[float, Parameter("k", "N m-1", "contact stiffness", above=0.0)]
@dataclass(frozen=True)
class Grip(Friction):
    name = "grip"
    equation = "|F| <= mu N"
    source = "a test"
@dataclass(frozen=True, kw_only=True)
class Grainy(Grip):
    name = "grainy"
    grain: Annotated[float, Parameter("r", "m", "size of a grain", above=0.0)]
"""


def installed(factory: pytest.TempPathFactory) -> Elsewhere:
    """Three packages: the example, a broken one, and one that has the name of a law of the second."""
    made = Elsewhere(factory.mktemp("packages"), factory.mktemp("elsewhere"))
    entries = {name: entry for name, (entry, _) in BROKEN.items()}
    classes = ("Smooth", "Contradicting", "NegativeBound", "PastTheEnd", "Raising", "Leaving")
    entries |= {re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower(): f"various:{name}" for name in classes}
    more = {"without_default": "various:WithoutDefault", "twice": "various:Law"}
    modules = {"various": VARIOUS, "failing": "1 / 0"}
    parts = {"contactlab.laws.friction": {"grainy": "various:Grainy"}}
    for title, (entry, _) in BROKEN_PARTS.items():
        family, _, name = title.partition("/")
        parts.setdefault(f"contactlab.laws.{family}", {})[name] = entry
    made.install(
        made.example(),
        made.wheel("broken-laws", "0.1", entries | more, modules, parts),
        made.wheel("other-laws", "0.2", {"twice": "various:Law"}, {}),
    )
    return made


def law_of(run: Path) -> tuple[str, dict[str, object]]:
    """The law's name and its section, as a run recorded them."""
    with xarray.open_dataset(run) as root:
        return root.attrs["law"], yaml.safe_load(root.attrs["configuration"])["law"]
