"""The contact laws, and the parts that one is composed of. A new one is one class and one name in a table."""

from contactlab.laws.archard import Archard
from contactlab.laws.base import ContactLaw, Damping, Friction, MultiplierLaw, NormalForce, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.damping import (
    Flores,
    HuntCrossley,
    KuwabaraKono,
    LankaraniNikravesh,
    LinearDamping,
    Tsuji,
    Undamped,
)
from contactlab.laws.declaration import FRICTION_COEFFICIENT, RESTITUTION, LawError
from contactlab.laws.friction import (
    AgeingStick,
    BoucWen,
    Cohesive,
    Coulomb,
    Dahl,
    ElastoPlastic,
    Iwan,
    LuGre,
    Microslip,
    Mindlin,
    Nagata,
    PerrinRiceZheng,
    RateAndState,
    Regularised,
    Ruina,
    Stribeck,
    TwoState,
)
from contactlab.laws.hertz_penalty import HertzPenalty, hertz_stiffness
from contactlab.laws.impact import Brach, ChatterjeeRuina, Johnson, MoreauJean, Newton, Poisson, Stronge
from contactlab.laws.lagrange import LagrangeSlip, LagrangeStick
from contactlab.laws.lagrange_ageing import LagrangeAgeing
from contactlab.laws.memory import InternalVariable
from contactlab.laws.normal import (
    Dmt,
    ForceTable,
    HertzElliptic,
    HertzPoint,
    Jkr,
    Line,
    Linear,
    Lining,
    Maugis,
    Prony,
    Thornton,
    WaltonBraun,
    tabor_number,
)
from contactlab.laws.registry import LAWS, PARTS, law, law_class, law_names, origin_of
from contactlab.parameter import Parameter
