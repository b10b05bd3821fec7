"""The contract of every part of a composed law, each in a law that is Hertz and Coulomb but for it."""

from contactlab.laws.composed import Composed
from contactlab.laws.damping import DAMPINGS, Flores, LinearDamping
from contactlab.laws.friction import FRICTIONS, LuGre, Mindlin
from contactlab.laws.normal import NORMAL_FORCES, Line
from contactlab.testing import LawContract

LAWS = {
    "Normal": {name: Composed(normal=part()) for name, part in NORMAL_FORCES.items()},
    "Damping": {name: Composed(damping=part()) for name, part in DAMPINGS.items()},
    "Friction": {name: Composed(friction=part()) for name, part in FRICTIONS.items()},
    "Mixed": {
        "line_flores_mindlin": Composed(Line(), Flores(0.6), Mindlin(0.2)),
        "hertz_linear_lugre": Composed(damping=LinearDamping(0.7), friction=LuGre(0.4, 1.3)),
    },
}

for family, laws in LAWS.items():
    for name, law in laws.items():
        words = f"Test{family}_{name}"
        globals()[words] = type(words, (LawContract,), {"law": law})
