"""Setups of a configuration with other values of some keys; only what these change is made anew."""

from collections.abc import Callable, Collection, Mapping
from typing import Any, Final, NamedTuple, final

from contactlab.config.faults import ConfigurationError
from contactlab.config.groups import BASES, OF_BEAMS
from contactlab.config.nesting import flat, with_key
from contactlab.config.schema import RULES, Examination, Rule, numbers_in, value_of
from contactlab.config.setup import Setup, Values, assembled, law_of
from contactlab.immutable import frozen
from contactlab.laws import ContactLaw
from contactlab.laws.declaration import SHARED
from contactlab.motor import NormalModes
from contactlab.parameter import DeclaredField
from contactlab.quantity import UnitError
from contactlab.settling.criterion import STEADY

_OF_LAW: Final = ("law.", f"contact.{SHARED}", "rotor.radius")
_OF_MODES: Final = tuple(f"{group}." for group in ("resonator", *OF_BEAMS))
"""Keys that a law and the modes of a beam are made from, by what they begin with."""

_APART: Final = (
    *("contact.angle", "contact.clearance", "drive.phase", "drive.voltage_1", "drive.voltage_2"),
    *("rotor.damping", "rotor.inertia", "rotor.initial_velocity", "rotor.load_torque"),
)
"""Numbers whose ranges and relations are all that can refuse them, without preload and changes in a run of
a fixed duration."""


class _Common(NamedTuple):
    """What setups share whose configurations differ in some numbers alone.

    Args:
        source: a configuration of them, as given.
        values: of it, checked and in SI; what follows from them is not added.
        fields: declarations of the numbers that differ, by full key.
        rules: relations that these are in.
        law, modes: those of all setups; None where the numbers change them.
        apart: whether values are sound that are in their ranges and relations.
    """

    source: Values
    values: dict[str, Any]
    fields: Mapping[str, DeclaredField]
    rules: tuple[Rule, ...]
    law: ContactLaw | None
    modes: NormalModes | None
    apart: bool

    @classmethod
    def of(cls, setup: Setup, configuration: Values, keys: Mapping[str, object]) -> "_Common | None":
        """Return what a setup has in common with others; None where not only numbers may differ."""
        source = setup.origin.source if setup.origin else {}
        if not source or any(configuration[name] != section for name, section in source.items()):
            # A value that refers to another key.
            return None
        if "plant" in source:
            return None
        examined = Examination(source)
        numbers = numbers_in(source)
        if not numbers.keys() >= {*keys}:
            return None
        sound = flat(examined.values)
        # Sections that no key changes are frozen once.
        source = frozen(source)
        beam = examined.values["resonator"]["basis"] in BASES and setup.motor.preload is None
        return cls(
            source,
            examined.values,
            {key: numbers[key] for key in keys},
            tuple(rule for rule in RULES if keys.keys() & {*rule.keys} and sound.keys() >= {*rule.keys}),
            None if any(key.startswith(_OF_LAW) for key in keys) else setup.law,
            None if not beam or any(key.startswith(_OF_MODES) for key in keys) else setup.motor.modes,
            {*_APART} >= {*keys}
            and setup.motor.preload is None
            and not setup.changes
            # The period of a drive hangs on which of its tones are silent.
            and setup.until != STEADY,
        )

    def values_at(self, point: Mapping[str, Any]) -> dict[str, Any] | None:
        """Return the values with other numbers; None where one is out of its range or its relations."""
        values = self.values
        try:
            for key, value in point.items():
                values = with_key(values, key, value_of(self.fields[key], value, key))
        except UnitError:
            return None
        sound = flat(values) if self.rules else {}
        return values if all(rule.holds(*(sound[key] for key in rule.keys)) for rule in self.rules) else None

    def setup(self, point: Mapping[str, Any]) -> Setup | None:
        """Return the setup of other numbers; None where one is refused."""
        source, values = self.source, self.values_at(point)
        if values is None:
            return None
        for key, value in point.items():
            source = with_key(source, key, value)
        try:
            values = {name: dict(section) for name, section in values.items()}
            contact, rotor = values["contact"], values["rotor"]
            law = self.law or law_of(values["law"], contact[SHARED], rotor["radius"])
            return assembled(source, values, law, self.modes)
        except ConfigurationError:
            return None


@final
class Variation:
    """Makes the setups of a configuration with other values of some keys, each as if built by itself.

    The first is built from its whole configuration. Of the others, where nothing but numbers differs, the
    numbers are checked, and the relations that they are in; what they do not change is shared. One that is
    refused is built whole, so that its faults are the usual ones.

    Args:
        configuration: of which all but the keys is taken.
        build: builds a setup from a whole configuration.
    """

    def __init__(self, configuration: Values, build: Callable[[Values], Setup]) -> None:
        self._configuration, self._build = configuration, build
        self._keys: Collection[str] | None = None
        self._common: _Common | None = None

    def setup(self, point: Mapping[str, Any]) -> Setup:
        """Return the setup with these values, quickly where the call before had the same keys.

        Raises:
            ConfigurationError: with every fault.
        """
        again = point.keys() == self._keys
        if again and self._common and (shared := self._common.setup(point)):
            return shared
        configuration = self._configuration
        for key, value in point.items():
            configuration = with_key(configuration, key, value)
        setup = self._build(configuration)
        if not again:
            self._keys, self._common = point.keys(), _Common.of(setup, configuration, point)
        return setup

    def check(self, point: Mapping[str, Any]) -> None:
        """Refuse these values as `setup` does, which is called where ranges and relations do not suffice."""
        common = self._common if point.keys() == self._keys else None
        if not (common and common.apart and common.values_at(point) is not None):
            self.setup(point)
