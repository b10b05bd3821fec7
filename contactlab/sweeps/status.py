"""What became of a run of a sweep, as a code that a dataset can hold."""

from enum import IntEnum

from contactlab.trajectory import Ending


class Status(IntEnum):
    """What became of a run; one that reached its end has numbers, a complete or an unbalanced one."""

    COMPLETE = 0
    DIVERGED = 1
    """Its state was no longer a motor's."""
    CHATTERED = 2
    """Its contact made no progress."""
    INTERRUPTED = 3
    """Somebody pressed Ctrl-C."""
    FAILED = 4
    """It raised an exception, or could not be written."""
    UNFINISHED = 5
    """It began and has not ended: killed, or still running."""
    REFUSED = 6
    """Its configuration is faulty, though each of its values alone is not."""
    ABSENT = 7
    """It has not begun."""
    UNBALANCED = 8
    """It reached its end, but its energy ledger is open."""
    STALLED = 9
    """Its law let it take no step, or too many."""
    INCONSISTENT = 10
    """Its law had no impulse for a contact that closes."""


def status_of(ending: Ending) -> Status:
    """The status of a run that ended in some way."""
    return Status[ending.name]
