"""From overrides or a configuration to the objects that run, and everything that can be wrong with one."""

from contactlab.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
