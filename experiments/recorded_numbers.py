"""Numbers of the recorded results as predicates and sentences name them: each with its uncertainty."""

import re
from collections.abc import Iterable, Mapping
from functools import cache
from math import ceil, isfinite, sqrt
from typing import Any, Final

import motor_findings
from results_store import read
from scipy.stats import chi2, fisher_exact
from verdicts import NONE, Number, every, exact, greatest, least, less, number, share, some, within

from contactlab.engine.defaults import DEFAULT_TOLERANCE
from contactlab.studies.compare.paired import ALONE, INCONCLUSIVE, ROLES, VARIES, VERDICTS, power

FILES: Final = ("accuracy", "motor", "experiments", "measurements")
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


def covering(kind: str) -> Number:
    """Return the share of 90 % intervals that hold the truth."""
    own = results("accuracy")[f"intervals of {kind}"]
    return share(sum(own["covered"].values()), own["sets"] * len(own["covered"]))


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


BEHIND: Final = ("mindlin, frame", "dahl, frame", "iwan, frame", "bouc_wen, frame")
"""Laws with a stiffness of their own behind the frame of a tribometer."""

CURVES: Final = ("stribeck, exponent 1, viscous", "stribeck, exponent 2, viscous")
"""Laws of a joint's friction with a Stribeck curve."""

STATES: Final = ("rate_and_state", "ruina", "perrin_rice_zheng", "nagata")
"""Laws of rock friction with a state."""

STRESSES: Final = ("15 MPa", "20 MPa")
"""Normal stresses at which these are fitted."""


def rubbing(experiment: str, law: str, seen: str = "") -> Mapping[str, Any]:
    """Return what is recorded of a law against measured friction, and fitted at a normal stress."""
    rows = results("measurements")[experiment]["rows"]
    (row,) = (x for x in rows if x["law"] == law and x.get("fitted at", "") == seen)
    return dict(row)


def over_reference(experiment: str, law: str, seen: str = "") -> Number:
    """Return the mean square of what a law misses unseen, over that of the reference of its experiment."""
    return interval(rubbing(experiment, law, seen), "ratio")


def of_rubbing(experiment: str, law: str, name: str, seen: str = "") -> float:
    """Return a number of a law against measured friction, by the beginning of its name."""
    (number,) = (x for key, x in rubbing(experiment, law, seen).items() if key.startswith(name))
    return float(number)


def missed(experiment: str, law: str, seen: str = "") -> float:
    """Return what a law misses unseen: of the force, of the normal stress [1], or of a torque [N m]."""
    return of_rubbing(experiment, law, "held out", seen)


def over_ageing() -> list[Number]:
    """Return the mean squares of what other laws with a state miss of velocity steps, over Dieterich's."""
    own = results("measurements")["velocity_steps"]["numbers"]["over ageing"].values()
    return [interval(each, "ratio") for each in own]


def against_friction(experiment: str, name: str) -> Number:
    """Return a number of an experiment on measured friction that belongs to no law."""
    stored: Number = value(f"{experiment}/numbers/{name}", "measurements")
    return number(stored)


def again() -> Number:
    """Return what the mean of the cycles seen misses of the others, over the force [1]."""
    return against_friction("friction_loop", "again") / against_friction("friction_loop", "force")


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
