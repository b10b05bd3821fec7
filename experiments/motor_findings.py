"""Numbers on the motor that README, steady.md, paper.md and the page on comparison state.

Settled velocities under laws on two bases, over phase and damping; the paired comparison of the default
motor in populations, three of which the usual draws seldom contain; and how often the rule of pairs, and the
naming of what turns an order, are wrong in worlds of known truth. They are made by remake.py.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np
import xarray
from joblib import Parallel, delayed

import contactlab as cl
from contactlab.processes import processors
from contactlab.refinement import Refinement
from contactlab.steady_state import BrokenOffError, NotSettledError
from contactlab.studies.compare.factors import START, Factor
from contactlab.studies.compare.hypercube import drawn
from contactlab.studies.compare.laws import grid_of
from contactlab.studies.compare.observables import do_draw, observed
from contactlab.studies.compare.paired import (
    AGREED,
    GREATER,
    INCONCLUSIVE,
    LESS,
    NO_ROLE,
    OUTCOMES,
    ROLES,
    VARIES,
    VERDICTS,
    bins_of,
    factor_shares,
    looks_up_to,
    orders,
)
from contactlab.studies.compare.pairs import Design, with_pairs
from contactlab.studies.compare.repeats import MARGIN

LAWS: Final = {
    "stick": ["law=lagrange_stick"],
    "newton": ["law=newton"],
    "poisson": ["law=poisson"],
    "hertz": ["law=hertz_penalty"],
    "mindlin": ["law=composed", "law/friction=mindlin"],
}
PICTURED: Final = {
    "stick": ["law=lagrange_stick"],
    "slip": ["law=lagrange_slip"],
    "newton": ["law=newton"],
    "hertz": ["law=hertz_penalty"],
    "mindlin": ["law=composed", "law/damping=none", "law/friction=mindlin"],
}
"""Laws of the picture of README: without damping under `mindlin`."""

CONVERGED: Final = ["resonator=finite_element"]
BASES: Final = {"four shapes": [], "converged": CONVERGED}
PHASES: Final = (None, 0.0, 0.524)
"""Phases of the first tone [rad]; None is the configured one."""

DAMPING: Final = (
    *(f"stiffness_damping={beta}" for beta in ("2e-5", "6e-6", "2e-6", "2e-7")),
    *(f"damping_ratio={ratio}" for ratio in ("0.05", "0.01", "0.002")),
)
"""The paper's damping per stiffness, and less; damping ratios of all modes."""

PHASE: Final = "converged, by phase"
DAMPED: Final = "converged, by damping ratio at equal free amplitude"
ROD: Final = "converged, with a rod"
"""Names of sections."""

WITH_ROD: Final = [*CONVERGED, "resonator.rod_length=19 mm"]
FOUR: Final = ("stick", "newton", "hertz", "mindlin")
BOTH: Final = ("rotor_velocity", "stall_torque")
REPETITIONS: Final = 1000
COMPARED: Final = {"stick": "lagrange_stick", "hertz": "hertz_penalty", "newton": "newton"}
"""Laws that are compared in populations, the first one with the others."""


SAMPLES, FIRST = 32, 3
"""Motors of each population, and those of its short form."""


class Motors(NamedTuple):
    """A population: what is drawn beside the usual, around which motor, and numbers of Hertz's law."""

    vary: Mapping[str, Any] = {}
    overrides: tuple[str, ...] = ()
    of_hertz: tuple[str, ...] = ()


POPULATIONS: Final = {
    "by default": Motors(),
    "damping per stiffness 2e-6 to 2e-5 s": Motors({"resonator.stiffness_damping": (2e-6, 2e-5)}),
    "outside: a tenth of the damping": Motors({"resonator.damping_ratio": "log(0.0002..0.02)"}),
    "outside: phase 0.3 rad later": Motors(overrides=("drive.phase=-0.328",)),
    "outside: Hertz's stiffness three times": Motors(of_hertz=("law.stiffness=3e10",)),
}
"""Motors that are drawn, and real ones that the draws do not contain, or seldom."""

WORLDS: Final = {
    "greater in 100 %": (1.0, 0.0, 0.0, 0.0),
    "greater in 95 %, less in 5 %": (0.95, 0.05, 0.0, 0.0),
    "greater in 80 %, less in 20 %": (0.8, 0.2, 0.0, 0.0),
    "greater in 60 %, less in 4 %, else no steady state": (0.6, 0.04, 0.0, 0.36),
    "greater in 40 %, less in 30 %, equal in 20 %": (0.4, 0.3, 0.2, 0.1),
}
"""Probabilities of the outcomes of every pair of laws."""

