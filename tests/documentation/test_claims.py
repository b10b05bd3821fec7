"""Every claim has a predicate that holds, fails and is open for some results, and a sentence for each."""

import ast
from collections.abc import Iterator, Mapping
from copy import deepcopy
from functools import cache
from math import sqrt
from typing import Any

import claims
import numpy as np
import pytest
import recorded_numbers
from claims import CLAIMS, PAGES, Claim
from recorded_numbers import CHANGED, DAMPING, PHASE, SPRING
from results_pages import of_page, pattern, rendered
from results_store import read
from verdicts import NONE, Number, every, exact, greatest, least, less, no, share, some, within

from contactlab.studies.compare.paired import VERDICTS

DISTINCT = [*{(claim.holds, claim.sentence): claim for claim in CLAIMS}.values()]
"""Claims, of one that stands on several pages one."""

World = dict[str, dict[str, Any]]
Edits = Mapping[str, Any]


@cache
def recorded() -> World:
    """Return the recorded results by file and section."""
    return {
        file: {name: section["results"] for name, section in read(file)["sections"].items()}
        for file in recorded_numbers.FILES
    }


def edited(edits: Edits) -> World:
    """Return results with other values; a key is FILE|SECTION|...|NAME, and `*` stands for every name."""
    world = {file: dict(sections) for file, sections in recorded().items()}
    for file, section in {tuple(key.split("|")[:2]) for key in edits}:
        world[file][section] = deepcopy(world[file][section])
    for key, value in edits.items():
        parents: list[Any] = [world]
        *way, last = key.split("|")
        for name in way:
            parents = [parent[each] for parent in parents for each in names_of(parent, name)]
        for parent in parents:
            for each in names_of(parent, last):
                parent[each] = value
    return world


def names_of(parent: Any, name: str) -> list[Any]:
    """Return the keys or places of a part that a name stands for."""
    if isinstance(parent, list):
        return [*range(len(parent))] if name == "*" else [int(name)]
    return [*parent] if name == "*" else [name]


def claim_of(start: str) -> Claim:
    """Return the claim whose sentence begins so, on the first of its pages."""
    claim, *others = (each for each in CLAIMS if " ".join(each.sentence.split()).startswith(start))
    assert {each.holds for each in others} <= {claim.holds}
    return claim


@pytest.fixture(autouse=True)
def as_recorded() -> Iterator[None]:
    """Return the claims to their own results after each test."""
    own = recorded_numbers.results
    yield
    recorded_numbers.results = own


def judged(claim: Claim, world: World) -> bool | None:
    """Return the verdict on a claim by some results."""
    recorded_numbers.results = world.__getitem__
    verdict: bool | None = claims.evaluated(claim.holds)
    return verdict


def gain(value: float, half: float = 1e-3) -> dict[str, float]:
    """Return a recorded difference with its interval."""
    return {"gain": value, "low": value - half, "high": value + half}


def alike(share: float, motors: int) -> dict[str, int]:
    """Return outcomes of so many motors, of which a share are faster."""
    greater = round(share * motors)
    return {"greater": greater, "less": motors - greater, "equal": 0, "none": 0}


POPULATIONS, WORLDS = "motor|populations|*", "motor|known worlds|*|*"
ELLIPSES, GEOMETRY = "measurements|ellipses", "measurements|ellipses|geometry|*"
SPHERES = "measurements|spheres|laws"
CONTRASTS, PRACTICE = "experiments|law_contrasts", "experiments|law_practice"
PUBLISHED = "experiments|published_motor|rows"
TABLE1, FIG9 = "experiments|table1_placement|rows", "experiments|fig9_normal_force|rows"
SLIP, NINE = f"{ELLIPSES}|over slip", range(9)


def held_out(law: str, low: float, high: float, geometry: str = "laws") -> Edits:
    """Return a held-out error with its interval."""
    own = {"error": 0.5 * (low + high), "low": low, "high": high}
    return {f"{ELLIPSES}|{geometry}|{law}|{name}": x for name, x in own.items()}


def ratio_at(slip: int, value: float, half: float) -> Edits:
    """Return quartiles of the ratio of gap rates in an eighth of 800 impacts whose median has an interval."""
    width = half * sqrt(100.0) / 1.82
    own = {"ratio": value, "low": value - 0.5 * width, "high": value + 0.5 * width}
    return {f"{ELLIPSES}|impacts": 800} | {f"{SLIP}|{slip}|{name}": x for name, x in own.items()}


