"""Random motors through the command's own configuration, judged from their results alone.

    python validation/random_runs.py [--motors N] [--workers N] [--seed N] [--first N] [--csv FILE]
                                      [--page docs/random_runs.md]

Every configuration is far wider than a workshop's (`random_configuration`). A run that does not end as
complete must say why; one that does must keep every invariant (`contactlab.metrics.INVARIANTS`): closed
ledgers of energy, momentum and impulse, no contact without length, none missed, no release while the gap
closes, peaks and depths that no record exceeds; and those of `OWN`, of cuts, changes and bearings. What a law
promises of friction and tension is reported beside it. Rows that the CSV file already has are not run again,
so that a search that was cut goes on. The status is 1 where an invariant is broken; the command line of every
such run is printed.
"""

import argparse
import os
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path
from time import process_time
from typing import Any, Final

import numpy as np
import pandas as pd
from joblib import Parallel, delayed
from random_configuration import COMPOSED, DURATION, random_configuration
from tqdm import tqdm

import contactlab as cl
from contactlab.config import compose
from contactlab.config.nesting import flat, nested
from contactlab.laws import MultiplierLaw, law_class
from contactlab.metrics import INVARIANTS, METRICS, assess
from contactlab.results.netcdf import to_datatree
from contactlab.results.provenance import code_digest
from contactlab.trajectory import Trajectory

FIGURES: Final = (
    *INVARIANTS,
    *("tension", "cone_excess", "friction_gain", "normal_gain", "contact_gain", "stick_slip"),
)
"""The invariants, and metrics of what most laws promise; some declare that they break them."""

CHUNK: Final = 20
"""Motors a task."""

COMPLETE, REFUSED, FAILED = "complete", "refused", "failed"

PLAIN: Final = (
    *("number", "law", "resonator", "drive", "bearing", "changes", "stepped", "ending", "message"),
    *("contacts", "steps", "seconds", "code"),
)
"""Columns of the rows beside the figures."""

CUT: Final = 5
"""Of so many motors one is run in two parts as well."""

AFTER: Final = 1e-5
"""Time after a change up to which the motor is run without it as well [s]."""

CUT_SERIES: Final = ("tip_normal_displacement", "tip_slope", "rotor_velocity", "rotor_angle", "drive_work")
"""What a cut, or a change that has yet to act, leaves as it is."""


def difference(run: Mapping[str, np.ndarray], other: Mapping[str, np.ndarray], i: int, j: int) -> float:
    """Largest difference of the record i of a run from record j of another, over the size of the first."""
    sizes = ((name, max(float(np.abs(run[name]).max()), 1e-300)) for name in CUT_SERIES)
    return max(abs(float(run[name][i] - other[name][j])) / size for name, size in sizes)


def cut_difference(setup: cl.Setup, run: Trajectory) -> float:
    """Difference of the end of a run in two parts from that in one."""
    first = 0.7 * setup.duration
    length = setup.duration - first
    interval = min(setup.record_interval, length)
    before = setup.run(duration=first)
    after = setup.run(duration=length, start=before.state, record_interval=interval)
    if not (before.ending.reached_end and after.ending.reached_end):
        return float("inf")
    return difference(run.series, after.series, -1, -1)


def change_difference(setup: cl.Setup, run: Trajectory) -> float:
    """Difference of the record at the first change from that of the run without changes."""
    time = setup.changes[0][0]
    plain = cl.build(setup.configuration | {"solver": setup.configuration["solver"] | {"changes": None}})
    uncut = plain.run(duration=min(time + AFTER, setup.duration), record_interval=time)
    at = int(np.argmin(np.abs(run.time - time)))
    if run.time[at] != time or uncut.time[1] != time:
        return float("inf")
    return difference(run.series, uncut.series, at, 1)


LEAN: Final = 1e-2
"""Angle between the contact's normal and the bearing [rad], up to which its mean over a record is known well
enough."""


