"""Independent reference solver of the motor with contact.

Event-driven, slow, in plain shape coordinates.  It shares no code with the package it judges.
"""

from oracle.compliant import solve_hertz
from oracle.motor import OracleMotor
from oracle.resonator import Resonator, build_resonator, natural_frequencies, shapes
from oracle.rigid import solve_rigid_stick
from oracle.run import OracleRun
from oracle.slip_only import SlipOnlyRun, solve_rigid_slip

__all__ = [
    "OracleMotor",
    "OracleRun",
    "Resonator",
    "SlipOnlyRun",
    "build_resonator",
    "natural_frequencies",
    "shapes",
    "solve_hertz",
    "solve_rigid_slip",
    "solve_rigid_stick",
]
