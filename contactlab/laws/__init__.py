"""The contact laws, and the parts that one is composed of. A new one is one class and one name in a table."""

from contactlab.laws.base import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.damping import (
    Flores,
    HuntCrossley,
    LankaraniNikravesh,
    LinearDamping,
    Undamped,
)
from contactlab.laws.declaration import FRICTION_COEFFICIENT, RESTITUTION, LawError
from contactlab.laws.friction import Coulomb, ElastoPlastic, LuGre, Mindlin, Regularised
from contactlab.laws.hertz_penalty import HertzPenalty, hertz_stiffness
from contactlab.laws.impact_process import Poisson, Stronge
from contactlab.laws.lagrange_slip import LagrangeSlip
from contactlab.laws.lagrange_stick import LagrangeStick
from contactlab.laws.newton import MoreauJean, Newton
from contactlab.laws.normal import HertzElliptic, HertzPoint, Line, Linear, Lining
from contactlab.laws.part import Damping, Friction, NormalForce
from contactlab.laws.registry import LAWS, PARTS, law, law_class, law_names, origin_of
from contactlab.parameter import Parameter