def bearing_momentum(setup: cl.Setup, run: Trajectory) -> float:
    """Momentum of the rotor on its bearing that force, preload, spring and damper do not explain.

    |m w' + c w + k int w dt - int (N_u - P) dt| / int (N + |P| + k |w|) dt
    """
    motors = [(0.0, setup.motor), *setup.changes]
    stiffness, damping = (x[-1] for x in (setup.motor.modes.stiffness, setup.motor.modes.damping))
    root = 1.0 / setup.motor.modes.rotor_displacement[-1]
    mass, length = root * root, np.diff(run.time)
    w, geometry = run.series["rotor_normal_displacement"], setup.motor.geometry
    lean = geometry.tip_length * run.series["tip_slope"] / geometry.rotor_radius
    forces = run.series["normal_force"][1:], run.series["friction_force"][1:]
    if np.abs(lean).max() > LEAN:
        return float("nan")
    pushed = float((forces[0] + forces[1] * 0.5 * (lean[1:] + lean[:-1])) @ length)
    ends = [*(time for time, _ in motors[1:]), setup.duration]
    pressed = -root * sum(
        float(motor.preload[-1]) * (end - time) for (time, motor), end in zip(motors, ends, strict=True)
    )
    sprung = mass * stiffness * float(0.5 * (w[1:] + w[:-1]) @ length)
    carried = root * float(run.final.velocity[-1]) + mass * damping * float(w[-1] - w[0])
    scale = float(forces[0] @ length) + abs(pressed) + mass * stiffness * float(np.abs(w[1:]) @ length)
    return abs(carried + sprung - pushed + pressed) / scale


OWN: Final[dict[str, tuple[float, Callable[[cl.Setup, Trajectory], float]]]] = {
    "cut_difference": (0.0, cut_difference),
    "change_difference": (1e-5, change_difference),
    "bearing_momentum": (1e-2, bearing_momentum),
}
"""Invariants of runs with a cut, a change or a bearing: bounds and functions. A change ends a step, which has
an error of its own; the bearing's momentum is summed from records."""

BOUNDS: Final = {key: metric.bound for key, metric in INVARIANTS.items()} | {
    key: bound for key, (bound, _) in OWN.items()
}
"""Bounds of all invariants."""


@lru_cache(maxsize=4096)
def _base(groups: frozenset[tuple[str, str]]) -> dict[str, Any]:
    """The values by full key where these options are chosen."""
    return flat(compose([f"{group}={option}" for group, option in sorted(groups)]))


def setup_of(number: int, seed: int = 0) -> cl.Setup:
    """Build a random configuration."""
    groups, values = random_configuration(number, seed)
    return cl.build(nested(_base(frozenset(groups.items())) | values))


def outcome_of(number: int, seed: int = 0) -> dict[str, Any]:
    """Run one random configuration.

    Returns:
        Its `number`, its `law` with the friction's name of a composed one, its resonator and drive, whether
        it has a bearing, how many changes, how its law is solved, the `ending` of the run, REFUSED or FAILED,
        the `message` why it did not reach its end, `contacts`, `steps` of the solver with the rejected ones,
        `seconds` of processor that it took, the digest of the `code`, and its figures.
    """
    groups, values = random_configuration(number, seed)
    law = groups["law"]
    row: dict[str, Any] = {
        "number": number,
        "law": f"{law}, {groups['law/friction']}" if law == COMPOSED else law,
        "resonator": groups["resonator"],
        "drive": groups["drive"],
        "bearing": "contact.preload" in values,
        "changes": len(values.get("solver.changes", ())),
        "stepped": "solver.contact_step" in values,
    }
    started = process_time()
    try:
        row |= _run(setup_of(number, seed), number)
    except cl.ConfigurationError as fault:
        row |= {"ending": REFUSED, "message": str(fault), "contacts": 0, "steps": 0}
    except Exception as fault:
        row |= {"ending": FAILED, "message": repr(fault), "contacts": 0, "steps": 0}
    return row | {"seconds": process_time() - started, "code": code_digest()[:12]}


def _run(setup: cl.Setup, number: int) -> dict[str, Any]:
    """Run a setup and judge it."""
    run = setup.run(record_interval=min(setup.record_interval, setup.duration))
    steps = ("flight_steps", "contact_steps", "rejected_steps")
    row = {
        "ending": run.ending.name.lower(),
        "message": run.message,
        "contacts": run.contacts["start_time"].size,
        "steps": sum(run.statistics[name] for name in steps),
        **assess(to_datatree(run, setup.configuration), set(FIGURES)),
    }
    if run.complete:
        judged = {
            "cut_difference": number % CUT == 0 and not setup.changes,
            "change_difference": bool(setup.changes) and setup.tolerance is not None,
            "bearing_momentum": setup.motor.preload is not None,
        }
        row |= {key: OWN[key][1](setup, run) for key, applies in judged.items() if applies}
    return row


def broken(outcome: Mapping[str, Any]) -> list[str]:
    """Name the invariants that a complete run breaks, or that it failed."""
    if outcome["ending"] == FAILED:
        return [FAILED]
    judged = BOUNDS if outcome["ending"] == COMPLETE else {}
    return [key for key, bound in judged.items() if outcome.get(key, 0.0) > bound]


