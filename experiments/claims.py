"""Sentences and tables of the pages that state a result; the sentences stand in claims.yaml.

A claim has a population, a predicate and what the page says if it holds, if it does not, and if that is open.
A predicate is an expression over the files of results with the functions of this module and of verdicts.py.
It is true, false, or None where the uncertainty of the numbers leaves it open. `{expression:format}` in a
sentence is a number. What was measured or follows in closed form, and claims nothing, is stated without a
predicate. `results_pages.py` writes the sentence that holds on its page.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from math import atanh, ceil, inf, isfinite, sqrt, tanh
from pathlib import Path
from typing import Any, Final

import motor_findings
import verdicts
import yaml
from dependencies import ROOT
from results_store import read
from scipy.stats import chi2, fisher_exact, norm
from verdicts import NONE, Number, every, exact, greatest, least, less, number, share, some, within

from contactlab.engine.preparation import DEFAULT_TOLERANCE
from contactlab.studies.compare.paired import ALONE, INCONCLUSIVE, ROLES, VARIES, VERDICTS, power

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
    if stored is None:
        return NONE
    return with_error(stored, here.get(f"{name}_error") if isinstance(here, dict) else None)


def with_error(stored: Any, error: float | None = None) -> Any:
    """Return what is stored; a float with its error."""
    return Number.of(stored, error) if isinstance(stored, float) else NONE if stored is None else stored


def interval(own: Mapping[str, float] | None, name: str) -> Number:
    """Return a number with the ends `low` and `high` that stand beside it; `NONE` if it is not recorded."""
    return Number(own[name], own["low"], own["high"]) if own else NONE


def velocity(section: str, law: str) -> Number:
    """Return the settled velocity under a law [rad/s]; `NONE` where there is none."""
    settled: Number = value(f"{section}/{law}/rotor_velocity")
    return settled


def settling_times() -> list[Number]:
    """Return the times in which the default motor settles by e under the laws that come to an orbit [s]."""
    times = (value(f"default motor/{basis}/{law}/settling_time") for basis in BASES for law in PICTURED)
    return [time for time in times if isfinite(time.value)]


ORBITS: Final = {
    "quasi-periodic": True,
    "chaotic": True,
    "aperiodic": True,
    "periodic": False,
    "standing": False,
}
"""Whether a kind of motion comes to no orbit; of other kinds, as one that seems to close, that is open."""


def of_no_orbit(basis: str, law: str) -> bool | None:
    """Return whether the default motor comes to no orbit under a law."""
    return ORBITS.get(value(f"default motor/{basis}/{law}/kind"))


def rows_of(experiment: str) -> list[dict[str, Any]]:
    """Return the rows of an experiment's table."""
    rows: list[dict[str, Any]] = results("experiments")[experiment]["rows"]
    return rows


def at(experiment: str, row: int, column: str) -> Any:
    """Return a number of a row of an experiment's table."""
    return with_error(rows_of(experiment)[row][column])


HALF_UNITS: Final = {"[Hz]": 5.0, "[N V-1]": 0.5e-3, "f_2/f_1": 0.005}
"""Half a unit of the last digit that Table 1 prints, by the unit."""

PRINTED_RATIOS: Final = {"placement 1": 2.67, "placement 2": 1.71}
"""Ratios of the second to the first frequency as printed in the last column of Table 1."""


def first_misses() -> list[Number]:
    """Return differences from the couplings and frequencies of Table 1 [half units of its last digit]."""
    rows = rows_of("table1_placement")
    units = [next(unit for unit in HALF_UNITS if row["quantity"].endswith(unit)) for row in rows]
    each = zip(rows, units, strict=True)
    return [abs(Number.of(row["computed"]) - row["printed"]) / HALF_UNITS[unit] for row, unit in each]


def frequency_ratio(placement: str, which: str = "computed", error: float | None = None) -> Number:
    """Return the ratio of the second to the first frequency of a placement, computed or of those printed."""
    first, second = (
        Number.of(row[which], error)
        for row in rows_of("table1_placement")
        if row["placement"] == placement and row["quantity"].endswith("[Hz]")
    )
    return second / first


