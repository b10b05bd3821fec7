"""The digest of another package's sources changes with all that may define a class, and with nothing else."""

import site
import sys
from importlib import import_module
from pathlib import Path

import pytest

from contactlab.foreign import covered_sources, digest_of_sources, other_sources
from contactlab.laws import HertzPenalty
from contactlab.results.provenance import digest_of

FILES = {
    "law.py": "import pack.middle\nfrom table import SLOPE\n\nclass Law:\n    slope = SLOPE\n",
    "table.py": "SLOPE = 2.0\n",
    "pack/__init__.py": "",
    "pack/middle.py": "from pack.leaf import GRAVITY\nimport beside\n",
    "pack/leaf.py": "GRAVITY = 9.81\n",
    "pack/late.py": "AT_LAST = 4.0\n",
    "beside.py": "LENGTH = 1.0\n",
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
    own = {name.partition("/")[0].removesuffix(".py") for name in FILES}
    for name in [name for name in sys.modules if name.partition(".")[0] in own]:
        del sys.modules[name]
    return digest_of_sources(import_module("law").Law)


@pytest.mark.parametrize(("file", "counts"), [(name, name != "unrelated.py") for name in FILES])
def test_it_changes_with_every_source_that_can_be_reached(folder: Path, file: str, counts: bool) -> None:
    before = digest()
    assert digest() == before
    (folder / file).write_text(f"{FILES[file]}MORE = 1.0\n")
    assert (digest() != before) == counts


def test_a_module_that_was_edited_since_it_was_loaded_has_the_digest_of_neither_text(folder: Path) -> None:
    file, text = folder / "law.py", f"{FILES['law.py']}    def force(self): return 1.0\n"
    file.write_text(text)
    before = digest()
    loaded = import_module("law").Law
    file.write_text(text.replace("1.0", "2.0"))
    between = digest_of_sources(loaded)
    file.write_text(text)
    assert digest_of_sources(loaded) == before
    file.write_text(text.replace("1.0", "2.0"))
    assert len({before, between, digest()}) == 3


def test_a_module_that_a_library_would_load_by_need_is_not_loaded(folder: Path) -> None:
    late = "class Late(ModuleType):\n    def __getattr__(self, name):\n        raise ImportError(name)\n"
    (folder / "beside.py").write_text(f"from types import ModuleType\n{late}absent = Late('absent')\n")
    assert digest()


def install(folder: Path, version: str, source: str) -> Path:
    """Put a distribution `beside` into a new folder of installed ones, with its record."""
    target = folder / version / "site-packages"
    (target / f"beside-{version}.dist-info").mkdir(parents=True)
    (target / "beside.py").write_text(source)
    digests = f"beside.py,sha256={version},9\n__pycache__/beside.pyc,,\nbesides.py,sha256={version},9\n"
    (target / f"beside-{version}.dist-info" / "RECORD").write_text(digests)
    return target


def test_what_is_installed_counts_by_its_record_and_is_not_read(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "beside.py").unlink()
    digests = []
    for version in ("1.0", "2.0"):
        target = install(folder, version, "import unrelated\n")
        monkeypatch.syspath_prepend(str(target))
        digests.append(digest())
        (target / "beside.py").write_text("import unrelated\nMORE = 1.0\n")
        assert digest() == digests[-1]
    assert digests[0] != digests[1]
    # Nor are the sources that it imports.
    (folder / "unrelated.py").write_text("UNUSED = 2.0\n")
    assert digest() == digests[1]


def test_what_is_installed_for_editing_counts_by_its_sources(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [each for each in sys.path if each != str(folder)])
    target = install(folder, "1.0", "")
    (target / "beside.py").unlink()
    (target / "editable.pth").write_text(f"{folder}\n")
    site.addsitedir(str(target))
    before = digest()
    (folder / "beside.py").write_text("LENGTH = 2.0\n")
    assert digest() != before


def test_a_class_of_an_installed_package_counts_by_its_sources(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = install(folder, "1.0", FILES["beside.py"])
    (folder / "law.py").rename(target / "law.py")
    monkeypatch.syspath_prepend(str(target))
    before = digest()
    (target / "law.py").write_text(f"{FILES['law.py']}MORE = 1.0\n")
    assert digest() != before


def test_a_process_with_other_sources_names_their_modules(folder: Path) -> None:
    digest()
    expected = {name: covered_sources()[name] for name in ("law", "table", "pack.leaf")}
    assert other_sources(expected) == []
    (folder / "table.py").write_text("SLOPE = 3.0\n")
    digest()
    assert other_sources(expected) == ["table"]


def test_classes_of_this_package_have_none() -> None:
    assert digest_of_sources(HertzPenalty) == ""


def test_written_kernels_beside_the_compiled_code_are_no_sources(folder: Path) -> None:
    before = digest_of(folder), digest()
    for cache in (folder / "__pycache__", folder / "pack" / "__pycache__"):
        cache.mkdir()
        (cache / "kernel.py").write_text("def force(): ...\n")
    assert (digest_of(folder), digest()) == before
