"""README's commands are read as they stand, and their steps are run and measured in an empty folder."""

import shutil
import subprocess
import sys
from pathlib import Path

import first_hour
import pytest
from first_hour import BEGIN, END, Step, main, page_of, put_into
from readme_commands import FIGURE, GREEN, commands_of, steps_of

ROOT = Path(__file__).resolve().parents[2]
OLD = """
    python3 -m venv .venv && . .venv/bin/activate && pip install -e ".[test]" && contactlab

Then the tests, `pytest`:

    pytest
"""
NEW = """
    not this one

```python
import pytest
```
```bash
contactlab --help
python3 -m venv .venv && . .venv/bin/activate && pip install -e . && contactlab
```
```bash
pip install -e ".[test]" && pytest
```
"""


def test_the_commands_are_found_indented_as_well_as_fenced() -> None:
    first, second = commands_of(OLD)
    assert first.startswith("python3 -m venv")
    assert second == "pytest"
    assert commands_of(NEW)[1] == 'pip install -e ".[test]" && pytest'


def test_the_readme_as_it_is_has_both_commands() -> None:
    names = [name for name, _ in steps_of((ROOT / "README.md").read_text(encoding="utf-8"), tests=True)]
    assert names[:4] == ["environment", "install", "first run", "second run"]
    assert names[-1] == "tests"


def test_what_a_shell_keeps_stands_before_every_later_step() -> None:
    steps = dict(steps_of(NEW, tests=True))
    assert [*steps] == [*FIGURE, "second run", *GREEN[-2:]]
    assert steps["environment"] == "python3 -m venv .venv"
    assert steps["tests"] == ". .venv/bin/activate && pytest"
    assert [*dict(steps_of(NEW, tests=False))] == [*FIGURE, "second run"]


def test_a_readme_without_the_commands_is_told() -> None:
    with pytest.raises(ValueError, match="no command that makes an environment"):
        commands_of("contactlab")


def of_step(name: str, processor: float, passed: bool = True) -> Step:
    return Step("abc", "3.13.0", name, 2.0 * processor, processor, 10.0, 0.0, passed)


def test_the_second_run_is_not_waited_for() -> None:
    every = zip(
        ("environment", "install", "first run", "second run"), (1.0, 20.0, 300.0, 4000.0), strict=True
    )
    told = page_of([of_step(*each) for each in every])
    assert "| 321 s (642 s) |" in told


def test_a_failed_step_reaches_nothing() -> None:
    told = page_of([of_step("environment", 1.0), of_step("install", 1.0, passed=False)])
    assert "1 s (2 s), failed | not reached |" in told


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("tests", "'tests' is none of python=..., commit=..."),
        ("tests=no", "tests=no must be true or false."),
        ("commit=nosuch", "There is no commit 'nosuch'"),
        ("page=README.md", "README.md is no page with a table of this script"),
        ("python=2.0", "Python 2.0 is not on this machine."),
    ],
)
def test_what_cannot_be_measured_is_told_in_a_sentence(
    word: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([f"output={tmp_path / 'left'}", word]) == 2
    assert told in capsys.readouterr().err
    assert not (tmp_path / "left").exists()


def test_the_table_of_a_page_is_made_anew_and_nothing_else(tmp_path: Path) -> None:
    there = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
    page = tmp_path / "install.md"
    page.write_text(there, encoding="utf-8")
    put_into(page, "| a |")
    put_into(page, "| b |")
    made = page.read_text(encoding="utf-8")
    assert f"{BEGIN}\n\n| b |\n{END}" in made
    assert "| a |" not in made
    outside = made.partition(BEGIN)[0], made.partition(END)[2]
    assert outside == (there.partition(BEGIN)[0], there.partition(END)[2])


@pytest.mark.long
def test_a_project_is_cloned_and_its_steps_are_run_and_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    project, left = tmp_path / "project", tmp_path / "left"
    project.mkdir()
    # A run that takes processor time and leaves its figure, under the settings of a new user.
    work = "sum(range(10**7)); open('run.png', 'w'); assert 'MPLBACKEND' not in os.environ"
    first = f'python3 -m venv .venv && . .venv/bin/activate && pip --version && python -c "import os; {work}"'
    (project / "README.md").write_text(f"    {first}\n\n    pytest\n")
    for words in (["init"], ["add", "."], ["commit", "-m", "one"]):
        author = ["-c", "user.name=a", "-c", "user.email=a@b"]
        subprocess.run([shutil.which("git") or "git", *author, "-C", str(project), *words], check=True)
    monkeypatch.setattr(first_hour, "ROOT", project)
    monkeypatch.setenv("MPLBACKEND", "agg")
    assert main([f"python={sys.executable}", "tests=false", f"output={left}"]) == 0
    rows = [line.split(",") for line in (left / "steps.csv").read_text().splitlines()]
    assert [row[2] for row in rows[1:]] == [*FIGURE, "second run"]
    assert all(0.0 < float(row[4]) < 100.0 for row in rows[1:])
    assert float(rows[3][4]) > 0.1
    assert any(line.split(",")[2] == "pip" for line in (left / "packages.csv").read_text().splitlines())
