"""Former name of `contactlab.compiler.kernels`, so that laws written for it run and learn the new one."""

from typing import Any
from warnings import warn

from contactlab.compiler import kernels


def __getattr__(name: str) -> Any:
    value = getattr(kernels, name)
    if not name.startswith("__"):
        sentence = f"contactlab.compiled is contactlab.compiler.kernels now; import {name} from there."
        warn(sentence, FutureWarning, stacklevel=2)
    return value
