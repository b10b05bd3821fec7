"""Files that a configuration names, recorded by path and digest: another content is another motor."""

from hashlib import sha256
from pathlib import Path
from typing import Any

from contactlab.config.faults import ConfigurationError


def named_file(group: str, section: dict[str, Any]) -> Path:
    """Return the file of a section, and write its whole path and its digest into the section.

    Raises:
        ConfigurationError: it cannot be read, or its digest is another than that of the section.
    """
    path, expected = Path(section["file"]).absolute(), section["digest"]
    try:
        digest = sha256(path.read_bytes()).hexdigest()[:16]
    except OSError as error:
        fault = f"{group}.file is '{path}', which cannot be read ({error.strerror}); it must be a file."
        raise ConfigurationError([fault]) from error
    if expected not in (None, digest):
        fault = f"{group}.digest is '{expected}'; it must be '{digest}', that of '{path}'."
        raise ConfigurationError([f"{fault} The file has changed; leave the digest out to take it as it is."])
    section |= {"file": str(path), "digest": digest}
    return path