def of_speeds(where: str, error: float, **speeds: float) -> Edits:
    """Return settled velocities by law."""
    names = {name: (f"motor|{where}|{law}|rotor_velocity", x) for law, x in speeds.items() for name in [law]}
    return dict(names.values()) | {f"{key}_error": error for key, _ in names.values()}


def of_law(law: str, misfit: float) -> Edits:
    return {f"{SPHERES}|{law}|all": misfit}


MADE: dict[str, tuple[str, Edits, bool | None]] = {}
"""Start of a claim's sentence, made results, and the verdict on it by them."""


def made(start: str, *cases: tuple[Edits, bool | None]) -> None:
    """Add made results of a claim."""
    MADE.update({f"{start}: {n}": (start, edits, known) for n, (edits, known) in enumerate(cases)})


def of_intervals(share: float, sets: int = 10_000) -> Edits:
    """Return how many of so many intervals of each number hold the truth."""
    where = [f"accuracy|intervals of {kind}" for kind in ("loop", "impacts", "points")]
    return {f"{x}|sets": sets for x in where} | {f"{x}|covered|*": round(share * sets) for x in where}


made(
    "Of forces on a path",
    (of_intervals(0.9), True),
    (of_intervals(0.8), False),
    (of_intervals(0.95), False),
    (of_intervals(0.9, 20), None),
)
ORDERED = of_speeds(f"{PHASE}|0.0", 1e-8, stick=-0.5, newton=-0.5, hertz=-0.9)
made(
    "On the converged beam, at this phase",
    (ORDERED | of_speeds(f"{PHASE}|configured", 1e-3, stick=-1.049, newton=-1.0, hertz=-0.952), True),
    (ORDERED | of_speeds(f"{PHASE}|configured", 1e-3, stick=-1.052, newton=-1.0, hertz=-0.949), False),
    (ORDERED | of_speeds(f"{PHASE}|configured", 1e-3, stick=-1.050, newton=-1.0, hertz=-0.950), None),
    (ORDERED | of_speeds(f"{PHASE}|configured", 1e-2, stick=-1.0, newton=-0.96, hertz=-0.95), None),
)
LAWS = ("stick", "newton", "mindlin")
FALLING = {
    key: value
    for damping in recorded_numbers.motor_findings.DAMPING
    for key, value in of_speeds(
        f"{DAMPING}|{damping}",
        1e-3,
        hertz=-1.0,
        **dict.fromkeys(LAWS, -1.1 if damping == recorded_numbers.PAPER.split("/")[1] else -0.9),
    ).items()
}
LAST = f"{DAMPING}|{recorded_numbers.motor_findings.DAMPING[-1]}"
made(
    "Hertz's contact is the slowest of the four",
    (FALLING, True),
    (FALLING | of_speeds(LAST, 1e-3, newton=-1.1), False),
    (FALLING | of_speeds(LAST, 1e-3, newton=-0.999), None),
)


def impacts(apart: float, error: float) -> Edits:
    """Return velocities under Newton's and Poisson's impacts at all phases."""
    both = {
        f"motor|{PHASE}|*|{law}|rotor_velocity": v for law, v in (("newton", 1.0), ("poisson", 1.0 + apart))
    }
    return both | {f"motor|{PHASE}|*|{law}|rotor_velocity_error": error for law in ("newton", "poisson")}


made(
    "Newton's and Poisson's impacts",
    (impacts(0.9e-5, 1e-7), True),
    (impacts(1.1e-5, 1e-7), False),
    (impacts(0.9e-5, 1e-6), None),
)
made(
    "The slip-only law",
    ({"motor|default motor|*|slip|kind": "aperiodic"}, True),
    ({"motor|default motor|*|slip|kind": "periodic"}, False),
    ({"motor|default motor|*|slip|kind": "periodic without an orbit"}, None),
)


def agreeing(every_law: int, first_law: int) -> Edits:
    """Return in how many of twenty motors a long run and shooting agree, under every law but the first."""
    rows = "experiments|steady_states|rows"
    return {f"{rows}|*|settle": 20, f"{rows}|*|run agrees": every_law, f"{rows}|0|run agrees": first_law}


made(
    "Of {RANDOM * len(rows_of('steady_states'))} random motors",
    (agreeing(20, 20), True),
    (agreeing(4, 4), False),
    (agreeing(19, 19), None),
    (agreeing(20, 13), None),
)


def at_steps(peak: float, impulse: float) -> Edits:
    """Return peak and impulse at a quarter of the step; at the step both are 1."""
    columns = {"peak [N]": (1.0, peak), "impulse [N s]": (1.0, impulse)}
    return {f"{FIG9}|{n}|{name}": x for name, both in columns.items() for n, x in enumerate(both)}


