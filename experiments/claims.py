"""Sentences and tables of the pages that state a result; the sentences stand in claims.yaml.

A claim has a population, a predicate and what the page says if it holds, if not, and if it is inconclusive.
A predicate is an expression over the files of results with the functions of this module. It is true, false,
or None where errors leave it open. `{expression:format}` in a sentence is a number. A claim without a
predicate states numbers. `results_pages.py` writes the sentence that holds on its page.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from math import floor, log10
from pathlib import Path
from typing import Any, Final, Self

import motor_findings
import yaml
from dependencies import ROOT
from results_store import read
from scipy.stats import fisher_exact

from contactlab.inference.paired import binomial_interval

FILES: Final = ("accuracy", "motor", "experiments", "measurements")
GENERATED: Final = (
    "docs/claims.md",
    "docs/judged_motors.md",
    "docs/law_table.md",
    "docs/laws.md",
    "docs/laws/",
    "docs/plausibility.md",
    "docs/random_runs.md",
    "docs/simulators.md",
)
"""Pages whose numbers other scripts write, from runs or declarations of their own."""

PAGES: Final = tuple(
    name
    for path in (ROOT / "README.md", ROOT / "paper" / "paper.md", *sorted((ROOT / "docs").rglob("*.md")))
    if not (name := path.relative_to(ROOT).as_posix()).startswith((*GENERATED, "docs/build/"))
)
"""Pages that state no result without a claim."""

USED: Final[set[tuple[str, str]]] = set()
"""Files and sections that were read."""


class Number(float):
    """A number of the store with its error."""

    error: float

    def __new__(cls, value: float, error: float = 0.0) -> Self:
        """Return a number with an error."""
        number = super().__new__(cls, value)
        number.error = error
        return number

    def __abs__(self) -> "Number":
        return Number(float(self) if self > 0.0 else -float(self), self.error)

    def __str__(self) -> str:
        """Return the number with the digits that its error leaves, and the error where it shows in four."""
        if self.error < 5e-5:
            return f"{float(self):.4f}"
        digits = max(-floor(log10(self.error)), 0)
        error = f"{self.error:.{digits}f}" if digits < 3 else f"{self.error:.0e}".replace("e-0", "e-")
        return f"{float(self):.{digits}f} +- {error}"


class Sections(dict[str, Any]):
    """Results of a file by section; which ones are read is put down in `USED`."""

    def __init__(self, file: str) -> None:
        super().__init__({name: section["results"] for name, section in read(file)["sections"].items()})
        self.file = file

    def __getitem__(self, name: str) -> Any:
        USED.add((self.file, name))
        return super().__getitem__(name)


@cache
def results(file: str) -> Sections:
    """Return the sections of a file of results."""
    return Sections(file)


def value(key: str, file: str = "motor") -> Any:
    """Return a value of the store by its key, "SECTION/.../NAME", a number with its error."""
    *way, name = key.split("/")
    here: Any = results(file)
    for part in way:
        here = here[int(part)] if isinstance(here, list) else here[part]
    stored = here[int(name)] if isinstance(here, list) else here.get(name)
    if not isinstance(stored, float):
        return stored
    return Number(stored, here.get(f"{name}_error", 0.0) if isinstance(here, dict) else 0.0)


def less(a: float, b: float) -> bool | None:
    """Return whether a number is less than another; None where they are nearer than their errors."""
    blur = sum(getattr(each, "error", 0.0) for each in (a, b))
    return None if abs(float(b) - float(a)) < blur else a < b


def every(verdicts: Iterable[bool | None]) -> bool | None:
    """Return whether all verdicts are true; None if some are open and none is false."""
    known = [*verdicts]
    return False if False in known else None if None in known else True


def velocity(section: str, law: str) -> Any:
    """Return the settled velocity under a law [rad/s]; None where there is none."""
    return value(f"{section}/{law}/rotor_velocity")


def settling_times() -> list[float]:
    """Return the times in which the default motor settles by e under the laws that come to an orbit [s]."""
    times = (value(f"default motor/{basis}/{law}/settling_time") for basis in BASES for law in PICTURED)
    return [float(time) for time in times if time is not None]


def rows_of(experiment: str) -> list[dict[str, Any]]:
    """Return the rows of an experiment's table."""
    rows: list[dict[str, Any]] = results("experiments")[experiment]["rows"]
    return rows


