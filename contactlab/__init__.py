"""Compare contact laws of standing-wave piezoelectric motors on one resonator model.

    import contactlab as cl

    solution = cl.simulate(cl.build(["law=newton", "contact.clearance=0.5 um"]))
    print(solution)
    solution.save("run.nc")

What a script needs stands here: a motor is made of a resonator's modes, a drive, a geometry and a rotor,
`simulate` runs it with a law, and `compare` judges laws side by side. The names, each with the module that
defines it, are declared in `__init__.pyi`; a module is imported when a name of it is first used.
"""

import ast
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path


def _declared() -> dict[str, str]:
    """Return the module that each public name is imported from."""
    stub = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    return {alias.name: str(node.module) for node in imports for alias in node.names}


_MODULES = _declared()
__all__ = ["__version__", *_MODULES]


def __getattr__(name: str) -> object:
    if name in _MODULES:
        value: object = getattr(import_module(_MODULES[name]), name)
    elif name == "__version__":
        value = import_module("contactlab.results.provenance").versions()["contactlab_version"]
    elif name.isidentifier() and not name.startswith("_") and find_spec(f"{__name__}.{name}"):
        return import_module(f"{__name__}.{name}")
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
