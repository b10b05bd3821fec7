"""The keys of a configuration: sections, units and ranges.

A section has no defaults; those stand in `conf/` alone, so there is one place to read them. What
binds several keys together is in `contactlab.config.rules`. The keys of a law are not written here
but made from what the law declares; see `contactlab.config.law_section`.
"""

from functools import cache
from typing import Annotated, ClassVar, Literal, final

from pydantic import Field, create_model

from contactlab.config.law_section import LawSection
from contactlab.config.quantity import Quantity
from contactlab.config.section import Section

MOST_SHAPES = 40
"""Beam shapes that `contactlab.motor.beam` vouches for; repeated here because its import takes long."""

MOST_KEPT_MODES = 40
"""Normal modes that `contactlab.motor.finite_element` vouches for; repeated for the same reason."""

MOST_FRICTION = 5.0
"""Dry solids slide on each other at 0.05 to 1.5; beyond 5 a slip of the pen is likelier."""

MOST_VOLTAGE = 1e5
"""Over patches of a millimetre; ceramics break down at some 1e3 V."""

MOST_TIME_SCALES = 1e9
"""Between the tones, and between a tone and a second, which a double tells apart within a run."""

MOST_PHASE = 1e6
"""Beyond it, a double has fewer than ten digits of the angle within a turn."""

_PAPER = "The paper's motor has {}.".format


@final
class SteelSection(Section):
    """The beam's material."""

    path: ClassVar[str] = "resonator.steel."

    youngs_modulus: Annotated[float, Quantity("Pa", above=0.0, hint="Steel has 210 GPa.")]
    poisson_ratio: Annotated[float, Quantity("1", above=-1.0, below=0.5, hint="Steel has 0.3.")]
    density: Annotated[float, Quantity("kg/m^3", above=0.0, hint="Steel has 7850 kg/m^3.")]


class ResonatorSection(Section):
    """The beam with its tip, whatever basis it is computed in."""

    path: ClassVar[str] = "resonator."

    length: Annotated[float, Quantity("m", above=0.0, hint=_PAPER("0.057 m"))]
    width: Annotated[float, Quantity("m", above=0.0, hint=_PAPER("0.016 m"))]
    beam_thickness: Annotated[float, Quantity("m", above=0.0, hint=_PAPER("0.001 m"))]
    patch_thickness: Annotated[float, Quantity("m", above=0.0, hint=_PAPER("0.001 m"))]
    tip_mass: Annotated[float, Quantity("kg", at_least=0.0, hint="0 is a beam without tip.")]
    tip_inertia: Annotated[float, Quantity("kg m^2", at_least=0.0, hint="0 is a point mass.")]
    mass_damping: Annotated[float, Quantity("1/s", at_least=0.0, hint="0 switches it off.")]
    stiffness_damping: Annotated[float, Quantity("s", at_least=0.0, hint="0 switches it off.")]
    steel: SteelSection


@final
class RitzSection(ResonatorSection):
    """The paper's basis: eigenshapes of the bare beam."""

    basis: Literal["ritz"]
    shapes: Annotated[
        int, Quantity("1", at_least=1, at_most=MOST_SHAPES, whole=True, hint="The paper takes 4.")
    ]


@final
class FiniteElementSection(ResonatorSection):
    """The converged basis: normal modes of finite elements."""

    basis: Literal["finite_element"]
    kept_modes: Annotated[
        int,
        Quantity(
            "1",
            at_least=1,
            at_most=MOST_KEPT_MODES,
            whole=True,
            hint="The static correction stands for the modes beyond.",
        ),
    ]
    static_correction: bool


_CeramicDensity = Annotated[float, Quantity("kg/m^3", above=0.0, hint="PZ26 has 7700 kg/m^3.")]
_Permittivity = Annotated[float, Quantity("F/m", above=0.0, hint="PZ26 has 6.2e-09 F/m.")]
_Elastic = Annotated[float, Quantity("Pa")]
_PositiveElastic = Annotated[float, Quantity("Pa", above=0.0)]
_Coupling = Annotated[float, Quantity("C/m^2")]


@final
class BendingSection(Section):
    """A piezoceramic by its modulus and coupling in bending."""

    path: ClassVar[str] = "piezoceramic."

    constants: Literal["bending"]
    bending_modulus: Annotated[float, Quantity("Pa", above=0.0, hint="PZ26 has about 94 GPa.")]
    bending_coupling: _Coupling
    density: _CeramicDensity
    permittivity: _Permittivity


@final
class TensorSection(Section):
    """A piezoceramic by the constants of its datasheet."""

    path: ClassVar[str] = "piezoceramic."

    constants: Literal["tensor"]
    c11: _PositiveElastic
    c12: _Elastic
    c13: _Elastic
    c33: _PositiveElastic
    e31: _Coupling
    e33: _Coupling
    poisson_ratio: Annotated[float, Quantity("1", hint="PZ26 has 0.334.")]
    density: _CeramicDensity
    permittivity: _Permittivity