PRINTED_RATIOS: Final = {"placement 1": 2.67, "placement 2": 1.71}
"""Ratios of the second to the first frequency as printed in the last column of Table 1."""


def frequency_ratio(placement: str) -> float:
    """Return the ratio of the second to the first frequency of a placement."""
    first, second = (
        float(row["computed"])
        for row in rows_of("table1_placement")
        if row["placement"] == placement and row["quantity"].endswith("[Hz]")
    )
    return second / first


def hastened() -> list[float]:
    """Return settled speeds of the default motor over those of figure 8 after 5 ms, by law."""
    early = {row["law"]: row["1 um, 5 ms"] for row in rows_of("fig8_rotor_velocity")}
    names = {"slip": "lagrange_slip", "stick": "lagrange_stick", "hertz": "hertz_penalty"}
    return [float(velocity("default motor/four shapes", x) / early[name]) for x, name in names.items()]


def steps_of_peak(column: str) -> list[float]:
    """Return peaks or impulses of figure 9 at a step, at a quarter of it, and under a Hertz contact."""
    return [float(row[column]) for row in rows_of("fig9_normal_force")]


def ratio(basis: str, mode: int) -> float:
    """Return a damping ratio of the default motor [1]."""
    return float(value(f"modes/{basis}/damping_ratio/{mode}"))


def speeds(section: str, laws: Iterable[str]) -> dict[str, Number]:
    """Return settled speeds by law [rad/s], without laws that have none."""
    return {law: abs(v) for law in laws if (v := velocity(section, law)) is not None}


def apart(section: str, laws: Iterable[str]) -> Number:
    """Return the range of speeds over their mean [1]."""
    least, *others, most = sorted(speeds(section, laws).values())
    mean = (least + sum(others) + most) / (2 + len(others))
    return Number((most - least) / mean, (most.error + least.error) / mean)


def fastest(section: str, law: str, laws: Iterable[str]) -> bool | None:
    """Return whether a law has the greatest speed of some laws."""
    here = speeds(section, laws)
    return every(less(speed, here[law]) for name, speed in here.items() if name != law)


def slowest(section: str, law: str, laws: Iterable[str]) -> bool | None:
    """Return whether a law has the least speed of some laws."""
    here = speeds(section, laws)
    return every(less(here[law], speed) for name, speed in here.items() if name != law)


NAMES: Final = {
    "hertz": "`hertz_penalty`",
    "stick": "`lagrange_stick`",
    "newton": "`newton`",
    "poisson": "`poisson`",
    "mindlin": "composed, `mindlin`",
    "slip": "`lagrange_slip`",
}
BASES: Final = ("four shapes", "converged")
THREE, FOUR = ("stick", "newton", "hertz"), ("hertz", "stick", "newton", "mindlin")
FIVE, PICTURED = (*THREE, "poisson", "mindlin"), tuple(motor_findings.PICTURED)
PHASE, DAMPING, ROD = motor_findings.PHASE, motor_findings.DAMPED, motor_findings.ROD
PAPER, *LOWER = (f"{DAMPING}/{damping}" for damping in motor_findings.DAMPING)


OF_THE_PAPER: Final = {
    part[0]: name
    for name in read("experiments")["sections"]
    if (part := re.match(r"(?:table|fig)\d+", name)) is not None
}
"""Experiments on tables and figures of the paper, by these."""

