"""The compiled code is kept where it belongs to these sources, and found again."""

import os
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from numba.core.errors import TypingError
from support.command_line import cases
from tqdm import tqdm

from contactlab.compiler import folders, kernels as compiled, notice
from contactlab.compiler.notice import telling
from contactlab.progress import shown_by


def test_the_former_name_of_the_module_of_kernels_tells_the_new_one() -> None:
    with pytest.warns(FutureWarning, match=r"contactlab\.compiler\.kernels"):
        from contactlab.compiled import kernel
    assert kernel is compiled.kernel


PROBE = "from contactlab.compiler.folders import code_folder; print(code_folder())"


def test_the_folder_is_the_same_in_every_process() -> None:
    result = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True, check=True)
    assert Path(result.stdout.strip()) == folders.code_folder()


def test_a_chosen_cache_directory_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert folders.code_folder.__wrapped__().parent == tmp_path


def test_without_a_writable_directory_the_code_lives_for_the_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocked = tmp_path / "file"
    blocked.touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(blocked))
    result = folders.code_folder.__wrapped__()
    assert result.is_dir()
    assert result.name.startswith("contactlab-")


def test_a_change_of_a_kernels_source_changes_the_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "engine").mkdir()
    source = tmp_path / "engine" / "module.py"
    source.write_text("a = 1\n")
    monkeypatch.setattr(folders, "PACKAGE", tmp_path)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    before = folders.code_folder.__wrapped__()
    source.write_text("a = 2\n")
    after = folders.code_folder.__wrapped__()
    assert before != after
    assert before.parent == after.parent == tmp_path / "__pycache__"


SAME = "# A comment.\na = (\n    1\n)\n"


@pytest.mark.parametrize(("text", "same"), [(SAME, True), ("a = 1.0\n", False), ('a = "1"\n', False)])
def test_comments_and_line_breaks_are_no_change(
    text: str, same: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "engine").mkdir()
    source = tmp_path / "engine" / "module.py"
    source.write_text("a = 1\n")
    monkeypatch.setattr(folders, "PACKAGE", tmp_path)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    before = folders.code_folder.__wrapped__()
    source.write_text(text)
    # By the texts that a folder is known to be of, and by what is compiled of them.
    assert [(folders.code_folder.__wrapped__() == before) for _ in range(2)] == [same, same]


def test_a_read_only_installation_falls_back_to_the_users_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "package"
    package.mkdir()
    # A file in the way stands for a directory without write permission, which root does not have.
    (package / "__pycache__").touch()
    monkeypatch.setattr(folders, "PACKAGE", package)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "users"))
    assert folders.code_folder.__wrapped__().parent == tmp_path / "users" / "contactlab"


@compiled.inner_kernel
def _third(x: float) -> float:
    return x / 3.0


@compiled.kernel
def _within(x: float) -> float:
    return _third(x) + 1.0


@compiled.kernel
def _around(x: float) -> float:
    return _third(x) + _within(x)


@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
def test_kernels_that_call_each_other_share_an_inner_kernel() -> None:
    inner: Any = _third
    assert compiled.units()
    with telling() as made:
        assert _around(6.0) == 5.0
    # Once for each of the two units, and the kernel that is called from the other.
    assert sorted(made.functions) == ["_around", "_third", "_third", "_within"]
    assert _within(6.0) == 3.0
    assert not inner.overloads


@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
def test_a_kernel_that_does_not_compile_leaves_no_inner_code_behind() -> None:
    @compiled.fleeting_kernel
    def wrong(x: float) -> float:
        return x.missing  # type: ignore[attr-defined, no-any-return]

    @compiled.kernel
    def fails(x: float) -> float:
        return _third(x) + wrong(x)

    with pytest.raises(TypingError):
        fails(6.0)
    inner: Any = _third
    assert not inner.overloads
    assert _within(9.0) == 4.0


EVERY = """
import importlib, inspect, pkgutil
import contactlab
from contactlab.compiler.kernels import Kernel

def outcome(function):
    try:
        return repr(function(*[0.5] * len(inspect.signature(function).parameters)))
    except Exception as error:
        return type(error)

kernels = {}
for module in pkgutil.walk_packages(contactlab.__path__, "contactlab."):
    if "__main__" not in module.name:
        made = importlib.import_module(module.name)
        for owner in (made, *filter(inspect.isclass, vars(made).values())):
            found = (getattr(each, "__func__", each) for each in vars(owner).values())
            kernels |= {id(each): each for each in found if isinstance(each, Kernel)}
for kernel in kernels.values():
    inner = "no_cpython_wrapper" in kernel.targetoptions
    print(inner and outcome(kernel) == outcome(kernel.py_func), outcome(kernel.py_func), sep="\\t")
"""


@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
def test_every_inner_kernel_is_its_python_function_to_python() -> None:
    result = subprocess.run([sys.executable, "-c", EVERY], capture_output=True, text=True, check=True)
    same, outcomes = zip(*(line.split("\t") for line in result.stdout.splitlines()), strict=True)
    # Inner ones, and those of laws, which call them by their Python functions.
    assert same.count("True") > 100
    assert sum(not each.startswith("<class") for each in outcomes) > 50