made(
    "The peak of the normal force",
    (at_steps(3.81, 1.0099), True),
    (at_steps(3.79, 1.0), False),
    (at_steps(4.0, 1.0101), False),
    (at_steps(3.8, 1.0), None),
)


def first_run(velocity: float, error: float) -> Edits:
    """Return the velocity of the first run, of a motor that settles to 2 rad/s."""
    settled = of_speeds("default motor|four shapes", 1e-8, hertz=-2.0)
    return settled | {
        "motor|first run|rotor_velocity": -velocity,
        "motor|first run|rotor_velocity_error": error,
    }


for start in ("And a run of some milliseconds", "A run of some milliseconds"):
    made(
        start, (first_run(1.79, 0.009), True), (first_run(1.81, 0.009), False), (first_run(1.79, 0.011), None)
    )
FREQUENCY = "motor|modes|four shapes|natural_frequency|0", "motor|modes|converged|natural_frequency|0"
made(
    "The frequencies are those of four shapes",
    (dict(zip(FREQUENCY, (1000.0, 899.0), strict=True)), True),
    (dict(zip(FREQUENCY, (1000.0, 901.0), strict=True)), False),
    (dict(zip(FREQUENCY, (1000.0, 900.0), strict=True)), None),
)
for start in ("is {100 * ratio", "ratios of"):
    made(
        start,
        ({"motor|modes|*|damping_ratio|*": 0.0101}, True),
        ({"motor|modes|*|damping_ratio|*": 0.0099}, False),
        ({"motor|modes|*|damping_ratio|*": 0.01}, None),
    )


def chattering(changes: int, slip: float, finer: float, stuck: float) -> Edits:
    """Return slip and changes of its sign at both steps, and the slip of the law with stick."""
    rows, name = "experiments|fig10_sticking|rows", "slip in it, rms [m/s]"
    slips = {f"{rows}|{n}|{name}": x for n, x in enumerate((slip, finer, stuck))}
    return slips | {f"{rows}|0|changes of sign": 1000, f"{rows}|1|changes of sign": changes}


made(
    "The slip law chatters",
    (chattering(100, 1.0, 0.79, 0.078), True),
    (chattering(12, 1.0, 0.5, 0.01), True),
    (chattering(8, 1.0, 0.5, 0.01), False),
    (chattering(100, 1.0, 0.82, 0.01), False),
    (chattering(100, 1.0, 0.5, 0.051), False),
    (chattering(10, 1.0, 0.5, 0.01), None),
    (chattering(100, 1.0, 0.798, 0.01), None),
)
CLOSED = "experiments|published_motor|numbers|largest error of the closed form [%]"
made("So the speed is a quantile", ({CLOSED: 4.9}, True), ({CLOSED: 5.1}, False), ({CLOSED: 5.0}, None))


def beside_best(low: float) -> Edits:
    """Return the error of all laws, and of the best impulse as 1 +- 0.1."""
    every_law = held_out("*", low, low + 0.1) | held_out("*", low, low + 0.1, "geometry|*|laws")
    return every_law | held_out("best impulse", 0.9, 1.1)


