"""A micro sign is a micro sign in every locale, whichever of the two it is."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PLAIN = {
    "LC_ALL": "C",
    "PYTHONUTF8": "0",
    "PYTHONCOERCECLOCALE": "0",
    "PYTHONIOENCODING": "ascii",
}
"""A locale in which Python takes bytes beyond ASCII for none of its characters."""


def contactlab(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "contactlab", *(os.fsencode(a) for a in arguments)],
        cwd=folder,
        env={**os.environ, **PLAIN},
        capture_output=True,
        encoding="ascii",
        check=False,
    )


@pytest.mark.parametrize("sign", ["\u00b5", "\u03bc"])
def test_a_micro_sign_is_read_and_shown_in_a_plain_locale(sign: str, tmp_path: Path) -> None:
    done = contactlab(tmp_path, f"contact.clearance='-1 {sign}m'")
    shown = sign.encode("ascii", "backslashreplace").decode()
    assert done.stderr.startswith(
        f"contact.clearance is '-1 {shown}m' (-1e-06 m); it must be at least"
    )
    assert done.returncode == 2
    done = contactlab(tmp_path, "-m", f"contact.clearance=linspace(-1 {sign}m,1 {sign}m,2)")
    assert done.stderr.startswith("contact.clearance is -1e-06 m; it must be at least")
    assert done.returncode == 2
    assert list(tmp_path.iterdir()) == []


def test_a_run_in_a_plain_locale_keeps_its_arguments(tmp_path: Path) -> None:
    short = ("solver.duration=1e-4", "record.picture=false", "hydra.run.dir=here")
    done = contactlab(tmp_path, "contact.clearance='2 \u00b5m'", *short)
    assert done.returncode == 0, done.stderr
    written = (tmp_path / "here/.hydra/overrides.yaml").read_text(encoding="utf-8")
    assert "contact.clearance='2 \u00b5m'" in written


def test_a_folder_that_the_locale_cannot_spell_is_refused(tmp_path: Path) -> None:
    done = contactlab(tmp_path, "hydra.run.dir='\u00b5'")
    assert done.returncode == 2
    assert "cannot be spelled in ascii, the encoding of this locale" in done.stderr
    assert "Traceback" not in done.stderr
    for verb in ("collect", "compare", "animate"):
        done = contactlab(tmp_path, verb, "\u00b5")
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
