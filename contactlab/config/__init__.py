"""From overrides or a configuration to the objects that run, and everything that can be wrong with one."""

from contactlab.config.composition import compose
from contactlab.config.faults import ConfigurationError
from contactlab.config.setup import Setup, build, validate

__all__ = ["ConfigurationError", "Setup", "build", "compose", "validate"]
