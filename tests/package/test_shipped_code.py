"""Machine code that came with the package is used where sources and compiler are its own; same bits."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import pytest
from numba.core import event

from contactlab.compiler import notice
from contactlab.compiler.folders import code_name, of_version
from contactlab.compiler.kernels import INTERPRETED
from contactlab.compiler.notice import Compiled
from contactlab.compiler.shipped import PROCESSOR, packed

PULLED = """
import sys
from pathlib import Path
from contactlab.compiler import folders
folders.shipped = lambda: Path(sys.argv[1])
from contactlab.compiler.notice import telling
from contactlab.laws.normal.jkr import Jkr
with telling() as made:
    forces = [Jkr.elastic(0.3 * depth, 0.1, 0.7) for depth in range(-3, 3)]
print(made.functions, *forces, sep="\\n")
"""

pytestmark = pytest.mark.skipif(INTERPRETED, reason="nothing is compiled")


def pulled(shipped: Path, kept: Path, **environment: str) -> list[str]:
    """Return the names of the functions that a process compiles, and the forces that it finds."""
    line = [sys.executable, "-c", PULLED, str(shipped)]
    environment = os.environ | environment | {"NUMBA_CACHE_DIR": str(kept)}
    result = subprocess.run(line, capture_output=True, text=True, check=True, env=environment)
    return result.stdout.split("\n")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """A folder of code for any processor, as a wheel has it, and what was pulled with it."""
    folder = tmp_path_factory.mktemp("shipped")
    result = pulled(folder / "none", folder / "kept", **PROCESSOR)
    for part, name in packed(folder / "kept"):
        shutil.copytree(part, folder / "compiled" / name)
    return folder / "compiled", result


@pytest.mark.long
def test_code_for_any_processor_is_loaded_in_another_place_and_gives_the_bits_of_this_processors_own(
    made: tuple[Path, list[str]], tmp_path: Path
) -> None:
    folder, (functions, *forces) = made
    assert "elastic" in functions
    assert pulled(folder, tmp_path / "kept") == ["[]", *forces]
    assert not [*tmp_path.rglob("*.nbc")]
    assert pulled(tmp_path / "none", tmp_path / "own") == [functions, *forces]


@pytest.mark.parametrize("part", ["version of the compiler", "sources"])
def test_code_of_another_compiler_or_of_other_sources_is_left_alone(
    part: str, made: tuple[Path, list[str]], tmp_path: Path
) -> None:
    folder = shutil.copytree(made[0], tmp_path / "compiled")
    (version,) = folder.iterdir()
    if part == "sources":
        (version / code_name()).rename(version / "kernels-0123456789abcdef")
    else:
        version.rename(folder / of_version("0.1"))
    assert pulled(folder, tmp_path / "kept") == made[1]


@pytest.mark.parametrize("of_sources", [False, True], ids=["another compiler", "other sources"])
def test_whoever_waits_is_told_what_the_code_that_came_is_for(
    of_sources: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / of_version(numba.__version__ if of_sources else "0.1")).mkdir()
    monkeypatch.setattr(notice, "shipped", lambda: tmp_path)
    Compiled("the engine", 20.0).on_start(event.Event("numba:compile", event.EventStatus.START))
    errors = capsys.readouterr().err
    assert ("sources" in errors, of_version("0.1") in errors) == (of_sources, not of_sources)
