"""Processes that share work: how many there may be, and how they begin and end."""

import gc
import multiprocessing
import os
import signal
import threading
import warnings
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from multiprocessing.pool import Pool

FORKS: Final = "fork" in multiprocessing.get_all_start_methods()
"""Whether a process of this system can have the memory of another."""


class WorkerError(RuntimeError):
    """A worker process died, or has other code than the process that keeps its results."""


def processors() -> int:
    """Count the processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def forked_pool(count: int) -> "Pool":
    """Return a pool of workers that have what this process has in memory."""
    # Python warns of threads (those of the linear algebra) that a fork does not have.
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "This process", DeprecationWarning)
        return multiprocessing.get_context("fork").Pool(count, begin_worker)


def begin_worker() -> None:
    """Make this process a worker, whose parent alone answers signals and whose end is that of its parent."""
    # A fork has the command's handlers too: signals to the whole group are for that to answer.
    for name in ("SIGINT", "SIGUSR1", "SIGUSR2"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    # What is there stays as it is: looking it over would copy the memory that a fork shares.
    gc.freeze()
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process as soon as nobody waits for it any more: a command that is killed tells nobody."""
    if (parent := multiprocessing.parent_process()) is not None:
        parent.join()
        os._exit(1)
