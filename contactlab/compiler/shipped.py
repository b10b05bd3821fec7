"""Machine code that came with the package, for any processor of its kind: how it is packed and read.

The compiler keeps a kernel's code in a folder named after the path of its module and of this machine's
processor. Here both are left out, so that code made in one place is found in another. The compiler's classes
that do it are not documented, and used only in the very version that made the code.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final, NamedTuple, final

import numba
from numba.core import caching

from contactlab.compiler.folders import code_name, of_version, shipped_folder

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

    def get_cache_path(self) -> str:
        return f"{shipped_folder()}/{Path(self._py_file).parent.name}"


class _Files(caching.CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 - the base class declares it


@final
class Shipped(caching.FunctionCache):
    """A kernel's code that came with the package, behind that which this machine keeps."""

    _impl_class = _Files

    def __init__(self, kept: caching.FunctionCache, function: Any) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._kept = kept

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the code for a signature, None where neither has it."""
        return self._kept.load_overload(signature, target) or super().load_overload(signature, target)  # type: ignore[no-untyped-call]

    def save_overload(self, signature: Any, made: Any) -> None:
        """Keep code on this machine."""
        self._kept.save_overload(signature, made)

    def _index_key(self, signature: Any, codegen: Any) -> Any:
        target = _Target(codegen.magic_tuple()[0])
        return super()._index_key(signature, target)  # type: ignore[no-untyped-call]
