"""How far something long has come: a bar on a terminal, elsewhere a sentence where it takes long."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import final

BAR_AFTER = 1.5
"""Seconds before a bar appears; most runs are over by then."""

LOOK_AFTER = 5.0
"""Seconds of work from which the time that is left is estimated."""

WORTH_SAYING = 60.0
"""Seconds that must be left for a sentence."""


@contextmanager
def progress(total: float, unit: str, what: str) -> Iterator[Callable[[float], None]]:
    """Show how far something has come.

    Args:
        total: all of it.
        unit: of the total.
        what: is being done, the subject of a sentence.

    Yields:
        The function to tell what is done of the total so far.
    """
    if not sys.stderr.isatty():
        yield _Estimate(total, what)
        return
    from tqdm import tqdm

    with tqdm(
        total=total,
        delay=BAR_AFTER,
        leave=False,
        file=sys.stderr,
        bar_format="{percentage:3.0f} %|{bar}| {n:.6g} of {total:.6g} "
        + unit
        + ", {remaining} left",
    ) as bar:

        def advance(done: float) -> None:
            bar.update(done - bar.n)

        yield advance


@final
class _Estimate:
    """Says once how long it will take, from what was done in the first seconds."""

    def __init__(self, total: float, what: str) -> None:
        self._total = total
        self._what = what
        self._began = 0.0
        self._said = False

    def __call__(self, done: float) -> None:
        # What comes before the first of it, a compiler's time, says nothing of the rest.
        self._began = self._began or perf_counter()
        spent = perf_counter() - self._began
        if self._said or spent < LOOK_AFTER or not 0.0 < done < self._total:
            return
        self._said = True
        left = spent * (self._total - done) / done
        if left > WORTH_SAYING:
            print(
                f"{self._what}: {done / self._total:.2%} is done in {spent:.0f} s, about {_spelled(left)} "
                "are left.",
                file=sys.stderr,
                flush=True,
            )


def _spelled(seconds: float) -> str:
    """A long time in the unit that one thinks in."""
    for unit, size in (("days", 86400.0), ("hours", 3600.0)):
        if seconds > 2.0 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds / 60.0:.2g} minutes"
