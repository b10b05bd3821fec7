"""When does the contact law matter, over drawn motors, against what is not known of each?

This is the plan, written before the first motor ran: motors and inputs are those of `motor_population`.

**Contrasts** (`CONTRASTS`) change one thing between two laws of the same motor. Every law with a restitution
has the motor's own in a straight impact at the motor's own speed: the median approach of its contacts under
`poisson`, weighted by their impulses. **Null contrasts** change nothing that is physics: another start, a
friction coefficient larger by a millionth, a tolerance a hundred times the default's.

**Size.** c = ln |Q_a / Q_b| of a quantity Q; infinite where Q has another sign under b, or is zero to its
error under one of both. Motors without a steady state under a law within `LONGEST` periods of the drive are
an outcome, counted by law.

**Share.** Of the variance of ln |Q| over laws and motors, the share of law, of motor, and of law x motor,
which is what no common factor of a law explains, with intervals by bootstrap over motors.

**Against knowledge.** |c| over the half-width of the 95 % prediction of ln |Q|, with secants s of ln |Q|
over the inputs of `KNOWN` under `poisson`: h = 1.96 sqrt(s' S s), with S as of a catalogue and of a bench,
and after the speed has been measured to `MEASURED` at two other voltages, which a linear Gaussian model takes
in.

A motor that never leaves its rotor has no contrast with `johnson`, whose restitution comes to one as the
speed falls: a pressed rotor bounces under it without end.

**Map.** ln |c| of speed and of torque by an additive spline of the groups (`contrast_map`), fitted on the
first `FITTED` motors and judged on the others, at which nobody has looked before: R^2 and coverage of its
90 % intervals. A contrast is predicted where the lower end of its R^2 lies above `BAR`.

**Stop.** At `LOOK` motors, if no contrast of laws has a share of law x motor above the largest of the null
contrasts' upper ends, in speed and in torque, that is the result.

**What will be said** is one of `SENTENCES`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import Annotated, Any, Final

import contrast_figures
import matplotlib.pyplot as plt
import numpy as np
import xarray
from contrast_map import BAR, Judged, mapped
from experiment import Experiment, main, part_of
from matplotlib.figure import Figure
from motor_population import ABSOLUTE, GROUPS, KNOWN, LAWS, begun, drawn, groups_of, law_of, motor_of

import contactlab as cl
from contactlab.arrays import Array
from contactlab.estimate import Estimate
from contactlab.steady_state import BrokenOffError, NotSettledError, Steady, steady
from contactlab.steady_state.means import LONGEST, motion_of
from contactlab.steady_state.search import steady_setup
from contactlab.studies.study import Part, Setups, Task, option
from contactlab_data.inference.known_orbits import KnownOrbits

MOTORS, FITTED, LOOK = 256, 192, 64
"""Motors in all, those on which the map is fitted, and those at the look."""

SLOWEST: Final = 1e-3
"""Least speed of a motor's own impacts [m/s]: one that never leaves its rotor has none."""

NEAR: Final = 1e-6
"""Relative change of the friction coefficient of a null contrast."""

COARSE: Final = 1e-5
"""Tolerance of a null contrast, a hundred times the default."""

MEASURED: Final = 0.02
"""Standard deviation of ln |speed| as measured."""

POINTS: Final = (1.0, 0.75, 1.3)
"""Operating points, as factors of the voltages; the last two are those at which the motor is measured."""

NULLS: Final = ("another start", "friction", "tolerance")
STATES: Final = (*LAWS, *(f"{law}, {null}" for law in ("poisson", "flores") for null in NULLS))

CONTRASTS: Final = {
    "rigid or compliant": ("poisson", "flores"),
    "restitution of velocity or of impulse": ("newton", "poisson"),
    "restitution of impulse or of energy": ("poisson", "stronge"),
    "rigid or elastic stick": ("flores", "flores, mindlin"),
    "restitution constant or by speed": ("newton", "johnson"),
    "always slip or stick": ("lagrange_slip", "lagrange_stick"),
    "damping of the contact": ("flores", "tsuji"),
    **{f"null: {law}, {null}": (law, f"{law}, {null}") for law in ("poisson", "flores") for null in NULLS},
}

