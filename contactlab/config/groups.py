"""The groups of a run's configuration, as the classes declare them: options, keys, units, ranges, defaults.

To add a group is to add a line to `GROUPS`; what binds several keys together is in
`contactlab.config.schema`. Options that differ from the declared defaults are files in `conf/`.

Another package brings a resonator by an entry point in its pyproject.toml:

    [project.entry-points."contactlab.resonators"]
    ring = "their_module:Ring"

It is a dataclass whose fields are declared numbers, as those of a law, with a property `modes`, the
`contactlab.NormalModes`. It is imported when it is chosen.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, is_dataclass, replace
from functools import cache, partial
from importlib.metadata import EntryPoint, entry_points
from typing import Annotated, Any, Final, Literal, TypeAlias, final

from contactlab import motor
from contactlab.checks import Checked
from contactlab.laws.declaration import SHARED, family_of, members_of
from contactlab.laws.lagrange import LagrangeSlip
from contactlab.laws.registry import PARTS, class_of, law_names
from contactlab.motor import (
    Chirp,
    FiniteElementResonator,
    RitzResonator,
    Sawtooth,
    TwoMode,
    TwoPhase,
    Vibration,
)
from contactlab.motor.modal import ModalFile
from contactlab.motor.plant import declared_arguments
from contactlab.parameter import DeclaredField, Parameter, declared_fields, positive
from contactlab.settling.criterion import LONGEST, PRECISION, Until
from contactlab.settling.verdict import SHARE

RESONATORS: Final = "contactlab.resonators"
"""Group of the entry points of resonators."""

BASES: Final = {"ritz": RitzResonator, "finite_element": FiniteElementResonator}
"""The bases of the beam."""

MODAL: Final = "modal"
"""The basis of a file."""

OF_BEAMS: Final = ("piezoceramic", "placement")
"""Groups of the beam, of which no other resonator has anything."""

OWN_RESONATORS: Final[Mapping[str, type]] = {**BASES, MODAL: ModalFile}


@cache
def other_resonators() -> dict[str, EntryPoint]:
    """Return the resonators of other packages by name."""
    return {point.name: point for point in entry_points(group=RESONATORS) if point.name not in OWN_RESONATORS}


def resonator_class(name: str) -> type:
    """Return the class of a resonator; a ValueError where another package's cannot be one."""
    if name in OWN_RESONATORS:
        return OWN_RESONATORS[name]
    try:
        owner: Any = other_resonators()[name].load()
    # Whatever a module of somebody else's does while it is imported, it is that resonator's fault alone.
    except (Exception, SystemExit) as error:
        raise ValueError(f"It cannot be imported ({type(error).__name__}: {error}).") from error
    if not (isinstance(owner, type) and is_dataclass(owner) and hasattr(owner, "modes")):
        raise ValueError("It must be a dataclass with a property `modes`.")
    return owner


Interpolation = Literal["linear", "cubic", "quintic", "septic"]

_FILE: Final = Parameter("", "1", "CSV or netCDF file")
_DIGEST: Final = Parameter("", "1", "digest of the file", hint="null takes the file as it is.")
_PERIOD: Final = positive("T", "s", "time after which the samples repeat themselves", hint="null is once.")
_INTERPOLATION: Final = Parameter("", "1", "spline through the samples")


@final
@dataclass(frozen=True)
class Tones(Checked):
    """Tones of a file: frequency, and voltage_1, phase_1, voltage_2 ..., U_e = V_e sin(2 pi f t + phi_e)."""

    file: Annotated[str, _FILE]
    digest: Annotated[str | None, _DIGEST] = None


@final
@dataclass(frozen=True)
class Sampled(Checked):
    """Samples of a file: time, and voltage_1, voltage_2 ... of every electrode; zero before and after."""

    file: Annotated[str, _FILE]
    digest: Annotated[str | None, _DIGEST] = None
    interpolation: Annotated[Interpolation, _INTERPOLATION] = "cubic"
    period: Annotated[float | None, _PERIOD] = None


SIGNALS: Final[dict[str, type]] = {
    "two_mode": TwoMode,
    "two_phase": TwoPhase,
    "tones": Tones,
    "sampled": Sampled,
    "chirp": Chirp,
}
"""What drives the electrodes, by the names of the options."""


MOTOR: Final = "motor"
"""Option of the group `plant` that is the motor of the other groups."""

PLANTS: Final = {
    make.__name__: make
    for make in (motor.ball, motor.belt, motor.block, motor.cantilever, motor.oscillator, motor.slider)
}
"""Small plants in place of the motor of the other groups: functions, whose numbers are the keys."""

