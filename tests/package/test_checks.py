"""Arguments from Python of the wrong type, shape or range are refused where they are passed."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

import numpy as np
import pytest

from contactlab.laws import HertzPenalty, LagrangeStick, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.friction import Coulomb
from contactlab.laws.normal import HertzPoint
from contactlab.motor import FiniteElementResonator, RitzResonator
from contactlab.motor.drive import Drive
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, Motor, Rotor
from contactlab.motor.patched_beam import Steel
from contactlab.parameter import Parameter
from contactlab.testing.plants import paper_motor

MOTOR = paper_motor()
MODES, DRIVE = MOTOR.modes, MOTOR.drive
STIFFNESS = Parameter("k", "N m-1", "contact stiffness", above=0.0)


class Undecorated(PenaltyLaw):
    name = "undecorated"
    equation = source = "this test"
    default_contact_step = 4e-6
    stiffness: Annotated[float, STIFFNESS] = 1e7

    @property
    def force(self) -> Any:
        return None


@dataclass(frozen=True)
class WithoutSource(PenaltyLaw):
    name: ClassVar[str] = "without_source"
    equation: ClassVar[str] = "N = k d"
    stiffness: Annotated[float, STIFFNESS] = 1e7

    @property
    def force(self) -> Any:
        return None


@dataclass
class Mutable(Undecorated):
    stiffness: Annotated[float, STIFFNESS] = 1e7


@dataclass(frozen=True)
class SourceAsField(WithoutSource):
    source: str = "this test"
    default_contact_step: float = 4e-6


@pytest.mark.parametrize("value", ["0.3", None, True, 0.3j, np.array([0.1, 0.2])], ids=str)
@pytest.mark.parametrize("law", [HertzPenalty, LagrangeStick, Coulomb])
def test_a_parameter_that_is_no_number_is_refused(law: Any, value: object) -> None:
    with pytest.raises(TypeError, match=rf"{law.name}: friction_coefficient\b"):
        law(friction_coefficient=value)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
def test_a_parameter_out_of_range_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match=r"hertz_penalty: friction_coefficient\b"):
        HertzPenalty(friction_coefficient=value)


WRONG_TYPE: list[tuple[Callable[[], Any], str]] = [
    (lambda: Composed(normal=Coulomb()), "normal"),
    (lambda: Composed(friction="coulomb"), "friction"),
    (lambda: Composed(normal=HertzPoint), "normal"),
    (lambda: Undecorated(1e7), "Undecorated"),
    (WithoutSource, "source"),
    (Mutable, "Mutable"),
    (SourceAsField, "source"),
    (lambda: Rotor(inertia="1e-5"), "inertia"),
    (lambda: ContactGeometry(clearance=None), "clearance"),
    (lambda: Steel(density="heavy"), "density"),
    (lambda: RitzResonator(shapes=2.5), "shapes"),
    (lambda: RitzResonator(steel="hard"), "steel"),
    (lambda: FiniteElementResonator(static_correction=1), "static_correction"),
    (lambda: Drive.two_mode("100", 100.0, 3210.0), "voltage_1"),
    (lambda: Drive([1.0], np.ones((2, 1))), "frequency"),
    (lambda: Motor(RitzResonator(), DRIVE), "NormalModes"),
    (lambda: Motor(MODES, DRIVE, start=(0.0, 0.0)), "ModalState"),
    (lambda: replace(MODES, tip_slope=[0.0] * 4), "tip_slope"),
]
WRONG_VALUE: list[tuple[Callable[[], Any], str]] = [
    (lambda: replace(MODES, tip_slope=np.ones(3)), "tip_slope"),
    (lambda: replace(MODES, coupling=MODES.coupling.T), "coupling"),
    (lambda: replace(MODES, tip_displacement=MODES.tip_displacement * np.nan), "tip_displacement"),
    (lambda: Motor(MODES, DRIVE, start=ModalState(np.zeros(3), np.zeros(4))), "start.displacement"),
    (lambda: Motor(MODES, DRIVE, preload=np.zeros(2)), "preload"),
    (lambda: Drive(np.ones(2), np.ones((2, 3))), "phasors"),
    (lambda: Rotor(inertia=0.0), "inertia"),
    (lambda: Rotor(damping=np.nan), "damping"),
    (lambda: ContactGeometry(rotor_radius=-1.0), "rotor_radius"),
]


@pytest.mark.parametrize(("make", "key"), WRONG_TYPE)
def test_an_argument_of_the_wrong_type_is_refused(make: Callable[[], Any], key: str) -> None:
    with pytest.raises(TypeError, match=key):
        make()


@pytest.mark.parametrize(("make", "key"), WRONG_VALUE)
def test_an_argument_of_the_wrong_shape_or_range_is_refused(make: Callable[[], Any], key: str) -> None:
    with pytest.raises(ValueError, match=key):
        make()
