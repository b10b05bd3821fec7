"""Print the contract of every law, or check what runs recorded.

A line a claim: what is expected and found, tolerance, verdict. Given RUNs, whether the numbers of each run
agree with each other. Exit status 1 if a claim fails.
"""

import shutil
from functools import partial
from pathlib import Path
from textwrap import shorten
from time import perf_counter

from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, RefusalError
from contactlab.metrics import read_run
from contactlab.testing import Claim, all_claims, invariants_of

NUMBERS = "{:>17} {:>15} {:>10}  {}"
WIDEST_CLAIM = 82


def main(arguments: list[str]) -> int:
    """Check everything, or some runs, print the table and give the exit status.

    Raises:
        RefusalError: a source is no run.
    """
    meaning = "a folder with run.nc, or a dataset in its layout: checked alone, by its numbers"
    operands, _ = Parser(__name__, __doc__, "[RUN ...]", meaning).read(arguments)
    runs = [*map(Path, operands)]
    try:
        trees = [read_run(path / "run.nc" if path.is_dir() else path) for path in runs]
    except ValueError as fault:
        raise RefusalError(str(fault)) from fault
    of_runs = [(str(p), partial(invariants_of, tree)) for p, tree in zip(runs, trees, strict=True)]
    started = perf_counter()
    width = min(max(shutil.get_terminal_size((140, 24)).columns - 58, 40), WIDEST_CLAIM)
    print(f"{'claim':<{width}}" + NUMBERS.format("expected", "found", "tolerance", "verdict"))
    checked: list[Claim] = []
    for heading, group in of_runs or all_claims():
        print(f"\n{heading}", flush=True)
        for claim in group():
            checked.append(claim)
            print(_row(claim, width), flush=True)
    failed = [claim for claim in checked if not claim.holds]
    broken = sum(bool(claim.excuse) and claim.holds for claim in checked)
    print(
        f"\n{len(checked)} claims in {perf_counter() - started:.0f} s: "
        f"{len(checked) - len(failed) - broken} hold, {broken} are broken as their law declares, "
        f"{len(failed)} fail."
    )
    for claim in failed:
        print(f"Failed: {claim}")
    return INCOMPLETE if failed else COMPLETE


def _row(claim: Claim, width: int) -> str:
    unit = "" if claim.units == "1" else f" [{claim.units}]"
    text = shorten(claim.statement + unit, width, placeholder="...")
    tolerance = f"{claim.tolerance:.1e}" if claim.relation == "=" else ""
    expected = f"{'' if claim.relation == '=' else claim.relation + ' '}{claim.expected:.9g}"
    return f"{text:<{width}}" + NUMBERS.format(expected, f"{claim.value:.9g}", tolerance, claim.verdict)