QUANTITIES: Final = ("rotor_velocity", "stall_torque", "normal_impulse")

SENTENCES: Final = (
    "In {motors} motors that were not looked at, the groups predict where the law decides: {contrasts}.",
    "No map: in {motors} motors that were not looked at, the groups explain at most {r2:.2f} of how much any "
    "of these differences matters.",
)
"""The first is said of the contrasts that are predicted, the second where none is, with the largest upper end
of their R^2."""

LEAST: Final = 16
"""Motors not seen of a run that was ended early, from which on the map is judged."""

TURNED: Final = "turned"
"""What stands for a contrast without a size, as no number is infinite in JSON."""

DIGITS: Final = 4
"""Digits of the recorded numbers of each motor."""

OUTCOMES: Final = ("steady", "not settled", "broken off", "no such law")
BRIEF: Final = (3, 13)
"""Motors of the short form."""

RESAMPLES, LEVEL, SEED = 2000, 0.95, 0


def law_at(name: str, motor: Mapping[str, Any], made: cl.Motor, speed: float) -> cl.ContactLaw:
    """Return a law of `law_of`.

    Raises:
        ValueError: the motor cannot have it.
    """
    if name == "johnson" and speed == SLOWEST:
        raise ValueError("A motor that never leaves its rotor bounces under johnson without end.")
    return law_of(name, motor, made, speed)


def settle(
    made: cl.Motor, law: cl.ContactLaw, velocity: float = 0.0, tolerance: float | None = None
) -> tuple[int, Steady | None]:
    """Return the outcome, an index of `OUTCOMES`, and the steady state."""
    try:
        return 0, steady(begun(made, law, velocity), law, tolerance=tolerance, longest=LONGEST)
    except NotSettledError:
        return 1, None
    except BrokenOffError:
        return 2, None


def numbers_of(state: Steady | None) -> list[Estimate]:
    """Return the quantities of a steady state, NaN where there is none."""
    none = Estimate(np.nan, np.nan)
    if state is None:
        return [none] * len(QUANTITIES)
    force = state.average("normal_force")
    try:
        torque = steady(state.setup, belt=0.0, start=state, longest=LONGEST).torque
    except (BrokenOffError, NotSettledError):
        torque = none
    return [state.velocity, torque, Estimate(state.period * force.value, state.period * force.error)]


def own_speed(state: Steady | None) -> float:
    """Return the median approach of the contacts, weighted by impulse, at least `SLOWEST` [m/s]."""
    if state is None:
        return SLOWEST
    contacts = motion_of(state).contacts
    speed, impulse = -contacts["approach_velocity"], contacts["normal_impulse"]
    order = np.argsort(speed)
    share = np.cumsum(impulse[order])
    middle = int(np.searchsorted(share, 0.5 * share[-1])) if share.size else 0
    return max(float(speed[order][middle]) if share.size else 0.0, SLOWEST)


def moved(motor: Mapping[str, Any], name: str, by: float) -> dict[str, Any]:
    """Return a motor with an input moved by some of its standard deviations on a bench."""
    step = by * KNOWN[name].bench
    return {**motor, name: motor[name] + step if name in ABSOLUTE else motor[name] * float(np.exp(step))}


def secants(motor: Mapping[str, Any], speed: float) -> Array:
    """Return d ln |speed| over a deviation of each input on a bench, shape (input, point)."""
    ends = [[log_speeds("poisson", moved(motor, x, by), speed, POINTS) for by in (1.0, -1.0)] for x in KNOWN]
    return np.array([0.5 * (above - below) for above, below in ends])


