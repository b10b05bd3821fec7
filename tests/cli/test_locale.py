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

SHORT = ("solver.duration=1e-4", "record.picture=false", "hydra.run.dir=here")
RUN = ("contact.clearance='2 \u00b5m'", *SHORT)

Told = tuple[Path, dict[tuple[str, ...], tuple[str, str]]]


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Told:
    """A folder, and errors and statuses of commands by their arguments; the run alone leaves anything."""
    folder = tmp_path_factory.mktemp("plain")
    values = [*((word,) for word in MICRO.values()), *(("-m", word) for word in SWEEP.values())]
    values += [RUN]
    done = subprocess.run(
        [sys.executable, "-c", ONE_AFTER_ANOTHER],
        cwd=folder,
        env={**os.environ, **PLAIN},
        input=b"\n".join(b"\0".join(map(os.fsencode, text)) for text in values),
        capture_output=True,
        check=False,
    )
    *reported, after = done.stderr.decode("ascii").split("\0")
    assert (done.returncode, after) == (0, ""), after
    assert [path.name for path in folder.iterdir()] == ["here"]
    return folder, dict(zip(values, zip(reported[::2], reported[1::2], strict=True), strict=True))


@pytest.mark.long
@pytest.mark.parametrize("sign", SIGNS)
def test_a_micro_sign_is_read_and_shown_in_a_plain_locale(sign: str, plain: Told) -> None:
    _, reported = plain
    shown = sign.encode("ascii", "backslashreplace").decode()
    err, status = reported[(MICRO[sign],)]
    assert err.startswith(f"contact.clearance is '-1 {shown}m' (-1e-06 m); it must be at least")
    assert status == "2"
    err, status = reported["-m", SWEEP[sign]]
    assert err.startswith("contact.clearance is -1e-06 m; it must be at least")
    assert status == "2"
