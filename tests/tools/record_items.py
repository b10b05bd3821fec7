"""Items of a record of results: motors, laws and arguments, drawn once.

A record keeps its items as JSON, and `record_results.py record --items BEFORE` reads them there: this module
is for the first record alone, and need not follow a change of what it draws from.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, is_dataclass
from typing import Any

import numpy as np

Item = dict[str, Any]
"""What is computed: 'id', 'overrides' of the command line, and arguments."""

SEED = 27

LONGEST = 400
"""Longest run without an orbit [periods of the drive]."""

ELLIPSES, SPHERES = "ellipse_impacts.mat", "sphere_impacts.csv"

RIGID = (
    *("lagrange_slip", "lagrange_stick", "lagrange_ageing", "newton", "moreau_jean"),
    *("poisson", "stronge", "brach", "johnson", "chatterjee_ruina"),
)
PARTS: dict[str, tuple[str, ...]] = {
    "normal": (
        *("hertz_point", "hertz_elliptic", "line", "linear", "lining"),
        *("thornton", "walton_braun", "jkr", "dmt", "prony"),
    ),
    "damping": ("linear", "hunt_crossley", "lankarani_nikravesh", "flores"),
    "friction": (
        *("coulomb", "regularised", "mindlin", "lugre", "elasto_plastic", "stribeck"),
        *("cohesive", "ageing_stick", "dahl", "bouc_wen", "iwan", "rate_and_state"),
    ),
}
FOREIGN = (
    *("compliant_laws:Power", "compliant_laws:KelvinVoigt", "compliant_laws:Tsuji"),
    *("frictions:Tustin", "frictions:SolidFriction", "frictions:SmoothCone"),
    *("rigid_laws:TurningImpact", "rigid_laws:ViscoelasticImpact"),
)
"""Laws and parts of the tests' own package, as somebody else would write them."""

COMPOSED = ["law=composed"]
LAWS: dict[str, list[str]] = {
    **{name: [f"law={name}"] for name in (*RIGID, "hertz_penalty", "archard")},
    **{name: [*COMPOSED, f"law/{part}={name}"] for part, names in PARTS.items() for name in names},
    "linear": [*COMPOSED, "law/normal=linear"],
    "linear damping": [*COMPOSED, "law/damping=linear"],
    "three parts": [*COMPOSED, "law/normal=line", "law/damping=hunt_crossley", "law/friction=mindlin"],
}
"""Overrides of every law, and of a composed law for every part."""

BODIES: dict[str, tuple[dict[str, float], float]] = {
    "ball": ({"mass": 1e-3, "height": 1e-4, "velocity": 0.05, "spin": 0.02}, 0.02),
    "belt": ({"mass": 1.0, "stiffness": 100.0, "weight": 10.0, "belt_velocity": 0.1}, 0.5),
    "oscillator": (
        {"mass": 1.0, "stiffness": 4e3, "damping": 2.0, "gap": 1e-4, "force": 3.0, "frequency": 10.0},
        0.3,
    ),
    "cantilever": ({"gap": 1e-4, "acceleration": 5.0, "frequency": 80.0, "damping_ratio": 0.01}, 0.05),
}
"""Bodies that are made in Python: arguments, and duration of the run [s]."""

JUDGED, WIDE = 130, 105
"""Drawn motors: realistic ones that touch the rotor soon; ones far wider, of which a fifth is refused."""

KEYS = {
    "placement": {"patch_start": "start", "patch_end": "end"},
    "resonator": ("tip_mass", "tip_inertia", "shapes", "mass_damping", "stiffness_damping"),
    "contact": ("tip_length", "clearance", "friction_coefficient"),
    "rotor": {
        **{f"rotor_{name}": name for name in ("radius", "inertia", "damping")},
        **{name: name for name in ("load_torque", "initial_velocity")},
    },
    "drive": ("voltage_1", "voltage_2", "frequency", "frequency_ratio", "phase"),
}
"""Where a configuration has the numbers of the tests' motors."""


def drawn_motors() -> list[Item]:
    """Draw motors over all laws and parts."""
    from random_configuration import random_configuration
    from support.judged_motors import case_of

    items = []
    for number in range(JUDGED):
        case = case_of(number)
        text = _law_overrides(case.law)
        for section, names in KEYS.items():
            pairs = names.items() if isinstance(names, dict) else zip(names, names, strict=True)
            text += [f"{section}.{key}={case.changes[name]!r}" for name, key in pairs]
        text += ["solver.duration=0.002", "record.interval=1e-06"]
        items.append({"id": f"judged_{number:03}", "overrides": text})
    numbers = np.random.default_rng(SEED).choice(1200, WIDE, replace=False)
    for number in sorted(numbers.tolist()):
        groups, values = random_configuration(number, SEED)
        text = [f"{group}={option}" for group, option in groups.items()]
        text += [f"{key}={'null' if value is None else repr(value)}" for key, value in values.items()]
        items.append({"id": f"wide_{number:04}", "overrides": text})
    return items