def log_speeds(
    name: str,
    motor: Mapping[str, Any],
    speed: float,
    points: Sequence[float],
    known: KnownOrbits | None = None,
    values: Array | None = None,
) -> Array:
    """Return ln |speed| of a motor under a law at operating points, NaN where it never settles.

    Where it stands that is minus infinity.

    Args:
        name: of the law.
        motor: its numbers.
        speed: of its own impacts [m/s].
        points: factors of the voltages.
        known: orbits that are followed; None for motors from rest.
        values: by which the nearest known orbit is found.

    Raises:
        ValueError: the motor cannot have the law.
    """
    # No law depends on the voltages.
    law, speeds = law_at(name, motor, motor_of(motor), speed), []
    for number, scale in enumerate(points):
        setup = steady_setup(begun(motor_of(motor, scale), law), law)
        try:
            if known is None or values is None:
                state = steady(setup, longest=LONGEST)
            else:
                state = known.steady(number, values, setup, longest=LONGEST)
            speeds.append(abs(state.velocity.value))
        except (BrokenOffError, NotSettledError):
            speeds.append(np.nan)
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(speeds))


def begin(number: int) -> tuple[dict[str, Any], cl.Motor, float]:
    """Return a motor as drawn and as made, and the speed of its own impacts [m/s]."""
    motor = drawn(number)
    made = motor_of(motor)
    return motor, made, own_speed(settle(made, law_of("poisson", motor, made, SLOWEST))[1])


def computed(number: int) -> Part:
    """Return the states of a motor, what is not known of it, and its groups."""
    motor, made, speed = begin(number)
    rows, outcomes, states, laws = [], [], dict[str, Steady | None](), dict[str, cl.ContactLaw]()
    for name in LAWS:
        try:
            laws[name] = law_at(name, motor, made, speed)
            outcome, states[name] = settle(made, laws[name])
        except ValueError:
            outcome, states[name] = 3, None
        outcomes.append(outcome)
        rows.append(numbers_of(states[name]))
    for name in ("poisson", "flores"):
        law, state = laws[name], states[name]
        near = law_of(
            name,
            moved(motor, "friction coefficient", NEAR / KNOWN["friction coefficient"].bench),
            made,
            speed,
        )
        there = state.velocity.value if state else 0.0
        for outcome, other in (
            settle(made, law, -0.5 * there),
            settle(made, near),
            settle(made, law, tolerance=COARSE),
        ):
            outcomes.append(outcome)
            rows.append(numbers_of(other))
    values = np.array([[(x.value, x.error) for x in row] for row in rows])
    data = {
        "value": (("state", "quantity"), values[..., 0]),
        "error": (("state", "quantity"), values[..., 1]),
        "outcome": ("state", outcomes),
        "group_value": ("group", groups_of(motor, made, laws["flores"], speed)),
        "secant": (("input", "point"), secants(motor, speed)),
    }
    return part_of(xarray.Dataset(data))


def contrast(value: Array, error: Array) -> Array:
    """Return c of two states, values and their errors of shape (2, ...): NaN where one is missing."""
    determined = np.abs(value) > 2.0 * error
    with np.errstate(all="ignore"):
        size = np.log(np.abs(value[0] / value[1]))
    opposed = (value[0] * value[1] < 0.0) | (determined[0] != determined[1])
    size = np.where(opposed, inf, size)
    # Two that are zero to their errors do not differ.
    size = np.where(determined.any(axis=0), size, 0.0)
    return np.asarray(np.where(np.isfinite(value).all(axis=0), size, np.nan))


def shares(logarithm: Array) -> Array:
    """Return the shares of law, motor and law x motor in the variance of ln |Q|, shape (motor, law)."""
    whole = logarithm.mean()
    law, motor = logarithm.mean(axis=0) - whole, logarithm.mean(axis=1) - whole
    rest = logarithm - whole - law - motor[:, None]
    parts = np.array([(law**2).mean(), (motor**2).mean(), (rest**2).mean()])
    return np.asarray(parts / parts.sum())


