"""Machine code that is read alone: of a folder without write permission, and that came with the package.

The compiler keeps a kernel's code in a folder named after the path of its module and of this machine's
processor. In code that came with the package, for any processor of its kind, both are left out, so that what
was made in one place is found in another. The compiler's classes that do it are not documented, and code is
found only in the very version that made it.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple, final

import numba
from numba.core import caching

from contactlab.compiler.folders import code_name, of_version, read_only_folder, shipped_folder

PROCESSOR: Final = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
"""What tells the compiler to use only what every processor of a kind can do."""


def packed(kept: Path) -> Iterator[tuple[Path, str]]:
    """Yield the folders of code in that of a `NUMBA_CACHE_DIR`, and the name of each in the package."""
    for folder in sorted((kept / code_name()).iterdir()):
        if any(folder.glob("*.nbi")):
            # The name of the modules' folder, "_" and a digest of its path.
            parent = folder.name.rpartition("_")[0]
            yield folder, f"{of_version(numba.__version__)}/{code_name()}/{parent}"


class _Target(NamedTuple):
    """What code is made for, as the compiler's caches ask for it."""

    triple: str

    def magic_tuple(self) -> tuple[str, ...]:
        return self.triple, *PROCESSOR.values()


class _Locator(caching._SourceFileBackedLocatorMixin, caching._CacheLocator):
    """Finds code by the name of the folder of a kernel's module."""

    def __init__(self, function: Any, file: str) -> None:
        self._py_file, self._lineno = file, function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, function: Any, file: str) -> "_Locator":
        return cls(function, file)

    def ensure_cache_path(self) -> None:
        """Make no folder: nothing is added to it."""

    def get_cache_path(self) -> str:
        return f"{shipped_folder()}/{Path(self._py_file).parent.name}"


class _ReadOnlyLocator(_Locator):
    """Finds code by the compiler's own names."""

    def get_cache_path(self) -> str:
        return f"{read_only_folder()}/{self.get_suitable_cache_subpath(self._py_file)}"  # type: ignore[no-untyped-call]


class _Files(caching.CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 - the base class declares it


class _ReadOnlyFiles(caching.CompileResultCacheImpl):
    _locator_classes = [_ReadOnlyLocator]  # noqa: RUF012 - the base class declares it


@final
class ReadOnly(caching.FunctionCache):
    """A kernel's code in a folder that cannot be added to."""

    _impl_class = _ReadOnlyFiles


@final
class Shipped(caching.FunctionCache):
    """A kernel's code that came with the package."""

    _impl_class = _Files

    def _index_key(self, signature: Any, codegen: Any) -> Any:
        target = _Target(codegen.magic_tuple()[0])
        return super()._index_key(signature, target)  # type: ignore[no-untyped-call]