made("The best impulse", (beside_best(2.21), True), (beside_best(1.59), False), (beside_best(2.19), None))
NEEDED = {
    key: x
    for law, low, high in (
        ("frictionless", 0.9, 1.1),
        ("constant impulse", 0.9, 1.1),
        *((law, 0.35, 0.44) for law in ("newton", "poisson", "stronge")),
        *((law, 1.11, 1.3) for law in ("hertz_penalty", "lagrange_stick", "lagrange_slip")),
    )
    for key, x in held_out(law, low, high).items()
}
made(
    "**Friction and restitution",
    (NEEDED, True),
    (NEEDED | held_out("newton", 0.56, 0.6), False),
    (NEEDED | held_out("newton", 0.35, 0.46), None),
    (NEEDED | held_out("hertz_penalty", 1.09, 1.3), None),
)
ROUNDED = {f"{TABLE1}|*|computed": 2000.0, f"{TABLE1}|*|printed": 2000.0}
made(
    "All {len(first_misses())} couplings",
    (ROUNDED | {f"{TABLE1}|3|computed": 2004.9}, True),
    (ROUNDED | {f"{TABLE1}|3|computed": 2005.1}, False),
    (ROUNDED | {f"{TABLE1}|3|computed": 2005.0}, None),
)
RATIOS = {f"{TABLE1}|{n}|computed": x for n, x in ((3, 1000.0), (4, 2670.0), (8, 1000.0), (9, 1710.0))}
made(
    "Both ratios of the frequencies",
    (RATIOS | {f"{TABLE1}|9|computed": 1714.9}, True),
    (RATIOS | {f"{TABLE1}|9|computed": 1715.1}, False),
    (RATIOS | {f"{TABLE1}|9|computed": 1715.0}, None),
)
CALM = {f"{PUBLISHED}|*|largest difference, {by} [mm/s]": 1e-3 for by in CHANGED}
WILD = dict.fromkeys(CALM, 4.1)
made(
    "**Under none of the four laws",
    (WILD, True),
    (
        WILD | {f"{PUBLISHED}|{n}|largest difference, {by} [mm/s]": 1.9 for n in (0, 1) for by in CHANGED},
        False,
    ),
    (
        WILD | {f"{PUBLISHED}|{n}|largest difference, {by} [mm/s]": 3.5 for n in (0, 1) for by in CHANGED},
        None,
    ),
)
MU, START = (f"largest difference, {by} [mm/s]" for by in CHANGED)
RIGID_GROW = CALM | {f"{PUBLISHED}|*|{START}": 5.0} | {f"{PUBLISHED}|{n}|{MU}": 5.0 for n in range(4)}
made(
    "**Under the two rigid laws",
    (RIGID_GROW, True),
    (RIGID_GROW | {f"{PUBLISHED}|*|{MU}": 5.0}, False),
    (RIGID_GROW | {f"{PUBLISHED}|4|{MU}": 2.5}, None),
)
LOADS = f"{PUBLISHED}|*|least loads moved", f"{PUBLISHED}|*|most loads moved"
made(
    "**No draw that is shown moves all loads",
    (dict(zip(LOADS, (7, 7), strict=True)), True),
    (dict(zip(LOADS, (8, 8), strict=True)), False),
    (dict(zip(LOADS, (7, 8), strict=True)), None),
)
MISFITS = {f"{PUBLISHED}|*|calibration misfit {end} [mm/s]": x for end, x in (("from", 20.0), ("to", 40.0))}


def hertz_misfit(low: float, high: float) -> Edits:
    ends = zip(("from", "to"), (low, high), strict=True)
    return MISFITS | {f"{PUBLISHED}|4|calibration misfit {end} [mm/s]": x for end, x in ends}


made(
    "**No ranking follows**",
    (hertz_misfit(41.0, 50.0), True),
    (hertz_misfit(10.0, 19.0), False),
    (hertz_misfit(39.0, 50.0), None),
)
made(
    "**Poisson's restitution",
    ({f"{GEOMETRY}|poisson before newton": gain(1.1e-3)}, True),
    ({f"{GEOMETRY}|poisson before newton": gain(-1.1e-3)}, False),
    ({f"{GEOMETRY}|poisson before newton": gain(0.9e-3)}, None),
    ({f"{GEOMETRY}|poisson before newton": None}, None),
)
made(
    "Brach's and Newton's laws",
    ({f"{ELLIPSES}|brach before newton": gain(0.5e-4, 0.4e-4)}, True),
    ({f"{ELLIPSES}|brach before newton": gain(1.5e-4, 0.4e-4)}, False),
    ({f"{ELLIPSES}|brach before newton": gain(0.5e-4, 0.6e-4)}, None),
)
made(
    "**The restitution falls",
    ({**ratio_at(0, 0.6, 0.01), **ratio_at(7, 0.579, 0.01)}, True),
    ({**ratio_at(0, 0.6, 0.01), **ratio_at(7, 0.621, 0.01)}, False),
    ({**ratio_at(0, 0.6, 0.01), **ratio_at(7, 0.581, 0.01)}, None),
)
GROUP = (f"{ELLIPSES}|laws|{SPRING}|group", f"{ELLIPSES}|laws|hertz_point + flores + coulomb|group")
made(
    "With the geometry of the file a tangential spring",
    (dict(zip(GROUP, (1, 2), strict=True)), True),
    (dict(zip(GROUP, (2, 1), strict=True)), False),
    (dict(zip(GROUP, (1, 1), strict=True)), None),
)


def at_ratios(soft: float, rigid: float) -> Edits:
    stiff = {
        f"{ELLIPSES}|stiffness ratio|{law} 1 before coulomb": gain(rigid) for law in ("mindlin", "microslip")
    }
    return stiff | {f"{ELLIPSES}|stiffness ratio|mindlin 4 before coulomb": gain(soft)}


