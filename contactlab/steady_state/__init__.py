"""Steady states of a motor: periodic orbits, their stability and branches, and means where there is none."""

from contactlab.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
