"""What is wrong with an argument from Python is told in a sentence, and where it is given."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

import numpy as np
import pytest

from contactlab.engine import simulate
from contactlab.laws import HertzPenalty, LagrangeStick, PenaltyLaw
from contactlab.laws.base import NormalForce
from contactlab.laws.composed import Composed
from contactlab.laws.friction import Coulomb
from contactlab.laws.normal import HertzPoint
from contactlab.motor import FiniteElementResonator, RitzResonator
from contactlab.motor.drive import Drive
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, Motor, Rotor
from contactlab.motor.patched_beam import Steel
from contactlab.parameter import Parameter
from contactlab.sweeps import sweep
from contactlab.testing.plants import paper_motor

MOTOR = paper_motor()
MODES, DRIVE = MOTOR.modes, MOTOR.drive
STIFFNESS = Parameter("k", "N m-1", "contact stiffness", above=0.0)

Make = Callable[[], Any]


class Undecorated(PenaltyLaw):
    name = "undecorated"
    equation = source = "this test"
    default_contact_step = 4e-6
    stiffness: Annotated[float, STIFFNESS] = 1e7

    @property
    def force(self) -> Any:
        return None


@dataclass(frozen=True)
class Speechless(PenaltyLaw):
    name: ClassVar[str] = "speechless"
    equation: ClassVar[str] = "N = k d"
    stiffness: Annotated[float, STIFFNESS] = 1e7

    @property
    def force(self) -> Any:
        return None


@dataclass
class Thawed(PenaltyLaw):
    name: ClassVar[str] = "thawed"
    equation: ClassVar[str] = "N = k d"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 4e-6
    stiffness: Annotated[float, STIFFNESS] = 1e7

    @property
    def force(self) -> Any:
        return None


@dataclass(frozen=True)
class Numbered(Speechless):
    name: ClassVar[Any] = 7
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 4e-6


@dataclass(frozen=True)
class Talkative(Speechless):
    source: str = "this test"
    default_contact_step: float = 4e-6


class UndecoratedPart(NormalForce):
    name = "undecorated"
    equation = source = "this test"
    stiffness: Annotated[float, STIFFNESS] = 1e7

    @property
    def elastic(self) -> Any:
        return None


@dataclass(frozen=True)
class SpeechlessPart(NormalForce):
    name: ClassVar[str] = "speechless"
    equation: ClassVar[str] = "this test"

    @property
    def elastic(self) -> Any:
        return None


def test_what_is_sound_passes() -> None:
    assert HertzPenalty(friction_coefficient=np.float32(0.25)).friction_limit == 0.25
    assert HertzPenalty(friction_coefficient=1).friction_limit == 1.0
    assert RitzResonator(shapes=np.int64(4)).modes.stiffness.size == 4  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("0.3", "friction_coefficient is '0.3'; it must be a number"),
        (None, "friction_coefficient is None; it must be a number"),
        (True, "friction_coefficient is True; it must be a number"),
        (0.3j, "friction_coefficient is 0.3j; it must be a number"),
        (np.array([0.1, 0.2]), "friction_coefficient is an array of shape (2,); it must be"),
    ],
)
@pytest.mark.parametrize("law", [HertzPenalty, LagrangeStick, Coulomb])
def test_a_parameter_that_is_no_number_is_refused(law: Any, value: object, words: str) -> None:
    with pytest.raises(TypeError) as refusal:
        law(friction_coefficient=value)
    assert f"{law.name}: {words}" in str(refusal.value)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
def test_a_parameter_out_of_range_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match=f"hertz_penalty: friction_coefficient is {value}"):
        HertzPenalty(friction_coefficient=value)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Composed(normal=Coulomb()), "composed: normal is Coulomb("),
        (lambda: Composed(normal=Coulomb()), "; it must be a NormalForce."),
        (lambda: Composed(friction="coulomb"), "friction is 'coulomb'; it must be a Friction"),
        (
            lambda: Composed(normal=HertzPoint),
            "normal is the class HertzPoint; it must be a NormalForce. Call it: HertzPoint(...).",
        ),
        (lambda: Undecorated(1e7), "Undecorated is no dataclass; decorate it with @dataclass"),
        (Undecorated, "Undecorated is no dataclass; decorate it with @dataclass(frozen=True)"),
        (UndecoratedPart, "UndecoratedPart is no dataclass; decorate it with @dataclass"),
        (Speechless, "Speechless does not say its source, default_contact_step."),
        (SpeechlessPart, "SpeechlessPart does not say its source."),
        (Thawed, "Thawed can be changed; decorate it with @dataclass(frozen=True)"),
        (Numbered, "Numbered has a name that is no text, 7"),
        (Talkative, "Talkative has its source, default_contact_step among its parameters"),
        (lambda: Rotor(inertia="1e-5"), "Rotor: inertia is '1e-5'; it must be a number"),
        (lambda: ContactGeometry(clearance=None), "ContactGeometry: clearance is None; it must"),
        (lambda: Steel(density="heavy"), "Steel: density is 'heavy'; it must be a number"),
        (lambda: RitzResonator(length="57 mm"), "RitzResonator: length is '57 mm'; it must be a"),
        (lambda: RitzResonator(shapes=2.5), "shapes is 2.5; it must be a whole number"),
        (lambda: RitzResonator(steel="hard"), "steel is 'hard'; it must be a Steel"),
        (lambda: FiniteElementResonator(kept_modes="6"), "kept_modes is '6'; it must be a whole"),
        (
            lambda: FiniteElementResonator(static_correction=1),
            "static_correction is 1; it must be True or False",
        ),
        (lambda: Drive.two_mode("100", 100.0, 3210.0), "voltage_1 is '100'; it must be a number"),
        (lambda: Drive([1.0], np.ones((2, 1))), "frequency is [1.0]; it must be a NumPy array"),
        (lambda: Motor(RitzResonator(), DRIVE), "it must be a NormalModes"),
        (lambda: Motor(MODES, DRIVE, start=(0.0, 0.0)), "it must be a ModalState or None"),
        (lambda: replace(MODES, tip_slope=[0.0] * 4), "tip_slope is [0.0, 0.0, 0.0, 0.0]; it must"),
    ],
)
def test_what_is_of_the_wrong_kind_is_refused(make: Make, words: str) -> None:
    with pytest.raises(TypeError) as refusal:
        make()
    assert words in str(refusal.value)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: replace(MODES, tip_slope=np.ones(3)), "tip_slope has shape (3,); it must have"),
        (lambda: replace(MODES, damping=np.ones(5)), "damping has shape (5,); it must have shape"),
        (lambda: replace(MODES, coupling=MODES.coupling.T), "coupling has shape (2, 4); it must"),
        (
            lambda: replace(MODES, tip_displacement=MODES.tip_displacement * np.nan),
            "tip_displacement has nan among its numbers; all must be finite",
        ),
        (
            lambda: Motor(MODES, DRIVE, start=ModalState(np.zeros(3), np.zeros(4))),
            "start.displacement has shape (3,); it must have shape (4,), one number a mode",
        ),
        (lambda: Motor(MODES, DRIVE, preload=np.zeros(2)), "preload has shape (2,); it must have"),
        (lambda: Drive(np.ones(2), np.ones((2, 3))), "phasors has shape (2, 3); it must have"),
        (
            lambda: Rotor(inertia=0.0),
            "Rotor: inertia is 0.0 kg m^2; it must be greater than 0 kg m^2. The default is",
        ),
        (lambda: Rotor(damping=np.nan), "Rotor: damping is nan; it must be finite"),
        (lambda: ContactGeometry(rotor_radius=-1.0), "rotor_radius is -1.0 m; it must be greater than 0 m"),
    ],
)
def test_what_has_the_wrong_shape_or_range_is_refused(make: Make, words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        make()


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"law": "hertz_penalty"}, "it must be a law and not its name"),
        ({"law": HertzPenalty}, "the class HertzPenalty; it must be a ContactLaw. Call it"),
        ({"law": None}, "The law is None; it must be a ContactLaw"),
        ({"motor": RitzResonator()}, "The motor is of the type RitzResonator; it must be a Motor"),
        ({"duration": "1"}, "The duration is '1'; it must be a number"),
        ({"duration": None}, "The duration is None; it must be a number"),
        ({"record_interval": "1"}, "The record interval is '1'; it must be a number"),
        ({"contact_step": "1"}, "The contact step is '1'; it must be a number"),
        ({"tolerance": "1"}, "The tolerance is '1'; it must be a number"),
    ],
)
def test_simulate_refuses_what_is_of_the_wrong_kind(changed: dict[str, Any], words: str) -> None:
    arguments: dict[str, Any] = {"motor": MOTOR, "law": HertzPenalty(), "duration": 1e-4}
    with pytest.raises(TypeError) as refusal:
        simulate(**arguments | {"record_interval": 1e-5} | changed)
    assert words in str(refusal.value)


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"law": 0.3}, "The law is 0.3; it must be a ContactLaw"),
        ({"law": None}, "there must be a law and a duration"),
        ({"motor": None}, "give motor="),
        ({"base": ["drive.phase=1"]}, "neither a base nor a folder"),
    ],
)
def test_sweep_refuses_what_is_of_the_wrong_kind(changed: dict[str, Any], sentence: str) -> None:
    arguments: dict[str, Any] = {"motor": lambda **_: MOTOR, "law": LagrangeStick(0.3)}
    with pytest.raises((TypeError, ValueError), match=sentence):
        sweep({"clearance": [1e-6]}, **arguments | changed, duration=1e-4, workers=1)
