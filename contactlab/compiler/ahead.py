"""Kernels compiled before they are called, by processes at once where there are several of them."""

import pickle
import subprocess
import sys
import warnings
from contextlib import suppress
from typing import Any, NamedTuple, final

from contactlab.compiler.folders import code_folder, code_name
from contactlab.compiler.kernels import Kernel
from contactlab.processes import processors


@final
class Signature(NamedTuple):
    """A kernel that is to be compiled, and the types of its arguments and result."""

    kernel: Kernel
    types: Any

    @property
    def code(self) -> Any:
        """The machine code, which other kernels call by its address: exceptions do not come through."""
        from numba.core.types import CompileResultWAP, FunctionType

        code: Any = CompileResultWAP(self.kernel.get_compile_result(self.types))
        # Its type, which every call would make anew.
        code._numba_type_ = FunctionType(self.types)
        return code

    def is_there(self) -> bool:
        """Load the code if it is kept, and return whether it is; the kernel takes no other types then.

        A law of another package is a type of its own, which is converted where nothing is compiled for it.
        """
        if self.types.args in self.kernel.overloads:
            return True
        context = self.kernel.targetctx
        code = self.kernel._cache.load_overload(self.types, context)
        if code is None:
            return False
        # As the compiler takes it in itself; asked for it, it would compile what is not kept.
        context.insert_user_function(code.entry_point, code.fndesc, [code.library])
        self.kernel.add_overload(code)
        self.kernel.disable_compile()
        return True

    def compile(self) -> None:
        """Compile the kernel, or load its code; from then on it takes no other types."""
        self.kernel.disable_compile(False)
        with warnings.catch_warnings():
            # Functions as arguments are new to the compiler.
            warnings.simplefilter("ignore")
            self.kernel.compile(self.types)
        self.kernel.disable_compile()


def compile_all(signatures: list[Signature]) -> None:
    """Compile kernels, each but the first in a process of its own that leaves its code where it is kept."""
    if not signatures:
        return
    first, *others = signatures
    # This process may have found its modules in other places than another would.
    places = "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer)"
    command = [sys.executable, "-P", "-c", f"{places}; from {__name__} import compile_beside; compile_beside()"]
    pipe, nothing = subprocess.PIPE, subprocess.DEVNULL
    # What lives for one process alone no other one finds.
    at_once = sys.executable and processors() > 1 and code_folder().name == code_name()
    begun = []
    try:
        for each in others if at_once else []:
            process = subprocess.Popen(command, stdin=pipe, stdout=nothing, stderr=nothing)
            begun.append(process)
            assert process.stdin
            # One that could not begin does not read.
            with suppress(BrokenPipeError), process.stdin as message:
                pickle.dump(sys.path, message)
                pickle.dump((each.kernel.__module__, each.kernel.__name__, each.types), message)
        first.compile()
        for process in begun:
            process.wait()
    finally:
        for process in begun:
            process.kill()
            process.wait()
    # What another process did not compile, for whatever reason, this one does.
    for each in others:
        each.compile()


def compile_beside() -> None:
    """Compile the kernel that another process names on standard input."""
    import gc
    from importlib import import_module

    gc.disable()
    module, name, types = pickle.load(sys.stdin.buffer)
    Signature(getattr(import_module(module), name), types).compile()
