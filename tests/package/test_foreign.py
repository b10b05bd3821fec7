"""The digest of another package's sources changes with all that may define a class, and with nothing else."""

import sys
from importlib import import_module
from pathlib import Path

import pytest

from contactlab.foreign import digest_of_sources
from contactlab.laws import HertzPenalty
from contactlab.results.provenance import digest_of

FILES = {
    "law.py": "import pack.middle\nfrom table import SLOPE\n\nclass Law:\n    slope = SLOPE\n",
    "table.py": "SLOPE = 2.0\n",
    "pack/__init__.py": "",
    "pack/middle.py": "from pack.leaf import GRAVITY\n",
    "pack/leaf.py": "GRAVITY = 9.81\n",
    "pack/late.py": "AT_LAST = 4.0\n",
    "unrelated.py": "UNUSED = 1.0\n",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The modules above, written and on the path."""
    (tmp_path / "pack").mkdir()
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    return tmp_path


def digest() -> str:
    for name in [name for name in sys.modules if name.partition(".")[0] in ("law", "table", "pack")]:
        del sys.modules[name]
    return digest_of_sources(import_module("law").Law)


@pytest.mark.parametrize(("file", "counts"), [(name, name != "unrelated.py") for name in FILES])
def test_it_changes_with_every_source_that_can_be_reached(folder: Path, file: str, counts: bool) -> None:
    before = digest()
    assert digest() == before
    (folder / file).write_text(f"{FILES[file]}MORE = 1.0\n")
    assert (digest() != before) == counts


def test_classes_of_this_package_have_none() -> None:
    assert digest_of_sources(HertzPenalty) == ""


def test_written_kernels_beside_the_compiled_code_are_no_sources(folder: Path) -> None:
    before = digest_of(folder), digest()
    for cache in (folder / "__pycache__", folder / "pack" / "__pycache__"):
        cache.mkdir()
        (cache / "kernel.py").write_text("def force(): ...\n")
    assert (digest_of(folder), digest()) == before
