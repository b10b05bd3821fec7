"""Tables of the pages on accuracy, fits and data sheets, from docs/results/accuracy.json."""

from collections.abc import Callable
from math import sqrt
from typing import Any, Final

from recorded_numbers import results
from result_tables import markdown
from verdicts import Number

from contactlab_data.inference.fit import ENDS

NAMES: Final = {
    "friction_coefficient": "friction coefficient",
    "rest_stiffness": "stiffness at rest",
    "voltage_1": "voltage",
    "restitution": "restitution",
    "discrepancy": "size of the error",
    "law.stiffness": "stiffness (N/m^1.5)",
    "contact.friction_coefficient": "friction coefficient",
}
"""Numbers that are fitted."""


def section(name: str) -> Any:
    """Return a section."""
    return results("accuracy")[name]


def case_a() -> str:
    """Return the reference case beside independent solvers."""
    labels = {
        "lagrange_slip": ("`lagrange_slip`", ", by its time stepping"),
        "lagrange_stick, stepped": ("`lagrange_stick` in time stepping, `solver.contact_step=5e-8`", ""),
    }
    head = ("", "rotor velocity (rad/s)", "reference (rad/s)", "contacts", "ledger residual over drive work")
    rows = []
    for name, row in section("case A").items():
        label, by = labels.get(name, (f"`{name}`", ""))
        reference = f"{row['reference']:.{5 if by else 7}f}".rstrip("0")
        rows.append(
            (label, f"{row['rotor_velocity']:.7f}", reference + by, row["contacts"], f"{row['residual']:.0e}")
        )
    return markdown(head, rows)


def bases() -> str:
    """Return the motor on truncated bases."""
    head = (
        "",
        "f1, f2 (Hz)",
        "tip compliance (um/N)",
        "mass that an impact meets (g)",
        "settled peak force (N)",
        "settled rotor velocity (rad/s)",
    )
    rows = (
        (
            name,
            ", ".join(f"{each:.1f}" for each in row["frequencies"]),
            f"{1e6 * row['compliance']:.6f}",
            f"{1e3 * row['mass']:.2f}",
            f"{row['peak_force']:.5f}",
            f"{row['rotor_velocity']:.5f}",
        )
        for name, row in section("bases").items()
    )
    return markdown(head, rows)


def coverage() -> str:
    """Return how many of the intervals of fits hold the truth."""
    here = section("coverage")
    kinds = {"stated": "stated", "found": "found by the fit"}
    fits, share = here["fits"], ENDS[1] - ENDS[0]
    expected = f"{share * fits:.1f} +- {sqrt(fits * share * (1.0 - share)):.1f}"
    rows = (
        (kinds[kind], NAMES[name], f"{count} of {fits}", expected)
        for kind, counts in here["covered"].items()
        for name, count in counts.items()
    )
    return markdown(("error of the impacts", "number", "intervals with the truth in them", "expected"), rows)


def intervals() -> str:
    """Return how many of the intervals of least squares hold the truth."""
    kinds = {"loop": "forces on a path", "impacts": "impacts", "points": "operating points"}
    head = ("data", "sets", "number", "intervals with the truth in them", "expected")
    share, rows = ENDS[1] - ENDS[0], []
    for kind, title in kinds.items():
        here = section(f"intervals of {kind}")
        sets = here["sets"]
        expected = f"{share * sets:.0f} +- {sqrt(sets * share * (1.0 - share)):.1f}"
        for name, count in here["covered"].items():
            rows.append((title, sets, NAMES.get(name.rpartition(".")[2], name), count, expected))
    return markdown(head, rows)


def true_law() -> str:
    """Return how often the law that has made the data is recognised."""
    columns = {
        "sets": "sets of data",
        "right": "right",
        "wrong": "wrong",
        "open": "not distinguishable",
        "largest": "true law has the largest evidence",
    }
    rows = ((count, *(row[name] for name in columns)) for count, row in section("true law").items())
    return markdown(("impacts", *columns.values()), rows)