FACTORS: Final = (
    *(Factor(f"factor {n}", "uniform", 0.0, 1.0) for n in range(7)),
    Factor(START, "uniform", 0.0, 1.0),
)
"""Seven numbers and the start, of 0 to 1 each."""

DECIDED: Final[dict[str, tuple[Callable[[Any], Any], set[int]]]] = {
    "one, at its median": (lambda u: u[:, 0] < 0.5, {0}),
    "one, at its quarter": (lambda u: u[:, 0] < 0.25, {0}),
    "one, at its tenth": (lambda u: u[:, 0] < 0.1, {0}),
    "the sense of the start": (lambda u: u[:, 7] < 0.5, {7}),
    "two, by exclusive or of their halves": (lambda u: (u[:, 0] < 0.5) ^ (u[:, 1] < 0.5), {0, 1}),
    "one and the start, by exclusive or": (lambda u: (u[:, 0] < 0.5) ^ (u[:, 7] < 0.5), {0, 7}),
    "the product of two": (lambda u: u[:, 0] * u[:, 1] < 0.25, {0, 1}),
    "the sum of two": (lambda u: u[:, 0] + u[:, 1] < 1.0, {0, 1}),
    "nothing that is drawn": (
        lambda u: np.random.default_rng(int(1e9 * u[0, 0])).random(len(u)) < 0.5,
        set(),
    ),
}
"""What decides the outcome of a pair in a motor, and the factors that have a say in it."""

DESIGNS: Final = 1000
"""Designs of draws, of different seeds, in each of which factors are named."""


def settled(overrides: list[str], names: tuple[str, ...] = ("rotor_velocity",)) -> dict[str, Any]:
    """Return kind and quantities of a settled motor at the finest of three steps, with numerical errors."""
    setup = cl.build(overrides)
    refinement, steps = Refinement.of(setup), []
    for value in refinement.values:
        key = f"solver.{refinement.control}={value!r}"
        try:
            kind, numbers = observed(cl.build([*overrides, key]), names)
        except (BrokenOffError, NotSettledError) as error:
            return {"kind": "none", "reason": str(error)}
        steps.append(numbers)
    result: dict[str, Any] = {"kind": kind}
    for name in names:
        values = [step[name].value for step in steps]
        result[name] = values[-1]
        result[f"{name}_error"] = abs(values[-1] - values[-2]) + steps[-1][name].error
    return result


def free_amplitude(overrides: list[str]) -> tuple[float, float]:
    """Return the normal and the tangential amplitude of the free tip, of the tones one by one [m]."""
    motor = cl.build(overrides).motor
    modes, rate = motor.modes, motor.drive.angular_frequency
    response = modes.coupling @ motor.drive.phasors
    tones = response / (modes.stiffness[:, None] - rate**2 + 1j * modes.damping[:, None] * rate)
    normal = np.abs(modes.tip_displacement @ tones)
    tangential = motor.geometry.tip_length * np.abs(modes.tip_slope @ tones)
    return float(normal.max()), float(tangential.max())


def at_equal_amplitude(damping: str) -> list[str]:
    """Return a damping and the voltages with which the free tip moves as with the paper's."""
    damped = [*CONVERGED, f"resonator.{damping}"]
    wanted, there = free_amplitude(CONVERGED), free_amplitude(damped)
    drive = cl.build(CONVERGED).configuration["drive"]
    # The first tone bends the beam to the rotor, the second turns its middle, or the other way round.
    voltages = [drive[f"voltage_{n}"] * wanted[n - 1] / there[n - 1] for n in (1, 2)]
    return [*damped, *(f"drive.voltage_{n}={x!r}" for n, x in enumerate(voltages, 1))]


def every(cases: Mapping[str, Callable[[], Any]]) -> dict[str, Any]:
    """Return the results of all cases, worked at by all processors."""
    results = Parallel(n_jobs=processors())(delayed(case)() for case in cases.values())
    return dict(zip(cases, results, strict=True))


def table(names: Iterable[str], overrides: list[str], quantities: tuple[str, ...]) -> dict[str, Any]:
    """Return the settled motor under laws."""
    return every({law: delayed_call(settled, [*overrides, *LAWS[law]], quantities) for law in names})


def delayed_call(function: Callable[..., Any], *arguments: Any) -> Callable[[], Any]:
    """Return a call without arguments that other processes can receive."""
    return partial(function, *arguments)


