"""From a configuration to the objects that run.

    build({"law": {...}, "resonator": {...}, ...}) -> Setup

The only module that knows both sides. Everything a configuration may get wrong is found here, all
at once, and told in a sentence each; see `contactlab.config.schema` for keys, units and ranges and
`contactlab.config.rules` for what binds keys together.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, final

from pydantic import ValidationError

from contactlab.config.faults import ConfigurationError, one_line, sentence
from contactlab.config.law_section import HertzPenaltySection, LawSection, chosen_section
from contactlab.config.rules import broken_rules
from contactlab.config.schema import (
    BendingSection,
    Configuration,
    DriveSection,
    PlacementSection,
    ResonatorSection,
    RitzSection,
    RotorSection,
    TensorSection,
    configuration_with,
)
from contactlab.config.section import Section, sound_values

# The objects are imported where they are built: they bring the compiler with them, and a
# configuration with a fault shall be told so at once.
if TYPE_CHECKING:
    from contactlab.laws import ContactLaw
    from contactlab.motor import NormalModes
    from contactlab.motor.drive import Drive
    from contactlab.motor.geometry import ContactGeometry
    from contactlab.motor.materials import Piezoceramic
    from contactlab.motor.motor import Motor, Rotor

RESONANCE = 1e-9
"""Relative distance at which an undamped tone counts as at a natural frequency."""


@final
@dataclass(frozen=True)
class Setup:
    """A run, ready to start: the arguments of `contactlab.engine.simulation` and their origin.

    Args:
        motor, law: what runs.
        duration: simulated time [s].
        record_interval: time between records [s].
        contact_step: largest step in contact [s], the default of law and motor where none was given.
        tolerance: relative tolerance in contact [1]; None for a law that takes none.
        configuration: the numbers that run, in SI, with nothing left to be resolved: building it
            again gives the same setup.
    """

    motor: "Motor"
    law: "ContactLaw"
    duration: float
    record_interval: float
    contact_step: float
    tolerance: float | None
    configuration: dict[str, Any]


def build(configuration: Mapping[str, object]) -> Setup:
    """Check a configuration and build the motor and the law from it.

    Args:
        configuration: nested mappings as `conf/` composes them; numbers in SI or texts with units. A
            section may also be one of what `validate` gave, which is not checked again.

    Raises:
        ConfigurationError: with every fault that was found.
    """
    checked = validate(configuration)
    # Not before: it brings the compiler.
    from contactlab.motor.motor import Motor

    resolved = checked.model_dump()
    modes = _modes(checked.resonator, checked.piezoceramic, checked.placement)
    if checked.drive.frequency is None:
        resolved["drive"]["frequency"] = float(modes.natural_frequency[0])
    law, computed = _law(checked.law, checked.contact.friction_coefficient, checked.rotor.radius)
    resolved["law"] |= computed
    if checked.solver.contact_step is None:
        resolved["solver"]["contact_step"] = _default_step(modes, law, checked.solver.duration)
    if checked.law.takes_tolerance and checked.solver.tolerance is None:
        resolved["solver"]["tolerance"] = _default_tolerance()
    drive = _drive(checked.drive, resolved["drive"]["frequency"])
    _refuse_undamped_resonance(drive, modes)
    return Setup(
        motor=Motor(modes, drive, _geometry(checked), _rotor(checked.rotor)),
        law=law,
        duration=checked.solver.duration,
        record_interval=checked.record.interval,
        contact_step=resolved["solver"]["contact_step"],
        tolerance=resolved["solver"]["tolerance"],
        configuration=resolved,
    )


def validate(configuration: Mapping[str, object]) -> Configuration:
    """Check a configuration without building anything.

    Args:
        configuration: as for `build`.

    Raises:
        ConfigurationError: with every fault that was found.
    """
    sound: dict[str, object] = {}
    checked = None
    given = configuration.get("law") if isinstance(configuration, Mapping) else None
    section, chosen, faults = chosen_section(given)
    for part in configuration.values() if isinstance(configuration, Mapping) else ():
        sound |= sound_values(part) if isinstance(part, Section) else {}
    try:
        checked = configuration_with(section).model_validate(configuration, context=sound)
    except ValidationError as error:
        faults += [sentence(fault, chosen) for fault in error.errors(include_url=False)]
    faults += broken_rules(sound)
    if faults or checked is None:
        raise ConfigurationError(faults)
    return checked


# A sweep over anything else asks for the same resonator again and again.
@lru_cache(maxsize=256)
def _modes(
    resonator: ResonatorSection,
    piezoceramic: BendingSection | TensorSection,
    placement: PlacementSection,
) -> "NormalModes":
    from contactlab.motor import FiniteElementResonator, PatchedBeam, RitzResonator
    from contactlab.motor.materials import Steel

    basis: Callable[..., PatchedBeam]
    basis = RitzResonator if isinstance(resonator, RitzSection) else FiniteElementResonator
    try:
        return basis(
            **resonator.model_dump(exclude={"basis", "steel"}),
            steel=Steel(**resonator.steel.model_dump()),
            piezoceramic=_piezoceramic(piezoceramic),
            patch_start=placement.start,
            patch_end=placement.end,
        ).modes
    except ValueError as error:
        raise ConfigurationError(
            [f"resonator, piezoceramic and placement make no resonator: {error}"]
        ) from error


def _piezoceramic(section: BendingSection | TensorSection) -> "Piezoceramic":
    from contactlab.motor.materials import Piezoceramic

    constants = section.model_dump(exclude={"constants"})
    if isinstance(section, BendingSection):
        return Piezoceramic(**constants)
    return Piezoceramic.from_datasheet(**constants)


@lru_cache(maxsize=4096)
def _law(
    section: LawSection, friction_coefficient: float, rotor_radius: float
) -> "tuple[ContactLaw, dict[str, Any]]":
    """The law, and the keys of its section that follow from others: a stiffness from the tip's radius."""
    from contactlab import laws
    from contactlab.fingerprint import is_own
    from contactlab.laws.registry import build_law

    computed: dict[str, Any] = {}
    if isinstance(section, HertzPenaltySection) and section.tip_radius is not None:
        stiffness = laws.hertz_stiffness(section.tip_radius, rotor_radius)
        computed = {"stiffness": stiffness, "tip_radius": None}
    values = section.model_dump() | computed
    try:
        law = build_law(laws.law_class(section.name), values, friction_coefficient)
        # Those of this package are sound, and their kernels are not needed yet.
        if not is_own(type(law)):
            from contactlab.engine.simulation import take_in

            take_in(law)
    # A law of another package may refuse, or fail, in ways of its own.
    except Exception as error:
        # What the law itself raised is in the sentence already.
        told = laws.LawError(*error.args) if isinstance(error, laws.LawError) else error
        raise ConfigurationError(
            [f"law={section.name} cannot be made from its parameters: {one_line(told)}"]
        ) from error
    return law, computed