SPRING: Final = "hertz_point + flores + mindlin"
CASES: Final = ("as measured", "inertia", "arms", "tilt and inertia")
"""Of what is free in the geometry of the ellipses."""


CARRIERS: Final = {
    "lagrange_stick": "`lagrange_stick`",
    "newton": "`newton`",
    "hertz_penalty": "`hertz_penalty`",
    "mindlin": "`hertz_point` + `flores` + `mindlin`",
}
"""Laws of the published motor."""

CHANGED: Final = ("friction coefficient", "start")
"""What its repetitions change."""

READ: Final = 3.0
"""To how much its speeds were read [mm/s]."""


DEFAULT, STIFFNESS, *OUTSIDE = motor_findings.POPULATIONS
OTHERS: Final = {"hertz": "`hertz_penalty`", "newton": "`newton`"}
"""Laws that `lagrange_stick` is compared with."""


def pair(population: str, name: str, law: str = "hertz") -> Any:
    """Return a number of `lagrange_stick` against another law in a population."""
    return value(f"populations/{population}/{law}/{name}")


def turned(population: str, law: str) -> float:
    """Return the p-value of as many faster among faster and slower motors as by default."""
    counts = [
        [pair(x, f"outcomes/{kind}", law) for kind in ("greater", "less")] for x in (DEFAULT, population)
    ]
    return float(fisher_exact(counts).pvalue)


def least_like(law: str) -> str:
    """Return the population outside of the draws that is least like them."""
    return min(OUTSIDE, key=lambda population: turned(population, law))


def ellipses(key: str) -> Any:
    """Return a number of laws against the ellipses."""
    return value(f"ellipses/{key}", "measurements")


def spheres(law: str, name: str = "all") -> Any:
    """Return a misfit of a law against the spheres [errors of digitisation]."""
    return value(f"spheres/laws/{law}/{name}", "measurements")


def predicted(case: str, law: str) -> float:
    """Return the held-out error of a law with some numbers of the geometry free [1]."""
    return float(ellipses(f"geometry/{case}/laws/{law}/error"))


def gain(case: str) -> Any:
    """Return what `mindlin` gains over Poisson's law, with the half of its interval [1]."""
    key = f"geometry/{case}/mindlin before poisson"
    return Number(ellipses(f"{key}/gain"), 0.5 * (ellipses(f"{key}/high") - ellipses(f"{key}/low")))


def geometry(case: str, name: str) -> float:
    """Return a number of the geometry that is fitted with Poisson's law."""
    return float(ellipses(f"geometry/{case}/laws/poisson/parameters/data.{name}"))


def carried(law: str, name: str, inertia: int = 0) -> Any:
    """Return a number of the published motor under a law [mm/s], the second time with more inertia."""
    return [row for row in rows_of("published_motor") if row["law"] == law][inertia][name]


def published(name: str) -> float:
    """Return a number of the published motor that is of no law."""
    return float(value(f"published_motor/numbers/{name}", "experiments"))


def spread(law: str, by: str) -> float:
    """Return the largest difference of the published motor's repeated speeds [mm/s]."""
    return max(float(carried(law, f"largest difference, {by} [mm/s]", n)) for n in (0, 1))


def misfit(law: str, end: str) -> float:
    """Return the least ('from') or the largest ('to') misfit of the calibration over repetitions [mm/s]."""
    return float(carried(law, f"calibration misfit {end} [mm/s]"))


def is_function(law: str) -> bool:
    """Return whether the published motor's speeds are a function of its numbers, to what they were read."""
    return max(spread(law, by) for by in CHANGED) <= READ


def mattering() -> list[dict[str, Any]]:
    """Return the rows of the experiment on when laws matter."""
    # A column with gaps has counts as floats.
    return [
        {key: int(x) if isinstance(x, float) and x.is_integer() else x for key, x in row.items()}
        for row in rows_of("when_laws_matter")
    ]