def rates(truth: Iterable[float], pairs: int, repetitions: int = REPETITIONS) -> dict[str, float]:
    """Return how often independent pairs with these outcomes get a false verdict, and any at all."""
    rng, chances, looks = np.random.default_rng(0), np.array(list(truth)), looks_up_to(64)
    true = np.append(chances > AGREED, [chances.max() <= AGREED, True])
    wrong = known = 0.0
    for _ in range(repetitions):
        outcomes = rng.choice(len(OUTCOMES), (pairs, looks[-1]), p=chances)
        verdicts = np.full(pairs, INCONCLUSIVE)
        for look in looks:
            latest = orders(outcomes[:, :look], len(looks)).verdict
            verdicts = np.where(verdicts >= VARIES, latest, verdicts)
        wrong += bool(~true[verdicts].all()) / repetitions
        known += float((verdicts != INCONCLUSIVE).mean()) / repetitions
    return {"any wrong": wrong, "known": known}


def default_motor() -> dict[str, Any]:
    """Return the laws of the picture on both bases, with the time in which the motor settles by e."""
    return {
        basis: every({law: delayed_call(with_time, [*overrides, *PICTURED[law]]) for law in PICTURED})
        for basis, overrides in BASES.items()
    }


def with_time(overrides: list[str]) -> dict[str, Any]:
    """Return kind, velocity and settling time of a settled motor."""
    steady = cl.converged(cl.build(overrides))
    best, velocity = steady.best, steady.velocity
    time = None if best.orbit is None else best.orbit.settling_time
    numbers = {"rotor_velocity": velocity.value, "rotor_velocity_error": velocity.error}
    return {"kind": best.kind, **numbers, "settling_time": time}


def first_run() -> dict[str, Any]:
    """Return the rotor velocity at the end of the default run, its error, and its time."""
    run = cl.simulate(cl.build())
    velocity, error = float(run["rotor_velocity"][-1]), float(run.attrs["rotor_velocity_error"])
    return {"time": float(run["time"][-1]), "rotor_velocity": velocity, "rotor_velocity_error": error}


def driven_modes() -> dict[str, Any]:
    """Return damping ratios and natural frequencies of the two driven modes on both bases."""
    names = ("damping_ratio", "natural_frequency")
    modes = {basis: cl.build(overrides).motor.modes for basis, overrides in BASES.items()}
    return {basis: {name: getattr(own, name)[:2].tolist() for name in names} for basis, own in modes.items()}


def by_phase() -> dict[str, Any]:
    """Return laws on the converged beam over the phase of the drive."""
    keys = {"configured" if phase is None else str(phase): phase for phase in PHASES}
    return {
        name: table(LAWS, [*CONVERGED, *([] if phase is None else [f"drive.phase={phase}"])], BOTH)
        for name, phase in keys.items()
    }


def by_damping() -> dict[str, Any]:
    """Return laws on the converged beam over damping, at equal free amplitude of the tip."""
    result = {}
    for damping in DAMPING:
        overrides = at_equal_amplitude(damping)
        result[damping] = {
            "overrides": overrides,
            "damping_ratio": cl.build(overrides).motor.modes.damping_ratio[:2].tolist(),
            **table(FOUR, overrides, ("rotor_velocity",)),
        }
    return result


def with_rod() -> dict[str, Any]:
    """Return laws on the converged beam whose tip is a rod that bends."""
    frequencies = cl.build(WITH_ROD).motor.modes.natural_frequency[:3].tolist()
    return {"natural_frequency": frequencies, **table(("stick", "newton", "hertz"), WITH_ROD, BOTH)}


def populations() -> dict[str, Any]:
    """Return paired comparisons of the default motor on the converged beam."""
    return {name: comparison(motors) for name, motors in POPULATIONS.items()}


def design_of(motors: Motors) -> Design:
    """Return the motors of a population under the laws that are compared."""
    setups = [
        cl.build([*CONVERGED, f"law={law}", *motors.overrides, *(motors.of_hertz if name == "hertz" else ())])
        for name, law in COMPARED.items()
    ]
    return Design.of(grid_of(setups), motors.vary, SAMPLES, ["rotor_velocity"], None)


def first_draws() -> dict[str, Any]:
    """Return the settled velocities of the first motors of the population by default, by law."""
    design = design_of(Motors())
    return {
        f"draw {n}": do_draw(motor, design.names).data["value"].values[:, 0].tolist()
        for n, motor in enumerate(design.drawn(0, FIRST).values())
    }