def ratio_miss(placement: str) -> Number:
    """Return the difference from the ratio of frequencies in Table 1 [half units of its last digit]."""
    return abs(frequency_ratio(placement) - PRINTED_RATIOS[placement]) / HALF_UNITS["f_2/f_1"]


def printed_allow(placement: str) -> Number:
    """Return the ratio of the printed frequencies, whose rounding leaves an interval."""
    return frequency_ratio(placement, "printed", HALF_UNITS["[Hz]"])


def followed(misses: Iterable[Number]) -> int:
    """Return how many numbers follow within their rounding."""
    return [less(miss, 1.0) for miss in misses].count(True)


RUN: Final = 100.0 * DEFAULT_TOLERANCE
"""Relative error of a run, which the tests hold to a hundred tolerances."""


def transient(row: int, clearance: int) -> Number:
    """Return the speed after 5 ms at a clearance [um], of a row of figure 8 [rad/s]."""
    stored = rows_of("fig8_rotor_velocity")[row][f"{clearance} um, 5 ms"]
    return NONE if stored is None else abs(Number.of(stored, RUN * abs(stored)))


def transient_rows() -> list[int]:
    """Return the rows of figure 8 that are transients, each of a law."""
    return [n for n, row in enumerate(rows_of("fig8_rotor_velocity")) if row["1 um, 5 ms"] is not None]


def hastened() -> list[Number]:
    """Return settled speeds of the default motor over those of figure 8 after 5 ms, by law."""
    early = {rows_of("fig8_rotor_velocity")[n]["law"]: transient(n, 1) for n in transient_rows()}
    names = {"slip": "lagrange_slip", "stick": "lagrange_stick", "hertz": "hertz_penalty"}
    return [abs(velocity("default motor/four shapes", x)) / early[name] for x, name in names.items()]


def over_steps(column: str) -> Number:
    """Return a number of figure 9 at a quarter of the step over that at the step."""
    fine: Number = at("fig9_normal_force", 1, column)
    return fine / at("fig9_normal_force", 0, column)


def chatter(row: int) -> Number:
    """Return the slip in the longest chatter of figure 10 [m/s]; one change of sign more or less is open."""
    slip, changes = (rows_of("fig10_sticking")[row][x] for x in ("slip in it, rms [m/s]", "changes of sign"))
    return NONE if slip is None else Number.of(slip, slip / max(changes, 1))


def changes_of_sign(row: int) -> Number:
    """Return the changes of sign in the longest chatter of figure 10, of which the ends are open."""
    return Number.of(rows_of("fig10_sticking")[row]["changes of sign"], 1.0)


RANDOM: Final = 20
"""Random motors of the experiment on steady states, each under every law."""


def agreeing() -> Number:
    """Return the share of random motors in which a long run and shooting agree under every law.

    Only the disagreements of each law are recorded: they lie in as many motors at most, and in as few as one
    motor may have under all laws.
    """
    rows = rows_of("steady_states")
    apart = sum(row["settle"] - row["run agrees"] for row in rows)
    fewest, most = max(RANDOM - apart, 0), max(RANDOM - ceil(apart / len(rows)), 0)
    return Number(fewest / RANDOM, share(fewest, RANDOM).low, share(most, RANDOM).high)


def ratio(basis: str, mode: int) -> Number:
    """Return a damping ratio of the default motor [1]."""
    return number(value(f"modes/{basis}/damping_ratio/{mode}"))


def quality(basis: str, mode: int) -> Number:
    """Return the quality factor of a mode of the default motor [1]."""
    return 0.5 / ratio(basis, mode)


def frequency(section: str, mode: int) -> Number:
    """Return a natural frequency [Hz]."""
    return number(value(f"{section}/natural_frequency/{mode}"))


def speeds(section: str, laws: Iterable[str]) -> dict[str, Number]:
    """Return settled speeds by law [rad/s], without laws that have none."""
    return {law: abs(v) for law in laws if isfinite((v := velocity(section, law)).value)}


def apart(section: str, laws: Iterable[str]) -> Number:
    """Return the range of speeds over their mean [1]."""
    there = [*speeds(section, laws).values()]
    return (greatest(there) - least(there)) * len(there) / sum(there, exact(0.0)) if there else NONE


