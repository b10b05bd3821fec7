"""Contents of the files that a configuration names, by digest: the dataset of a run contains them.

A section of a configuration that has a `digest` names a file. Its content is kept when it is read, so that a
dataset can be written with it; a content from a dataset stands for its file where that is gone or changed.
"""

from collections.abc import Mapping
from hashlib import sha256
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    import xarray

GROUP: Final = "files"
"""Group of a dataset."""

_contents: dict[str, bytes] = {}
_recorded: set[str] = set()


def keep(content: bytes, *, recorded: bool = False) -> str:
    """Keep a content, which may be that of a dataset, and return its digest, 16 hexadecimal digits."""
    digest = sha256(content).hexdigest()[:16]
    _contents[digest] = content
    if recorded:
        _recorded.add(digest)
    return digest


def recorded_content(digest: str | None) -> bytes | None:
    """Return the content of a digest from a dataset, or from a setup of another process; None without one."""
    return _contents[digest] if digest in _recorded else None


def contents_of(configuration: Mapping[str, Any]) -> dict[str, bytes]:
    """Return the contents of the files that a configuration names, by section."""
    digests = {name: keys.get("digest") for name, keys in configuration.items() if isinstance(keys, Mapping)}
    return {name: _contents[digest] for name, digest in digests.items() if digest in _contents}


def keep_contents(tree: "xarray.DataTree") -> None:
    """Keep the contents that a dataset contains."""
    if GROUP in tree.children:
        for values in tree.children[GROUP].to_dataset(inherit=False).values():
            keep(np.asarray(values.values, dtype=np.uint8).tobytes(), recorded=True)
