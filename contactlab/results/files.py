"""Files that stand under their name only when whole."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import file_digest
from pathlib import Path
from typing import Final

from contactlab.results.partials import partial_of, remove_left

_WITHOUT_LINKS: Final = (errno.EPERM, errno.ENOTSUP, errno.ENOSYS)
"""How a file system tells that a file cannot have two names."""


@contextmanager
def whole_file(path: Path, *, fresh: bool = False) -> Iterator[Path]:
    """Let the body write a file under a temporary name that becomes `path` only when it is whole.

    The temporary file lies beside `path`, is synchronised with the disk and then takes the name;
    whatever stops this before, a keyboard interrupt too, removes it, and what a process that was killed
    has left is removed by the next. A file that stood at `path` stays until the new one takes its place.

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
    remove_left(path.parent)
    partial = partial_of(path)
    try:
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
            if cause := _cause_of_failure(partial):
                raise cause from fault
            if isinstance(fault, OSError):
                raise
            raise OSError(errno.EIO, f"the netCDF library says: {fault}") from fault


def told(error: OSError) -> str:
    """Say an error of the system as a sentence."""
    where = f" The place is '{error.filename}'." if error.filename else ""
    return f"{error.strerror or error}.{where}"


def digest_of_file(path: Path) -> str:
    """Digest of a file as it lies on the disk, 64 hexadecimal digits, as `sha256sum` gives it.

    Raises:
        OSError: it cannot be read.
    """
    with path.open("rb") as stream:
        return file_digest(stream, "sha256").hexdigest()


def _cause_of_failure(partial: Path) -> OSError | None:
    """What the system says where a little more cannot be written to a file either."""
    try:
        with partial.open("ab") as stream:
            stream.write(bytes(2**20))
            stream.flush()
            os.fsync(stream.fileno())
    except OSError as cause:
        return cause
    return None


def _link(partial: Path, path: Path) -> None:
    """Give a file its name if no other has it."""
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
