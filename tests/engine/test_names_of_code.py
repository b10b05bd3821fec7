"""Claims on the names of machine code, by which processes find it that others have made."""

import subprocess
import sys

NAMED = """
import sys
import numpy as np
from numba import from_dtype
from contactlab.compiler.units import short_name

kinds = [from_dtype(np.dtype([(name, np.float64)])) for name in sys.argv[1:]]
print(short_name("step", kinds[-1:], abi_tags=()))
"""
"""Prints the name of a function of the last of some records, as they come to be known."""


def named(*records: str) -> str:
    command = [sys.executable, "-c", NAMED, *records]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_a_name_tells_the_types_whatever_its_process_has_compiled_before() -> None:
    """The compiler numbers records as it meets them: the first of two processes are no one record."""
    assert named("gap") != named("slip")
    assert named("gap") == named("slip", "gap")
