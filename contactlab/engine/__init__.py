"""The engine: exact free flight, located touch-down, and in-contact steppers for both families of laws."""

from contactlab.engine.simulation import Ends, Flow, Simulator, simulate, simulator_of

__all__ = ["Ends", "Flow", "Simulator", "simulate", "simulator_of"]