def comparison(motors: Motors) -> dict[str, Any]:
    """Return outcomes and sizes of the differences of laws in speed, and what turns the outcome."""
    design = design_of(motors)
    tasks = design.nominal() | design.drawn(0, SAMPLES)
    parts = every({key: delayed_call(do_draw, motor, design.names) for key, motor in tasks.items()})
    laws = xarray.Dataset(coords={"law": [*design.grid.laws]}, attrs={"notes": ""})
    data = with_pairs(laws, design, {key: part.data for key, part in parts.items()}, MARGIN)
    data = data.sel(quantity="rotor_velocity").isel(law=0, cell=0)
    pairs = {
        name: pair(data.isel(other_law=n), "damping") for n, name in enumerate(COMPARED) if name != "stick"
    }
    return {"prior": data["prior"].values.tolist(), **pairs}


def pair(here: xarray.Dataset, factor: str) -> dict[str, Any]:
    """Return the outcomes of a pair, in all motors and by quarters of a factor that is named in part."""
    outcome, roles = here["outcome"].values, here["factor_role"].values
    names = [str(name) for name in here["factor"].values]
    most = int(here["factor_share"].fillna(0.0).values.argmax())
    values = here["drawn"].values[:, [factor in name for name in names]][:, 0]
    bins = bins_of(values)
    ends = {name: float(here[f"relative_{name}"]) for name in ("nominal", "other")}
    ends |= {name: float(here[f"relative_difference{name}"]) for name in ("_low", "", "_high")}
    return {
        "motors": outcome.size,
        "outcomes": {name: int((outcome == kind).sum()) for kind, name in enumerate(OUTCOMES)},
        "order": VERDICTS[int(here["order"])],
        "relative": ends,
        "factor": names[most],
        "share": float(here["factor_share"][most]),
        "by chance": float(here["chance_share"]),
        "roles": {name: ROLES[role] for name, role in zip(names, roles, strict=True) if role != NO_ROLE},
        "quarters": [
            {"up to": float(values[bins == n].max())}
            | {name: int((outcome[bins == n] == kind).sum()) for kind, name in enumerate(OUTCOMES)}
            for n in range(int(bins.max()) + 1)
        ],
    }


def known_worlds() -> dict[str, Any]:
    """Return error rates of the rule of pairs, of one pair and of ten."""
    return {name: {str(n): rates(truth, n) for n in (1, 10)} for name, truth in WORLDS.items()}


def known_factors(designs: int = DESIGNS) -> dict[str, Any]:
    """Return how often a factor without a say is named, and those that have one alone, over the looks."""
    result: dict[str, Any] = {}
    for world, (decides, say) in DECIDED.items():
        result[world] = {}
        for look in looks_up_to(64):
            wrong = right = 0
            for seed in range(designs):
                draws = drawn(FACTORS, look, seed)
                role = factor_shares(np.where(decides(draws), GREATER, LESS), draws).role
                named = {*np.flatnonzero(role != NO_ROLE).tolist()}
                wrong += not named <= say
                right += bool(say) and named == say
            rates = {"wrong": wrong / designs, "right": right / designs}
            result[world][str(look)] = {"designs": designs, **rates}
    return result


def once(names: Iterable[str], overrides: list[str], quantities: tuple[str, ...]) -> dict[str, Any]:
    """Return the settled motor under laws at one step."""
    values = {name: observed(cl.build([*overrides, *LAWS[name]]), quantities)[1] for name in names}
    return {law: {name: each.value for name, each in own.items()} for law, own in values.items()}


def default_once() -> dict[str, Any]:
    """Return the laws of the picture on both bases at one step."""
    return {
        basis: {
            law: cl.steady(cl.build([*overrides, *PICTURED[law]])).details.velocity.value for law in PICTURED
        }
        for basis, overrides in BASES.items()
    }


SECTIONS: Final[dict[str, tuple[Callable[[], dict[str, Any]], Callable[[], dict[str, Any]]]]] = {
    "default motor": (default_motor, default_once),
    "first run": (first_run, first_run),
    "modes": (driven_modes, driven_modes),
    PHASE: (by_phase, lambda: once(LAWS, CONVERGED, BOTH)),
    DAMPED: (by_damping, lambda: once(FOUR, at_equal_amplitude(DAMPING[1]), BOTH[:1])),
    ROD: (with_rod, lambda: once(("stick", "newton", "hertz"), WITH_ROD, BOTH)),
    "populations": (populations, first_draws),
    "known worlds": (known_worlds, lambda: {name: rates(truth, 1, 20) for name, truth in WORLDS.items()}),
    "known factors": (known_factors, lambda: known_factors(10)),
}
"""What makes a section, and its short form."""
