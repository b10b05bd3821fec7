"""Compare contact laws of standing-wave piezoelectric motors on one resonator model.

    import contactlab as cl

    solution = cl.simulate(cl.build(["law=newton", "contact.clearance=0.5 um"]))
    print(solution)
    solution.save("run.nc")

What a script needs stands here: a motor is made of a resonator's modes, a drive, a geometry and a rotor,
`simulate` runs it with a law, and `compare` judges laws side by side.
"""

from contactlab.comparison import compare
from contactlab.config import ConfigurationError, Setup, build
from contactlab.laws import (
    Composed,
    ContactLaw,
    Coulomb,
    Damping,
    ElastoPlastic,
    Flores,
    Friction,
    HertzElliptic,
    HertzPenalty,
    HertzPoint,
    HuntCrossley,
    LagrangeSlip,
    LagrangeStick,
    LankaraniNikravesh,
    LawError,
    Line,
    Linear,
    LinearDamping,
    Lining,
    LuGre,
    Mindlin,
    MoreauJean,
    MultiplierLaw,
    Newton,
    NormalForce,
    PenaltyLaw,
    Poisson,
    Regularised,
    Stronge,
    Undamped,
    hertz_stiffness,
    law,
    law_names,
)
from contactlab.motor import (
    ContactGeometry,
    Drive,
    FiniteElementResonator,
    ModalState,
    Motor,
    NormalModes,
    Piezoceramic,
    RitzResonator,
    Rotor,
    Steel,
)
from contactlab.parameter import Parameter
from contactlab.results.provenance import versions
from contactlab.simulation import Solution, load, simulate
from contactlab.trajectory import Ending

__version__ = versions()["contactlab_version"]

__all__ = [
    "Composed",
    "ConfigurationError",
    "ContactGeometry",
    "ContactLaw",
    "Coulomb",
    "Damping",
    "Drive",
    "ElastoPlastic",
    "Ending",
    "FiniteElementResonator",
    "Flores",
    "Friction",
    "HertzElliptic",
    "HertzPenalty",
    "HertzPoint",
    "HuntCrossley",
    "LagrangeSlip",
    "LagrangeStick",
    "LankaraniNikravesh",
    "LawError",
    "Line",
    "Linear",
    "LinearDamping",
    "Lining",
    "LuGre",
    "Mindlin",
    "ModalState",
    "MoreauJean",
    "Motor",
    "MultiplierLaw",
    "Newton",
    "NormalForce",
    "NormalModes",
    "Parameter",
    "PenaltyLaw",
    "Piezoceramic",
    "Poisson",
    "Regularised",
    "RitzResonator",
    "Rotor",
    "Setup",
    "Solution",
    "Steel",
    "Stronge",
    "Undamped",
    "__version__",
    "build",
    "compare",
    "hertz_stiffness",
    "law",
    "law_names",
    "load",
    "simulate",
]