def matters(quantity: str) -> dict[str, Any]:
    """Return the motors in which the law matters to a quantity."""
    return next(row for row in mattering() if row["quantity"] == quantity and row["group"] == "all")


def of(quantity: str) -> str:
    """Return the motors in which the law matters to a quantity, over those where that is known."""
    return f"{matters(quantity)['D > 1']}/{matters(quantity)['motors']}"


def share(quantity: str) -> tuple[float, float]:
    """Return the 95 % interval of the probability that D > 1."""
    low, high = binomial_interval(matters(quantity)["D > 1"], matters(quantity)["motors"])
    return float(low), float(high)


def clear_share(quantity: str) -> tuple[float, float]:
    """Return the 95 % interval of the probability that D > 1; what is not clear counts as either."""
    here = matters(quantity)
    low, _ = binomial_interval(here["clearly above"], here["motors"])
    _, high = binomial_interval(here["motors"] - here["clearly below"], here["motors"])
    return float(low), float(high)


def counted(rate: float, trials: int) -> Number:
    """Return a rate with the half of its 95 % interval over independent trials."""
    low, high = binomial_interval(round(rate * trials), trials)
    return Number(rate, 0.5 * float(high - low))


def separating() -> list[dict[str, Any]]:
    """Return the groups over which D differs."""
    return [row for row in mattering() if row["p"] is not None and row["p"] < 0.05]


def evaluated(expression: str) -> Any:
    """Return the value of an expression over the store."""
    return eval(expression, globals())


@dataclass(frozen=True)
class Claim:
    """A sentence of a page, chosen by a predicate.

    Args:
        page: where it stands.
        population: what the predicate is about.
        sentence: what the page says if the predicate holds.
        holds: the predicate, an expression; empty for numbers that are stated as they are.
        otherwise, open: the sentence if the predicate does not hold, and if it is inconclusive.
    """

    page: str
    population: str
    sentence: str
    holds: str = ""
    otherwise: str = ""
    open: str = ""

    @property
    def templates(self) -> list[str]:
        """Every sentence that may stand on the page, the longest first."""
        return sorted(filter(None, (self.sentence, self.otherwise, self.open)), key=len, reverse=True)

    @property
    def verdict(self) -> str:
        """Whether the claim holds."""
        if not self.holds:
            return "stated"
        return {True: "holds", False: "does not hold", None: "is inconclusive"}[evaluated(self.holds)]

    @property
    def template(self) -> str:
        """The sentence that the page states; a KeyError where none is written for an open predicate."""
        if self.verdict == "is inconclusive" and not self.open:
            raise KeyError(self.sentence)
        return {"does not hold": self.otherwise, "is inconclusive": self.open}.get(
            self.verdict, self.sentence
        )


CLAIMS: Final = tuple(
    Claim(**claim)
    for claim in yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))
)


