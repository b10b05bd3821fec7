"""Compare contact laws of standing-wave piezoelectric motors on one resonator model.

    import contactlab as cl

    solution = cl.simulate(cl.build(["law=newton", "contact.clearance=0.5 um"]))
    print(solution)
    solution.save("run.nc")

What a script needs stands here: a motor is made of a resonator's modes, a drive, a geometry and a rotor,
`simulate` runs it with a law, and `compare` judges laws side by side. The names, each with the module that
defines it, are declared in `__init__.pyi`; a module is imported when a name of it is first used. Other
packages add names by entry points of the group `contactlab.names`.
"""

from contactlab.lazy import attach

_get, _own_names, __all__ = attach(__name__, __file__)


def __getattr__(name: str) -> object:
    if name == "__version__":
        # Imported here: it reads the metadata of every library.
        from contactlab.results.provenance import versions

        return versions()["contactlab_version"]
    try:
        return _get(name)
    except AttributeError:
        if name.startswith("_"):
            raise
    # Imported here, as below: it takes as long as the rest of the package.
    from contactlab.packages import added

    return added(name)


def __dir__() -> list[str]:
    from contactlab.packages import names

    return sorted({*_own_names(), *names()})
