"""What the compiler is at, told while one waits: what is compiled, how long it has taken and will take."""

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from shutil import get_terminal_size
from time import perf_counter, process_time
from typing import Never, final

from numba import __version__
from numba.core import event
from tqdm import tqdm

from contactlab.compiler.folders import of_version, shipped, shipped_folder
from contactlab.progress import is_shown, tell_progress

SURE = 1.0
"""Time of a processor from which the pace is known [s]."""

_BAR = "{percentage:3.0f} %|{bar}| {n:.0f} of about {total:.0f} s{postfix}"


@final
class Compiled(event.Listener):
    """Counts the functions that the compiler makes, loaded ones left out, and tells of them.

    Args:
        what: is compiled; empty to tell nothing.
        usual: time of an idle processor that all of it usually takes [s].

    Attributes:
        functions: the names of those that there are so far.
    """

    def __init__(self, what: str = "", usual: float = 0.0) -> None:
        self.functions: list[str] = []
        self._what, self._usual = what, usual
        self._began: tuple[float, float] | None = None
        self._bar: tqdm[Never] | None = None

    def on_start(self, _: event.Event) -> None:
        """Announce the first function, which is the sign that not all is there."""
        if self._began is not None or not self._what:
            return
        self._began = perf_counter(), process_time()
        versions = [] if shipped_folder() else sorted(each.name for each in shipped().glob(of_version("*")))
        other = "of other sources" if of_version(__version__) in versions else f"for {', '.join(versions)}"
        came = f" (what came with the package is {other})" if versions else ""
        _say(f"compiling {self._what}, once for an installation: about {self._usual:.0f} s{came}.")
        # tqdm shows nothing on a terminal that does not tell its size.
        columns, lines = get_terminal_size()
        # Where another line tells of the progress, it tells of this too.
        hidden = True if is_shown() else None
        self._bar = tqdm(
            total=self._usual, bar_format=_BAR, leave=False, disable=hidden, ncols=columns, nrows=lines
        )

    def on_end(self, made: event.Event) -> None:
        """Count a function, and show how far it is at the pace that there was so far."""
        self.functions.append(made.data["dispatcher"].__name__)
        if self._began is None or self._bar is None:
            return
        spent = self._elapsed
        # Whoever shares the processor waits longer.
        pace = spent / max(process_time() - self._began[1], SURE)
        total = max(self._usual * max(pace, 1.0), spent)
        if is_shown():
            tell_progress(f"compiling {self._what}, {spent:.0f} of about {total:.0f} s")
            return
        self._bar.total, self._bar.n = total, spent
        self._bar.set_postfix_str(self.functions[-1])

    def close(self) -> None:
        """Print how long it took."""
        if self._bar is not None:
            self._bar.close()
            _say(f"compiled in {self._elapsed:.0f} s.")

    @property
    def _elapsed(self) -> float:
        return perf_counter() - self._began[0] if self._began else 0.0


@contextmanager
def telling(what: str = "", usual: float = 0.0) -> Iterator[Compiled]:
    """Report on standard error what the compiler makes meanwhile, and collect no garbage until it has ended.

    Arguments are those of `Compiled`.
    """
    compiled, collected = Compiled(what, usual), gc.isenabled()
    # Most of what a compiler makes stays: to look through it for garbage would take a tenth of its time.
    gc.disable()
    try:
        with event.install_listener("numba:compile", compiled):
            yield compiled
    finally:
        if collected:
            gc.enable()
    compiled.close()


def _say(sentence: str) -> None:
    # A line of progress that stands there is drawn again below.
    start = "\r\x1b[K" if is_shown() and sys.stderr.isatty() else ""
    print(f"{start}contactlab: {sentence}", file=sys.stderr, flush=True)
