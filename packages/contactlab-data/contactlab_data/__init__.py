"""Contact laws from measurements: files, fits, validation, and numbers of laws from single quantities.

    from contactlab_data import fit

Its names are those that it adds to `contactlab`; type checkers know them here alone, as `contactlab` may be
installed without it. A module is imported when a name of it, declared in `__init__.pyi`, is first used.
"""

from contactlab.lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
