"""The numbers of a motor and a law made in Python, by the keys of a configuration."""

from dataclasses import is_dataclass, replace
from functools import reduce
from typing import Any, Final, Protocol, TypeVar

from contactlab.config.faults import ConfigurationError
from contactlab.config.groups import GROUPS
from contactlab.laws import ContactLaw
from contactlab.motor import Drive, Motor
from contactlab.motor.drive import TwoMode
from contactlab.parameter import DeclaredField, Parameter, declared_fields
from contactlab.quantity import UnitError, number_of

AMPLITUDE: Final = Parameter("U_1", "1", "amplitude of the first tone, in the unit of the drive", above=0.0)
"""Of a motor made in Python: of an oscillator it is a force, of a cantilever an acceleration."""

KEYS: Final = {
    "duration": ("solver", "duration"),
    "record_interval": ("record", "interval"),
    "contact_step": ("solver", "contact_step"),
    "tolerance": ("solver", "tolerance"),
}
"""Where a configuration holds the numbers of a run, in the order of the arguments of `simulate`."""

PLACES: Final = KEYS | {"until": ("solver", "until"), "precision": ("solver", "precision")}
"""Configuration keys of all arguments of `simulate` that say how a run is made."""


class MotorUnderLaw(Protocol):
    """A motor and a law, as `contactlab.Setup` has them."""

    @property
    def motor(self) -> Motor:
        """What moves."""

    @property
    def law(self) -> ContactLaw:
        """What acts between tip and rotor."""


Made = TypeVar("Made", bound=MotorUnderLaw)


def variable_numbers(setup: MotorUnderLaw) -> dict[str, tuple[tuple[str, ...], DeclaredField]]:
    """Return paths and declarations of the numbers of a motor and a law made in Python, by keys.

    Beam and voltages are not among them: such a motor has modes and phasors alone. Of its tones it is the
    frequency and the largest amplitude of the first, to which the others keep their ratios, where no waveform
    has a time of its own. A small plant has the arguments of its function too, `plant.table.amplitude`.
    """
    owners = [("contact", ("motor", "geometry")), ("rotor", ("motor", "rotor")), ("law", ("law",))]
    numbers = {}
    while owners:
        group, path = owners.pop(0)
        owner: Any = reduce(getattr, path, setup)
        kind: type = type(owner)
        for name, field in declared_fields(kind).items():
            if is_dataclass(getattr(owner, name)):
                owners.append((f"{group}.{name}", (*path, name)))
            elif field.is_number:
                numbers[f"{group}.{name}"] = (*path, name), field
    numbers["rotor.radius"] = numbers.pop("contact.rotor_radius")
    plant, modes, drive = setup.motor.plant, setup.motor.modes, setup.motor.drive
    if plant is not None:
        numbers |= {f"plant.{name}": (("motor", "plant", name), x) for name, (_, x) in plant.numbers.items()}
    # A base whose displacement is recorded drives by its acceleration too: its numbers are the plant's.
    recorded = modes.is_prescribed & (modes.approach == 0.0) & (modes.tip_slope == 0.0)
    if drive.frequency.size and drive.waveform is None and not recorded.any():
        first = declared_fields(TwoMode)["frequency"]
        assert first.parameter is not None
        declared = DeclaredField(float, first.default, replace(first.parameter, hint=""))
        numbers["drive.frequency"] = ("motor", "drive", "frequency"), declared
        if drive.amplitude > 0.0:
            numbers["drive.amplitude"] = ("motor", "drive", "amplitude"), DeclaredField(float, 1.0, AMPLITUDE)
    # The coefficient that laws share, of a composed law that of its friction.
    for key in ("law.friction.friction_coefficient", "law.friction_coefficient"):
        if key in numbers:
            numbers["contact.friction_coefficient"] = numbers[key]
    return numbers


def with_number(setup: Made, key: str, value: object) -> Made:
    """Return the setup of a motor and a law made in Python with another number, of motor, law or solver.

    Raises:
        ConfigurationError: the key is none of them, or does not admit the value.
    """
    numbers = variable_numbers(setup)
    for name, (group, leaf) in KEYS.items():
        field = next(iter(GROUPS[group].options.values()))[leaf]
        assert isinstance(field, DeclaredField)
        numbers[f"{group}.{leaf}"] = (name,), field
    if key not in numbers:
        raise ConfigurationError(
            f"{key} is no number of a motor made in Python; it must be one of {', '.join(numbers)}. Vary "
            "anything else by a function that makes the motor."
        )
    path, field = numbers[key]
    try:
        return _replaced(setup, path, number_of(field, value))  # type: ignore[no-any-return]
    # What binds several numbers of one class is checked by the class.
    except ValueError as fault:
        message = f"{key} {fault}" if isinstance(fault, UnitError) else str(fault)
        raise ConfigurationError(message) from None


def _replaced(owner: Any, path: tuple[str, ...], value: Any) -> Any:
    """Return a dataclass with another value at a path of attributes."""
    name, *rest = path
    if isinstance(owner, Motor) and name == "plant" and owner.plant is not None:
        return owner.plant.with_number(rest[0], value)
    if isinstance(owner, Drive):
        return owner.with_amplitude(value) if name == "amplitude" else owner.with_first_tone(value)
    return replace(owner, **{name: _replaced(getattr(owner, name), tuple(rest), value) if rest else value})