made(
    "On one impact in eight",
    (at_ratios(1.1e-3, -1.1e-3), True),
    (at_ratios(1.1e-3, 1.1e-3), False),
    (at_ratios(0.9e-3, -1.1e-3), None),
)


def arms(before: float, now: float) -> Edits:
    """Return what Poisson's law gains by free arms, and what a spring gains over it then; before, 5e-3."""
    return {
        f"{ELLIPSES}|geometry|arms|poisson before all as measured": gain(before),
        f"{ELLIPSES}|geometry|arms|mindlin before poisson": gain(now),
        f"{ELLIPSES}|geometry|as measured|mindlin before poisson": gain(5e-3),
    }


made(
    "With offsets of",
    (arms(1.1e-3, 2.9e-3), True),
    (arms(1.1e-3, 7.1e-3), False),
    (arms(1.1e-3, 3.1e-3), None),
    (arms(0.9e-3, 2.9e-3), None),
)


def inertia(now: float) -> Edits:
    free = f"{ELLIPSES}|geometry"
    return {
        f"{free}|inertia|mindlin before poisson": gain(now),
        f"{free}|as measured|mindlin before poisson": gain(8e-3),
    }


made(
    "With {geometry('inertia', 'inertia'):.2f} times",
    (inertia(5.6e-3), True),
    (inertia(2.4e-3), False),
    (inertia(5.4e-3), None),
)
made(
    "No law explains",
    ({f"{ELLIPSES}|impacts": 1000, f"{ELLIPSES}|unexplained|observed": 18}, True),
    ({f"{ELLIPSES}|impacts": 1000, f"{ELLIPSES}|unexplained|observed": 3}, False),
    ({f"{ELLIPSES}|impacts": 1000, f"{ELLIPSES}|unexplained|observed": 17}, None),
)


def dependent(correlation: float, wide: float) -> Edits:
    widths = {f"{ELLIPSES}|half-width|{block}": x for block, x in ((1, 1.0), (50, wide))}
    return widths | {f"{ELLIPSES}|impacts": 10_000, f"{ELLIPSES}|correlation of neighbours": correlation}


made(
    "Errors of Poisson's law in successive",
    (dependent(0.08, 1.26), True),
    (dependent(0.12, 1.0), False),
    (dependent(0.01, 1.8), False),
    (dependent(0.09, 1.0), None),
    (dependent(0.01, 1.4), None),
)
made(
    "Any curve that is free",
    (of_law("any curve", 1.07), True),
    (of_law("any curve", 2.20), False),
    (of_law("any curve", 1.09), None),
)
made(
    "The {len(sticking())} laws",
    (of_law("*", 2.41), True),
    (of_law("*", 1.59), False),
    (of_law("*", 2.39), None),
)
made(
    "`microslip` falls to",
    (of_law("microslip", 2.0) | of_law("mindlin", 2.81), True),
    (of_law("microslip", 2.0) | of_law("mindlin", 1.19), False),
    (of_law("microslip", 2.0) | of_law("mindlin", 2.79), None),
)
made(
    "discretised otherwise",
    (of_law("*", 3.0) | of_law("microslip", 2.19), True),
    (of_law("*", 3.0) | of_law("microslip", 3.81), False),
    (of_law("*", 3.0) | of_law("microslip", 2.21), None),
)


def order(verdict: str, nominal: float, other: float) -> Edits:
    ends = {f"{POPULATIONS}|hertz|relative|{name}": x for name, x in (("nominal", nominal), ("other", other))}
    return ends | {f"{POPULATIONS}|hertz|order": verdict}


