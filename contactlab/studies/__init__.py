"""Studies: questions put to motors, each declared once, with one runner, one page and one path of tables."""

from contactlab.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
