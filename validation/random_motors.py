"""Random motors over every law and part, each for the engine and for the independent judge.

Number i is of row i modulo the number of rows; its motor and its law's numbers are those of the seed (i, 26).
Round by round through the rows the motor is plain, on a bearing, changes while it runs, or both.
"""

# ruff: noqa: ARG005 - the makers of one family have one signature
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from oracle.composed import Judge, JudgedRun, Parts
from oracle.flight import Flight
from oracle.friction_parts import (
    Ageing,
    BoucWen,
    Bristles,
    Dahl,
    Friction,
    Iwan,
    Mindlin,
    RateAndState,
    Regularised,
    SetValued,
    Stribeck,
)
from oracle.motor import Mechanics
from oracle.normal_parts import (
    Damping,
    Dmt,
    Jkr,
    Lining,
    Normal,
    Power,
    Prony,
    Thornton,
    WaltonBraun,
    dashpot,
    dashpot_coefficient,
    elliptic_stiffness,
    hysteretic,
    loss_number,
)
from oracle.rigid import (
    Impact,
    RigidJudge,
    Rough,
    brach,
    chatterjee_ruina,
    johnson,
    newton,
    plastic_ageing,
    process,
    slip_only,
)
from support.motors import default_motor, oracle_motor

from contactlab.engine import simulate
from contactlab.laws import LAWS, PARTS, ContactLaw
from contactlab.motor.motor import Motor
from contactlab.trajectory import Trajectory

STEEL = 210e9 / (2.0 * (1.0 - 0.3**2))
DURATION = 2e-3
TOTAL = 245
LOOSE, TIGHT = 1e-9, 1e-11
"""Relative tolerances of the judge: its change from the first to the second is its own error, and more."""

DEFAULT, FINE = "default", "fine"
"""Engine at its default tolerance and at 1e-10."""

PLAIN, BEARING, CHANGES, BOTH = KINDS = ("plain", "bearing", "changes", "bearing and changes")
"""What a motor has beside its law."""

CARRYING = 1e-3
"""A contact counts from this share of the largest impulse on: bounces that die out have no last one,
and grazing contacts come and go with a picometre."""

QUANTITIES = ("rotor_velocity", "normal_impulse", "contact_time", "displacement", "contact_work")
"""What is compared: at the end, in sum, in sum, at the end, in sum."""

Draw = dict[str, Any]


class Dice:
    """Random numbers of one case."""

    def __init__(self, number: int, stream: int = 26) -> None:
        self.rng = np.random.default_rng([number, stream])

    def between(self, low: float, high: float) -> float:
        """Uniform."""
        return float(self.rng.uniform(low, high))

    def log(self, low: float, high: float) -> float:
        """Uniform in the logarithm."""
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def choice(self, *values: float) -> float:
        """One of some values."""
        return float(self.rng.choice(values))


def motor_of(dice: Dice) -> Draw:
    """A motor that touches its rotor within half of the run, in words of `motors.DEFAULTS`."""
    while True:
        changes = any_motor(dice)
        mechanics = Mechanics(oracle_motor(**changes))
        if Flight(mechanics).until(0.0, mechanics.initial_state(), 0.5 * DURATION, lambda _: 0.0)[2]:
            return changes


def any_motor(dice: Dice) -> Draw:
    """A motor, in words of `motors.DEFAULTS`."""
    start = dice.between(0.2e-3, 15e-3)
    return {
        "patch_start": start,
        "patch_end": dice.between(start + 5e-3, min(start + 12e-3, 27e-3)),
        "tip_mass": dice.log(0.4e-3, 2.5e-3),
        "tip_inertia": dice.log(0.6e-7, 3e-7),
        "tip_length": dice.between(10e-3, 24e-3),
        "rotor_radius": dice.between(12e-3, 40e-3),
        "rotor_inertia": dice.log(4e-6, 1e-4),
        "rotor_damping": dice.choice(0.0, dice.log(1e-6, 1e-3)),
        "load_torque": dice.choice(0.0, dice.between(-5e-3, 5e-3)),
        "initial_velocity": dice.choice(0.0, dice.between(-2.0, 2.0)),
        "clearance": dice.log(5e-8, 1e-6),
        "friction_coefficient": dice.between(0.05, 0.7),
        "voltage_1": dice.between(60.0, 300.0),
        "voltage_2": dice.between(60.0, 300.0),
        "frequency": dice.between(1800.0, 4500.0),
        "frequency_ratio": dice.choice(1.0, 1.5, 2.0, 3.0),
        "phase": dice.between(-np.pi, np.pi),
        "shapes": int(dice.choice(3, 4, 5)),
        "mass_damping": dice.log(2.0, 200.0),
        "stiffness_damping": dice.log(4e-6, 4e-5),
    }


