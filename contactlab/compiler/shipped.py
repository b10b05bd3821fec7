"""A kernel's machine code: kept by this machine, read from where nothing can be added, and shipped.

Left to itself the compiler keeps a kernel's code in a folder named after the path of its module, and finds it
no more once a checkout is copied or moved; here the name of the module's folder alone counts. In code that
came with the package, for any processor of its kind, that of this machine's processor is left out, too. The
compiler's classes that do it are not documented, and code is found only in the very version that made it.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ClassVar, Final, NamedTuple, final

import numba
from numba.core import caching

from contactlab.compiler.folders import code_folder, code_name, of_version, read_only_folder, shipped_folder

PROCESSOR: Final = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
"""What tells the compiler to use only what every processor of a kind can do."""


def packed(kept: Path) -> Iterator[tuple[Path, str]]:
    """Yield the folders of code in that of a `NUMBA_CACHE_DIR`, and the name of each in the package."""
    for folder in sorted((kept / code_name()).iterdir()):
        if any(folder.glob("*.nbi")):
            yield folder, f"{of_version(numba.__version__)}/{code_name()}/{folder.name}"


class _Target(NamedTuple):
    """What code is made for, as the compiler's caches ask for it."""

    triple: str

    def magic_tuple(self) -> tuple[str, ...]:
        return self.triple, *PROCESSOR.values()


class _Locator(caching._SourceFileBackedLocatorMixin, caching._CacheLocator):
    """Finds code by the name of the folder of a kernel's module."""

    folder: ClassVar[Callable[[], Path | None]] = staticmethod(code_folder)

    def __init__(self, function: Any, file: str) -> None:
        self._py_file, self._lineno = file, function.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        return f"{type(self).folder()}/{Path(self._py_file).parent.name}"


class _ReadOnlyLocator(_Locator):
    folder = staticmethod(read_only_folder)

    def ensure_cache_path(self) -> None:
        """Make no folder: nothing is added to it."""


class _ShippedLocator(_ReadOnlyLocator):
    folder = staticmethod(shipped_folder)


class _Files(caching.CompileResultCacheImpl):
    _locator_classes = [_Locator]  # noqa: RUF012 - the base class declares it


class _ReadOnlyFiles(caching.CompileResultCacheImpl):
    _locator_classes = [_ReadOnlyLocator]  # noqa: RUF012 - the base class declares it


class _ShippedFiles(caching.CompileResultCacheImpl):
    _locator_classes = [_ShippedLocator]  # noqa: RUF012 - the base class declares it


@final
class Kept(caching.FunctionCache):
    """A kernel's code that this machine keeps."""

    _impl_class = _Files


@final
class ReadOnly(caching.FunctionCache):
    """A kernel's code in a folder that cannot be added to."""

    _impl_class = _ReadOnlyFiles


@final
class Shipped(caching.FunctionCache):
    """A kernel's code that came with the package."""

    _impl_class = _ShippedFiles

    def _index_key(self, signature: Any, codegen: Any) -> Any:
        target = _Target(codegen.magic_tuple()[0])
        return super()._index_key(signature, target)  # type: ignore[no-untyped-call]
