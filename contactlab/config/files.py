"""Files that a configuration names, recorded by path and digest: another content is another motor."""

from pathlib import Path
from typing import Any

from contactlab.config.faults import ConfigurationError
from contactlab.results.contents import keep, recorded_content
from contactlab.results.files import check_file


def named_file(group: str, section: dict[str, Any]) -> tuple[Path, bytes]:
    """Return path and content of the file of a section, and write whole path and digest into the section.

    The content of a dataset stands for that of a file that is gone or has changed since.

    Raises:
        ConfigurationError: it cannot be read, or its digest is another than that of the section.
    """
    path, expected = Path(section["file"]).absolute(), section["digest"]
    try:
        check_file(path)
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        if (recorded := recorded_content(expected)) is not None:
            return path, recorded
        reason = getattr(error, "strerror", None) or error
        fault = f"{group}.file is '{path}', which cannot be read ({reason}); it must be a file."
        raise ConfigurationError(fault) from error
    digest = keep(content)
    if expected not in (None, digest):
        if (recorded := recorded_content(expected)) is not None:
            return path, recorded
        fault = f"{group}.digest is '{expected}'; it must be '{digest}', that of '{path}'."
        raise ConfigurationError(f"{fault} The file has changed; leave the digest out to take it as it is.")
    section |= {"file": str(path), "digest": digest}
    return path, content
