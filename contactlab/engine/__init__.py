"""The engine: exact free flight, located touch-down, and in-contact steppers for both families of laws."""

from contactlab.engine.flow import Ends, Flow
from contactlab.engine.simulation import prepare, simulate

__all__ = ["Ends", "Flow", "prepare", "simulate"]