def fastest(section: str, law: str, laws: Iterable[str]) -> bool | None:
    """Return whether a law has the greatest speed of some laws."""
    here = speeds(section, laws)
    return every(less(speed, here.get(law, NONE)) for name, speed in here.items() if name != law)


def slowest(section: str, law: str, laws: Iterable[str]) -> bool | None:
    """Return whether a law has the least speed of some laws."""
    here = speeds(section, laws)
    return every(less(here.get(law, NONE), speed) for name, speed in here.items() if name != law)


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

READ: Final = Number.of(3.0, 1.0)
"""To how much its speeds were read [mm/s]: to some 3."""


DEFAULT, STIFFNESS, *OUTSIDE = motor_findings.POPULATIONS
OTHERS: Final = {"hertz": "`hertz_penalty`", "newton": "`newton`"}
"""Laws that `lagrange_stick` is compared with."""


def pair(population: str, name: str, law: str = "hertz") -> Any:
    """Return a number of `lagrange_stick` against another law in a population."""
    return value(f"populations/{population}/{law}/{name}")


def no_order(population: str, law: str = "hertz") -> bool | None:
    """Return whether no outcome is that of most motors of a population; None where draws leave it open."""
    verdict = pair(population, "order", law)
    return None if verdict == VERDICTS[INCONCLUSIVE] else verdict == VERDICTS[VARIES]


def nominal(law: str = "hertz") -> Number:
    """Return by how much `lagrange_stick` is faster as configured [1]; its error is that of the basis."""
    own, other = (pair(DEFAULT, f"relative/{name}", law) for name in ("nominal", "other"))
    return Number.of(own.value, abs(own.value - other.value)) if isfinite(other.value) else NONE


SEEN: Final = 0.95
"""Share of the motors with one outcome, of which pages say how often it is seen."""


def seen(samples: int, laws: int, quantities: int = 1) -> Number:
    """Return the probability that an order of 95 of 100 motors is stated after so many draws."""
    return exact(power(samples, laws * (laws - 1) * quantities, SEEN))


def alone(population: str, law: str) -> list[str]:
    """Return the factors whose share in the outcome exceeds chance and leads the second one's."""
    roles = pair(population, "roles", law)
    return [] if roles is NONE else [name for name, role in roles.items() if role == ROLES[ALONE]]


def turns(factor: str, population: str, law: str) -> bool | None:
    """Return whether a factor turns the outcome; None where the draws name none."""
    named = alone(population, law)
    return any(factor in name for name in named) if named else None


def turned(population: str, law: str) -> float:
    """Return the p-value of as many faster among faster and slower motors as by default."""
    counts = [
        [pair(x, f"outcomes/{kind}", law) for kind in ("greater", "less")] for x in (DEFAULT, population)
    ]
    return float(fisher_exact(counts).pvalue)


ALIKE: Final = 0.25
"""Difference of two shares from which on populations are not alike."""


def faster(population: str, law: str) -> Number:
    """Return the share of faster motors among faster and slower ones."""
    greater, smaller = (pair(population, f"outcomes/{kind}", law) for kind in ("greater", "less"))
    return share(greater, greater + smaller)


def other_motors(population: str, law: str) -> bool | None:
    """Return whether a population is faster in another share of its motors than the one by default.

    It is by Fisher's exact test at 5 % in all populations; it is not where the intervals of both shares lie
    within `ALIKE` of each other.
    """
    if turned(population, law) < 0.05 / len(OUTSIDE):
        return True
    return False if within(faster(population, law) - faster(DEFAULT, law), -ALIKE, ALIKE) else None


def least_like(law: str) -> str:
    """Return the population outside of the draws that is least like them."""
    return min(OUTSIDE, key=lambda population: turned(population, law))


def named_wrongly() -> list[Number]:
    """Return the shares of designs that name a factor without a say, in worlds of known truth."""
    worlds = results("motor")["known factors"].values()
    return [of_designs(rates, "wrong") for each in worlds for rates in each.values()]


def named_rightly(world: str, draws: int) -> Number:
    """Return the share of designs that name the factors which have a say in a world, and no other."""
    return of_designs(results("motor")["known factors"][world][str(draws)], "right")