def _law_overrides(law: Any) -> list[str]:
    """Return the overrides that make a law, without its friction coefficient."""
    text = [f"law={law.name}"]
    if is_dataclass(getattr(law, "normal", None)):
        text += [f"law/{part}={getattr(law, part).name}" for part in PARTS]
    flat = _leaves(asdict(law), "law")
    return [
        *text,
        *(f"{k}={x!r}" for k, x in flat if x is not None and not k.endswith("friction_coefficient")),
    ]


def _leaves(values: Mapping[str, Any], path: str) -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{path}.{name}")
        else:
            yield f"{path}.{name}", value


def mild_motor(rng: np.random.Generator) -> list[str]:
    """Draw a motor near the default one, which settles."""
    return [
        f"contact.clearance={rng.uniform(0.5e-6, 2e-6)!r}",
        f"contact.friction_coefficient={rng.uniform(0.15, 0.45)!r}",
        f"drive.phase={rng.uniform(-np.pi, np.pi)!r}",
        f"drive.voltage_1={rng.uniform(80.0, 130.0)!r}",
        f"drive.voltage_2={rng.uniform(80.0, 130.0)!r}",
        f"placement.end={rng.uniform(9e-3, 11e-3)!r}",
        f"rotor.inertia={rng.uniform(1e-5, 4e-5)!r}",
    ]


def impact_items() -> Iterator[Item]:
    """Every law at its defaults, laws of another package, and the laws of all drawn motors."""
    for name, text in LAWS.items():
        yield {"id": f"default_{name.replace(' ', '_')}", "overrides": text}
    for name in FOREIGN:
        yield {"id": f"foreign_{name.partition(':')[2]}", "overrides": [], "law": name}
    for item in drawn_motors():
        yield item | {
            "overrides": [w for w in item["overrides"] if w.startswith(("law", "contact.friction"))]
        }


def run_items() -> Iterator[Item]:
    """Drawn motors, laws of another package, bodies, runs in pieces and runs until steady."""
    short = ["solver.duration=0.002"]
    for body, (arguments, duration) in BODIES.items():
        for name in ("lagrange_stick", "newton", "hunt_crossley", "lugre"):
            run = {
                "arguments": arguments,
                "options": {"duration": duration, "record_interval": duration / 2e3},
            }
            yield {"id": f"{body}_{name}", "overrides": LAWS[name], "motor": body} | run
    for name in FOREIGN:
        yield {"id": f"foreign_{name.partition(':')[2]}", "overrides": short, "law": name}
    for name in ("newton", "hertz_penalty", "prony", "lugre"):
        text = LAWS[name]
        pieces = {"options": {"duration": 7e-4, "record_interval": 1e-6}, "pieces": 3}
        yield {"id": f"pieces_{name}", "overrides": text} | pieces
        until = {"options": {"until": "steady", "duration": 0.5, "record_interval": 1e-5}}
        yield {"id": f"until_{name}", "overrides": text} | until
    yield from drawn_motors()


def sweep_items() -> Iterator[Item]:
    """A hundred cells over laws, phases and clearances."""
    over = {
        "law": ["newton", "lagrange_slip", "poisson", "hertz_penalty", "archard"],
        "drive.phase": np.linspace(-3.0, 3.0, 10).tolist(),
        "contact.clearance": [0.0, 1e-6],
    }
    options = {"duration": 1.5e-3, "record_interval": 2e-6, "series": ["rotor_velocity"]}
    yield {
        "id": "phases",
        "overrides": ["contact.friction_coefficient=0.25"],
        "over": over,
        "options": options,
    }


def steady_items() -> Iterator[Item]:
    """The default motor under every law, held, loaded and braked; drawn motors."""
    rng, names = np.random.default_rng(SEED), list(LAWS)
    for name, text in LAWS.items():
        yield {"id": f"default_{name.replace(' ', '_')}", "overrides": text, "options": {"longest": LONGEST}}
    for name in ("hertz_penalty", "newton", "lagrange_stick", "prony", "lugre", "iwan"):
        for key, value in (("belt", -1.0), ("load", 1e-3), ("brake", 2e-3)):
            options = {"longest": LONGEST, key: value}
            yield {"id": f"{key}_{name}", "overrides": LAWS[name], "options": options}
    for name in ("hertz_penalty", "newton", "mindlin", "walton_braun"):
        # More than the motor can turn.
        yield {"id": f"held_{name}", "overrides": LAWS[name], "options": {"longest": LONGEST, "brake": 0.01}}
    for item in drawn_motors()[:JUDGED]:
        yield item | {"options": {"longest": LONGEST}}
    for number in range(40):
        name = names[number * 7 % len(names)]
        text, options = [*LAWS[name], *mild_motor(rng)], {"longest": LONGEST}
        yield {"id": f"drawn_{number:02}_{name.replace(' ', '_')}", "overrides": text, "options": options}