def kind_of(number: int) -> str:
    """What the motor with a number has beside its law.

    Slow rebounds lose nothing under Johnson's law, so that a rotor that is pressed bounces without end.
    """
    names = rows()
    kind = KINDS[number // len(names) % len(KINDS)] if number < DENTED else PLAIN
    return (
        {BEARING: PLAIN, BOTH: CHANGES}.get(kind, kind) if names[number % len(names)] == "johnson" else kind
    )


def bearing_of(dice: Dice, changes: Draw) -> Draw:
    """A bearing whose rotor begins above the tip."""
    return {
        "rotor_mass": dice.log(5e-3, 0.2),
        "bearing_stiffness": dice.choice(0.0, dice.log(1e3, 1e6)),
        "bearing_damping": dice.choice(0.0, dice.log(1.0, 100.0)),
        "preload": dice.log(0.3, 10.0),
        "rotor_start": -dice.between(0.2, 0.8) * changes["clearance"],
    }


def later_of(dice: Dice, changes: Draw) -> list[tuple[float, Draw]]:
    """One or two times [s], and all numbers of the motor from each on."""
    later, now = [], dict(changes)
    for time in sorted(dice.between(0.3, 0.9) for _ in range(int(dice.choice(1, 2)))):
        now |= {
            "voltage_1": dice.between(60.0, 300.0),
            "load_torque": dice.between(-5e-3, 5e-3),
            "rotor_damping": dice.log(1e-6, 1e-3),
        }
        if "preload" in now:
            now["preload"] = dice.log(0.3, 10.0)
        later.append((time * DURATION, dict(now)))
    return later


def sphere(dice: Dice) -> Draw:
    return {"radius": dice.log(1e-3, 8e-3), "effective_modulus": STEEL * dice.log(0.2, 1.0)}


def adhesive(dice: Dice) -> Draw:
    return sphere(dice) | {"work_of_adhesion": dice.log(0.02, 2.0)}


def bristles(dice: Dice) -> Draw:
    return {
        "static_ratio": dice.between(1.0, 1.8),
        "bristle_stiffness": dice.log(3e5, 3e6),
        "bristle_damping": dice.choice(0.0, dice.log(0.01, 0.3)),
        "stribeck_velocity": dice.log(5e-3, 5e-2),
    }


def prony(dice: Dice) -> Draw:
    arms = int(dice.choice(1, 2, 3))
    return {
        "relaxed_stiffness": dice.log(2e6, 2e7),
        "first_stiffness": dice.log(2e6, 2e7),
        "first_time": dice.log(3e-6, 3e-4),
        "second_stiffness": dice.log(1e6, 1e7) if arms > 1 else 0.0,
        "second_time": dice.log(3e-5, 1e-3),
        "third_stiffness": dice.log(1e6, 1e7) if arms > 2 else 0.0,
        "third_time": dice.log(3e-4, 3e-3),
    }


def walton_braun(dice: Dice) -> Draw:
    loading = dice.log(3e6, 3e7)
    return {
        "loading_stiffness": loading,
        "unloading_stiffness": loading * dice.between(1.1, 3.0),
        "hardening": dice.choice(0.0, dice.log(1e5, 1e6)),
    }


def prony_of(p: Draw) -> Normal:
    arms = [(p[f"{k}_stiffness"], p[f"{k}_time"]) for k in ("first", "second", "third")]
    return Prony(p["relaxed_stiffness"], [arm for arm in arms if arm[0] > 0.0])


NORMALS: dict[str, tuple[Callable[[Dice], Draw], Callable[[Draw], Normal]]] = {
    "hertz_point": (lambda d: {"stiffness": d.log(3e8, 5e10)}, lambda p: Power(p["stiffness"], 1.5)),
    "hertz_elliptic": (
        lambda d: {
            "radius_along": d.log(1e-3, 2e-2),
            "radius_across": d.log(1e-3, 2e-2),
            "effective_modulus": STEEL * d.log(0.2, 1.0),
        },
        lambda p: Power(elliptic_stiffness(*p.values()), 1.5),
    ),
    "line": (
        lambda d: {"length": d.log(2e-3, 2e-2), "effective_modulus": STEEL * d.log(0.05, 0.5)},
        lambda p: Power(p["effective_modulus"] * (p["length"] ** 0.8 / 1.36) ** (10.0 / 9.0), 10.0 / 9.0),
    ),
    "linear": (lambda d: {"stiffness": d.log(2e6, 5e7)}, lambda p: Power(p["stiffness"], 1.0)),
    "lining": (
        lambda d: {
            "soft_stiffness": d.log(2e6, 1e7),
            "hard_stiffness": d.log(2e7, 1e8),
            "lining_depth": d.log(5e-8, 5e-7),
            "passage": d.log(5e-8, 3e-7),
        },
        lambda p: Lining(*p.values()),
    ),
    "thornton": (
        lambda d: sphere(d) | {"yield_pressure": d.log(2e8, 1.5e9)},
        lambda p: Thornton(*p.values()),
    ),
    "walton_braun": (walton_braun, lambda p: WaltonBraun(*p.values())),
    "jkr": (adhesive, lambda p: Jkr(*p.values())),
    "dmt": (adhesive, lambda p: Dmt(*p.values())),
    "prony": (prony, prony_of),
}

DAMPINGS: dict[str, tuple[Callable[[Dice], Draw], Callable[[Draw, Normal], Damping]]] = {
    "linear": (
        lambda d: {
            "restitution": d.between(0.4, 0.95),
            "effective_mass": d.log(5e-4, 5e-3),
            "impact_speed": d.log(0.02, 0.2),
        },
        lambda p, n: dashpot(
            dashpot_coefficient(n, p["restitution"], p["effective_mass"], p["impact_speed"])
        ),
    ),
    "hunt_crossley": (
        lambda d: {"restitution": d.between(0.5, 0.95), "impact_speed": d.log(0.02, 0.2)},
        lambda p, n: hysteretic(loss_number(p["restitution"]), p["impact_speed"]),
    ),
    "lankarani_nikravesh": (
        lambda d: {"restitution": d.between(0.7, 0.97), "least_speed": 1e-3},
        lambda p, n: hysteretic(loss_number(p["restitution"]), least=p["least_speed"]),
    ),
    "flores": (
        lambda d: {"restitution": d.between(0.2, 0.95), "least_speed": 1e-3},
        lambda p, n: hysteretic(loss_number(p["restitution"]), least=p["least_speed"]),
    ),
}

FRICTIONS: dict[str, tuple[Callable[[Dice], Draw], Callable[[float, Draw], Friction]]] = {
    "coulomb": (
        lambda d: {"static_ratio": d.choice(1.0, d.between(1.0, 2.5))},
        lambda mu, p: SetValued(mu, p["static_ratio"]),
    ),
    "regularised": (
        lambda d: {"creep_velocity": d.log(1e-4, 1e-2)},
        lambda mu, p: Regularised(mu, p["creep_velocity"]),
    ),
    "mindlin": (
        lambda d: {"stiffness_ratio": d.between(0.4, 1.2)},
        lambda mu, p: Mindlin(mu, p["stiffness_ratio"]),
    ),
    "lugre": (bristles, lambda mu, p: Bristles(mu, *p.values())),
    "elasto_plastic": (
        lambda d: bristles(d) | {"breakaway_ratio": d.between(0.2, 0.9)},
        lambda mu, p: Bristles(mu, *p.values()),
    ),
    "stribeck": (
        lambda d: {
            "static_ratio": d.between(1.0, 2.0),
            "stribeck_velocity": d.log(3e-3, 1e-1),
            "stribeck_exponent": d.choice(1.0, 2.0),
        },
        lambda mu, p: Stribeck(mu, *p.values()),
    ),
    "cohesive": (
        lambda d: {"static_ratio": d.choice(1.0, d.between(1.0, 2.0)), "cohesion": d.log(0.01, 1.0)},
        lambda mu, p: SetValued(mu, p["static_ratio"], p["cohesion"]),
    ),
    "ageing_stick": (
        lambda d: {
            "strengthening": d.log(0.003, 0.1),
            "ageing_time": d.log(1e-6, 1e-4),
            "longest_age": d.choice(1e5, d.log(1e-6, 1e-5)),
        },
        lambda mu, p: Ageing(mu, *p.values()),
    ),
    "dahl": (
        lambda d: {"rest_stiffness": d.log(3e5, 3e6), "exponent": d.choice(1.0, 2.0, 1.5)},
        lambda mu, p: Dahl(mu, *p.values()),
    ),
    "bouc_wen": (
        lambda d: {
            "yield_displacement": d.log(1e-7, 1e-6),
            "shape": d.between(0.5, 1.0),
            "exponent": d.choice(1.0, 2.0, 3.0),
        },
        lambda mu, p: BoucWen(mu, *p.values()),
    ),
    "iwan": (
        lambda d: {"elements": int(d.choice(1, 3, 6)), "full_slip": d.log(1e-7, 1e-6)},
        lambda mu, p: Iwan(mu, *p.values()),
    ),
    "rate_and_state": (
        lambda d: {
            "direct_effect": d.log(0.005, 0.03),
            "evolution_effect": d.log(0.005, 0.03),
            "renewal_distance": d.log(3e-7, 3e-6),
            "reference_velocity": d.log(1e-6, 1e-5),
            "fresh_age": d.log(1e-7, 1e-5),
            "creep_velocity": d.log(1e-7, 1e-6),
        },
        lambda mu, p: RateAndState(mu, *p.values()),
    ),
}

MIXED = "mixed"
"""Parts of a composed law drawn together."""


DENTED = 1000
"""Numbers from here on are of contacts that dent, under frictions with a variable, on motors that hardly
open: some touch down again inside of a dent, where the variables of the contact still live."""


@dataclass(frozen=True)
class Case:
    """One motor: for the engine, and for the judge."""

    number: int
    row: str
    changes: Draw
    later: list[tuple[float, Draw]]
    law: ContactLaw
    judge: Callable[[float], Any]
    """Gives the judge's run at a relative tolerance."""

    @property
    def motor(self) -> Motor:
        """The engine's motor at the start."""
        return default_motor(**self.changes)

    def run(self, **accuracy: float) -> Trajectory:
        """The engine's run."""
        run, done = None, 0.0
        ends = [*(time for time, _ in self.later), DURATION]
        for (_, changes), end in zip([(0.0, self.changes), *self.later], ends, strict=True):
            piece = simulate(
                default_motor(**changes),
                self.law,
                duration=end - done,
                record_interval=min(1e-6, end - done),
                start=run and run.state,
                **accuracy,
            )
            run, done = run.followed_by(piece) if run else piece, end
            if not run.complete:
                raise RuntimeError(run.message)
        return run


def composed(changes: Draw, dice: Dice, normal: str, damping: str, friction: str) -> tuple[ContactLaw, Parts]:
    """The law of three parts, twice."""
    mu = changes["friction_coefficient"]
    n, f = NORMALS[normal][0](dice), FRICTIONS[friction][0](dice)
    if normal in ("hertz_point",) and damping == "none" and friction != "coulomb":
        # Stiff contacts are short: friction with a spring would see one half period of it.
        n = {"stiffness": dice.log(1e9, 2e10)}
    spring = NORMALS[normal][1](n)
    damped, p = None, {}
    if damping != "none":
        p = DAMPINGS[damping][0](dice)
        damped = DAMPINGS[damping][1](p, spring)
    law = LAWS["composed"](
        normal=PARTS["normal"][normal](**n),
        damping=PARTS["damping"][damping](**p),
        friction=PARTS["friction"][friction](friction_coefficient=mu, **f),
    )
    own = Parts(spring, FRICTIONS[friction][1](mu, f), *([damped] if damped else []))
    return law, own


def rows() -> list[str]:
    """Names of the rows of the table."""
    parts = [f"normal {n}" for n in NORMALS] + [f"damping {n}" for n in DAMPINGS]
    return ["hertz_penalty", "archard", *parts, *(f"friction {n}" for n in FRICTIONS), MIXED, *RIGID]


RIGID = (
    *("lagrange_stick", "lagrange_slip", "lagrange_ageing", "newton", "moreau_jean"),
    *("poisson", "stronge", "brach", "johnson", "chatterjee_ruina"),
)


def rigid(row: str, mu: float, dice: Dice) -> tuple[ContactLaw, Impact, Rough]:
    """A rigid law, and its impact and friction for the judge."""
    e = dice.between(0.1, 0.8)
    rough, numbers = Rough(mu), {}
    if row == "lagrange_slip":
        impact = slip_only(mu)
    elif row == "lagrange_stick":
        impact = newton(mu, 0.0)
    elif row == "lagrange_ageing":
        numbers = {
            "static_ratio": dice.between(1.0, 1.6),
            "strengthening": dice.log(0.003, 0.05),
            "ageing_time": dice.log(1e-6, 1e-4),
        }
        rough = Rough(mu, *numbers.values())
        impact = plastic_ageing(rough)
    elif row == "johnson":
        numbers = {
            "modulus": dice.log(2e10, 1e11),
            "yield_strength": dice.log(3e7, 5e8),
            "radius": dice.log(1e-3, 8e-3),
        }
        impact = johnson(mu, *numbers.values())
    elif row == "chatterjee_ruina":
        numbers = {"restitution": e, "tangential_restitution": dice.between(-0.9, 0.9)}
        impact = chatterjee_ruina(mu, *numbers.values())
    else:
        numbers = {"restitution": e}
        made = {"poisson": process(mu, e, False), "stronge": process(mu, e, True), "brach": brach(mu, e)}
        impact = made.get(row, newton(mu, e))
    return LAWS[row](friction_coefficient=mu, **numbers), impact, rough


def case_of(number: int) -> Case:
    """The motor and law with a number."""
    names, dice = rows(), Dice(number)
    row = names[number % len(names)] if number < DENTED else MIXED
    changes = motor_of(dice)
    if row in RIGID:
        changes["friction_coefficient"] = min(changes["friction_coefficient"], 0.4)
    mu, other, kind = changes["friction_coefficient"], Dice(number, 27), kind_of(number)
    if kind in (BEARING, BOTH):
        changes |= bearing_of(other, changes)
    later = later_of(other, changes) if kind in (CHANGES, BOTH) else []
    if row in RIGID:
        law, impact, rough = rigid(row, mu, dice)

        def judge(rtol: float) -> JudgedRun:
            pieces = [(time, oracle_motor(**now)) for time, now in later]
            return RigidJudge(oracle_motor(**changes), impact, rough, rtol).run(DURATION, pieces)

        return Case(number, row, changes, later, law, judge)
    if row == "hertz_penalty":
        k = dice.log(3e8, 5e10)
        law, parts = LAWS["hertz_penalty"](k, mu), Parts(Power(k, 1.5), SetValued(mu))
    elif row == "archard":
        k, wear = dice.log(3e8, 2e10), dice.log(1e-4, 1e-1)
        law = LAWS["archard"](k, mu, wear)
        parts = Parts(Power(k, 1.5), SetValued(mu), wear=wear / (law.hardness * law.apparent_area))
    elif number >= DENTED:
        normal = ("thornton", "walton_braun")[number % 2]
        friction = ("bouc_wen", "dahl", "lugre", "mindlin")[number // 2 % 4]
        changes["clearance"], changes["voltage_1"] = dice.log(1e-9, 1e-8), dice.between(100.0, 400.0)
        changes["voltage_2"], changes["frequency"] = dice.between(5.0, 40.0), dice.between(600.0, 1500.0)
        changes["phase"] = dice.between(0.0, 0.3)
        law, parts = composed(changes, dice, normal, "none", friction)
    elif row == MIXED:
        normal = list(NORMALS)[int(dice.between(0, len(NORMALS)))]
        friction = list(FRICTIONS)[int(dice.between(0, len(FRICTIONS)))]
        law, parts = composed(changes, dice, normal, "none", friction)
    else:
        family, name = row.split()
        chosen = {"normal": "hertz_point", "damping": "none", "friction": "coulomb", family: name}
        law, parts = composed(changes, dice, **chosen)

    def judged_by(rtol: float) -> JudgedRun:
        pieces = [(time, oracle_motor(**now)) for time, now in later]
        return Judge(oracle_motor(**changes), parts, rtol).run(DURATION, pieces)

    return Case(number, row, changes, later, law, judged_by)


def of_judge(run: JudgedRun) -> dict[str, float]:
    """The quantities of the judge's run."""
    return {
        "rotor_velocity": run.rotor_velocity,
        "normal_impulse": sum(run.normal_impulses),
        "contact_time": sum(run.durations),
        "displacement": run.u,
        "contact_work": run.contact_work,
        "contacts": carrying(np.array(run.normal_impulses)),
    }


def carrying(impulses: np.ndarray) -> int:
    """How many contacts count."""
    return int((impulses > CARRYING * impulses.max()).sum()) if impulses.size else 0


def of_engine(case: Case, effort: str) -> tuple[dict[str, float], dict[str, float]]:
    """The quantities of the engine's run, and their scales."""
    run = case.run(**({"tolerance": 1e-10} if effort == FINE else {}))
    series, contacts = run.series, run.contacts
    taken = series["friction_loss"] + series["contact_loss"] + series["contact_energy"]
    relative = series["tip_normal_displacement"] - series.get("rotor_normal_displacement", 0.0)
    values = {
        "rotor_velocity": series["rotor_velocity"][-1],
        "normal_impulse": contacts["normal_impulse"].sum(),
        "contact_time": contacts["duration"].sum(),
        "displacement": relative[-1],
        "contact_work": taken[-1],
        "contacts": carrying(contacts["normal_impulse"]),
    }
    scales = {
        "rotor_velocity": np.abs(series["rotor_velocity"]).max(),
        "normal_impulse": contacts["normal_impulse"].sum(),
        "contact_time": DURATION if case.row in RIGID else contacts["duration"].sum(),
        "displacement": np.abs(relative).max(),
        "contact_work": np.abs(taken).max(),
    }
    return values, scales


def judgement(number: int) -> dict[str, float]:
    """The quantities of the judge at both of its tolerances, the tight one for the result."""
    case = case_of(number)
    return {
        f"{effort} {name}": value
        for effort, rtol in (("tight", TIGHT), ("loose", LOOSE))
        for name, value in of_judge(case.judge(rtol)).items()
    }


def judged(
    number: int, efforts: tuple[str, ...] = (DEFAULT, FINE), known: dict[str, float] | None = None
) -> dict[str, Any]:
    """One motor against its judge: errors over scales, by effort, and the judge's own change.

    known: what `judgement` has said of it.
    """
    case, judge = case_of(number), known or judgement(number)
    out: dict[str, Any] = {"number": number, "row": case.row, "kind": kind_of(number)}
    out["contacts"] = int(judge["tight contacts"])
    for effort in efforts:
        values, scales = of_engine(case, effort)
        out[f"{effort} contacts"] = values["contacts"]
        for name in QUANTITIES:
            size, right = max(scales[name], 1e-300), judge[f"tight {name}"]
            out[f"{effort} {name}"] = abs(values[name] - right) / size
            out[f"judge {name}"] = abs(judge[f"loose {name}"] - right) / size
    return out
