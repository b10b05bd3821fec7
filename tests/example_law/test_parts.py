from parts import Ageing, Stiffening

from contactlab.laws import Composed
from contactlab.testing import LawContract


class TestParts(LawContract):
    law = Composed(normal=Stiffening(), friction=Ageing())