def rotor_fit() -> str:
    """Return what a rotor's velocity tells of stiffness and friction."""

    def row(name: str, own: dict[str, float]) -> tuple[str, ...]:
        numbers = (own["mean"], own["deviation"], own["low"], own["high"])
        mean, deviation, low, high = (f"{x:.{d}g}" for x, d in zip(numbers, (4, 2, 4, 4), strict=True))
        return NAMES[name], f"{own['truth']:g}", mean, deviation, f"{low} to {high}"

    head = ("", "truth", "posterior mean", "standard deviation", "interval of 90 %")
    return markdown(head, (row(*item) for item in section("rotor fit").items()))


def data_sheets() -> str:
    """Return the data sheets of the default motor."""
    rows = (
        ("velocity without load (rad/s)", "no_load_velocity", 1.0),
        ("stall torque (mN m)", "stall_torque", 1e3),
        ("greatest output power (mW)", "output_power", 1e3),
        ("greatest efficiency (%)", "electrical_efficiency", 100.0),
    )
    here = section("data sheets")
    names = {"four shapes": "", "converged": "on the converged beam: "}
    lines = (
        (
            names[basis] + text,
            *(Number.of(scale * own[name], scale * own[f"{name}_error"]) for own in here[basis].values()),
        )
        for basis in names
        for text, name, scale in rows
    )
    return markdown(("", *here["converged"]), lines)


def waits() -> str:
    """Return what users wait for, from the differences of processes of benchmark_waits.py."""
    # Imported here: listed_numbers.py makes the folder known.
    import benchmark_waits

    times = benchmark_waits.kept()

    def each(few: str, many: str, count: int, scale: float, law: str) -> str:
        whole, start = times.get(f"{many}, {law}"), times.get(f"{few}, {law}")
        return "not timed" if whole is None or start is None else f"{scale * (whole - start) / count:.2g}"

    runs = [f"{count} runs of a sweep" for count in (benchmark_waits.FEW, benchmark_waits.MANY)]
    done = benchmark_waits.MANY - benchmark_waits.FEW
    lines: dict[str, tuple[str, str, int, float]] = {
        "a motor second (s)": ("1 motor seconds", "6 motor seconds", 5, 1.0),
        "a run of 2 ms from Python (ms)": ("1 runs of 2 ms", "501 runs of 2 ms", 500, 1e3),
        "such a run in a sweep over a number (ms)": (*runs, done, 1e3),
        "a steady state (ms)": ("1 steady states", "101 steady states", 100, 1e3),
    }
    rows = ((text, *(each(*line, law) for law in benchmark_waits.LAWS)) for text, line in lines.items())
    return markdown(("", *(f"`{law}`" for law in benchmark_waits.LAWS)), rows)


def paths() -> str:
    """Return times of laws on paths beside those of LSODA, by benchmark_paths.py."""
    # Imported here: listed_numbers.py makes the folder known.
    import benchmark_paths

    head = (
        "",
        "evaluation in a fit (ms)",
        "call of `cl.drive` (ms)",
        "LSODA over an evaluation",
        "LSODA over a call",
        "error of the force",
        "of LSODA",
    )
    rows = (
        (
            f"`{law}`, {where}",
            *(f"{1e3 * row[name]:.2g}" for name in ("evaluation", "call")),
            *(f"{row['LSODA'] / row[name]:.2g}" for name in ("evaluation", "call")),
            *(f"{row[name]:.0e}" for name in ("error", "error of LSODA")),
        )
        for (law, where), row in ((name.split(", "), own) for name, own in benchmark_paths.kept().items())
    )
    return markdown(head, rows)


TABLES: Final[dict[str, Callable[[], str]]] = {
    "case A": case_a,
    "bases": bases,
    "data sheets": data_sheets,
    "coverage": coverage,
    "intervals": intervals,
    "true law": true_law,
    "rotor fit": rotor_fit,
    "waits": waits,
    "paths": paths,
}