@lru_cache(maxsize=4096)
def _drive(section: DriveSection, frequency: float) -> "Drive":
    from contactlab.motor.drive import Drive

    return Drive.two_mode(**section.model_dump(exclude={"frequency"}), frequency=frequency)


@lru_cache(maxsize=4096)
def _rotor(section: RotorSection) -> "Rotor":
    from contactlab.motor.motor import Rotor

    return Rotor(**section.model_dump(exclude={"radius"}))


def _geometry(checked: Configuration) -> "ContactGeometry":
    from contactlab.motor.geometry import ContactGeometry

    contact = checked.contact
    return ContactGeometry(contact.tip_length, checked.rotor.radius, contact.clearance)


def _default_step(modes: "NormalModes", law: "ContactLaw", duration: float) -> float:
    from contactlab.engine.arguments import default_contact_step

    return min(default_contact_step(modes, law), duration)


def _default_tolerance() -> float:
    from contactlab.engine.simulation import DEFAULT_TOLERANCE

    return DEFAULT_TOLERANCE


def _refuse_undamped_resonance(drive: "Drive", modes: "NormalModes") -> None:
    """Refuse a tone that meets an undamped natural frequency, where no steady state exists."""
    without = modes.damping == 0.0
    if not without.any():
        return
    faults = []
    keys = ("drive.frequency", "drive.frequency times drive.frequency_ratio")
    undamped = modes.natural_frequency[without].tolist()
    for key, tone in zip(keys, drive.frequency.tolist(), strict=True):
        for natural in undamped:
            if abs(tone - natural) <= RESONANCE * natural:
                faults.append(
                    f"{key} is {tone:.12g} Hz, a natural frequency of a resonator without damping; "
                    f"it must differ from {natural:.12g} Hz by more than {RESONANCE:g} of it. "
                    "Shift it or give resonator.stiffness_damping a number greater than 0 s."
                )
    if faults:
        raise ConfigurationError(faults)
