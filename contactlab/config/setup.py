"""From a configuration to the objects that run; all its faults are reported at once.

See `contactlab.config.groups` for keys, units and ranges, `contactlab.config.schema` for relations of keys.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import lru_cache, reduce
from html import escape
from pathlib import Path
from shlex import join
from typing import Any, Final, final

from contactlab.checks import check_records, checked_arguments
from contactlab.config.changes import changed
from contactlab.config.composition import completed, compose, differences, overridden, parsed
from contactlab.config.faults import ConfigurationError, as_fault, faults_added, one_line
from contactlab.config.made_in_python import PLACES, with_number
from contactlab.config.motors import motor_of, named_file
from contactlab.config.nesting import flat
from contactlab.config.numbers import Number, numbers_of
from contactlab.config.options import groups
from contactlab.config.schema import Examination, declared_in
from contactlab.engine.arguments import check_kinds
from contactlab.engine.defaults import run_numbers
from contactlab.engine.equilibrium import at_rest
from contactlab.engine.preparation import take_in
from contactlab.engine.simulation import simulate
from contactlab.foreign import is_own
from contactlab.immutable import Frozen, frozen
from contactlab.laws import ContactLaw, LawError
from contactlab.laws.declaration import SHARED
from contactlab.laws.registry import build_law, classes_of, law_class
from contactlab.motor import Motor, NormalModes
from contactlab.motor.table import keep
from contactlab.results.netcdf import contents_of, settings_of
from contactlab.results.yaml_text import write_yaml
from contactlab.settling.criterion import PRECISION, STEADY, Until, check_until_steady
from contactlab.settling.until import simulate_until_steady
from contactlab.trajectory import Ending, Trajectory

Values = Mapping[str, Any]

_PLACED: Final = {
    section: {key: name for name, (group, key) in PLACES.items() if group == section}
    for section, _ in PLACES.values()
}
"""Attributes of a setup that are numbers of a run, by section and key."""


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
        contact_step: largest step in contact of a compliant law, or the step of a rigid law's time stepping
            [s]; None of a rigid law in its limit of no step.
        tolerance: relative tolerance in contact [1]; None for time stepping, which has none.
        until: 'duration', or 'steady' to end once the motor has settled, at the latest after the duration.
        precision: share by which a motor may be off its steady state where a run until then ends [1].
        changes: times after the start [s], and the motor from each on.
        origin: the configuration from which motor, law and changes were built, None if they were made in
            Python.

    Attributes:
        configuration: the numbers that run, in SI, all resolved, read-only; building it again gives the same
            setup. That of a motor made in Python has the numbers that are keys.
    """

    motor: Motor
    law: ContactLaw
    duration: float
    record_interval: float
    contact_step: float | None
    tolerance: float | None
    until: Until = "duration"
    precision: float = PRECISION
    changes: tuple[tuple[float, Motor], ...] = ()
    origin: "Origin | None" = field(default=None, repr=False, compare=False)
    configuration: Frozen = field(init=False)

    def __post_init__(self) -> None:
        origin, motor = self.origin, self.motor
        if origin is not None and origin.is_of(self):
            configuration = {**origin.configuration}
            if motor.rotor is not origin.motor.rotor:
                configuration["rotor"] = {**configuration["rotor"], **asdict(motor.rotor)}
        else:
            configuration = settings_of(self.motor, self.law)
            if self.changes:
                changes = [f"{time!r}; another motor" for time, _ in self.changes]
                configuration["solver"] = {"changes": changes}
        for section, keys in _PLACED.items():
            numbers = {key: getattr(self, name) for key, name in keys.items()}
            before = configuration.get(section, {})
            if any(before.get(key, self) is not number for key, number in numbers.items()):
                configuration[section] = {**before, **numbers}
        object.__setattr__(self, "configuration", frozen(configuration))

    @classmethod
    @checked_arguments(duration="s", record_interval="s", contact_step="s", tolerance="1")
    def of(
        cls,
        motor: Motor,
        law: ContactLaw,
        duration: float,
        record_interval: float | None = None,
        contact_step: float | None = None,
        tolerance: float | None = None,
    ) -> "Setup":
        """Return the setup of a motor and a law made in Python, with the defaults of `contactlab.simulate`.

            >>> import contactlab as cl
            >>> cl.Setup.of(cl.ball(1e-3, height=1e-4), cl.Newton(restitution=0.5), "20 ms").duration
            0.02

        Raises:
            TypeError: the motor or the law is of another kind.
        """
        check_kinds(motor, law)
        numbers = run_numbers(motor, law, duration, record_interval, contact_step, tolerance)
        return cls(motor, law, duration, *numbers)

    @property
    def made_in_python(self) -> bool:
        """Whether motor or law are others than its configuration would give."""
        return self.origin is None or not self.origin.is_of(self)

    def with_(self, *overrides: str | Mapping[str, Any]) -> "Setup":
        """Return the setup with other values of keys, or other options of groups, composed and checked anew.

            >>> import contactlab as cl
            >>> setup = cl.build().with_("contact.clearance=0.5 um", "law=newton")
            >>> setup.motor.geometry.clearance, setup.law.name
            (5e-07, 'newton')

        A mapping of keys to values in SI is taken as it is, and is fast enough for a slider:

            >>> cl.build().with_({"drive.voltage_1": 90.0}, {"law": "newton"}).source["drive"]["voltage_1"]
            90.0

        What follows from other keys, such as a drive at the first natural frequency, follows from the new
        values. A motor made in Python has the numbers of contact, rotor, law and solver, and
        drive.frequency.

        Args:
            overrides: texts as of `contactlab.build`, or mappings of full keys to values and of groups to the
                names of options.

        Raises:
            ConfigurationError: with every fault.
        """
        texts = [each for each in overrides if isinstance(each, str)]
        options, values = parsed(texts) if texts else ({}, {})
        for each in overrides:
            if isinstance(each, Mapping):
                chosen = {key: value for key, value in each.items() if key in groups()}
                options |= chosen
                values |= {key: value for key, value in each.items() if key not in chosen}
        if self.made_in_python:
            if options:
                fault = f"{next(iter(options))} is an option; a motor made in Python must have KEY=VALUE."
                raise ConfigurationError(fault)
            return reduce(lambda setup, item: with_number(setup, *item), values.items(), self)
        return rebuild(overridden(self.source, options, values))

    def numbers(self) -> dict[str, Number]:
        """Return the numbers of what is selected by full key: value, default, unit, meaning, ranges, choices.

            >>> import contactlab as cl
            >>> numbers = cl.build(["law=composed", "law/friction=dahl"]).numbers()
            >>> numbers["law.normal.stiffness"].value, numbers["drive.voltage_1"].usual
            (10000000000.0, (0.0, 200.0))

        Of a motor made in Python they are those that `with_` takes.
        """
        return numbers_of(self, self.configuration, self.made_in_python)

    def command(self, verb: str = "") -> str:
        """Return the command that runs the setup, or puts a study to it: `contactlab steady law=newton`.

        Raises:
            ConfigurationError: the motor was made in Python, which no command can say.
        """
        return join(["contactlab", *([verb] if verb else []), *self._differences])

    def python(self) -> str:
        """Return the lines of Python that make the setup, as `setup`; errors as of `command`."""
        lines = "".join(f"\n    {line!r}," for line in self._differences)
        return f"import contactlab as cl\n\nsetup = cl.build([{lines}{lines and chr(10)}])\n"

    def yaml(self) -> str:
        """Return the whole configuration as YAML, which `build` takes once read; errors as of `command`."""
        self._refuse_made("a configuration")
        return write_yaml(self.source)

    @property
    def _differences(self) -> list[str]:
        self._refuse_made("a command")
        return differences(self.source)

    def _refuse_made(self, text: str) -> None:
        if self.made_in_python:
            fault = f"The motor was made in Python; {text} must be of one that keys describe."
            raise ConfigurationError(fault)

    @property
    def source(self) -> dict[str, Any]:
        """The configuration as given, with the numbers that have changed since; nothing of it is derived."""
        origin = self.origin
        if origin is None:
            return {**self.configuration}
        source = {name: dict(section) for name, section in origin.source.items()}
        for name, (section, key) in PLACES.items():
            if getattr(self, name) != origin.configuration[section][key]:
                source[section][key] = getattr(self, name)
        rotor = self.configuration["rotor"]
        source["rotor"] |= {k: x for k, x in rotor.items() if x != origin.configuration["rotor"][k]}
        return source

    def __repr__(self) -> str:
        if self.made_in_python:
            numbers = ", ".join(f"{key}={value}" for key, value in flat(self.configuration).items())
            return f"<Setup of a motor made in Python: {numbers}>"
        return f"contactlab.build({differences(self.source)})"

    def _repr_html_(self) -> str:
        """Show every key with its value, unit and meaning as a table in a notebook."""
        declared = declared_in(self.configuration)
        rows = []
        for key, value in flat(self.configuration).items():
            about = declared.get(key)
            texts = key, f"{value}{about.label if about else ''}", about.meaning if about else ""
            name, *cells = map(escape, texts)
            rows.append(f"<tr><th>{name}</th>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
        return f"<table>{''.join(rows)}</table>"

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
        duration, interval = arguments.pop("duration"), arguments.pop("record_interval")
        ends = [*(time for time, _ in self.changes if time < duration), duration]
        name = "The record interval, record_interval,"
        check_records(duration, interval, name, len(self.law.internal_variables), len(ends))
        motors = [self.motor, *(motor for _, motor in self.changes)]
        run, done = None, 0.0
        for motor, end in zip(motors, ends, strict=False):
            length = end - done
            piece = function(
                motor, self.law, duration=length, record_interval=min(interval, length), **arguments
            )
            run = piece if run is None else run.followed_by(piece)
            if not piece.ending.reached_end:
                break
            arguments["start"], done = piece.state, end
        assert run is not None
        if run.ending is Ending.INTERRUPTED and not keep_interrupted:
            raise KeyboardInterrupt(run.message)
        return run


@final
@dataclass(frozen=True, eq=False)
class Origin:
    """A configuration, as given and with all that follows from it, and what was built from it."""

    source: Mapping[str, Any]
    configuration: Mapping[str, Any]
    motor: Motor
    law: ContactLaw
    changes: tuple[tuple[float, Motor], ...]
    files: tuple[bytes, ...]

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        for content in self.files:
            keep(content, recorded=True)

    def is_of(self, setup: Setup) -> bool:
        """Return whether a setup runs what was built, the rotor's numbers and those of the run apart."""
        parts = ("modes", "drive", "geometry", "preload", "start")
        same = all(getattr(setup.motor, name) is getattr(self.motor, name) for name in parts)
        return same and setup.changes is self.changes and setup.law == self.law


@checked_arguments()
def build(configuration: Values | Sequence[str] = (), config_dir: str | Path | None = None) -> Setup:
    """Check a configuration and build the motor and the law from it; without arguments, the default run.

        >>> build(["law=newton", "contact.clearance=0.5 um"]).motor.geometry.clearance
        5e-07

    Args:
        configuration: overrides as on the command line, ["law=newton", "drive.phase=0"], or a mapping of
            groups, each the name of an option or a mapping of keys, with numbers in SI or texts with units:
            {"law": "newton", "contact.clearance": "0.5 um"}, or nested. What is absent has its default.
        config_dir: folder with further options of groups, `config_dir/experiment/mine.yaml`, as --config-dir
            of the command.

    Raises:
        ConfigurationError: with every fault.
    """
    make: Any = completed if isinstance(configuration, Mapping) else compose
    return rebuild(make(configuration, config_dir))


def rebuild(configuration: Values) -> Setup:
    """Check a whole configuration, such as a recorded one, and build from it; nothing may be absent."""
    return assembled(configuration, *_checked(configuration))


def assembled(
    configuration: Values, values: dict[str, Any], law: ContactLaw, modes: NormalModes | None = None
) -> Setup:
    """Return the setup of a checked configuration.

    Args:
        configuration: as given.
        values: of it, checked and in SI; what follows from them is added.
        law: that of the values.
        modes: those of the values, where they are known.

    Raises:
        ConfigurationError: the sections do not fit each other, or a file cannot be used.
    """
    motor = motor_of(values, modes)
    solver, record, changes = values["solver"], values["record"], values["solver"]["changes"] or ()
    duration, step = solver["duration"], solver["contact_step"]
    numbers = run_numbers(motor, law, duration, record["interval"], step, solver["tolerance"])
    record["interval"], step, solver["tolerance"] = numbers
    solver["contact_step"] = None if step is None else min(step, duration)
    with as_fault():
        more, parts = len(law.internal_variables), len(changes) + 1
        check_records(duration, record["interval"], "record.interval", more, parts)
    if (preload := values["contact"]["preload"]) is not None:
        with as_fault(f"contact.preload is {preload:g} N. ", LawError):
            motor = at_rest(motor, law)
    later = tuple((time, motor_of(_checked(each)[0])) for time, each in changed(values, changes, duration))
    if solver["until"] == STEADY:
        with as_fault():
            check_until_steady(motor.drive, record["interval"])
    # What follows from the rotor takes its place in the configuration.
    of_law = {key for key, value in values["law"].items() if not isinstance(value, str | dict)}
    values["law"] |= {key: getattr(law, key) for key in of_law}
    arguments = {name: values[section][key] for name, (section, key) in PLACES.items()}
    files = tuple(contents_of(values).values())
    origin = Origin(frozen({**configuration}), frozen(values), motor, law, later, files)
    return Setup(motor, law, **arguments, changes=later, origin=origin)


def validate(configuration: Values) -> dict[str, Any]:
    """Check a configuration, building nothing but its law, and return it in SI; errors as of `build`."""
    return _checked(configuration)[0]


def _checked(configuration: Values) -> tuple[dict[str, Any], ContactLaw]:
    examined = Examination(configuration)
    law, faults = None, examined.faults
    contact, rotor = (examined.values.get(name, {}) for name in ("contact", "rotor"))
    if SHARED in contact and "radius" in rotor and not any(f.startswith("law") for f in faults):
        with faults_added(faults):
            law = law_of(examined.values["law"], contact[SHARED], rotor["radius"])
    if faults or law is None:
        raise ConfigurationError(faults)
    return examined.values, law


# A sweep over anything else asks for the same law again and again.
_take_in_once = lru_cache(maxsize=4096)(take_in)


def law_of(values: Values, friction_coefficient: float, rotor_radius: float) -> ContactLaw:
    """Return the law of a section, on a rotor of a radius [m]; a ConfigurationError if it cannot be made.

    Path and digest of a file are completed in the section.
    """
    name = values["name"]
    sections: dict[str, Any] = {
        "law": values,
        **{f"law.{key}": x for key, x in values.items() if isinstance(x, dict)},
    }
    for key, section in sections.items():
        if section.get("file") is not None:
            named_file(key, section)
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
        for key, section in sections.items():
            if reason.startswith(opening := f"{section['name']}: "):
                sentence = f"{key}.{reason.removeprefix(opening)}"
        raise ConfigurationError(sentence) from error
