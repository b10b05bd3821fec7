"""Examples are listed and copied, from a checkout as from a wheel, and a copy harms nothing."""

import subprocess
import sys
from pathlib import Path

import pytest
from support.command_line import Command, left_behind

from contactlab.cli.verbs import example
from contactlab.results.provenance import digest_of

ROOT = Path(__file__).resolve().parents[2]
ONE_CONTACT = next((ROOT / example.GALLERY).glob("*_one_contact.py"))


def test_every_script_of_the_gallery_is_listed_by_its_name_with_its_title(command: Command) -> None:
    status, out, err = command("example")
    assert (status, err) == (0, "")
    scripts = sorted((ROOT / example.GALLERY).glob("*.py"))
    rows = [line.split(maxsplit=1) for line in out.partition("\n\n")[0].splitlines()]
    assert len(rows) == len(dict(rows)) > len(scripts) >= 5
    for path in scripts:
        assert f"\n{dict(rows)[path.stem.split('_', 2)[2]]}\n=====" in path.read_text(encoding="utf-8")
    assert left_behind() == []


@pytest.mark.parametrize(
    ("name", "copies"),
    [
        ("one_contact", {"one_contact.py": f"docs/gallery/{ONE_CONTACT.name}"}),
        ("drops", {"drops.csv": "docs/gallery/drops.csv"}),
        ("force_curve", {"force_curve.csv": "docs/gallery/force_curve.csv"}),
        ("motor_measurement", {"motor_measurement.csv": "docs/gallery/motor_measurement.csv"}),
        *(
            (
                copy,
                {
                    f"{copy}/{path.name}": f"{source}/{path.name}"
                    for path in (ROOT / source).iterdir()
                    if path.is_file()
                },
            )
            for copy, (source, *_) in example.PACKAGES.items()
        ),
    ],
)
def test_a_copy_has_the_bytes_of_the_example_and_its_next_step_is_told(
    command: Command, name: str, copies: dict[str, str]
) -> None:
    status, out, err = command("example", name)
    assert (status, err) == (0, "")
    made = {path.as_posix() for path in left_behind() if path.is_file()}
    assert made == set(copies)
    whole = min(copies).partition("/")[0]
    assert all(Path(copy).read_bytes() == (ROOT / source).read_bytes() for copy, source in copies.items())
    first, onward = out.splitlines()
    assert first.startswith(f"{whole} is here: ")
    assert onward.endswith(".")
    assert whole in onward


def test_a_loop_of_few_samples_a_corner_is_joined_by_lines() -> None:
    """A spline of degree 7 through the tribometer's turns swings beyond them."""
    (onward,) = (each.onward for each in example.examples() if each.name == "tribometer")
    assert " degree=1 " in onward


@pytest.mark.parametrize(("name", "copy"), [("run", "run.py"), ("own_law", "own_law")])
def test_a_copy_overwrites_nothing(command: Command, name: str, copy: str) -> None:
    Path(copy).write_text("mine")
    status, out, err = command("example", name)
    assert (status, out) == (2, "")
    assert copy in err
    assert Path(copy).read_text() == "mine"
    assert left_behind() == [Path(copy)]


def test_a_package_that_cannot_be_copied_whole_is_not_copied(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = example.shutil.copyfile

    def copyfile(source: Path, target: Path) -> None:
        if source.name == "pyproject.toml":
            raise OSError(28, "No space left on device", str(target))
        real(source, target)

    monkeypatch.setattr(example.shutil, "copyfile", copyfile)
    status, out, err = command("example", "own_law")
    assert (status, out) == (1, "")
    assert "No space left on device" in err
    assert left_behind() == []


@pytest.mark.long
def test_a_copied_script_runs(command: Command) -> None:
    command("example", "run")
    done = subprocess.run([sys.executable, "run.py"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "rotor velocity     -1.39" in done.stdout


def test_the_examples_of_a_wheel_are_no_part_of_the_code_that_a_run_depends_on(tmp_path: Path) -> None:
    (tmp_path / "examples").mkdir()
    (tmp_path / "engine.py").write_text("step = 1")
    before = digest_of(tmp_path)
    (tmp_path / "examples/run.py").write_text("a = 1")
    assert digest_of(tmp_path) == before