def outcomes_of(numbers: Sequence[int], seed: int = 0) -> pd.DataFrame:
    """Run some configurations, one after the other; gives a row for each, see `outcome_of`."""
    rows = pd.DataFrame([outcome_of(number, seed) for number in numbers])
    return rows.reindex(columns=[*PLAIN, *FIGURES, *OWN])


def table(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Return a row a law: how its runs end, and the worst of every figure among the complete ones."""
    by_law = outcomes.groupby("law")
    rows = by_law.agg(
        motors=("number", "size"),
        contacts=("contacts", "sum"),
        endings=("ending", _counts),
        longest=("seconds", "max"),
    )
    complete = outcomes[outcomes["ending"] == COMPLETE]
    return rows.join(complete.groupby("law")[[*FIGURES, *OWN]].max())


def _counts(endings: pd.Series) -> str:
    return ", ".join(f"{n} {word}" for word, n in endings.value_counts().items())


def reasons(outcomes: pd.DataFrame) -> list[tuple[int, str, str]]:
    """Return how often runs ended otherwise than complete or refused, by ending and reason, with examples."""
    others = outcomes[~outcomes["ending"].isin([COMPLETE, REFUSED])]
    number = re.compile(r"[-+]?\d[\d.e+-]*")
    numbers_of: dict[tuple[str, str], list[int]] = {}
    for row in others.to_dict("records"):
        sentence = number.sub("#", row["message"]).partition(". ")[0]
        numbers_of.setdefault((row["ending"], sentence), []).append(row["number"])
    counted = sorted(numbers_of.items(), key=lambda item: -len(item[1]))
    return [
        (
            len(numbers),
            f"{ending}: {sentence}",
            ", ".join(map(str, numbers[:MOST])) + " ..." * (len(numbers) > MOST),
        )
        for (ending, sentence), numbers in counted
    ]


MOST: Final = 12
"""Numbers of motors that a row lists."""


def page(outcomes: pd.DataFrame, command: str) -> str:
    """Return the tables as Markdown: parts, endings, and the worst figures of every law's complete runs."""
    rows = table(outcomes).reset_index()
    whole = outcomes[outcomes["ending"] == COMPLETE]
    faults = sum(bool(broken(outcome)) for outcome in outcomes.to_dict("records"))
    parts = outcomes.assign(
        resonator="resonator=" + outcomes["resonator"],
        drive="drive=" + outcomes["drive"],
        bearing=outcomes["bearing"].map({True: "bearing", False: "fixed axle"}),
        changes=outcomes["changes"].map(lambda n: "with changes" if n else "without changes"),
        way=[*map(_way, outcomes["law"], outcomes["stepped"])],
    )
    counted = [
        (name, len(group), int(group["contacts"].sum()), _counts(group["ending"]))
        for column in ("resonator", "drive", "bearing", "changes", "way")
        for name, group in parts.groupby(column)
    ]
    judged = outcomes[list(OWN)].notna().sum()
    return "\n".join(
        [
            "# Random motors",
            "",
            f"<!-- Made by {command}. Do not edit. -->",
            "",
            f"{len(outcomes)} random configurations of the command, numbers {outcomes['number'].min()} to "
            f"{outcomes['number'].max()}, of {1e3 * DURATION[0]:g} to {1e3 * DURATION[1]:g} ms each, judged "
            "from their results alone (`validation/random_runs.py`). Complete runs that break an "
            f"invariant: {faults}. [plausibility.md](plausibility.md) has the meaning of the invariants and "
            "the reason for their bounds. Beside them:",
            "",
            f"* `cut_difference`, of {judged['cut_difference']} motors: end of a run in two parts against "
            "that in one;",
            f"* `change_difference`, of {judged['change_difference']} motors: record at the first change "
            "against the run without it, which the end of a step there moves by its error;",
            f"* `bearing_momentum`, of {judged['bearing_momentum']} motors: momentum of a rotor on its "
            "bearing against force, preload, spring and damper, summed from records.",
            "",
            f"Endings: {_counts(outcomes['ending'])}. Motors by the digest of the code that ran them: "
            f"{_counts(outcomes['code'])}.",
            "",
            *_table(["part", "motors", "contacts", "endings"], counted),
            "",
            "## Runs that end early",
            "",
            *_table(["runs", "ending and reason", "numbers"], reasons(outcomes)),
            "",
            "## Worst of the complete runs",
            "",
            *_table(
                ["invariant", "bound", "worst", "of the law", "motor"],
                ([f"`{key}`", f"{bound:g}", *_worst(whole, key)] for key, bound in BOUNDS.items()),
            ),
            "",
            "## Laws",
            "",
            *_table(
                ["law", "motors", "contacts", "endings"],
                rows[["law", "motors", "contacts", "endings"]].itertuples(index=False),
            ),
            "",
        ]
    )


def _worst(runs: pd.DataFrame, key: str) -> tuple[str, str, int | str]:
    """Return the largest value of an invariant, with the law and the number of its motor."""
    if runs[key].isna().all():
        return "", "", ""
    row = runs.loc[runs[key].idxmax()]
    return f"{row[key]:.1e}", str(row["law"]), int(row["number"])


def _way(law: str, stepped: bool) -> str:
    if not issubclass(law_class(law.partition(",")[0]), MultiplierLaw):
        return "compliant"
    return "rigid, stepped in time" if stepped else "rigid, limit of no step"


def _table(heads: Sequence[str], rows: Iterable[Iterable[object]]) -> list[str]:
    return [_cells(heads), _cells(["---"] * len(heads)), *map(_cells, rows)]


def _cells(cells: Iterable[object]) -> str:
    return f"| {' | '.join(map(str, cells))} |"


def command_line(number: int, seed: int = 0) -> str:
    """Return the command that runs a configuration."""
    groups, values = random_configuration(number, seed)
    text = [f"{group}={option}" for group, option in groups.items()]
    text += [f"{key}={'null' if value is None else value}" for key, value in values.items()]
    return shlex.join(["contactlab", *text])


def show(outcomes: pd.DataFrame, seed: int) -> None:
    """Print the table, how runs ended that are not complete, and every broken invariant."""
    rows = table(outcomes)
    print(rows[["motors", "contacts", "longest", "endings"]].to_string(float_format="%.1f s"))
    print("\nWorst figure of the runs that say complete:")
    bounds = {key: METRICS[key].bound for key in FIGURES} | BOUNDS
    worst = rows[list(bounds)].T.assign(bound=[*bounds.values()])
    print(worst.to_string(float_format="%.1e"))
    for outcome in outcomes.to_dict("records"):
        text = f"{outcome['number']} {outcome['law']}"
        if outcome["ending"] not in {COMPLETE, REFUSED}:
            print(f"\n{text}: {outcome['ending']}. {outcome['message']}")
        if faults := broken(outcome):
            print(f"\nBroken: {text}: {', '.join(f'{key} {outcome.get(key)}' for key in faults)}")
            print(f"  {command_line(outcome['number'], seed)}")


def outcomes_in(path: Path, numbers: range, seed: int, workers: int) -> pd.DataFrame:
    """Run the numbers that a file lacks, and add their rows chunk by chunk; returns all rows."""
    have = set(pd.read_csv(path, usecols=["number"])["number"]) if path.is_file() else set()
    missing = [number for number in numbers if number not in have]
    chunks = [missing[i : i + CHUNK] for i in range(0, len(missing), CHUNK)]
    work = delayed(partial(outcomes_of, seed=seed))
    parts = Parallel(n_jobs=workers, return_as="generator_unordered")(work(chunk) for chunk in chunks)
    for rows in tqdm(parts, total=len(chunks), unit=f" x {CHUNK}", disable=None):
        rows.to_csv(path, mode="a", header=not path.is_file(), index=False)
    blanks = {key: [""] for key in (*FIGURES, *OWN)}
    # A digest may look like a number.
    rows = pd.read_csv(path, keep_default_na=False, na_values=blanks, dtype={"code": str})
    return rows[rows["number"].isin(numbers)].sort_values("number", ignore_index=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print and write the table; returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--motors", type=int, default=10_000, help="how many motors")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes")
    parser.add_argument("--seed", type=int, default=0, help="of the random generator")
    parser.add_argument(
        "--csv", type=Path, default=Path("random_runs.csv"), help="the rows, which are gone on with"
    )
    parser.add_argument("--page", type=Path, help="the tables as a page")
    options = parser.parse_args(arguments)
    # Matrices this small are slower on threads, and the workers take all cores already.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    numbers = range(options.first, options.first + options.motors)
    outcomes = outcomes_in(options.csv, numbers, options.seed, options.workers)
    show(outcomes, options.seed)
    if options.page:
        script = "python validation/random_runs.py"
        command = f"{script} --first {options.first} --motors {options.motors} --seed {options.seed}"
        options.page.write_text(page(outcomes, command), encoding="utf-8")
    return int(any(broken(outcome) for outcome in outcomes.to_dict("records")))


if __name__ == "__main__":
    # Workers import what they are to do, which they could not from a script.
    import random_runs

    sys.exit(random_runs.main())
