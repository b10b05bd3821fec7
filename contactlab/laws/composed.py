"""A compliant law composed of a normal force, a damping and a friction."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, final

from contactlab.laws.base import ContactLaw, Damping, Friction, NormalForce, PenaltyLaw
from contactlab.laws.damping import Undamped
from contactlab.laws.declaration import Coefficient, names_of
from contactlab.laws.friction import Coulomb
from contactlab.laws.memory import InternalVariable, dependent
from contactlab.laws.normal import HertzPoint
from contactlab.parameter import not_negative

VISCOUS_FRICTION = not_negative("sigma_2", "N s m-1", "viscous friction beside the friction")

OUTSIDE = {"inside_the_cone": "viscous friction is beside the cone and grows with the slip."}


def _of(part: str, name: str) -> Any:
    """Return a property that is that of a part."""
    return property(lambda law: getattr(getattr(law, part), name), doc=f"That of the part {part}.")


def _of_either(name: str) -> Any:
    """Return a property that is the friction's kernel, or that of the normal force where it has none."""
    return property(lambda law: getattr(law.friction, name) or getattr(law.normal, name), doc="As `force`.")


@final
@dataclass(frozen=True)
class Composed(PenaltyLaw):
    """Any normal force with any damping and any friction, and viscous friction beside it.

    F_f is the force of the friction. Viscous friction is that of a film or a lubricant, sigma_2 v of Canudas
    de Wit et al. (1995): in contact only, whatever the normal force, so that F jumps by it at a touch-down
    and a release that slip. It loses sigma_2 v^2 and holds no load: stick and its bound are the friction's.
    """

    name = "composed"
    equation = "N of the normal force and the damping, F = F_f - sigma_2 v"
    source = "that of its parts"
    default_contact_step = 4e-6

    normal: NormalForce = field(default_factory=HertzPoint)
    damping: Damping = field(default_factory=Undamped)
    friction: Friction = field(default_factory=Coulomb)
    viscous_friction: Annotated[float | None, VISCOUS_FRICTION] = None

    friction_kind = _of("friction", "friction_kind")
    friction_limit = _of("friction", "friction_limit")
    friction_offset = _of("friction", "friction_offset")
    coupled = _of("friction", "coupled")
    exact_stick = _of("friction", "exact_stick")
    friction_force = _of("friction", "state")
    allows_tension = _of("normal", "allows_tension")
    limits = _of("normal", "limits")
    rate = _of_either("rate")
    guard = _of_either("guard")
    jump = _of_either("jump")

    def __post_init__(self) -> None:
        super().__post_init__()
        normal = self.normal
        if not self.damping.any_force and (normal.elastic is None or normal.allows_tension):
            raise ValueError(
                f"{self.name}: damping is {self.damping.name} and normal is {normal.name}; such a damping is "
                "solved for an elastic force that does not pull. Choose damping none or another normal force."
            )
        if self.friction.limits is not None:
            raise ValueError(
                f"{self.name}: friction is {self.friction.name}, which has limits; where a contact begins "
                "and ends is the normal force's. Give them to that."
            )

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return sigma_2 [N s/m]; those of the parts are their own."""
        return {"viscous_friction": self.viscous_friction or 0.0}

    @property
    def title(self) -> str:
        """The names of the parts."""
        return f"{self.name} of {', '.join(f'{part.family} {part.name}' for part in self.parts)}"

    @property
    def parts(self) -> tuple[NormalForce, Damping, Friction]:
        """Normal force, damping and friction."""
        return self.normal, self.damping, self.friction

    @dependent
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        """The friction's, then the normal force's."""
        return *self.friction.internal_variables, *self.normal.internal_variables

    @dependent
    def guards(self) -> int:
        """The friction's and the normal force's."""
        return self.friction.guards + self.normal.guards

    @dependent
    def keeps_tolerance(self) -> bool:
        """The friction's, unless its rings follow a stiffness that has kinks: theirs end no step."""
        rate = self.friction.rate
        follows = rate is not None and "normal_stiffness_rate" in names_of(rate)
        return self.friction.keeps_tolerance and (self.normal.smooth_stiffness or not follows)

    @dependent
    def convergence_order(self) -> float:
        """That of the part which has the lower one."""
        return min(part.convergence_order for part in self.parts)

    @dependent
    def violations(self) -> Mapping[str, str]:
        """Those of the parts, and of viscous friction."""
        own = OUTSIDE if self.viscous_friction else {}
        return own | {name: reason for part in self.parts for name, reason in part.violations.items()}

    @property
    def force(self) -> Any:
        """Made from those of the parts, see `contactlab.engine.binding`."""
        return self.normal.elastic if self.normal.force is None else self.normal.force


def label_of(law: ContactLaw) -> str:
    """Return the name of a law, or those of a composed law's parts: "hertz_point + flores + mindlin"."""
    if not isinstance(law, Composed):
        return law.name
    damping = [] if law.damping.name == "none" else [law.damping.name]
    return " + ".join([law.normal.name, *damping, law.friction.name])
