"""Temporary files: names that tell whose they are, so that those of killed processes can be removed."""

import os
import platform
import re
import secrets
import time
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Final

FOREIGN_AFTER: Final = 7 * 24 * 3600.0
"""Seconds without a change after which a file of another machine, whose processes cannot be asked, is taken
for left: what is being written changes all the time."""

_NAME: Final = re.compile(
    r"\..+\.((?P<machine>[0-9a-f]{8})-(?P<process>\d+)-)?[0-9a-f]{8}\.partial"
)


def partial_of(path: Path) -> Path:
    """Make up a temporary name beside a file, which no other process or machine gives."""
    token = f"{_machine()}-{os.getpid()}-{secrets.token_hex(4)}"
    return path.with_name(f".{path.name}.{token}.partial")


def remove_left(folder: Path) -> None:
    """Remove the temporary files in a folder whose processes have ended; what cannot be removed stays."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if (named := _NAME.fullmatch(entry.name)) and _is_left(Path(entry.path), named):
                Path(entry.path).unlink(missing_ok=True)


def _is_left(path: Path, named: re.Match[str]) -> bool:
    if named["machine"] == _machine() and not _lives(int(named["process"])):
        return True
    with suppress(OSError):
        return time.time() - path.stat().st_mtime > FOREIGN_AFTER
    return False


@cache
def _machine() -> str:
    """Tell apart what numbers processes: this start of this machine, and in a container the container."""
    try:
        start = Path("/proc/sys/kernel/random/boot_id").read_text()
        told = f"{start}{Path('/proc/self/ns/pid').readlink()}"
    except OSError:
        told = platform.node()
    return sha256(told.encode()).hexdigest()[:8]


def _lives(process: int) -> bool:
    """Whether a process of this machine runs; where that cannot be asked, it may."""
    # On Windows the same call would end the process.
    if os.name != "posix":
        return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        return True
    return True