made(
    "As configured `lagrange_stick`",
    (order("varies", 0.06, 0.069), True),
    (order("greater", 0.06, 0.06), False),
    (order("varies", 0.04, 0.04), False),
    (order("inconclusive", 0.06, 0.06), None),
    (order("varies", 0.06, 0.071), None),
)
made(
    "What turns the outcome",
    ({f"{POPULATIONS}|newton|roles": {"damping ratio": "alone"}}, True),
    ({f"{POPULATIONS}|newton|roles": {"voltage": "alone"}}, False),
    ({f"{POPULATIONS}|newton|roles": {"damping ratio": "among", "voltage": "among"}}, None),
    ({f"{POPULATIONS}|newton|roles": {"damping ratio": "together", "voltage": "together"}}, None),
    ({f"{POPULATIONS}|newton|roles": {}}, None),
    ({f"{POPULATIONS}|newton|share": 0.9, f"{POPULATIONS}|newton|roles": None}, None),
)
BY_DEFAULT = {f"motor|populations|{recorded_numbers.DEFAULT}|newton|outcomes": alike(0.5, 40)}
made(
    "Real motors outside",
    ({f"{POPULATIONS}|newton|outcomes": alike(0.8, 40)} | BY_DEFAULT, True),
    ({f"{POPULATIONS}|newton|outcomes": alike(0.5, 400)}, False),
    ({f"{POPULATIONS}|newton|outcomes": alike(0.75, 40)} | BY_DEFAULT, None),
    ({f"{POPULATIONS}|newton|outcomes": alike(0.5, 50)}, None),
)
made(
    "In none of these worlds",
    ({f"{WORLDS}|any wrong": 0.036}, True),
    ({f"{WORLDS}|any wrong": 0.066}, False),
    ({f"{WORLDS}|any wrong": 0.038}, None),
)
FACTORS = "motor|known factors|*|*"
made(
    "In each of these worlds a factor",
    ({f"{FACTORS}|designs": 1000, f"{FACTORS}|wrong": 0.036}, True),
    ({f"{FACTORS}|designs": 1000, f"{FACTORS}|wrong": 0.066}, False),
    ({f"{FACTORS}|designs": 1000, f"{FACTORS}|wrong": 0.038}, None),
    ({f"{FACTORS}|designs": 0, f"{FACTORS}|wrong": 0.0}, None),
)
made(
    "What decides a tenth",
    ({f"{FACTORS}|designs": 1000, f"{FACTORS}|right": 0.46}, True),
    ({f"{FACTORS}|designs": 1000, f"{FACTORS}|right": 0.54}, False),
    ({f"{FACTORS}|designs": 1000, f"{FACTORS}|right": 0.47}, None),
)


def of_shares(low: float, high: float, chance: float = 0.01) -> Edits:
    """Return shares of law x motor of a difference of laws and of a null contrast."""
    ends = {"a": (low, high), "null: a": (0.0, chance)}
    rows = [
        {"quantity": quantity, "contrast": name, "share": 0.5 * sum(own), "low": own[0], "high": own[1]}
        for quantity in ("rotor_velocity", "stall_torque")
        for name, own in ends.items()
    ]
    size = {row["quantity"]: {name: [0.1] for name in ends} for row in rows}
    return {f"{CONTRASTS}|rows": rows, f"{CONTRASTS}|numbers|size": size}


made(
    "In {motors()} drawn motors",
    (of_shares(0.011, 0.2), True),
    (of_shares(0.0, 0.009), False),
    (of_shares(0.009, 0.2), None),
    (of_shares(0.011, 0.2, chance=0.02), None),
)


def motors_beyond(count: int, level: str) -> Edits:
    """Return sizes of 100 motors, so many of which, one of them turned, exceed what is known."""
    other = dict.fromkeys(("catalogue", "bench", "measured"), [1e9] * 100) | {level: [1.0] * 100}
    size = {"a": ["turned", *[1.1] * (count - 1), *[0.9] * (100 - count)], "null: a": [1e-9] * 100}
    sizes = dict.fromkeys(("rotor_velocity", "stall_torque"), size)
    return {f"{CONTRASTS}|numbers|size": sizes, f"{CONTRASTS}|numbers|half-width": other}


for start, level in (
    ("Of {bounded('catalogue')} motors", "catalogue"),
    ("Of {bounded('bench')} motors", "bench"),
    ("Of {bounded('measured')} motors", "measured"),
):
    made(
        start,
        (motors_beyond(61, level), True),
        (motors_beyond(39, level), False),
        (motors_beyond(58, level), None),
        (motors_beyond(42, level), None),
    )


def of_maps(low: float) -> Edits:
    """Return a map whose R^2 has a lower end."""
    own = {"r2": 0.5, "low": low, "high": 0.8, "coverage": 0.9, "motors": 64}
    return {f"{CONTRASTS}|numbers|map": {"rotor_velocity": {"a": own}, "stall_torque": {"a": own}}}


made(
    "Dimensionless groups predict",
    (of_maps(0.26), True),
    (of_maps(0.24), False),
    ({f"{CONTRASTS}|numbers|map": {"rotor_velocity": {}, "stall_torque": {}}}, None),
)


def fitted(count: int) -> Edits:
    """Return errors of 100 predictions, so many of which are less than 5 %."""
    errors = [0.048] * count + [0.049] * (100 - count)
    return {f"{PRACTICE}|numbers|error": {"newton": [0.0] * 100, "poisson": errors}}


