"""`contactlab warm-up`: the engine compiled ahead, for laws of every kind."""

from time import perf_counter
from typing import Final

from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE

LAWS: Final = (
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
    parser = Parser(
        "warm-up",
        ". A run compiles what it needs by itself, once for an installation; this does it for all at once, "
        "in a minute or two, before a class, a sweep or jobs on a cluster.",
    )
    parser.read(arguments)
    # Imported here: they bring the compiler, which --help does not need.
    from contactlab.compiler.kernels import INTERPRETED, code_folder
    from contactlab.compiler.notice import telling
    from contactlab.config import build
    from contactlab.engine.binding import bind
    from contactlab.engine.preparation import LOOPS, SECONDS, kind_of
    from contactlab.impacts import velocities_after
    from contactlab.laws.base import PenaltyLaw

    if INTERPRETED:
        print("NUMBA_DISABLE_JIT asks for no compiled code: there is nothing to compile.")
        return COMPLETE
    width, whole = max(map(len, SECONDS)), perf_counter()
    for overrides in LAWS:
        setup = build(overrides)
        # An impact of a compliant law is integrated as a run is.
        for impacts in (False,) if isinstance(setup.law, PenaltyLaw) else (False, True):
            began = perf_counter()
            with telling() as compiled:
                if impacts:
                    velocities_after(setup.law, [[1.0, 0.0], [0.0, 3.5]], [-1.0, 0.5])
                else:
                    setup.run(duration=DURATION, record_interval=DURATION)
            done = "compiled" if LOOPS & {*compiled.functions} else "was there, loaded"
            kind = kind_of(bind(setup.law), impacts)
            print(f"{kind:<{width}}  {done} in {perf_counter() - began:.1f} s", flush=True)
    seconds = perf_counter() - whole
    print(f"The engine is ready after {seconds:.0f} s; its code is kept in {code_folder()}.")
    return COMPLETE
