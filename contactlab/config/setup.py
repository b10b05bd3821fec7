"""From a configuration to the objects that run; all its faults are reported at once.

See `contactlab.config.groups` for keys, units and ranges, `contactlab.config.schema` for relations of keys.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, final

from contactlab.config.composition import compose
from contactlab.config.faults import ConfigurationError, one_line
from contactlab.config.groups import BASES, NOT_OF_A_RUN
from contactlab.config.nesting import flat, nested
from contactlab.config.schema import FRICTION, Examination
from contactlab.engine.preparation import DEFAULT_TOLERANCE, default_contact_step, take_in
from contactlab.engine.simulation import simulate
from contactlab.foreign import is_own
from contactlab.laws import ContactLaw, LawError, PenaltyLaw
from contactlab.laws.registry import build_law, classes_of, law_class
from contactlab.motor import (
    ContactGeometry,
    Drive,
    Motor,
    NormalModes,
    Piezoceramic,
    PiezoceramicDatasheet,
    Rotor,
    Steel,
)
from contactlab.settling.until import PRECISION, STEADY, Until, check_until_steady, simulate_until_steady
from contactlab.trajectory import Ending, Trajectory

RESONANCE = 1e-9
"""Relative distance at which an undamped tone counts as at a natural frequency."""

Values = Mapping[str, Any]


@final
@dataclass(frozen=True)
class Setup:
    """A run, ready to start: the arguments of `contactlab.engine.simulation` and their origin.

        >>> import contactlab as cl
        >>> setup = cl.build(["law=newton", "solver.duration=5 ms"])
        >>> setup.law.name, setup.duration, setup.configuration["contact"]["clearance"]
        ('newton', 0.005, 1e-06)

    Args:
        motor, law: what runs.
        duration, record_interval: simulated time, and time between records [s].
        contact_step: largest step in contact [s], the default of law and motor where none was given.
        tolerance: relative tolerance in contact [1]; None for a law that takes none.
        configuration: the numbers that run, in SI, all resolved; building it again gives the same setup.
        until: 'duration', or 'steady' to end once the motor has settled, at the latest after the duration.
        precision: share by which a motor may be off its steady state where a run until then ends [1].
    """

    motor: Motor
    law: ContactLaw
    duration: float
    record_interval: float
    contact_step: float
    tolerance: float | None
    configuration: dict[str, Any]
    until: Until = "duration"
    precision: float = PRECISION

    def run(self, *, keep_interrupted: bool = False, **others: Any) -> Trajectory:
        """Simulate it, with other arguments of `contactlab.engine.simulate` beside or in place of its own.

        Raises:
            KeyboardInterrupt: somebody pressed Ctrl-C, unless what there is by then is to be kept.
        """
        names = ["duration", "record_interval", "contact_step", "tolerance"]
        if self.until == STEADY:
            names.append("precision")
        arguments = {name: getattr(self, name) for name in names} | others
        function = simulate_until_steady if self.until == STEADY else simulate
        trajectory = function(self.motor, self.law, **arguments)
        if trajectory.ending is Ending.INTERRUPTED and not keep_interrupted:
            raise KeyboardInterrupt(trajectory.message)
        return trajectory


def build(configuration: Values | Sequence[str] = ()) -> Setup:
    """Check a configuration and build the motor and the law from it; without arguments, the default run.

        >>> build(["law=newton", "contact.clearance=0.5 um"]).motor.geometry.clearance
        5e-07

    Args:
        configuration: overrides as on the command line, ["law=newton", "drive.phase=0"], or a whole
            configuration: a mapping of groups of keys, with numbers in SI or texts with units.

    Raises:
        ConfigurationError: with every fault.
    """
    if isinstance(configuration, str):
        raise TypeError(f"configuration is {configuration!r}; it must be a list of overrides or a mapping.")
    if not isinstance(configuration, Mapping):
        configuration = compose(configuration)
    values, law = _checked(configuration)
    resolved = {group: keys for group, keys in values.items() if group not in NOT_OF_A_RUN}
    drive, solver, contact = resolved["drive"], resolved["solver"], resolved["contact"]
    rotor = dict(resolved["rotor"])
    geometry = ContactGeometry(contact["tip_length"], rotor.pop("radius"), contact["clearance"])
    resonator = {group: resolved[group] for group in ("resonator", "piezoceramic", "placement")}
    modes = _modes(tuple(flat(resonator).items()))
    first = drive["frequency"]
    if first is None:
        drive["frequency"] = float(modes.natural_frequency[0])
    tones = _two_mode(**drive)
    _refuse_undamped_resonance(first, tones, modes)
    if solver["until"] == STEADY:
        _refuse_unseen_periods(tones, resolved["record"]["interval"])
    # What follows from the rotor takes its place in the configuration.
    numbers = {key for key, value in resolved["law"].items() if not isinstance(value, str | dict)}
    resolved["law"] |= {key: getattr(law, key) for key in numbers}
    if solver["contact_step"] is None:
        solver["contact_step"] = min(default_contact_step(modes, law), solver["duration"])
    if isinstance(law, PenaltyLaw) and solver["tolerance"] is None:
        solver["tolerance"] = DEFAULT_TOLERANCE
    motor = Motor(modes, tones, geometry, Rotor(**rotor))
    interval = resolved["record"]["interval"]
    return Setup(motor, law, record_interval=interval, **solver, configuration=resolved)


def validate(configuration: Values) -> dict[str, Any]:
    """Check a configuration, building nothing but its law, and return it in SI; errors as of `build`."""
    return _checked(configuration)[0]


def _checked(configuration: Values) -> tuple[dict[str, Any], ContactLaw]:
    examined = Examination(configuration)
    law, sound, faults = None, flat(examined.values), examined.faults
    if {FRICTION, "rotor.radius"} <= sound.keys() and not any(f.startswith("law") for f in faults):
        try:
            law = _law(examined.values["law"], sound[FRICTION], sound["rotor.radius"])
        except ConfigurationError as error:
            faults += error.faults
    if faults or law is None:
        raise ConfigurationError(faults)
    return examined.values, law


# A sweep over anything else asks for the same law, drive and resonator again and again.
_take_in_once = lru_cache(maxsize=4096)(take_in)
_two_mode = lru_cache(maxsize=256)(Drive.two_mode)


@lru_cache(maxsize=256)
def _modes(values: tuple[tuple[str, Any], ...]) -> NormalModes:
    """Return the modes of a resonator by its sections, flat."""
    resonator, constants, placement = nested(dict(values)).values()
    if constants.pop("constants") == "bending":
        piezoceramic = Piezoceramic(**constants)
    else:
        piezoceramic = PiezoceramicDatasheet(**constants).in_bending()
    resonator |= {"steel": Steel(**resonator["steel"]), "piezoceramic": piezoceramic}
    resonator |= {f"patch_{edge}": place for edge, place in placement.items()}
    try:
        modes: NormalModes = BASES[resonator.pop("basis")](**resonator).modes
    except ValueError as error:
        raise ConfigurationError([f"resonator, piezoceramic or placement: {error}"]) from error
    return modes


def _law(values: Values, friction_coefficient: float, rotor_radius: float) -> ContactLaw:
    name = values["name"]
    try:
        law: ContactLaw = build_law(law_class(name), values, friction_coefficient)
        # Those of this package are sound, and their kernels are not needed yet.
        if not all(map(is_own, classes_of(law))):
            _take_in_once(law)
        return law.on_rotor(rotor_radius)
    # A law of another package may refuse, or fail, in ways of its own.
    except Exception as error:
        # What the law itself raised is in the sentence already.
        reason = one_line(LawError(*error.args) if isinstance(error, LawError) else error)
        sentence = f"law={name} cannot be made from its parameters: {reason}"
        if reason.startswith(f"{name}: "):
            sentence = f"law.{reason.removeprefix(f'{name}: ')}"
        raise ConfigurationError([sentence]) from error


def _refuse_unseen_periods(drive: Drive, interval: float) -> None:
    try:
        check_until_steady(drive, interval)
    except ValueError as error:
        raise ConfigurationError([str(error)]) from error


def _refuse_undamped_resonance(frequency: float | None, drive: Drive, modes: NormalModes) -> None:
    """Refuse a tone that meets an undamped natural frequency, where no steady state exists."""
    null = " null, that is the first natural frequency," if frequency is None else ""
    keys = (f"drive.frequency is{null}", "drive.frequency times drive.frequency_ratio is")
    faults = [
        f"{key} {tone:.12g} Hz, an undamped natural frequency with unbounded response; it must differ from "
        f"{natural:.12g} Hz by more than {RESONANCE:g} of it, or resonator.stiffness_damping be positive."
        for key, tone in zip(keys, drive.frequency.tolist(), strict=True)
        for natural in modes.natural_frequency[modes.damping == 0.0].tolist()
        if abs(tone - natural) <= RESONANCE * natural
    ]
    if faults:
        raise ConfigurationError(faults)