MOTIONS: Final[dict[str, type]] = {"table": Vibration, "base": Vibration, "tip": Sawtooth}
"""Arguments of plants that are motions, by the kind that keys describe."""

OF_MOTOR: Final = ("resonator", "piezoceramic", "placement", "drive", "contact", "rotor")
"""Groups of which a plant has nothing but the friction coefficient that laws share."""

DURATION: Final = 0.02
"""Duration of a run where none is configured [s]."""

_declared = partial(Parameter, "", "1")
_DURATION = positive(
    "T",
    "s",
    "simulated time, at most that with solver.until=steady",
    hint=f"Leave it out for {DURATION:g} s, or at most {LONGEST:g} s with solver.until=steady.",
)
_PRECISION = positive(
    "",
    "1",
    "share by which a motor may be off its steady state where solver.until=steady ends its run",
    at_most=SHARE,
)
_STEP = positive(
    "h",
    "s",
    "largest step in contact of a compliant law, step of the time stepping of a rigid one",
    hint="Leave it out for that of the law.",
)
_INTERVAL = positive(
    "", "s", "time between records", hint="Leave it out for 1 us, or longer for slow motors that run long."
)
_TOLERANCE = Parameter(
    "",
    "1",
    "relative tolerance in contact, not of time stepping",
    at_least=1e-14,
    at_most=1e-2,
    hint="Leave it out for the solver's own default.",
)
_UNTIL = _declared("end at the duration, or when the motor has settled, then at the latest")
_CHANGES = _declared("changes during the run, a text each: 'TIME; KEY=VALUE; KEY=VALUE'")


@final
@dataclass(frozen=True)
class Solver(Checked):
    """How long and how finely to integrate."""

    duration: Annotated[float | None, _DURATION] = None
    until: Annotated[Until, _UNTIL] = "duration"
    precision: Annotated[float, _PRECISION] = PRECISION
    contact_step: Annotated[float | None, _STEP] = None
    tolerance: Annotated[float | None, _TOLERANCE] = None
    changes: Annotated[list[str] | None, _CHANGES] = None


@final
@dataclass(frozen=True)
class Record(Checked):
    """What is kept; it does not change the motion."""

    interval: Annotated[float | None, _INTERVAL] = None
    picture: Annotated[bool, _declared("whether run.png is drawn; it takes long")] = True


Keys: TypeAlias = dict[str, "DeclaredField | Section"]


@final
@dataclass(frozen=True)
class Section:
    """A section of a configuration.

    Args:
        options: the keys of each option.
        selector: the key that selects an option.
        labels: the options by the values of that key, where those are not their names.
    """

    options: Mapping[str, Keys]
    selector: str = ""
    labels: Mapping[str, str] | None = None

    @property
    def labelled(self) -> Mapping[str, str]:
        """The options by the values of the selector; none is imported."""
        return self.labels or {option: option for option in self.options}


@final
@dataclass(frozen=True)
class Options(Mapping[str, Keys]):
    """The keys of options by name, each imported when its keys are read.

    Args:
        names: returns the names.
        keys_by_name: returns the keys of an option; a ValueError says what is wrong with one that is broken.
    """

    names: Callable[[], Collection[str]]
    keys_by_name: Callable[[str], Keys]

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def __len__(self) -> int:
        return len(self.names())

    def __getitem__(self, name: str) -> Keys:
        if name not in self.names():
            raise KeyError(name)
        return self.keys_by_name(name)


def keys_of(owner: type, *without: str) -> Keys:
    """Return the keys that a class declares, those of objects in its fields included."""
    return {
        name: field if field.parameter else Section({name: keys_of(field.kind)})
        for name, field in declared_fields(owner).items()
        if name not in without
    }


def named(key: str, name: str, keys: Keys) -> Keys:
    """Return the keys of an option that is selected by its name."""
    return {key: DeclaredField(Literal[name], name, None), **keys}


def _narrowed(field: DeclaredField, **changes: Any) -> DeclaredField:
    """Return a field that the configuration declares more narrowly than its class."""
    assert field.parameter is not None
    return replace(field, parameter=replace(field.parameter, **changes))


def _optional(field: DeclaredField, hint: str) -> DeclaredField:
    """Return a field of a number that may be null in the configuration, which the hint explains."""
    return replace(_narrowed(field, hint=hint), kind=field.kind | None, default=None)


