"""Files that stand under their name only when whole."""

import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Let the body write a file under a temporary name that becomes `path` only when it is whole.

    The temporary file lies beside `path`, is synchronised with the disk and then takes the name;
    whatever stops this before, a keyboard interrupt too, removes it. A file that stood at `path`
    stays until the new one takes its place.

    Args:
        path: the final name, in a folder that exists.

    Yields:
        The temporary name, at which nothing exists yet.

    Raises:
        OSError: the folder is missing, not writable or full; a sentence that names the file.
    """
    if not path.parent.is_dir():
        raise NotADirectoryError(
            errno.ENOTDIR,
            f"'{path.name}' cannot be written, its folder does not exist; create it first",
            str(path.parent),
        )
    partial = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
    try:
        yield partial
        _synchronise(partial)
        partial.replace(path)
    except OSError as fault:
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


def _synchronise(path: Path) -> None:
    """Have the file system put a file or folder onto the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