def interval(statistic: Any, rows: Array) -> tuple[Array, Array, Array]:
    """Return a statistic of rows, and the ends of its interval by bootstrap over them."""
    rng = np.random.default_rng(SEED)
    drawn = [statistic(rows[rng.integers(len(rows), size=len(rows))]) for _ in range(RESAMPLES)]
    low, high = np.quantile(drawn, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL], axis=0)
    return statistic(rows), low, high


def half_widths(secant: Array) -> Array:
    """Return the half-width of ln |speed| as of a catalogue, a bench, and measured, shape (motor, level).

    Args:
        secant: shape (motor, input, point), over deviations on a bench.
    """
    ratio = np.array([known.catalogue / known.bench for known in KNOWN.values()])
    result = []
    for s in secant:
        catalogue = ratio[:, None] * s
        covariance = s.T @ s
        seen = covariance[1:, 1:] + MEASURED**2 * np.eye(len(POINTS) - 1)
        after = covariance[0, 0] - covariance[0, 1:] @ np.linalg.solve(seen, covariance[1:, 0])
        result.append([catalogue[:, 0] @ catalogue[:, 0], covariance[0, 0], max(after, 0.0)])
    return np.asarray(1.96 * np.sqrt(result))


def maps(data: xarray.Dataset) -> dict[tuple[str, str], Judged]:
    """Return how well the groups predict each contrast of laws, by quantity and contrast.

    There is no map where less than `LEAST` motors have not been seen.
    """
    if data.sizes["motor"] < FITTED + LEAST:
        return {}
    groups = data["group_value"].transpose("motor", "group").values
    return {
        (quantity, name): mapped(
            groups, np.abs(data["contrast_size"].sel(contrast=name, quantity=quantity).values), FITTED
        )
        for quantity in QUANTITIES[:2]
        for name in CONTRASTS
        if "null" not in name
    }


def map_sentence(judged: Mapping[tuple[str, str], Judged]) -> str:
    """Return the sentence of `SENTENCES` that the maps bear out."""
    predicted = [
        f"{name} ({quantity.replace('_', ' ')}, R^2 {own.r2:.2f}, {own.low:.2f} to {own.high:.2f})"
        for (quantity, name), own in judged.items()
        if own.low > BAR
    ]
    motors = max(own.motors for own in judged.values())
    if predicted:
        return SENTENCES[0].format(motors=motors, contrasts=", ".join(predicted))
    return SENTENCES[1].format(motors=motors, r2=max(own.high for own in judged.values()))


def recorded(value: float) -> float | str | None:
    """Return a number with `DIGITS` digits, `TURNED` where it is infinite, None where it is missing."""
    return float(f"{value:.{DIGITS}g}") if isfinite(value) else TURNED if value == inf else None