def of_designs(rates: Mapping[str, float], name: str) -> Number:
    """Return a rate over the designs of worlds of known truth; `NONE` if their number is not recorded."""
    designs = int(rates.get("designs", 0))
    return share(round(designs * rates[name]), designs) if designs else NONE


def ellipses(key: str) -> Any:
    """Return a number of laws against the ellipses."""
    return value(f"ellipses/{key}", "measurements")


def part_of_ellipses(key: str) -> Any:
    """Return a part of the results on laws against the ellipses; None if it is not recorded."""
    part = ellipses(key)
    return None if part is NONE else part


def predicted(law: str, case: str = "") -> Number:
    """Return the held-out error of a law [1], also with some numbers of the geometry free."""
    return interval(part_of_ellipses(f"geometry/{case}/laws/{law}" if case else f"laws/{law}"), "error")


def predicting(*kinds: str, case: str = "") -> list[Number]:
    """Return the held-out errors of all laws of some kinds [1]."""
    laws = part_of_ellipses(f"geometry/{case}/laws" if case else "laws")
    return [predicted(law, case) for law, own in laws.items() if own["kind"] in kinds]


def before(pair: str, case: str = "") -> Number:
    """Return by how much the first law of a pair, "A before B", predicts better [1], by paired impacts."""
    return interval(part_of_ellipses(f"geometry/{case}/{pair}" if case else pair), "gain")


def distinct(better: str, worse: str) -> bool | None:
    """Return whether the best law of a group predicts better than another, after Holm's correction."""
    first, second = (ellipses(f"laws/{law}/group") for law in (better, worse))
    return None if first == second else first < second


def geometry(case: str, name: str) -> Number:
    """Return a number of the geometry that is fitted with Poisson's law."""
    return number(ellipses(f"geometry/{case}/laws/poisson/parameters/data.{name}"))


def at_slip(eighth: int) -> Number:
    """Return the median ratio of the gap rates in an eighth of the impacts by slip [1].

    Its interval at 95 % is that of a median from the quartiles (McGill, Tukey and Larsen 1978, Am. Stat. 32,
    12): 1.96 x 1.25 / 1.35 times their distance over the root of the number of impacts.
    """
    bins = part_of_ellipses("over slip")
    own, impacts = bins[eighth], ellipses("impacts") / len(bins)
    return Number.of(own["ratio"], 1.82 * (own["high"] - own["low"]) / sqrt(impacts))


def of_neighbours() -> Number:
    """Return the correlation of the errors of successive impacts [1], with its interval if it is none."""
    stored: Number = ellipses("correlation of neighbours")
    return Number.of(stored.value, 1.96 / sqrt(ellipses("impacts")))


def half_width(block: int) -> Number:
    """Return the half-width of an interval by blocks of impacts [1], with the error of so many blocks."""
    stored: Number = ellipses(f"half-width/{block}")
    return Number.of(stored.value, 1.96 * stored.value / sqrt(2.0 * ellipses("impacts") / block))


DIGITISED, CURVE = 24, 8
"""Digitised numbers of the spheres, and values of a curve that is free at each incidence."""


def spheres(law: str, name: str = "all") -> Number:
    """Return a number of a law against the spheres.

    A misfit, in errors of digitisation, is moved by these errors of the data: each by at most the root of
    their number in the mean square.
    """
    stored: Number = value(f"spheres/laws/{law}/{name}", "measurements")
    return stored if name in ("lowest", "at") else Number.of(stored.value, 1.96 / sqrt(DIGITISED))


def scattered() -> Number:
    """Return the scatter of the spheres' figures about any curve, by chi-square [errors of digitisation]."""
    freedom = DIGITISED - CURVE
    squares = DIGITISED * spheres("any curve").value ** 2
    low, high = (sqrt(squares / chi2.ppf(level, freedom)) for level in (0.975, 0.025))
    return Number(sqrt(squares / freedom), low, high)


def against_spheres() -> dict[str, Mapping[str, Any]]:
    """Return what is recorded of each law against the spheres, without bounds and references."""
    laws = results("measurements")["spheres"]["laws"]
    return {law: own for law, own in laws.items() if own["kind"] not in ("bound", "reference")}


