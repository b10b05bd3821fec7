"""Claims on kernels that processes compile at once."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

COMPILED = """
import sys
from numba import float64
from contactlab.compiler import ahead
from contactlab.compiler.notice import telling
from contactlab.laws.base import cone, coulomb

ahead.processors = lambda: 2
exec(sys.argv[1])
two = [ahead.Signature(coulomb, float64(float64, float64)), ahead.Signature(cone, float64(*4 * [float64]))]
with telling() as compiled:
    ahead.compile_all(two)
assert coulomb(2.0, 0.5) == cone(2.0, 0.0, 0.5, 1.0) == 1.0
print(*compiled.functions)
"""


def compiled_here(folder: Path, before: str, **environment: str) -> set[str]:
    """Return which of the two kernels a process compiled itself."""
    result = subprocess.run(
        [sys.executable, "-c", COMPILED, before],
        env=os.environ | {"NUMBA_CACHE_DIR": str(folder / "code")} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    return {"coulomb", "cone"}.intersection(result.stdout.split())


def test_another_process_finds_modules_where_this_one_does(tmp_path: Path) -> None:
    """Not by a variable: environments that build wheels start nothing whose variable names their folders."""
    refuses = "import os, sys\nif any('of this process' in place for place in sys.path): os._exit(1)\n"
    (tmp_path / "sitecustomize.py").write_text(refuses)
    added = "sys.path.append('of this process')"
    assert compiled_here(tmp_path, added, PYTHONPATH=str(tmp_path)) == {"coulomb"}


@pytest.mark.skipif(os.name == "nt", reason="/bin/false is a program of Unix")
def test_what_a_process_that_dies_leaves_is_compiled_here(tmp_path: Path) -> None:
    # It dies before it has read the list of places, which is longer than what a pipe holds.
    before = "sys.executable = '/bin/false'; sys.path.append(2**20 * 'x')"
    assert compiled_here(tmp_path, before) == {"coulomb", "cone"}
