from power_law import PowerLaw

from contactlab.testing import LawContract


class TestPowerLaw(LawContract):
    law = PowerLaw()
