"""Files that stand under their name only when whole, and whether a run's file is still what the run left.

A file is written under a temporary name beside its own. What a killed process has left of it is removed
once it is a day old.
"""

import errno
import json
import os
import secrets
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import file_digest
from pathlib import Path
from stat import S_ISREG
from types import FrameType
from typing import Final

DATASET: Final = "run.nc"
STATE: Final = "state.json"
LOG: Final = "run.log"
"""The files of a run's folder; the log is there for a run that raised an exception."""

STALE_AFTER: Final = 24 * 3600.0
"""Age [s] from which a temporary file counts as left behind: what is being written changes all the time."""

_WITHOUT_LINKS: Final = (errno.EPERM, errno.ENOTSUP, errno.ENOSYS)
"""How a file system tells that a file cannot have two names."""

_ENDING: Final = ("SIGTERM", "SIGHUP", "SIGXCPU")
"""Signals that end a process at once where nobody handles them, as of a cluster whose time is up."""

_writing: Final[set[Path]] = set()
"""Temporary files of this process."""


def remove_own() -> None:
    """Remove the temporary files that this process writes, as before it ends at once."""
    for partial in tuple(_writing):
        with suppress(OSError):
            partial.unlink(missing_ok=True)


def _end(number: int, _: FrameType | None) -> None:
    remove_own()
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """Let signals that would end the process at once remove its temporary files before."""
    numbers = []
    if os.name == "posix" and threading.current_thread() is threading.main_thread():
        every = (getattr(signal, name) for name in _ENDING)
        numbers = [number for number in every if signal.getsignal(number) is signal.SIG_DFL]
    for number in numbers:
        signal.signal(number, _end)
    try:
        yield
    finally:
        for number in numbers:
            signal.signal(number, signal.SIG_DFL)


@contextmanager
def whole_file(path: Path, *, fresh: bool = False) -> Iterator[Path]:
    """Let the body write a file under a temporary name that becomes `path` only when it is whole.

    The temporary file lies beside `path`, is synchronised with the disk and then takes the name;
    whatever stops this before, a keyboard interrupt or a signal that ends the process too, removes it. What a
    killed process has left is removed by a later one, see `remove_stale`. A file that stood at `path` stays
    until the new one takes its place.

    Args:
        path: the final name, in a folder that exists.
        fresh: whether a file that stands at `path` by then is kept instead of the new one.

    Yields:
        The temporary name, at which nothing exists yet.

    Raises:
        FileExistsError: `fresh`, and another file stands at `path`.
        OSError: the folder is missing, not writable or full; a sentence that names the file.
    """
    if not path.parent.is_dir():
        raise NotADirectoryError(
            errno.ENOTDIR,
            f"'{path.name}' cannot be written, its folder does not exist; create it first",
            str(path.parent),
        )
    remove_stale(path.parent)
    partial = path.with_name(f".{path.name}.{secrets.token_hex(8)}.partial")
    _writing.add(partial)
    try:
        with _ended_by_signals():
            yield partial
        _synchronise(partial)
        (_link if fresh else Path.replace)(partial, path)
    except OSError as fault:
        if fresh and isinstance(fault, FileExistsError):
            raise
        raise OSError(
            fault.errno or errno.EIO,
            f"'{path.name}' cannot be written ({fault.strerror or fault}); "
            "choose a folder that is writable and has space left",
            str(path.parent),
        ) from fault
    finally:
        partial.unlink(missing_ok=True)
        _writing.discard(partial)
    # The file is whole by now; a file system that cannot synchronise a folder is no reason to fail.
    with suppress(OSError):
        _synchronise(path.parent)


@contextmanager
def whole_netcdf(path: Path) -> Iterator[Path]:
    """Do as `whole_file` for what the netCDF library writes, which does not say why it could not."""
    with whole_file(path) as partial:
        try:
            yield partial
        except (OSError, RuntimeError) as fault:
            if isinstance(fault, RuntimeError) and not str(fault).startswith("NetCDF"):
                raise
            # The system tells the cause where a little more cannot be written either.
            with partial.open("ab") as stream:
                stream.write(bytes(2**20))
                stream.flush()
                os.fsync(stream.fileno())
            if isinstance(fault, OSError):
                raise
            raise OSError(errno.EIO, f"the netCDF library says: {fault}") from fault


def error_text(error: OSError) -> str:
    """Return an error of the system as a sentence."""
    where = f" The place is '{error.filename}'." if error.filename else ""
    return f"{error.strerror or error}.{where}"


def check_file(path: Path) -> None:
    """Refuse what cannot be read as a whole: a device, which may have no end, or more than memory.

    Raises:
        OSError: it is missing, or no file.
        ValueError: it is too large; a sentence.
    """
    if not S_ISREG((status := path.stat()).st_mode):
        raise OSError(errno.EINVAL, "it is a folder or a device", str(path))
    # Imported here: help needs no NumPy.
    from contactlab.checks import check_size

    check_size("The file", status.st_size)


def digest_of_file(path: Path) -> str:
    """Return the digest of a file as it lies on the disk, 64 hexadecimal digits, as `sha256sum` does.

    Raises:
        OSError: it cannot be read.
    """
    with path.open("rb") as stream:
        return file_digest(stream, "sha256").hexdigest()


def damage(dataset: Path) -> str:
    """Return why a dataset is not the one that its run left; nothing where it is, and where nothing tells.

    Call it before the dataset is opened: the libraries take damaged numbers for numbers, and may hang.

    Raises:
        OSError: the file cannot be read.
    """
    try:
        state = json.loads((dataset.parent / STATE).read_text(encoding="utf-8"))
        digest = state["digest"] if dataset.name == DATASET else ""
    # Somebody else's file of that name may be anything.
    except (OSError, ValueError, TypeError, LookupError):
        return ""
    if not isinstance(digest, str) or digest in ("", digest_of_file(dataset)):
        return ""
    return (
        f"'{dataset}' is not as its run left it, by the digest in {STATE} beside it; it is damaged or "
        f"was replaced. Run it again, or remove {STATE} if the change is yours."
    )


def remove_stale(folder: Path) -> None:
    """Remove temporary files in a folder older than `STALE_AFTER`; what cannot be removed stays."""
    for left in folder.glob(f".*{'[0-9a-f]' * 8}.partial"):
        # Another process may have renamed or removed it by now.
        with suppress(OSError):
            if time.time() - left.stat().st_mtime > STALE_AFTER:
                left.unlink()


def _link(partial: Path, path: Path) -> None:
    """Let a file have its name if no other has it."""
    try:
        path.hardlink_to(partial)
    except OSError as fault:
        if fault.errno not in _WITHOUT_LINKS:
            raise
        partial.replace(path)


def _synchronise(path: Path) -> None:
    """Have the file system put a file or folder onto the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
