"""Files that a configuration names, recorded by path and digest: another content is another motor."""

from pathlib import Path
from typing import Any

from contactlab.config.faults import ConfigurationError
from contactlab.results.files import check_file, digest_of_file


def named_file(group: str, section: dict[str, Any]) -> Path:
    """Return the file of a section, and write its whole path and its digest into the section.

    Raises:
        ConfigurationError: it cannot be read, or its digest is another than that of the section.
    """
    path, expected = Path(section["file"]).absolute(), section["digest"]
    try:
        check_file(path)
        digest = digest_of_file(path)[:16]
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        fault = f"{group}.file is '{path}', which cannot be read ({reason}); it must be a file."
        raise ConfigurationError([fault]) from error
    if expected not in (None, digest):
        fault = f"{group}.digest is '{expected}'; it must be '{digest}', that of '{path}'."
        raise ConfigurationError([f"{fault} The file has changed; leave the digest out to take it as it is."])
    section |= {"file": str(path), "digest": digest}
    return path
