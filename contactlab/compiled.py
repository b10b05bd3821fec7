"""The one place that names the compiler: a typed decorator for numeric kernels."""

from collections.abc import Callable
from typing import TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., object])


def kernel(function: Function) -> Function:
    """Compile a scalar or array function on first use and keep the result in the on-disk cache.

    Division follows IEEE (`error_model="numpy"`), and no fast-math is used, so that the same
    input gives the same bits and a NaN stays visible.
    """
    return cast(Function, numba.njit(cache=True, error_model="numpy", _nrt=False)(function))


def inner_kernel(function: Function) -> Function:
    """Compile a function that only other kernels call: no way in from Python is built for it.

    Most of the time to compile a small function goes into unpacking its arguments from Python.
    """
    compile_it = numba.njit(
        cache=True, error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False
    )
    return cast(Function, compile_it(function))