@dataclass(frozen=True, kw_only=True)
class LawContrasts(Experiment):
    """In which motors does which difference of laws change what the motor does?"""

    says = "One difference of laws at least has a share of law x motor above all null contrasts."

    motors: Annotated[int, option("motors, the first ones of the population", at_least=2)] = MOTORS

    def tasks(self, setups: Setups) -> Iterator[Task]:
        """Yield a task a motor."""
        del setups
        for number in BRIEF if self.short else range(self.motors):
            yield Task(f"{number:04d}", computed, (number,))

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return everything by motor, with contrasts and half-widths."""
        del setup
        data = xarray.concat(parts, "motor").assign_coords(
            state=[*STATES], quantity=[*QUANTITIES], group=[*GROUPS], input=[*KNOWN], point=[*POINTS]
        )
        pairs = [[STATES.index(name) for name in pair] for pair in CONTRASTS.values()]
        value, error = (data[x].transpose("state", "motor", "quantity").values for x in ("value", "error"))
        sizes = [contrast(value[pair], error[pair]) for pair in pairs]
        return data.assign(
            contrast_size=(("contrast", "motor", "quantity"), np.array(sizes)),
            half_width=(("motor", "level"), half_widths(data["secant"].values)),
        ).assign_coords(contrast=[*CONTRASTS], level=["catalogue", "bench", "measured"])

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Return the contrasts: sizes, turned motors, shares, and motors beyond each level of knowledge."""
        rows: list[dict[str, object]] = []
        for quantity in QUANTITIES:
            for name, pair in CONTRASTS.items():
                size = np.abs(data["contrast_size"].sel(contrast=name, quantity=quantity).values)
                known = ~np.isnan(size)
                row: dict[str, object] = {"quantity": quantity, "contrast": name, "motors": int(known.sum())}
                row["turned"] = int(np.isinf(size).sum())
                row["median"] = float(np.median(size[known])) if known.any() else np.nan
                both = data["value"].sel(state=[*pair], quantity=quantity).values
                whole = both[np.isfinite(size) & (both != 0.0).all(axis=-1)]
                if len(whole) > 2:
                    share, low, high = interval(shares, np.log(np.abs(whole)))
                    row |= {"share": float(share[2]), "low": float(low[2]), "high": float(high[2])}
                if quantity == "rotor_velocity":
                    for level in data["level"].values:
                        width = data["half_width"].sel(level=level).values
                        some = known & np.isfinite(width)
                        row[f"beyond {level}"] = float((size > width)[some].mean()) if some.any() else np.nan
                rows.append(row)
        return rows

    def numbers(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return what pages and figures have: outcomes, and by motor contrasts and half-widths."""
        own = data.to_dataset()
        sizes = np.abs(own["contrast_size"])
        width = own["half_width"].transpose("level", "motor")
        judged = maps(own)
        outcome = own["outcome"].sel(state=[*LAWS]).transpose("state", "motor").values
        return {
            "motors": own.sizes["motor"],
            "outcomes": {
                law: {name: int((row == n).sum()) for n, name in enumerate(OUTCOMES)}
                for law, row in zip(LAWS, outcome, strict=True)
            },
            "size": {
                quantity: {
                    name: [*map(recorded, sizes.sel(quantity=quantity, contrast=name).values.tolist())]
                    for name in CONTRASTS
                }
                for quantity in QUANTITIES[:2]
            },
            "half-width": {
                str(level): [*map(recorded, row.values.tolist())]
                for level, row in zip(own["level"].values, width, strict=True)
            },
            "map": {
                quantity: {name: each._asdict() for (of, name), each in judged.items() if of == quantity}
                for quantity in QUANTITIES[:2]
            },
        }

    def draw(self, data: xarray.Dataset) -> Figure:
        """Draw the sizes of the contrasts in speed."""
        return contrast_figures.sizes(self.numbers(xarray.DataTree(data)))

    def figures(self, data: xarray.DataTree) -> dict[str, Figure]:
        """Return the sizes, and the figures of what is known and of the map."""
        figures = {
            f"{self.name}{suffix}": draw(self.numbers(data))
            for suffix, draw in contrast_figures.FIGURES.items()
        }
        for figure in figures.values():
            plt.close(figure)
        return figures

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """State the contrasts whose share of law x motor lies above all null contrasts'."""
        rows = [row for row in self.rows(data) if "share" in row and row["quantity"] != "normal_impulse"]
        if not rows:
            return "Too few motors for a share.", False
        chance = max((float(row["high"]) for row in rows if "null" in str(row["contrast"])), default=inf)  # type: ignore[arg-type]
        above = [row for row in rows if "null" not in str(row["contrast"]) and float(row["low"]) > chance]  # type: ignore[arg-type]
        names = [
            f"{row['contrast']} ({str(row['quantity']).replace('_', ' ')}, {row['share']:.2g})"
            for row in above
        ]
        motors = data.sizes["motor"]
        text = f"In {motors} motors, above the null contrasts' {chance:.2g}: {', '.join(names) or 'none'}."
        judged = maps(data)
        return f"{text} {map_sentence(judged)}" if judged else text, bool(above)


if __name__ == "__main__":
    main(__file__)
