"""Every recorded quantity once: name, dimensions, unit and meaning, for dataset and recorder alike."""

from dataclasses import dataclass, field
from functools import cache
from typing import Final, final


@final
@dataclass(frozen=True)
class Variable:
    """One recorded quantity.

    `cell_methods` says in the words of the CF conventions what a value stands for where it is not a point;
    `flags` names the values of an enumerated quantity, in the order 0, 1, 2, ...; `comment` is a sentence,
    `standard_name` that of the CF conventions, where there is one.
    """

    name: str
    dims: tuple[str, ...]
    units: str
    symbol: str
    long_name: str
    cell_methods: str = ""
    flags: tuple[str, ...] = field(default=(), kw_only=True)
    comment: str = field(default="", kw_only=True)
    standard_name: str = field(default="", kw_only=True)


def _along(dimension: str, *rows: tuple[str, ...]) -> tuple[Variable, ...]:
    return tuple(Variable(name, (dimension,), *rest) for name, *rest in rows)


_MEAN: Final = "time: mean (over the record interval that ends at the time)"

TIME: Final = Variable(
    "time", ("time",), "s", "t", "time since the drive was switched on", standard_name="time"
)

SERIES: Final = _along(
    "time",
    ("tip_normal_displacement", "m", "u", "displacement of the beam's centre"),
    ("tip_tangential_displacement", "m", "L_x", "displacement of the tip end along the rotor"),
    ("tip_slope", "rad", "theta", "slope of the beam at its centre"),
    ("gap", "m", "g", "normal gap between tip and rotor, positive when open"),
    ("slip_velocity", "m s-1", "v", "tip minus rotor surface velocity, tangential"),
    ("rotor_velocity", "rad s-1", "Omega", "angular velocity of the rotor"),
    ("rotor_angle", "rad", "alpha", "angle of the rotor since the start"),
    ("normal_force", "N", "N", "normal force on the tip, mean over the record interval", _MEAN),
    ("friction_force", "N", "F", "friction force on the tip, mean over the record interval", _MEAN),
    ("kinetic_energy", "J", "T", "kinetic energy of resonator and rotor"),
    ("strain_energy", "J", "V", "strain energy of the resonator"),
    ("contact_energy", "J", "V_c", "energy stored in the contact"),
    ("drive_work", "J", "W_d", "work of the drive on the resonator since the start"),
    ("damping_loss", "J", "W_c", "loss in the resonator's and the rotor's viscous damping"),
    ("friction_loss", "J", "W_f", "loss in friction"),
    ("contact_loss", "J", "W_n", "loss in normal damping and impacts"),
    ("load_work", "J", "W_l", "work of the rotor on the load torque"),
    ("energy_residual", "J", "r", "energy that the ledger cannot account for"),
)
"""Real-valued root variables over time."""

BEARING: Final = Variable(
    "rotor_normal_displacement",
    ("time",),
    "m",
    "w",
    "displacement of the rotor on its bearing, away from the tip",
)
"""A root variable of motors whose rotor is on a bearing."""


@cache
def of_electrode(number: int) -> tuple[Variable, ...]:
    """Return charge and current of an electrode, root variables of motors whose capacitance is known."""
    return _along(
        "time",
        (f"charge_{number}", "C", f"Q_{number}", f"charge of electrode {number}"),
        (f"current_{number}", "A", f"I_{number}", f"current into electrode {number}"),
    )


POINT: Final = "point_"
"""What the name of a point's displacement begins with."""


@cache
def of_point(name: str) -> tuple[Variable, ...]:
    """Return displacement and velocity of a point of the structure, root variables of motors that have it."""
    return _along(
        "time",
        (f"{POINT}{name}", "m", f"x_{name}", f"displacement of the point {name}"),
        (f"{POINT}{name}_velocity", "m s-1", f"v_{name}", f"velocity of the point {name}"),
    )


CONTACT_MODE: Final = Variable(
    "contact_mode", ("time",), "1", "m", "state of the contact", flags=("free", "slip", "stick")
)

INTERNAL: Final = "internal_"
"""What the name of an internal variable of a law begins with, and no other; see `results.netcdf`."""

RESONATOR: Final = (
    Variable(
        "natural_frequency",
        ("mode",),
        "Hz",
        "f",
        "undamped natural frequency; pseudo-modes of a static correction come last",
    ),
    Variable("damping_ratio", ("mode",), "1", "zeta", "damping ratio"),
    Variable(
        "electromechanical_coupling",
        ("shape", "electrode"),
        "N V-1",
        "Gamma",
        "generalised force per voltage on a shape psi of int psi^2 dx = L: beam shapes (ritz) or "
        "modes (finite_element); electrode 0 is the patch set as placed, 1 its mirror",
    ),
)

CONTACTS: Final = _along(
    "contact",
    ("start_time", "s", "t_s", "time of the touch-down"),
    ("duration", "s", "t_c", "time from touch-down to the end of the forces"),
    ("stick_duration", "s", "t_st", "part of the duration that sticks"),
    ("normal_impulse", "N s", "p_n", "time integral of the normal force"),
    ("friction_impulse", "N s", "p_t", "time integral of the friction force"),
    ("peak_normal_force", "N", "N_max", "largest normal force; infinite with an impact"),
    ("max_penetration", "m", "d_max", "largest penetration"),
    ("approach_velocity", "m s-1", "gdot_0", "gap rate at touch-down, negative"),
    (
        "separation_velocity",
        "m s-1",
        "gdot_1",
        "gap rate at release; missing for a contact that the end of the run cut",
    ),
    ("energy_loss", "J", "W", "friction and contact loss of the contact, until the next begins"),
)

IMPACTS: Final = _along(
    "contact",
    ("peak_lasting_force", "N", "N_l", "largest normal force while the contact lasts, impacts left out"),
    ("largest_impact", "N s", "p_i", "largest normal impulse of an impact"),
    ("impact_energy_gain", "J", "W_g", "kinetic energy that impacts created"),
)
"""Further variables of contacts under rigid laws."""

SUMS: Final = {
    *("duration", "stick_duration", "normal_impulse", "friction_impulse"),
    *("energy_loss", "impact_energy_gain"),
}
"""Variables of a contact that add up while it lasts."""

EXTREMES: Final = {"peak_normal_force", "max_penetration", "peak_lasting_force", "largest_impact"}
"""Variables of a contact that are the largest of it."""