def branch_items() -> Iterator[Item]:
    """Branches over keys and over a belt, basins and attractors."""
    gap, belt = ("contact.clearance", 1e-6), ("belt", -2.0)
    for name, (key, start), end in (
        *(("hertz_penalty", gap, 1.4e-6), ("lagrange_stick", gap, 1.1e-6), ("lugre", gap, 1.05e-6)),
        *(("hertz_penalty", belt, 0.5), ("newton", belt, -1.0), ("prony", gap, 1.2e-6)),
        ("mindlin", ("contact.friction_coefficient", 0.3), 0.2),
    ):
        options = {"parameter": key, "start": start, "end": end}
        ident = f"branch_{key.rpartition('.')[2]}_{name}"
        yield {"id": ident, "study": "branch", "overrides": LAWS[name], "options": options}
    axes = {"rotor_velocity": [-3.0, -1.0, 1.0, 3.0], "drive_phase": [0.0, 0.25, 0.5, 0.75]}
    for name, wide, narrow in (("newton", 3.895e-6, 2.5e-6), ("hertz_penalty", 3.5e-6, 2.5e-6)):
        text = [*LAWS[name], f"contact.clearance={narrow!r}"]
        yield {"id": f"basins_{name}", "study": "basins", "overrides": text, "options": {}, "axes": axes}
        text, options = (
            [*LAWS[name], f"contact.clearance={wide!r}"],
            {"count": 4, "seed": SEED, "longest": LONGEST},
        )
        yield {"id": f"attractors_{name}", "study": "attractors", "overrides": text, "options": options}


def fit_items() -> Iterator[Item]:
    """Measured impacts, impacts and series that were made, by both methods."""
    shared = {"options": {"points": 50, "starts": 4, "seed": SEED}}
    yield {"id": "ellipses", "data": ELLIPSES, "overrides": ["law=newton,poisson"]} | shared
    tails = {"data": ELLIPSES, "degrees_of_freedom": 5.0}
    yield {"id": "ellipses_tails", "overrides": ["law=brach"]} | shared | tails
    made: Item = {"overrides": ["law=newton"], "impacts": 60, "noise": 0.01, "seed": SEED}
    yield {"id": "made_rigid", "made": made, "overrides": ["law=poisson"], "discrepancy": "both"} | shared
    text = ["law=composed", "law/damping=hunt_crossley", "law.damping.restitution=0.8"]
    made = {"overrides": text, "impacts": 25, "noise": 0.01, "seed": SEED}
    free = [*text[:2], "law.damping.restitution=0.4..1", "contact.friction_coefficient=0.1..0.5"]
    yield {"id": "made_impacts", "made": made, "overrides": free} | shared
    text = ["law=hertz_penalty", "law.stiffness=1e10", "contact.friction_coefficient=0.3"]
    made = {
        "overrides": [*text, "solver.duration=1.5e-3", "record.interval=1e-5"],
        "series": ["rotor_velocity", "tip_normal_displacement"],
        "noise": 0.01,
        "seed": SEED,
    }
    free = ["law.stiffness=1e9..1e11", "contact.friction_coefficient=0.1..0.5"]
    yield {"id": "made_series", "made": made, "overrides": free} | shared


def validate_items() -> Iterator[Item]:
    """The measured impacts under all laws, and the spheres."""
    yield {"id": "spheres", "data": SPHERES}
    yield {"id": "ellipses_0", "data": ELLIPSES, "options": {"folds": 5, "seed": 0}}
    yield {"id": "ellipses_1", "data": ELLIPSES, "options": {"folds": 3, "seed": SEED}}


def compare_items() -> Iterator[Item]:
    """Rigid and compliant laws, settled and as recorded."""
    laws, short = [LAWS["newton"], LAWS["hertz_penalty"]], ["solver.duration=2e-3"]
    options = {"samples": 8, "starts": 2}
    yield {"id": "settled", "overrides": short, "laws": laws, "options": options}
    more = {"laws": [LAWS["lagrange_slip"], LAWS["mindlin"], LAWS["archard"]], "recorded": True}
    yield {"id": "recorded", "overrides": short, "options": {}} | more
    more = {"laws": [LAWS["hunt_crossley"], LAWS["lugre"]], "options": {"samples": 0, "starts": 2}}
    yield {"id": "parts", "overrides": [*short, "drive.phase=0.5"]} | more


def characterise_items() -> Iterator[Item]:
    """Data sheets of the default motor under every law, and of drawn motors."""
    rng = np.random.default_rng([SEED, 1])
    for name, text in LAWS.items():
        yield {"id": name.replace(" ", "_"), "overrides": text}
    for number, name in enumerate(("hertz_penalty", "newton", "mindlin", "prony", "poisson", "lugre") * 2):
        yield {"id": f"drawn_{number:02}_{name}", "overrides": [*LAWS[name], *mild_motor(rng)]}


DRAWN: dict[str, Callable[[], Iterator[Item] | list[Item]]] = {
    "impacts": impact_items,
    "runs": run_items,
    "sweep": sweep_items,
    "steady": steady_items,
    "branches": branch_items,
    "fit": fit_items,
    "validate": validate_items,
    "compare": compare_items,
    "characterise": characterise_items,
}
