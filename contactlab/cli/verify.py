"""`contactlab verify [RUN ...]`: every claim with what is expected, what is found, tolerance and verdict."""

import shutil
import sys
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from textwrap import shorten
from time import perf_counter
from typing import TYPE_CHECKING

from contactlab.cli.arguments import Parser
from contactlab.cli.verbs import VERBS

if TYPE_CHECKING:
    from contactlab.testing import Claim

HOLDS, FAILS, REFUSED = 0, 1, 2
"""Exit statuses."""

NUMBERS = "{:>17} {:>15} {:>10}  {}"
WIDEST_CLAIM = 82


def main(arguments: list[str]) -> int:
    """Check everything, or some runs, and print the table.

    Returns:
        The exit status: 0 if every claim is as it should be, 2 for what is no run.
    """
    parser = Parser("verify", _description())
    parser.add_argument(
        "runs",
        metavar="RUN",
        nargs="*",
        help="a folder with run.nc, or a dataset in its layout: checked alone, by its numbers",
    )
    wanted = parser.read(arguments)
    try:
        groups = list(_of_runs(wanted.runs)) if wanted.runs else _groups()
    except ValueError as fault:
        print(fault, file=sys.stderr)
        return REFUSED
    started = perf_counter()
    width = min(max(shutil.get_terminal_size((140, 24)).columns - 58, 40), WIDEST_CLAIM)
    print(f"{'claim':<{width}}" + NUMBERS.format("expected", "found", "tolerance", "verdict"))
    checked: list[Claim] = []
    for heading, group in groups:
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
    return FAILS if failed else HOLDS


def _description() -> str:
    return (
        f"{VERBS['verify'].capitalize()}: closed forms on small plants, numbers of independent solvers "
        "for the paper's motor, random flights, and the contract of every law; or, given RUNs, whether "
        "what each recorded agrees with itself. Exit status 1 if a claim fails."
    )


def _of_runs(sources: Iterable[str]) -> Iterator[tuple[str, Callable[[], Iterable["Claim"]]]]:
    """Headings and claims of recorded runs.

    Raises:
        ValueError: a source is no run.
    """
    from contactlab.metrics import read_run
    from contactlab.testing.contract import invariants_of

    for source in sources:
        path = Path(source)
        tree = read_run(path / "run.nc" if path.is_dir() else path)
        yield source, partial(invariants_of, tree)


def _groups() -> Iterator[tuple[str, Callable[[], Iterable["Claim"]]]]:
    """Headings and their claims."""
    # Imported here: they bring the compiler, which --help does not need.
    from contactlab.testing import all_claims

    return all_claims()


def _row(claim: "Claim", width: int) -> str:
    unit = "" if claim.units == "1" else f" [{claim.units}]"
    words = shorten(claim.statement + unit, width, placeholder="...")
    tolerance = f"{claim.tolerance:.1e}" if claim.relation == "=" else ""
    expected = f"{'' if claim.relation == '=' else claim.relation + ' '}{claim.expected:.9g}"
    return f"{words:<{width}}" + NUMBERS.format(
        expected, f"{claim.found:.9g}", tolerance, claim.verdict
    )