def markdown(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Return a table in Markdown."""
    lines = [[*head], *([*map(str, row)] for row in rows)]
    head, *body = [f"| {' | '.join(line)} |".replace("|  |", "| |") for line in lines]
    return "\n".join([head, "|---" * len(lines[0]) + "|", *body])


def front_page() -> str:
    """Return what the example of README prints."""
    bases = {"ritz": "four shapes", "finite_element": "converged"}
    lines = [
        f"{basis:15} {law:15} {float(number):8.4f} +- {number.error:.1g} rad/s"
        for basis, section in bases.items()
        for law in ("lagrange_stick", "newton", "hertz_penalty")
        for number in [
            velocity(f"default motor/{section}", law.removeprefix("lagrange_").removesuffix("_penalty"))
        ]
    ]
    return "\n".join(["```text", *lines, "```"])


def default_motor() -> str:
    """Return settled velocities and times of the default motor on both bases."""

    def cell(basis: str, law: str) -> str:
        here = value(f"default motor/{basis}/{law}")
        time, speed = here["settling_time"], velocity(f"default motor/{basis}", law)
        return f"{speed}, {here['kind']}" if time is None else f"{speed} ({1e3 * time:.1f} ms)"

    rows = ([NAMES[law], cell("four shapes", law), cell("converged", law)] for law in PICTURED)
    return markdown(("", "four shapes of the paper", "converged beam"), rows)


def by_phase() -> str:
    """Return velocity and stall torque over the phase of the drive."""
    phases = results("motor")[PHASE]

    def cell(phase: str, law: str) -> str:
        return (
            f"{velocity(f'{PHASE}/{phase}', law)}, {1e3 * value(f'{PHASE}/{phase}/{law}/stall_torque'):.3f}"
        )

    head = ("law", *(phase if phase == "configured" else f"phase {float(phase):g}" for phase in phases))
    laws = ("stick", "newton", "poisson", "hertz", "mindlin")
    return markdown(head, ([NAMES[x], *(cell(p, x) for p in phases)] for x in laws))


def by_damping() -> str:
    """Return velocities over the damping."""

    def row(section: str) -> Iterator[object]:
        damping = section.removeprefix(f"{DAMPING}/")
        yield f"`{damping}`{' (paper)' * (section == PAPER)}"
        yield ", ".join(
            f"{ratio:.2g}" if ratio < 0.1 else f"{ratio:.3f}" for ratio in value(f"{section}/damping_ratio")
        )
        yield from (velocity(section, law) or "none" for law in FOUR)

    head = ("damping", "ratios", *(NAMES[law].removeprefix("composed, ") for law in FOUR))
    return markdown(head, map(row, (PAPER, *LOWER)))


def laws_against_ellipses() -> str:
    """Return held-out error, interval, group and fitted numbers of every law."""

    def row(label: str, law: Mapping[str, Any]) -> Iterator[object]:
        yield from (
            f"`{label}`",
            law["kind"],
            f"{law['error']:.4f}",
            f"{law['low']:.4f} to {law['high']:.4f}",
        )
        yield law["group"] or ""
        yield ", ".join(f"{k.rpartition('.')[2]} {x:.4g}" for k, x in law["parameters"].items())

    laws = results("measurements")["ellipses"]["laws"]
    head = ("law", "", "held-out error", "95 % interval", "group", "fitted numbers")
    return markdown(head, (row(*each) for each in laws.items()))


def free_geometry() -> str:
    """Return held-out errors with free numbers of the geometry."""

    def row(case: str) -> Iterator[object]:
        yield case
        yield from (f"{predicted(case, law):.4f}" for law in (SPRING, "poisson", "newton"))
        own = ellipses(f"geometry/{case}/mindlin before poisson")
        yield f"{own['gain']:.4f} ({own['low']:.4f} to {own['high']:.4f})"
        yield f"{own['p']:.1g}"
        fitted = ellipses(f"geometry/{case}/laws/poisson/parameters")
        yield ", ".join(f"{k[5:]} {x:.3g}" for k, x in fitted.items() if k.startswith("data."))

    head = (
        "free in the data",
        "mindlin",
        "poisson",
        "newton",
        "mindlin before poisson",
        "p",
        "under poisson",
    )
    return markdown(head, map(row, CASES))


def restitution_over_slip() -> str:
    """Return the measured ratio of the gap rates over the slip, and the best law's residual."""
    rows = (
        (f"{x['slip']:.2f}", f"{x['ratio']:.3f}", f"{x['low']:.2f} to {x['high']:.2f}", f"{x['missed']:+.3f}")
        for x in results("measurements")["ellipses"]["over slip"]
    )
    head = ("slip before (m/s)", "gap rate after over before", "quartiles", "residual of the best law (m/s)")
    return markdown(head, rows)


def laws_against_spheres() -> str:
    """Return misfits of every law in errors of digitisation."""
    names = ("restitution", "angle", "spin", "all", "both axes", "mean stiffness")

    def row(label: str, law: Mapping[str, Any]) -> Iterator[str]:
        yield label.replace("_", "\\_")
        yield from ("" if law[name] is None else f"{law[name]:.3g}" for name in names)
        yield f"{law['lowest']:.3g}" + ("" if law["at"] is None else f" at {law['at']:.3g}")
        yield law["free"].replace("_", "\\_")

    laws = results("measurements")["spheres"]["laws"]
    rows = (row(label, law) for label, law in laws.items())
    return markdown(("law", *names, "lowest", "free"), rows)


def carrying() -> str:
    """Return spreads of the published motor's speeds, and how many loads it moves, by law."""

    def loads(law: str, n: int) -> str:
        ends = (str(carried(law, f"{end} loads moved", n)) for end in ("least", "most"))
        return " to ".join(dict.fromkeys(ends))

    def row(law: str) -> Iterator[str]:
        yield CARRIERS[law]
        for by in CHANGED:
            first, second = (carried(law, f"largest difference, {by} [mm/s]", n) for n in (0, 1))
            yield f"{first:.0f} ({second:.0f})"
        yield f"{loads(law, 0)} ({loads(law, 1)})"
        yield f"{misfit(law, 'to'):.0f}" if is_function(law) else "none"

    own = [f"{published(f'published model, {part}'):.0f}" for part in ("calibration", "test")]
    model = ("the authors' model, not calibrated", "0", "0", "8", f"{own[0]} (payload), {own[1]} (force)")
    head = (
        "law",
        "by the friction coefficient (mm/s)",
        "by the start (mm/s)",
        "loads moved, of 8",
        "misfit (mm/s)",
    )
    return markdown(head, [*map(row, CARRIERS), model])


def when_laws_matter() -> str:
    """Return in how many motors the law matters, by quantity."""

    def row(own: Mapping[str, Any]) -> Iterator[object]:
        low, high = share(own["quantity"])
        yield from (own["quantity"].replace("_", " "), own["motors"])
        yield f"{own['D > 1']} ({100 * low:.0f} to {100 * high:.0f} %)"
        yield from (own["clearly above"], own["clearly below"])
        yield f"{own['median']:.2g} ({own['10 %']:.2g} to {own['90 %']:.2g})"

    head = ("quantity", "motors", "D > 1", "clearly", "clearly not", "median D (10 to 90 %)")
    rows = (row(own) for own in mattering() if own["group"] == "all")
    return markdown(head, rows)


def groups() -> str:
    """Return the groups over which D differs, or for each quantity the one that tells most."""
    rows = []
    for quantity in dict.fromkeys(row["quantity"] for row in mattering()):
        own = sorted(
            (x for x in mattering() if x["quantity"] == quantity and x["p"] is not None), key=lambda x: x["p"]
        )
        for row in [x for x in own if x["p"] < 0.05] or own[:1]:
            halves = (str(int(row[f"{half} half"])) for half in ("lower", "upper"))
            numbers = f"{row['rank correlation']:+.2f}", f"{row['p']:.2g}"
            rows.append((quantity.replace("_", " "), row["group"], ", ".join(halves), *numbers))
    head = ("quantity", "group", "motors with D > 1 in the lower, upper half", "rank correlation", "p")
    return markdown(head, rows)


def populations() -> str:
    """Return outcomes of pairs of laws in populations."""

    def row(population: str, law: str) -> Iterator[object]:
        yield from (population, OTHERS[law])
        yield from pair(population, "outcomes", law).values()
        yield pair(population, "order", law)
        yield "; ".join(f"{x['greater']}, {x['less']}" for x in pair(population, "quarters", law))

    head = ("population", "against", "faster", "slower", "equal", "no steady state", "verdict",
            "faster, slower by quarters of rising damping")  # fmt: skip
    rows = (row(each, law) for law in OTHERS for each in motor_findings.POPULATIONS)
    return markdown(head, rows)


def known_worlds() -> str:
    """Return error rates of the rule of pairs in worlds of known truth."""
    rows = (
        (world, pairs, f"{100 * rates['any wrong']:.1f} %", f"{100 * rates['known']:.0f} %")
        for world, each in results("motor")["known worlds"].items()
        for pairs, rates in each.items()
    )
    head = ("the first law is, in all motors", "pairs", "any false claim", "verdict known")
    return markdown(head, rows)


def known_factors() -> str:
    """Return how often the naming of what turns an order is wrong in worlds of known truth."""
    rows = [
        (world, *(f"{100 * rates[name]:.0f} %" for name in ("wrong", "right") for rates in each.values()))
        for world, each in results("motor")["known factors"].items()
    ]
    looks = [f"of {look}" for look in (16, 32, 64)]
    head = (
        "the outcome is decided by",
        *(f"{what}, {look}" for what in ("wrong", "right") for look in looks),
    )
    return markdown(head, rows)


def experiments() -> str:
    """Return the findings of the experiments beyond the paper, and whether their claims hold."""
    own = results("experiments")
    those = {x: own[x] for x in own if x not in OF_THE_PAPER.values()}
    rows = ((f"`{x}`", "yes" if each["holds"] else "no", each["finding"]) for x, each in those.items())
    return markdown(("script", "holds", "finding"), rows)


def finding(experiment: str) -> str:
    """Return the finding of an experiment."""
    return str(results("experiments")[experiment]["finding"])


def impact_mass() -> str:
    """Return the mass that an impact meets, and settled velocities, over the number of modes."""
    kept: dict[tuple[object, object], dict[bool, Mapping[str, Any]]] = {}
    for row in rows_of("impact_mass"):
        own = kept.setdefault((row["damping ratio [1]"], row["kept modes [1]"]), {})
        own[row["residual mass"]] = row
    laws = ("newton", "lagrange_stick", "hertz_penalty")
    names = ("mass in 0.01 ns [g]", *(f"{law} [rad/s]" for law in laws))
    rows = (
        (*those, *(", ".join(f"{own[residual][name]:.4f}" for residual in (False, True)) for name in names))
        for those, own in kept.items()
    )
    head = (
        "damping ratio",
        "kept modes",
        "mass in 0.01 ns (g): without, with",
        *(f"`{x}` (rad/s)" for x in laws),
    )
    text = results("experiments")["impact_mass"]["finding"]
    return f"{text}\n\n{markdown(head, rows)}"


def first_table() -> str:
    """Return the numbers of the paper's Table 1, the printed ones in brackets."""
    cells: dict[str, dict[str, str]] = {}
    for row in rows_of("table1_placement"):
        name, unit = row["quantity"].split(" ", 1)
        digits = ".0f" if unit == "[Hz]" else ".4f"
        cell = f"{row['computed']:{digits}} ({row['printed']:{'.0f' if unit == '[Hz]' else '.3f'}})"
        cells.setdefault(row["placement"], {})[f"{name} {unit}".replace(" V-1", "/V")] = cell
    head = ("", *next(iter(cells.values())))
    rows = ((placement, *row.values()) for placement, row in cells.items())
    return markdown(head, rows)


TABLES: Final[dict[str, Callable[[], str]]] = {
    "front page": front_page,
    "default motor": default_motor,
    "by phase": by_phase,
    "by damping": by_damping,
    "experiments": experiments,
    "of Table 1": first_table,
    "of impact mass": impact_mass,
    **{f"of {short}": partial(finding, name) for short, name in OF_THE_PAPER.items()},
    "laws against ellipses": laws_against_ellipses,
    "free geometry": free_geometry,
    "restitution over slip": restitution_over_slip,
    "laws against spheres": laws_against_spheres,
    "published motor": carrying,
    "when laws matter": when_laws_matter,
    "groups": groups,
    "populations": populations,
    "known worlds": known_worlds,
    "known factors": known_factors,
}
