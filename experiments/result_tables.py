"""Tables of the pages that state results of motors, experiments and measurements."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any, Final

import motor_findings
import recorded_contrasts
import recorded_practice
from contrast_map import Judged
from friction_loop import FRAME
from law_contrasts import map_sentence
from recorded_numbers import (
    CARRIERS,
    CASES,
    CHANGED,
    DAMPING,
    FOUR,
    LOWER,
    NAMES,
    OF_THE_PAPER,
    OTHERS,
    PAPER,
    PHASE,
    PICTURED,
    PRINTED_RATIOS,
    SPRING,
    carried,
    ellipses,
    frequency_ratio,
    is_function,
    misfit,
    pair,
    predicted,
    published,
    results,
    rows_of,
    value,
    velocity,
)
from velocity_steps import STIFFNESS


def markdown(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Return a table in Markdown."""
    lines = [[*head], *([*map(str, row)] for row in rows)]
    head, *body = [f"| {' | '.join(line)} |".replace("|  |", "| |") for line in lines]
    return "\n".join([head, "|---" * len(lines[0]) + "|", *body])


def front_page() -> str:
    """Return what the example of README prints."""
    bases = {"ritz": "four shapes", "finite_element": "converged"}
    lines = [
        f"{basis:15} {law:15} {settled:8.4f} +- {settled.error:.2g} rad/s"
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


def frame(stiffness: float, most: float, unit: float, digits: str) -> str:
    """Return a frame's stiffness; one near the stiffest that is tried yields by nothing."""
    return "rigid" if stiffness > 0.9 * most else f"{unit * stiffness:{digits}}"


def friction_loop() -> str:
    """Return what each law misses of a tribometer's loop, and its numbers."""

    def row(law: Mapping[str, Any]) -> Iterator[str]:
        yield law["law"].replace("_", "\\_")
        yield str(law["free numbers"])
        yield f"{law['friction coefficient']:.3f}"
        yield "" if law["frame [N/m]"] is None else frame(law["frame [N/m]"], FRAME[-1], 1e-3, ".0f")
        yield from (f"{100 * law[name]:.1f}" for name in ("fitted", "held out"))
        yield f"{law['low']:.3f} to {law['high']:.3f}"

    head = (
        "law",
        "free numbers",
        "friction coefficient",
        "frame (N/mm)",
        "fitted (%)",
        "not seen (%)",
        "ratio",
    )
    return markdown(head, map(row, results("measurements")["friction_loop"]["rows"]))


def joint_friction() -> str:
    """Return what each law misses of a joint's friction at speeds that it has not seen."""
    rows = (
        (
            law["law"].replace("_", "\\_"),
            law["free numbers"],
            f"{law['held out [N m]']:.3f}",
            f"{law['low']:.2f} to {law['high']:.2f}",
        )
        for law in results("measurements")["joint_friction"]["rows"]
    )
    return markdown(("law", "free numbers", "not seen (N m)", "ratio"), rows)


def velocity_steps() -> str:
    """Return numbers of laws of rock friction, and what they miss at another normal stress."""

    def row(law: Mapping[str, Any]) -> Iterator[str]:
        yield law["law"].replace("_", "\\_")
        yield law["fitted at"]
        for name in ("direct effect", "evolution effect"):
            yield "" if law[name] is None else f"{law[name]:.4f}"
        length = law["renewal distance [m]"]
        yield "" if length is None else f"{1e6 * length:.0f}"
        yield frame(law["stiffness [Pa/m]"], STIFFNESS[-1], 1e-12, ".2f")
        yield from (f"{1e3 * law[name]:.2f}" for name in ("fitted", "held out"))
        yield f"{law['low']:.2f} to {law['high']:.2f}"

    head = (
        "law",
        "fitted at",
        "a",
        "b",
        "D (um)",
        "frame (MPa/um)",
        "fitted (0.001)",
        "not seen (0.001)",
        "ratio",
    )
    return markdown(head, map(row, results("measurements")["velocity_steps"]["rows"]))


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


def contrasts() -> str:
    """Return sizes and shares of the contrasts, and motors in which each exceeds what is known."""

    def row(name: str) -> Iterator[object]:
        yield from (name.replace("null: ", "*null*: "), recorded_contrasts.turning(name))
        yield f"{recorded_contrasts.middle(name):.2g}"
        own = recorded_contrasts.interaction(name)
        yield f"{own.value:.2g} ({own.low:.2g} to {own.high:.2g})"
        for level in recorded_contrasts.levels():
            each = recorded_contrasts.beyond(name, level)
            yield f"{100 * each.value:.0f} ({100 * each.low:.0f} to {100 * each.high:.0f})"

    head = (
        "contrast",
        "turned",
        "median",
        "law x motor",
        *(f"beyond {level} (%)" for level in recorded_contrasts.levels()),
    )
    return markdown(head, map(row, recorded_contrasts.contrasts()))


def decided() -> str:
    """Return for each difference of laws how well a motor must be known for it to show in most motors."""
    head = ("difference of laws", "shows in most motors that are known", "a designer may conclude")
    rows = ((name, *recorded_contrasts.conclusion(name)) for name in recorded_contrasts.differences())
    return markdown(head, rows)


def practice() -> str:
    """Return how well laws, fitted at two operating points, predict the third, and the times of starts."""

    def row(law: str) -> Iterator[str]:
        own = recorded_practice.near(law)
        yield f"`{law}`"
        for scale, of in ((100.0, recorded_practice.errors_of), (1.0, recorded_practice.starts_of)):
            low, middle, high = (scale * x for x in of(law))
            yield f"{middle:.3g} ({low:.3g} to {high:.3g})"
        yield f"{100 * own.value:.0f} ({100 * own.low:.0f} to {100 * own.high:.0f})"

    margin = 100 * recorded_practice.MARGIN
    head = (
        "law",
        "median error (quartiles) (%)",
        "start over the truth's (quartiles)",
        f"motors within {margin:.0f} % (%)",
    )
    return markdown(head, map(row, recorded_practice.fitting()))


def sentence_of_map() -> str:
    """Return the sentence on the map that was written before, or that it is not judged yet."""
    judged = {
        (quantity, name): Judged(**own)
        for quantity, each in recorded_contrasts.of_run("map").items()
        for name, own in each.items()
    }
    if judged:
        return map_sentence(judged)
    return f"The map is not judged yet: {recorded_contrasts.motors()} motors have run."


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
    "friction loop": friction_loop,
    "joint friction": joint_friction,
    "velocity steps": velocity_steps,
    "published motor": carrying,
    "contrasts": contrasts,
    "what decides": decided,
    "practice": practice,
    "sentence on the map": sentence_of_map,
    "populations": populations,
    "known worlds": known_worlds,
    "known factors": known_factors,
}
