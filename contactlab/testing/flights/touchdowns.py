"""No touch-down is missed: random flights, judged by a dense closed-form reference."""

from collections.abc import Iterator

from contactlab.testing.claim import Claim, at_least, at_most
from contactlab.testing.flights.randomly import fly

FLIGHTS, SEED = 1000, 0


def random_touchdowns() -> Iterator[Claim]:
    """Flights that touch, graze by less than a nanometre, dip twice, or dip between two samples."""
    for kind, tally in fly(SEED, range(FLIGHTS)).items():
        words = f"random flights, {kind}"
        yield at_least(f"{words}: of them touch", tally.touched, 1)
        for fault, count in (
            ("missed", tally.missed),
            ("late", tally.late),
            ("invented", tally.invented),
        ):
            yield at_most(f"{words}: touch-downs {fault} of {tally.flights} flights", count, 0)