def sticking() -> list[Number]:
    """Return the misfits of laws with a restitution whose tangential one stays at 5/7 and more."""
    return [
        spheres(law)
        for law, own in against_spheres().items()
        if own["lowest"] >= 5.0 / 7.0 - 1e-9 and "no restitution" not in own["free"]
    ]


def next_to(law: str) -> str:
    """Return the other law with the least misfit against the spheres."""
    others = {name: own["all"] for name, own in against_spheres().items() if name != law}
    return min(others, key=others.__getitem__)


def carried(law: str, name: str, inertia: int = 0) -> Any:
    """Return a number of the published motor under a law [mm/s], the second time with more inertia."""
    return with_error([row for row in rows_of("published_motor") if row["law"] == law][inertia][name])


def published(name: str) -> Number:
    """Return a number of the published motor that is of no law."""
    return number(value(f"published_motor/numbers/{name}", "experiments"))


def spread(law: str, *by: str) -> Number:
    """Return the largest difference of the published motor's repeated speeds [mm/s]."""
    return greatest(carried(law, f"largest difference, {each} [mm/s]", n) for each in by for n in (0, 1))


def misfit(law: str) -> Number:
    """Return the misfit of the calibration [mm/s]; its interval is that of the repetitions."""
    ends = [carried(law, f"calibration misfit {end} [mm/s]") for end in ("from", "to")]
    return Number(0.5 * (ends[0].value + ends[1].value), *(end.value for end in ends))


def moved(law: str, which: str) -> list[int]:
    """Return the least or most loads that the published motor moves in a repetition, by inertia."""
    return [carried(law, f"{which} loads moved", n) for n in (0, 1)]


LOADS: Final = 8
"""Loads of the published motor."""


def moves_all(law: str) -> bool | None:
    """Return whether the published motor moves all loads under a law; None if in some repetitions."""
    return some(
        True if fewest == LOADS else False if most < LOADS else None
        for fewest, most in zip(moved(law, "least"), moved(law, "most"), strict=True)
    )


def is_function(law: str) -> bool | None:
    """Return whether repetitions of the published motor agree to what its speeds were read."""
    return less(spread(law, *CHANGED), READ)


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


def clear_share(quantity: str) -> Number:
    """Return the share of motors with D > 1 and its 95 % interval; what is not clear counts as either."""
    here = matters(quantity)
    fewest, most = here["clearly above"], here["motors"] - here["clearly below"]
    counts = [share(times, here["motors"]) for times in (here["D > 1"], fewest, most)]
    return Number(counts[0].value, counts[1].low, counts[2].high)


def in_most(quantity: str) -> bool | None:
    """Return whether the law matters to a quantity in more than half of such motors."""
    return less(0.5, clear_share(quantity))


TOLD: Final = 0.5
"""Rank correlation below which a group tells little of D."""


def tested_groups() -> list[dict[str, Any]]:
    """Return the groups of which the correlation with D is tested."""
    return [row for row in mattering() if row["p"] is not None]


def separates(row: Mapping[str, Any]) -> bool | None:
    """Return whether D goes with a group: by the corrected p-value at 5 %.

    It does not where the interval of the rank correlation lies below `TOLD` (Fisher's transformation).
    """
    if row["p"] < 0.05:
        return True
    correlation = min(abs(row["rank correlation"]), 1.0 - 1e-9)
    return False if tanh(atanh(correlation) + 1.96 * blur(row["motors"])) < TOLD else None


def blur(motors: int) -> float:
    """Return the standard deviation of Fisher's transform of a rank correlation."""
    return 1.03 / sqrt(motors - 3) if motors > 3 else inf


def shown_by_half() -> Number:
    """Return the rank correlation that the motors show with a probability of one half, corrected."""
    rows = tested_groups()
    return exact(tanh(norm.isf(0.025 / len(rows)) * blur(min(row["motors"] for row in rows))))


def evaluated(expression: str) -> Any:
    """Return the value of an expression over the store, with the names of this module and of verdicts.py."""
    return eval(expression, {**vars(verdicts), **globals()})