made(
    "Fitted at two operating points",
    (fitted(61), True),
    (fitted(39), False),
    (fitted(58), None),
    ({f"{PRACTICE}|numbers|error": {"newton": [], "poisson": []}}, None),
)


JOINT = "measurements|joint_friction|rows"


def over_plain(ratio: float, *rows: int) -> dict[str, float]:
    """Return mean squares of laws of a joint over that of the plain one, to a tenth."""
    ends = {"ratio": ratio, "low": 0.9 * ratio, "high": 1.1 * ratio}
    return {f"{JOINT}|{row}|{name}": value for row in rows for name, value in ends.items()}


made(
    "A Stribeck curve predicts better",
    (over_plain(0.9, 2) | over_plain(2.0, 3), True),
    (over_plain(1.12, 2, 3), False),
    (over_plain(1.0, 2, 3), None),
)
made(
    "Viscous friction is needed",
    (over_plain(1.23, 0, 4), True),
    (over_plain(2.0, 0) | over_plain(1.0, 4), False),
    (over_plain(1.1, 0, 4), None),
)


@pytest.mark.parametrize("case", MADE)
def test_a_claim_is_judged_by_the_uncertainty_of_its_numbers(case: str) -> None:
    start, edits, known = MADE[case]
    assert judged(claim_of(start), edited(edits)) is known


CATEGORIES = (
    {"periodic", "quasi-periodic", "chaotic", "aperiodic", "standing", "periodic without an orbit"},
    {*VERDICTS},
    {"alone", "among", "together"},
)
"""Texts of results that a predicate may read."""


def varied(node: Any, rng: np.random.Generator, part: float, by: float, wide: float, key: str = "") -> Any:
    """Return results of which a part differs by random factors, with wider or narrower errors."""
    if isinstance(node, dict):
        result = {name: varied(each, rng, part, by, wide, name) for name, each in node.items()}
        centre = next((name for name in ("error", "gain", "ratio") if {name, "low", "high"} <= {*node}), None)
        if centre is not None:
            result |= {x: result[centre] + wide * (node[x] - node[centre]) for x in ("low", "high")}
        return result
    if isinstance(node, list):
        return [varied(each, rng, part, by, wide, key) for each in node]
    if isinstance(node, str):
        choice = next((sorted(each) for each in CATEGORIES if node in each), [node])
        return str(rng.choice(choice)) if rng.random() < part else node
    if node is None or rng.random() >= part:
        return node * wide if key.endswith("_error") else node
    factor = float(np.exp(by * rng.normal()))
    return round(node * factor) if isinstance(node, int) else node * factor


def between(a: Any, b: Any, place: float) -> Any:
    """Return results between two of one form."""
    if isinstance(a, dict):
        return {name: between(a[name], b.get(name), place) for name in a}
    if isinstance(a, list):
        return [between(x, y, place) for x, y in zip(a, b, strict=True)]
    if isinstance(a, float | int) and isinstance(b, float | int):
        here = a + place * (b - a)
        return here if isinstance(a, float) else round(here)
    return a if place < 0.5 else b


@cache
def worlds_of(claim: Claim) -> dict[bool | None, World]:
    """Return results by which a claim holds, does not hold and is open."""
    own, worlds = recorded_numbers.results, dict[bool | None, World]()
    recorded_numbers.USED.clear()
    claims.evaluated(claim.holds)
    used = sorted(recorded_numbers.USED)
    for start, edits, _ in MADE.values():
        if claim_of(start).holds == claim.holds:
            world = edited(edits)
            worlds.setdefault(judged(claim, world), world)
    rng = np.random.default_rng(0)
    for _ in range(400):
        if len(worlds) == 3:
            break
        part, by, wide = (
            rng.choice(x) for x in ((0.05, 0.3, 1.0), (0.0, 0.1, 0.5, 2.0), (1e-3, 1.0, 1e3, 1e6))
        )
        world = {file: dict(sections) for file, sections in recorded().items()}
        for file, section in used:
            world[file][section] = varied(world[file][section], rng, part, by, wide)
        worlds.setdefault(judged(claim, world), world)
    # Between results by which it holds and others by which it does not, it must be open.
    low, high = 0.0, 1.0
    while None not in worlds and low < (middle := 0.5 * (low + high)) < high:
        world = {file: dict(sections) for file, sections in worlds[True].items()}
        for file, section in used:
            world[file][section] = between(world[file][section], worlds[False][file][section], middle)
        known = judged(claim, world)
        worlds.setdefault(known, world)
        low, high = (middle, high) if known else (low, middle)
    recorded_numbers.results = own
    return worlds


