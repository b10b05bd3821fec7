"""Answer the contact questions with contactlab and with simulators of the package index.

    python benchmarks/simulators/run.py

Installs the simulators in an environment of its own in a temporary folder, writes results.json beside this
file, and from it the findings and the table of docs/simulators.md. It takes some three minutes.
"""

import json
import subprocess
import sys
import venv
from collections.abc import Iterator
from importlib.metadata import version
from math import isfinite, nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import simulator_page
from questions import questions

HERE: Final = Path(__file__).parent

PACKAGES: Final = {"mujoco": "MuJoCo", "pybullet": "PyBullet", "exudyn": "Exudyn", "scipy": "SciPy"}

DIGITS: Final = 12
"""Of the answers that are kept, and two of the ratios of time."""

ROUND_OFF: Final = 1e-13
"""Answers below are zero: their digits are those of a machine."""


def installed(folder: Path) -> tuple[Path, dict[str, str], dict[str, str]]:
    """Return the interpreter of a new environment, versions of its simulators, and why others are missing."""
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    versions, missing = {}, {}
    for package in PACKAGES:
        pip = [python, "-m", "pip", "install", "--quiet", "--only-binary", ":all:", "numpy", package]
        if subprocess.run(pip, check=False).returncode:
            missing[PACKAGES[package]] = "pip installs no wheel of it here"
            continue
        code = f"from importlib.metadata import version; print(version({package!r}))"
        made = subprocess.run([python, "-c", code], check=True, capture_output=True, text=True)
        versions[PACKAGES[package]] = made.stdout.strip()
    return python, versions, missing


class Entrant:
    """A process that answers questions."""

    def __init__(self, python: Path, script: str) -> None:
        self.process = subprocess.Popen(
            [python, HERE / f"{script}.py"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        offers = self.line()
        self.settings, self.kinds = offers["settings"], offers["kinds"]

    def line(self) -> Any:
        """Return the next object that is printed; libraries may print lines of their own."""
        assert self.process.stdout is not None
        for text in self.process.stdout:
            if text.startswith("{"):
                return json.loads(text)
        raise RuntimeError(f"{self.process.args} ended with status {self.process.wait()}.")

    def reply(self, setting: str, kind: str, numbers: Any) -> Any:
        """Return answers and processor time [s] to a question."""
        assert self.process.stdin is not None
        question = {"setting": setting, "kind": kind, "numbers": dict(numbers)}
        self.process.stdin.write(json.dumps(question) + "\n")
        self.process.stdin.flush()
        return self.line()

    def close(self) -> None:
        """End the process."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


def rounded(value: float, digits: int = DIGITS) -> float | None:
    """Return a number to some digits, zero where it is round-off; None where there is none."""
    if not isfinite(value):
        return None
    return 0.0 if abs(value) < ROUND_OFF else float(f"{value:.{digits}g}")


def measured(entrant: Entrant) -> Iterator[tuple[str, dict[str, Any], float]]:
    """Yield each setting with its answers, and the processor time of the blocks [s].

    Every question is put twice: what is compiled or loaded at first has no part in the time.
    """
    for setting in entrant.settings:
        values: dict[str, dict[str, list[float | None]]] = {}
        seconds = 0.0
        for question in questions():
            if question.kind not in entrant.kinds:
                continue
            for _ in range(2):
                reply = entrant.reply(setting, question.kind, question.numbers)
            for name in question.exact | question.at_most:
                value = rounded(reply["answers"].get(name, nan))
                values.setdefault(question.name, {}).setdefault(name, []).append(value)
            seconds += reply["seconds"] * (question.kind == "block")
        yield setting, values, seconds


def main() -> None:
    """Measure, and write results and page."""
    with TemporaryDirectory() as folder:
        python, versions, missing = installed(Path(folder))
        versions = {"contactlab": version("contactlab"), **versions}
        scripts = {"contactlab": (Path(sys.executable), "with_contactlab")}
        scripts |= {name: (python, f"with_{each}") for each, name in PACKAGES.items() if name in versions}
        rows = []
        for name, (interpreter, script) in scripts.items():
            entrant = Entrant(interpreter, script)
            for setting, values, seconds in measured(entrant):
                print(name, setting, file=sys.stderr)
                rows.append({"entrant": name, "setting": setting, "values": values, "time": seconds})
            entrant.close()
    unit = rows[0]["time"]
    for row in rows:
        row["time"] = rounded(row["time"] / unit, 2)
    lines = ",\n".join(map(json.dumps, rows))
    head = json.dumps({"versions": versions, "missing": missing})[:-1]
    simulator_page.RESULTS.write_text(f'{head}, "rows": [\n{lines}\n]}}\n', encoding="utf-8")
    simulator_page.PAGE.write_text(simulator_page.page(), encoding="utf-8")


if __name__ == "__main__":
    main()