@final
class PlacementSection(Section):
    """Where the first patch set lies."""

    path: ClassVar[str] = "placement."

    start: Annotated[float, Quantity("m", at_least=0.0, hint="0 is the clamp.")]
    end: Annotated[float, Quantity("m", above=0.0, hint="It is measured from the same clamp.")]


_Voltage = Annotated[
    float,
    Quantity(
        "V",
        at_least=-MOST_VOLTAGE,
        at_most=MOST_VOLTAGE,
        hint=_PAPER("100 V"),
    ),
]


@final
class DriveSection(Section):
    """Two tones."""

    path: ClassVar[str] = "drive."

    voltage_1: _Voltage
    voltage_2: _Voltage
    frequency: Annotated[
        float | None,
        Quantity(
            "Hz",
            at_least=1.0 / MOST_TIME_SCALES,
            at_most=MOST_TIME_SCALES,
            none=True,
            hint="Leave it out for the first natural frequency.",
        ),
    ]
    frequency_ratio: Annotated[
        float,
        Quantity(
            "1",
            at_least=1.0 / MOST_TIME_SCALES,
            at_most=MOST_TIME_SCALES,
            hint="The paper takes 2.",
        ),
    ]
    phase: Annotated[
        float,
        Quantity(
            "rad",
            at_least=-MOST_PHASE,
            at_most=MOST_PHASE,
            hint="Whole turns change nothing but the last digits.",
        ),
    ]


@final
class ContactSection(Section):
    """What every law shares."""

    path: ClassVar[str] = "contact."

    tip_length: Annotated[float, Quantity("m", above=0.0, hint=_PAPER("0.019 m"))]
    clearance: Annotated[
        float,
        Quantity("m", at_least=0.0, hint="A motor that is pressed together at rest is no option."),
    ]
    friction_coefficient: Annotated[
        float,
        Quantity(
            "1",
            at_least=0.0,
            at_most=MOST_FRICTION,
            hint="Dry solids have 0.05 to 1.5, and 0 is frictionless.",
        ),
    ]


@final
class RotorSection(Section):
    """The rotor."""

    path: ClassVar[str] = "rotor."

    radius: Annotated[float, Quantity("m", above=0.0, hint=_PAPER("0.025 m"))]
    inertia: Annotated[float, Quantity("kg m^2", above=0.0, hint=_PAPER("4.8e-05 kg m^2"))]
    damping: Annotated[float, Quantity("N m s/rad", at_least=0.0, hint="0 switches it off.")]
    load_torque: Annotated[
        float,
        Quantity(
            "N m",
            hint="It acts towards negative rotation: a positive one brakes positive rotation.",
        ),
    ]
    initial_velocity: Annotated[float, Quantity("rad/s")]


@final
class SolverSection(Section):
    """How long and how finely."""

    path: ClassVar[str] = "solver."

    duration: Annotated[float, Quantity("s", above=0.0, hint="A usual run lasts 0.02 s.")]
    contact_step: Annotated[
        float | None,
        Quantity("s", above=0.0, none=True, hint="Leave it out for the law's own default."),
    ]
    tolerance: Annotated[
        float | None,
        Quantity(
            "1",
            at_least=1e-14,
            at_most=1e-2,
            none=True,
            hint="Leave it out for the solver's own default.",
        ),
    ]


@final
class RecordSection(Section):
    """What is kept."""

    path: ClassVar[str] = "record."

    interval: Annotated[float, Quantity("s", above=0.0, hint="1e-06 s is usual.")]
    picture: bool


class Configuration(Section):
    """A whole configuration, every number in SI; see `configuration_with` for the law's keys."""

    path: ClassVar[str] = ""

    law: LawSection
    resonator: Annotated[RitzSection | FiniteElementSection, Field(discriminator="basis")]
    piezoceramic: Annotated[BendingSection | TensorSection, Field(discriminator="constants")]
    placement: PlacementSection
    drive: DriveSection
    contact: ContactSection
    rotor: RotorSection
    solver: SolverSection
    record: RecordSection


KINDS = {"resonator": "basis", "piezoceramic": "constants"}
"""The groups whose keys depend on a choice, and the key that tells which was made; that of the law
is told by its name, and made from its declarations."""


def group_told_by(key: str) -> str:
    """The group whose choice a key tells, 'law/normal' for 'law.normal.name'; empty for other keys."""
    section, _, last = key.rpartition(".")
    told_by = "name" if section.partition(".")[0] == "law" else KINDS.get(section)
    return section.replace(".", "/") if last == told_by else ""


@cache
def configuration_with(law: type[LawSection]) -> type[Configuration]:
    """The keys of a configuration with one law."""
    return create_model("Configuration", __base__=Configuration, law=(law, ...))