AT_ONCE = """
import sys
from numba import types
from contactlab.compiler import ahead
from contactlab.compiler.ahead import Signature, compile_all
from contactlab.compiler.notice import telling
from contactlab.laws.base import coulomb
from contactlab.laws.normal.elastic import hertz_elastic

ahead.processors = lambda: int(sys.argv[1])
pair = (types.float64, types.float64)
forces = Signature(hertz_elastic, types.UniTuple(types.float64, 4)(*pair))
friction = Signature(coulomb, types.float64(*pair))
assert not friction.is_there()
with telling() as made:
    compile_all([forces, friction])
assert friction.is_there()
print(*made.functions, coulomb(3.0, 0.25), *hertz_elastic(2.0, 0.5))
"""


@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
def test_what_another_process_compiles_is_loaded_and_the_same(tmp_path: Path) -> None:
    outputs = []
    for count in (1, 2):
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / str(count))}
        line = [sys.executable, "-c", AT_ONCE, str(count)]
        done = subprocess.run(line, capture_output=True, text=True, check=True, env=environment)
        outputs.append(done.stdout.split())
    assert ["coulomb" in each for each in outputs] == [True, False]
    assert outputs[0][-5:] == outputs[1][-5:]


WITHOUT_UNITS = {
    "no module": "import sys; sys.modules['contactlab.compiler.units'] = None",
    "an error": "from contactlab.compiler import units; units._JoinUnit.run_pass = lambda *_: 1 / 0",
    "a wrong result": "from contactlab.compiler import units; units.around = units._within",
}
PULLED = """
from contactlab.compiler.kernels import units
from contactlab.laws.normal.jkr import Jkr
print(units() is not None, *(Jkr.elastic(0.3 * depth, 0.1, 0.7) for depth in range(-3, 3)), sep="\\n")
"""


@pytest.fixture(scope="module")
def with_units(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    return pulled("", tmp_path_factory.mktemp("units"))


def pulled(first: str, folder: Path) -> list[str]:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder)}
    line = [sys.executable, "-c", first + PULLED]
    return subprocess.run(line, capture_output=True, text=True, check=True, env=environment).stdout.split(
        "\n"
    )


@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
@pytest.mark.parametrize("name", cases(WITHOUT_UNITS, ("an error",)))
def test_without_units_a_kernel_gives_the_same_bits(name: str, with_units: list[str], tmp_path: Path) -> None:
    without = pulled(WITHOUT_UNITS[name], tmp_path)
    assert (with_units[0], without[0]) == ("True", "False")
    assert with_units[1:] == without[1:]


IMPACT = """
import contactlab as cl
from contactlab.compiler.notice import telling
from contactlab.progress import shown_by
with telling() as made:
    found = cl.impact(cl.Newton(restitution=0.8), [[1.0, 0.2], [0.2, 3.5]], [-1.0, 0.3])
print(len(made.functions), *map(float, found.velocity_after[0]))
"""

READ_ONLY = """
import os, tempfile
from pathlib import Path
# Root may write everywhere.
whole = tempfile.TemporaryFile
def refused(*arguments, dir=None, **named):
    if str(dir).startswith({folder!r}):
        raise PermissionError(13, "read-only", str(dir))
    return whole(*arguments, dir=dir, **named)
tempfile.TemporaryFile = refused
"""


def outcome_of(folder: Path, first: str = "") -> list[str]:
    """Return the number of functions that a process compiles for an impact, and the velocity after it."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(folder), "TMPDIR": str(folder.parent)}
    line = [sys.executable, "-c", first + IMPACT]
    return subprocess.run(line, capture_output=True, text=True, check=True, env=environment).stdout.split()


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """A folder with the code of an impact, and the velocity after that."""
    folder = tmp_path_factory.mktemp("filled") / "code"
    count, *velocity = outcome_of(folder)
    assert int(count) > 0
    assert float(velocity[0]) == pytest.approx(0.8)
    return folder, velocity


@pytest.mark.long
@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
def test_without_units_an_impact_has_the_same_bits(filled: tuple[Path, list[str]], tmp_path: Path) -> None:
    count, *velocity = outcome_of(tmp_path, WITHOUT_UNITS["no module"])
    assert int(count) > 0
    assert velocity == filled[1]


@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
def test_code_that_cannot_be_added_to_is_used(filled: tuple[Path, list[str]]) -> None:
    folder, velocity = filled
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    assert outcome_of(folder, READ_ONLY.format(folder=str(folder))) == ["0", *velocity]
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before


@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
def test_files_that_were_cut_are_made_anew(filled: tuple[Path, list[str]]) -> None:
    folder, velocity = filled
    files = [path for path in folder.rglob("*") if path.suffix in (".py", ".nbi", ".nbc")]
    assert {path.suffix for path in files} == {".py", ".nbi", ".nbc"}
    for path in files:
        whole = path.read_bytes()
        path.write_bytes(whole[: len(whole) // 2])
    count, *after = outcome_of(folder)
    assert int(count) > 0
    assert after == velocity
    assert outcome_of(folder) == ["0", *velocity]


@pytest.mark.skipif(compiled.INTERPRETED, reason="nothing is compiled")
def test_whoever_shows_progress_shows_what_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two bars on one line would be drawn over each other."""
    bars: list[bool | None] = []
    received: list[str] = []

    def drawn(**options: Any) -> Any:
        bars.append(options["disable"])
        return tqdm(disable=True)

    monkeypatch.setattr(notice, "tqdm", drawn)
    for shown in (nullcontext(), shown_by(lambda what, _: received.append(what))):
        assert not received
        with shown, telling("a kernel", 1.0):
            compiled.fleeting_kernel(lambda x: x + 1.0)(1.0)
    assert received
    assert bars == [None, True]