@pytest.mark.parametrize("claim", DISTINCT, ids=lambda claim: " ".join(claim.sentence.split())[:50])
def test_a_predicate_holds_does_not_hold_and_is_open_for_some_results(claim: Claim) -> None:
    worlds = worlds_of(claim)
    assert {*worlds} == {True, False, None}
    for world in worlds.values():
        recorded_numbers.results = world.__getitem__
        assert pattern(claim.template).fullmatch(rendered(claim))
    assert len({claim.sentence, claim.otherwise, claim.open}) == 3


@pytest.mark.parametrize("known", [True, False, None])
@pytest.mark.parametrize("page", sorted({claim.page for claim in CLAIMS}))
def test_every_sentence_is_found_on_its_page_whatever_the_others_say(page: str, known: bool | None) -> None:
    """A page is rebuilt from any verdicts to any others."""
    texts = []
    for claim in of_page(page):
        recorded_numbers.results = (
            worlds_of(claim)[known] if isinstance(claim, Claim) else recorded()
        ).__getitem__
        texts.append(rendered(claim))
    text = "\n\n".join(texts)
    for claim in of_page(page):
        places = {each.start() for template in claim.templates for each in pattern(template).finditer(text)}
        assert len(places) == 1


@pytest.mark.parametrize("claim", DISTINCT, ids=lambda claim: " ".join(claim.sentence.split())[:50])
def test_a_predicate_compares_by_what_uncertainty_leaves_open(claim: Claim) -> None:
    """No comparison, `and`, `or`, `not`, `all` or `any`, which know two outcomes."""
    assert claim.page in PAGES
    for node in ast.walk(ast.parse(claim.holds.strip(), mode="eval")):
        assert not isinstance(node, ast.Compare | ast.BoolOp | ast.Not)
        assert not (isinstance(node, ast.Name) and node.id in {"all", "any", "bool", "min", "max", "float"})


@pytest.mark.parametrize("claim", DISTINCT, ids=lambda claim: " ".join(claim.sentence.split())[:50])
def test_the_list_gives_the_reason_of_the_sentence_that_stands_there(claim: Claim) -> None:
    reasons = set()
    for known, world in worlds_of(claim).items():
        recorded_numbers.results = world.__getitem__
        reasons.add(claim.reason)
        assert claim.template == {True: claim.sentence, False: claim.otherwise, None: claim.open}[known]
    assert len(reasons) == 3


def test_arithmetic_carries_errors_and_comparison_knows_them() -> None:
    a, b = Number.of(1.0, 0.1), Number.of(2.0, 0.2)
    assert less(a, b) is True
    assert less(b, a) is False
    assert less(a, 1.05) is None
    assert less(0.5 * b, 0.95) is None
    assert less(0.5 * b, 0.89) is False
    assert less(b - a, 0.69) is False
    assert less(1.0 - a, 0.11) is True
    assert less(a / b, 0.62) is True
    assert less(a / b, 0.60) is None
    assert less(1.0 / a, 0.9) is False
    assert less(1.0, a / Number.of(0.0, 0.1)) is None
    assert less(abs(Number.of(-1.0, 0.1)), 0.89) is False
    assert less(abs(Number.of(0.05, 0.1)), 0.16) is True
    assert less(exact(1.0), 1.0) is False
    assert less(Number.of(1.0), 1.0) is None
    assert less(NONE, 1.0) is None
    assert less(NONE + 1.0, NONE) is None
    assert within(a, 0.8, 1.2) is True
    assert within(a, 1.0, 1.2) is None
    assert (least((a, b)).low, greatest((a, b)).high) == (0.9, 2.2)
    with pytest.raises(TypeError):
        a == b  # noqa: B015 - what is tested is that it raises
    with pytest.raises(TypeError):
        a < b  # noqa: B015 - what is tested is that it raises
    with pytest.raises(TypeError):
        bool(a)


def test_verdicts_are_joined_with_what_is_open() -> None:
    assert every((True, None)) is None
    assert every((False, None)) is False
    assert some((True, None)) is True
    assert some((False, None)) is None
    assert some((False, False)) is False
    assert no(None) is None
    # Eleven of sixteen motors are 41 to 89 %.
    eleven = share(11, 16)
    assert (round(eleven.low, 2), round(eleven.high, 2)) == (0.41, 0.89)
    assert less(0.5, eleven) is None
