"""A micro sign is a micro sign in every locale, whichever of the two it is."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PLAIN = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"}
"""A locale in which Python takes bytes beyond ASCII for none of its characters."""

ONE_AFTER_ANOTHER = """
import os, sys
from contactlab.cli.main import main

for line in sys.stdin.buffer.read().splitlines():
    # As Python takes the bytes of a command line.
    sys.argv[1:] = map(os.fsdecode, line.split(b"\\0"))
    print("\\0", main(), "\\0", sep="", end="", file=sys.stderr)
"""

SIGNS = ("\u00b5", "\u03bc")
MICRO = {sign: f"contact.clearance='-1 {sign}m'" for sign in SIGNS}
SWEEP = {sign: f"contact.clearance=linspace(-1 {sign}m,1 {sign}m,2)" for sign in SIGNS}
UNSPELLED = [("hydra.run.dir='\u00b5'",), *((v, "\u00b5") for v in ("collect", "compare", "animate"))]

Refusals = dict[tuple[str, ...], tuple[str, str]]


@pytest.fixture(scope="module")
def refusals(tmp_path_factory: pytest.TempPathFactory) -> Refusals:
    """Errors and statuses of commands that are refused, by their arguments; nothing is left of them."""
    folder = tmp_path_factory.mktemp("plain")
    given = [*((word,) for word in MICRO.values()), *(("-m", word) for word in SWEEP.values())]
    given += UNSPELLED
    done = subprocess.run(
        [sys.executable, "-c", ONE_AFTER_ANOTHER],
        cwd=folder,
        env={**os.environ, **PLAIN},
        input=b"\n".join(b"\0".join(map(os.fsencode, words)) for words in given),
        capture_output=True,
        check=False,
    )
    *told, after = done.stderr.decode("ascii").split("\0")
    assert (done.returncode, after) == (0, ""), after
    assert list(folder.iterdir()) == []
    return dict(zip(given, zip(told[::2], told[1::2], strict=True), strict=True))


@pytest.mark.parametrize("sign", SIGNS)
def test_a_micro_sign_is_read_and_shown_in_a_plain_locale(sign: str, refusals: Refusals) -> None:
    shown = sign.encode("ascii", "backslashreplace").decode()
    err, status = refusals[(MICRO[sign],)]
    assert err.startswith(f"contact.clearance is '-1 {shown}m' (-1e-06 m); it must be at least")
    assert status == "2"
    err, status = refusals["-m", SWEEP[sign]]
    assert err.startswith("contact.clearance is -1e-06 m; it must be at least")
    assert status == "2"


def test_a_run_in_a_plain_locale_keeps_its_arguments(tmp_path: Path) -> None:
    given = "contact.clearance='2 \u00b5m'"
    short = ("solver.duration=1e-4", "record.picture=false", "hydra.run.dir=here")
    done = subprocess.run(
        [sys.executable, "-m", "contactlab", os.fsencode(given), *short],
        cwd=tmp_path,
        env={**os.environ, **PLAIN},
        capture_output=True,
        encoding="ascii",
        check=False,
    )
    assert done.returncode == 0, done.stderr
    written = (tmp_path / "here/.hydra/overrides.yaml").read_text(encoding="utf-8")
    assert given in written


def test_a_folder_that_the_locale_cannot_spell_is_refused(refusals: Refusals) -> None:
    for words in UNSPELLED:
        err, status = refusals[words]
        assert status == "2"
        assert "Traceback" not in err
    assert "cannot be spelled in ascii, the encoding of this locale" in refusals[UNSPELLED[0]][0]