def keys_of_plant(make: Callable[..., Any]) -> Keys:
    """Return the keys of a small plant, those of its motions included."""
    keys: Keys = {}
    for name, field in declared_arguments(make).items():
        if field.is_number:
            keys[name] = field
        elif name in MOTIONS:
            own = keys_of(MOTIONS[name])
            if field.default is None:
                # The first number says whether there is a motion.
                first, declared = next(iter(own.items()))
                assert isinstance(declared, DeclaredField)
                own[first] = _optional(declared, "null is none.")
            keys[name] = Section({"default": own})
    return keys


_BEAM: Final = declared_fields(motor.PatchedBeam)
_CONTACT: Final = declared_fields(motor.ContactGeometry)
_BEARING_FIELDS: Final = declared_fields(motor.Bearing)
_PRELOAD: Final = _optional(
    _BEARING_FIELDS["preload"], "null is a fixed axle, which holds the rotor at the clearance."
)
_BEARING: Final = {
    "mass": _optional(_BEARING_FIELDS["mass"], "null is that of a disc of this inertia and radius."),
    "bearing_stiffness": _BEARING_FIELDS["stiffness"],
    "bearing_damping": _BEARING_FIELDS["damping"],
}
_OF_OTHERS: Final = ("patch_start", "patch_end", "piezoceramic")


GROUPS: Final[dict[str, Section]] = {
    "resonator": Section(
        Options(
            lambda: [*OWN_RESONATORS, *other_resonators()],
            lambda name: named("basis", name, keys_of(resonator_class(name), *_OF_OTHERS)),
        ),
        "basis",
    ),
    "piezoceramic": Section(
        {
            "pz26_identified": named("constants", "bending", keys_of(motor.Piezoceramic)),
            "pz26_datasheet": named("constants", "tensor", keys_of(motor.PiezoceramicDatasheet)),
        },
        "constants",
        {"bending": "pz26_identified", "tensor": "pz26_datasheet"},
    ),
    "placement": Section({"placement_2": {"start": _BEAM["patch_start"], "end": _BEAM["patch_end"]}}),
    "drive": Section(
        {name: named("signal", name, keys_of(kind)) for name, kind in SIGNALS.items()}, "signal"
    ),
    "contact": Section(
        {
            "default": {
                "tip_length": _CONTACT["tip_length"],
                "clearance": _narrowed(
                    _CONTACT["clearance"],
                    at_least=0.0,
                    usual=(0.0, 5e-6),
                    hint="A rotor that is pressed on the tip has a contact.preload.",
                ),
                "angle": _narrowed(_CONTACT["angle"], usual=(-0.3, 0.3)),
                "preload": _PRELOAD,
                SHARED: _narrowed(
                    declared_fields(LagrangeSlip)[SHARED],
                    at_most=5.0,
                    usual=(0.0, 1.0),
                    hint="Dry solids have 0.05 to 1.5, and 0 is frictionless.",
                ),
            }
        }
    ),
    "rotor": Section({"default": {"radius": _CONTACT["rotor_radius"], **keys_of(motor.Rotor), **_BEARING}}),
    "solver": Section({"default": keys_of(Solver)}),
    "record": Section({"default": keys_of(Record)}),
    "plant": Section(
        {
            MOTOR: named("name", MOTOR, {}),
            **{name: named("name", name, keys_of_plant(make)) for name, make in PLANTS.items()},
        },
        "name",
    ),
}
"""The groups of a run but that of the laws, in the order of a configuration."""

ADDED: Final = (
    *("resonator.residual_mass", "resonator.damping_ratio", "resonator.rod_length"),
    *("piezoceramic.loss_tangent", "piezoceramic.free_permittivity", "drive.signal"),
    *("contact.angle", "contact.preload", "rotor.mass", "rotor.bearing_stiffness", "rotor.bearing_damping"),
    *("solver.changes", "solver.until", "solver.precision"),
)
"""Keys that an option file of one's own may leave out: their defaults are those of the motor of the paper."""


@cache
def keys_of_law(owner: Any) -> Keys:
    """Return the keys of a law or a part; a ValueError if a field cannot be one."""
    members = {name: field for name, field in members_of(owner).items() if name != SHARED}
    keys = {name: FAMILIES.get(family_of(field), field) for name, field in members.items()}
    return named("name", owner.name, keys)


def _laws_of(family: str) -> Section:
    """Return the section of the laws, or of the parts of a family."""
    return Section(
        Options(partial(law_names, family), lambda name: keys_of_law(class_of(name, family))), "name"
    )


FAMILIES: Final = {family: _laws_of(family) for family in PARTS}
"""The parts of the composed law."""

LAW: Final = _laws_of("")
"""The laws."""