@dataclass(frozen=True)
class Statement:
    """A sentence of a page on what was measured or follows in closed form.

    Args:
        page: where it stands.
        population: what it is about.
        sentence: what the page says.
    """

    page: str
    population: str
    sentence: str

    @property
    def templates(self) -> list[str]:
        """Every sentence that may stand on the page, the longest first."""
        return [self.sentence]

    @property
    def template(self) -> str:
        """The sentence that the page states."""
        return self.sentence

    @property
    def reason(self) -> str:
        """Why the page states it."""
        return "Stated as it was measured or follows in closed form."


HOLDS, DOES_NOT_HOLD, OPEN = "holds", "does not hold", "open"
"""Verdicts on a claim."""


@dataclass(frozen=True)
class Claim(Statement):
    """A sentence of a page, chosen by a predicate.

    Args:
        holds: the predicate, an expression; `sentence` is what the page says if it holds.
        otherwise, open: the sentence if it does not hold, and if that is open.
    """

    holds: str
    otherwise: str
    open: str

    @property
    def templates(self) -> list[str]:
        """Every sentence that may stand on the page, the longest first."""
        return sorted({self.sentence, self.otherwise, self.open}, key=len, reverse=True)

    @property
    def verdict(self) -> str:
        """Whether the claim holds."""
        return {True: HOLDS, False: DOES_NOT_HOLD, None: OPEN}[evaluated(self.holds)]

    @property
    def template(self) -> str:
        """The sentence that the page states."""
        return {HOLDS: self.sentence, DOES_NOT_HOLD: self.otherwise, OPEN: self.open}[self.verdict]

    @property
    def reason(self) -> str:
        """Why the page states it."""
        return {
            HOLDS: f"Stated as this is true: `{self.holds}`",
            DOES_NOT_HOLD: f"Stated as this is false: `{self.holds}`",
            OPEN: f"Stated as the results leave open whether this is true: `{self.holds}`",
        }[self.verdict]


_WRITTEN: Final = yaml.safe_load(Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"))

CLAIMS: Final = tuple(Claim(**claim) for claim in _WRITTEN["claims"])
STATEMENTS: Final = (*CLAIMS, *(Statement(**each) for each in _WRITTEN["measured"]))


def markdown(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Return a table in Markdown."""
    lines = [[*head], *([*map(str, row)] for row in rows)]
    head, *body = [f"| {' | '.join(line)} |".replace("|  |", "| |") for line in lines]
    return "\n".join([head, "|---" * len(lines[0]) + "|", *body])


def front_page() -> str:
    """Return what the example of README prints."""
    bases = {"ritz": "four shapes", "finite_element": "converged"}
    lines = [
        f"{basis:15} {law:15} {settled:8.4f} +- {settled.error:.1g} rad/s"
        for basis, section in bases.items()
        for law in ("lagrange_stick", "newton", "hertz_penalty")
        for settled in [
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
        torque = value(f"{PHASE}/{phase}/{law}/stall_torque")
        return f"{velocity(f'{PHASE}/{phase}', law)}, {1e3 * torque:.3f}"

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
        yield from (velocity(section, law) for law in FOUR)

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
        yield from (f"{predicted(law, case):.4f}" for law in (SPRING, "poisson", "newton"))
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
        yield f"{misfit(law).high:.0f}" if is_function(law) else "none"

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
        near = share(own["D > 1"], own["motors"])
        yield from (own["quantity"].replace("_", " "), own["motors"])
        yield f"{own['D > 1']} ({100 * near.low:.0f} to {100 * near.high:.0f} %)"
        yield from (own["clearly above"], own["clearly below"])
        yield f"{own['median']:.2g} ({own['10 %']:.2g} to {own['90 %']:.2g})"

    head = ("quantity", "motors", "D > 1", "clearly", "clearly not", "median D (10 to 90 %)")
    rows = (row(own) for own in mattering() if own["group"] == "all")
    return markdown(head, rows)


def groups() -> str:
    """Return the groups over which D differs, or for each quantity the one that tells most."""
    rows = []
    for quantity in dict.fromkeys(row["quantity"] for row in mattering()):
        own = sorted((x for x in tested_groups() if x["quantity"] == quantity), key=lambda x: x["p"])
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
    return markdown(("script", "agrees with its claim", "finding"), rows)


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
    for placement, own in cells.items():
        own["f_2/f_1"] = f"{frequency_ratio(placement):.4f} ({PRINTED_RATIOS[placement]:.2f})"
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
