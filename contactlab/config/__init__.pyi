from contactlab.config.composition import compose as compose
from contactlab.config.faults import ConfigurationError as ConfigurationError
from contactlab.config.setup import Setup as Setup, build as build, rebuild as rebuild, validate as validate
