"""The counters of `docs/tools` count what they say, and nothing has grown beyond `ratchets.yaml`."""

from pathlib import Path

import called_once
import ledger
import pytest
from public_names import names_in, without_use

MODULES = {
    "once.py": """
def _once(x):
    return x

def _twice(x):
    return _twice(x - 1)

def _unused():
    def _inner():
        pass

@cache
def _kept(x):
    return x

def _given(x):
    return x

def public(x):
    return map(_given, [_kept(x), _once(_twice(_twice(x)))])
""",
    "classes.py": """
from contactlab.once import _unused

class Motor:
    def _drive(self):
        return self

    def _stop(self):
        return self._drive()

    def run(self):
        return self._stop()._drive()

class Block:
    def _go(self):
        pass

class Belt:
    def _go(self):
        pass

def go(body):
    body._go(_unused())
""",
}


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    (tmp_path / "contactlab").mkdir()
    for name, text in MODULES.items():
        (tmp_path / "contactlab" / name).write_text(text)
    return tmp_path


def test_a_private_function_counts_if_it_is_used_in_one_place(checkout: Path) -> None:
    counted = {(Path(file).name, name): lines for file, name, lines in called_once.called_once(checkout)}
    assert counted == {("once.py", "_once"): 2, ("once.py", "_unused"): 3, ("classes.py", "_stop"): 2}


def test_no_more_private_functions_are_called_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert called_once.main() == 0, capsys.readouterr().out


def test_every_file_of_package_and_tests_has_a_row() -> None:
    assert [file for _, file, row, _ in ledger.lines() if not row] == []


def test_a_row_is_the_first_that_matches_and_a_new_module_has_none() -> None:
    assert ledger.row_of("package", "contactlab/studies/compare/page.py") == "compare"
    assert ledger.row_of("package", "contactlab/studies/runner.py") == "studies, Dask, page"
    assert ledger.row_of("package", "contactlab/new.py") == ""


def test_a_name_is_used_where_a_text_takes_it_from_the_package() -> None:
    text = """
    import contactlab as cl
    from contactlab.laws import Newton, Poisson
    from contactlab import (
        Setup,
    )
    motor = cl.Motor(modes, drive)
    Stronge = 1.0
    """
    assert names_in(text) == {"Newton", "Poisson", "Setup", "Motor"}


def test_every_public_name_and_option_is_used_on_a_page() -> None:
    assert without_use() == []
