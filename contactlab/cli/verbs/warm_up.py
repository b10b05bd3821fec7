"""Compile the engine ahead, for laws of every kind, so that no run has to wait for it.

A run compiles what it needs by itself, once for an installation; this does it for all at once, in a minute or
two, before a class, a sweep or jobs on a cluster.
"""

from time import perf_counter
from typing import Final

from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE

FAMILIES: Final = (
    ["law=hertz_penalty"],
    ["law=lagrange_stick"],
    ["law=composed", "law/normal=walton_braun"],
    ["law=lagrange_ageing"],
)
"""A law of each kind that the engine is compiled for."""

DURATION: Final = 2e-6
"""Of the run that loads a loop [s]."""


def main(arguments: list[str]) -> int:
    """Compile or load every loop, and print for each which it was and how long it took."""
    Parser(__name__, __doc__).read(arguments)
    # Imported here: they bring the compiler, which --help does not need.
    from contactlab.compiler.folders import code_folder, shipped_folder
    from contactlab.compiler.kernels import INTERPRETED
    from contactlab.compiler.notice import telling
    from contactlab.config import build
    from contactlab.engine.binding import bind
    from contactlab.engine.compiled_loops import name_of, units_of
    from contactlab.impacts import velocities_after
    from contactlab.laws.base import ContactLaw, PenaltyLaw
    from contactlab.laws.composed import Composed
    from contactlab.laws.registry import LAWS, PARTS

    if INTERPRETED:
        print("NUMBA_DISABLE_JIT asks for no compiled code: there is nothing to compile.")
        return COMPLETE
    whole = perf_counter()
    for overrides in FAMILIES:
        setup = build(overrides)
        compliant, plain = isinstance(setup.law, PenaltyLaw), bind(setup.law).plain
        for impacts in (False, True):
            began = perf_counter()
            with telling() as compiled:
                if impacts:
                    velocities_after(setup.law, [[1.0, 0.0], [0.0, 3.5]], [-1.0, 0.5])
                else:
                    setup.run(duration=DURATION, record_interval=DURATION)
            done = "compiled" if compiled.functions else "loaded"
            name = name_of(units_of(compliant, impacts), plain)
            print(f"{done} in {perf_counter() - began:4.1f} s  {name}", flush=True)
    # What makes a law's own functions of its kernels.
    made: list[ContactLaw] = [law() for law in LAWS.values()]
    for family, parts in PARTS.items():
        made += (Composed(**{family: part()}) for part in parts.values())  # type: ignore[arg-type]
    for law in made:
        bind(law)
    seconds = perf_counter() - whole
    print(f"The engine is ready after {seconds:.0f} s; its code is in {shipped_folder() or code_folder()}.")
    return COMPLETE
