"""When does the contact law matter, over drawn motors, against what is not known of each?

Every motor is drawn: friction, damping, clearance, phase, detuning, voltage, stiffness of the contact, angle
of the contact, inertia of the rotor. Its laws have one coefficient of restitution at one speed. Around it lie
`NEIGHBOURS` motors as near as a workshop knows it, the same for every law. Of a quantity Q under laws a and b

    D = max_ab |mean(Q_a) - mean(Q_b)| / sqrt(mean_a var(Q_a)),

mean and variance over the neighbours: the law matters where D > 1, more than what is not known of the motor.
The standard error of ln D is the jackknife's over the neighbours, and D is above or below 1 where its 95 %
interval is.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite, pi
from typing import Final
from warnings import catch_warnings

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main, part_of
from matplotlib.figure import Figure
from scipy.stats import qmc, spearmanr, t
from variations import tip_phasors

import contactlab as cl
from contactlab.arrays import Array
from contactlab.config.nesting import flat, nested
from contactlab.steady_state import BrokenOffError, NotSettledError
from contactlab.studies.compare.laws import delassus_at_rest
from contactlab.studies.compare.multiple import holm
from contactlab.studies.compare.observables import observed
from contactlab.studies.compare.paired import binomial_interval
from contactlab.studies.study import Part, Setups, Task
from contactlab_data.inference.calibration import Datum, calibrated

RESTITUTION: Final = Datum("restitution", 0.6, 0.1)
"""What every law has; at the speeds of the contacts the others of its numbers act."""

LAWS: Final = {
    "newton": ["law=newton"],
    "poisson": ["law=poisson"],
    "flores": ["law=composed", "law/normal=hertz_point", "law/damping=flores", "law/friction=coulomb"],
    "flores, mindlin": [
        "law=composed",
        "law/normal=hertz_point",
        "law/damping=flores",
        "law/friction=mindlin",
    ],
}

RANGES: Final[dict[str, tuple[float, float, bool]]] = {
    "friction coefficient": (0.1, 0.6, False),
    "damping ratio": (0.005, 0.2, True),
    "clearance over amplitude": (0.0, 0.8, False),
    "phase": (-0.5 * pi, 0.0, False),
    "detuning": (0.95, 1.05, False),
    "voltage": (30.0, 300.0, True),
    "stiffness": (1e9, 1e11, True),
    "angle": (0.0, 0.6, False),
    "inertia": (1e-6, 1e-4, True),
}
"""Least and largest value, and whether their logarithm is drawn evenly: V, N m^-3/2, rad and kg m^2. Half a
period of the second tone later, a motor is its mirror image."""

KNOWN: Final = {
    "friction coefficient": 0.1,
    "damping ratio": 0.2,
    "clearance over amplitude": 0.1,
    "detuning": 0.003,
    "stiffness": 0.3,
    "restitution": 0.1,
}
"""Half the range of a neighbour over the value, as near as a motor on a bench is known."""

MOTORS, NEIGHBOURS = 16, 8
"""Motors, and motors around each; powers of two."""

QUANTITIES: Final = ("rotor_velocity", "stall_torque", "start_time", "normal_impulse")
"""Of `contactlab.studies.compare.observables.OBSERVABLES`."""

GROUPS: Final = (
    "friction coefficient",
    "damping ratio",
    "clearance over amplitude",
    "phase",
    "detuning",
    "contact time over period",
    "approach over tangential speed",
    "coupling",
    "inertia over tip's",
)
"""Dimensionless: time of an impact at 0.1 m/s over the period of the first tone, amplitudes of the free tip's
velocity, D_nt / sqrt(D_nn D_tt), and J D_tt' / R^2 with the tip's own mobility D_tt' along the rotor."""

SEED, LEVEL = 0, 0.05


def drawn(count: int) -> list[dict[str, float]]:
    """Return motors by the names of `RANGES`."""
    uniform = qmc.LatinHypercube(len(RANGES), rng=SEED).random(count)
    columns = []
    for at, (low, high, logarithmic) in zip(uniform.T, RANGES.values(), strict=True):
        columns.append(low * (high / low) ** at if logarithmic else low + (high - low) * at)
    return [dict(zip(RANGES, row, strict=True)) for row in np.transpose(columns).tolist()]


def around(motor: Mapping[str, float]) -> list[dict[str, float]]:
    """Return the neighbours of a motor."""
    shares = 2.0 * qmc.LatinHypercube(len(KNOWN), rng=SEED).random(NEIGHBOURS) - 1.0
    values = {**motor, "restitution": RESTITUTION.value}
    return [
        values
        | {
            name: values[name] * (1.0 + share * x)
            for (name, share), x in zip(KNOWN.items(), row, strict=True)
        }
        for row in shares.tolist()
    ]


def setup_of(law: str, motor: Mapping[str, float], resonator: str) -> cl.Setup:
    """Return the setup of a law in a motor, at its restitution."""
    changes = {
        "contact.friction_coefficient": motor["friction coefficient"],
        "resonator.damping_ratio": motor["damping ratio"],
        "drive.phase": motor["phase"],
        "drive.voltage_1": motor["voltage"],
        "drive.voltage_2": motor["voltage"],
        "contact.angle": motor["angle"],
        "rotor.inertia": motor["inertia"],
    }
    base = cl.build([f"resonator={resonator}", *LAWS[law]])
    settings = flat(base.configuration) | changes
    settings["drive.frequency"] = motor["detuning"] * base.motor.modes.natural_frequency[0]
    made = cl.build(nested(settings))
    rise = float(np.abs(tip_phasors(made.motor.modes, made.motor.drive)[0]).sum())
    settings["contact.clearance"] = motor["clearance over amplitude"] * rise
    if "law.normal.stiffness" in settings:
        settings["law.normal.stiffness"] = motor["stiffness"]
    made = cl.build(nested(settings))
    datum = Datum("restitution", motor["restitution"], RESTITUTION.speed)
    # A bench measures it in a straight impact.
    numbers = calibrated(made.law, datum, np.diag(np.diag(delassus_at_rest(made.motor))))
    assert numbers
    return cl.build(nested(settings | {f"law.{name}": value for name, value in numbers.items()}))


def groups_of(motor: Mapping[str, float], setup: cl.Setup) -> list[float]:
    """Return the dimensionless groups of a motor, of its compliant law, in the order of `GROUPS`."""
    made, d = setup.motor, delassus_at_rest(setup.motor)
    rate = made.drive.angular_frequency
    approach, lean = (float(np.abs(rate * each).sum()) for each in tip_phasors(made.modes, made.drive))
    time = Datum("contact_time", 1.0, RESTITUTION.speed).measured(setup.law, np.diag(np.diag(d)))
    tangential = made.rows_at_rest[1]
    own = float(tangential @ tangential)
    derived = {
        "contact time over period": time * float(made.drive.frequency[0]),
        "approach over tangential speed": approach / (made.geometry.tip_length * lean),
        "coupling": abs(d[0, 1]) / np.sqrt(d[0, 0] * d[1, 1]),
        "inertia over tip's": made.rotor.inertia * own / made.geometry.rotor_radius**2,
    }
    return [float({**motor, **derived}[name]) for name in GROUPS]


def numbers_of(setup: cl.Setup) -> list[float]:
    """Return the quantities of a settled motor; NaN where it does not settle or start."""
    try:
        numbers = observed(setup, QUANTITIES)[1]
    except (BrokenOffError, NotSettledError):
        return [np.nan] * len(QUANTITIES)
    return [value if isfinite(value := numbers[name].value) else np.nan for name in QUANTITIES]


def settled(motor: Mapping[str, float], resonator: str) -> Part:
    """Return quantities of a motor's neighbours under every law, and the motor's groups."""
    values = [[numbers_of(setup_of(law, each, resonator)) for each in around(motor)] for law in LAWS]
    known = setup_of("flores", {**motor, "restitution": RESTITUTION.value}, resonator)
    data = {
        "value": (("law", "neighbour", "quantity"), values),
        "group_value": ("group", groups_of(motor, known)),
    }
    return part_of(xarray.Dataset(data))


def over_spread(value: Array) -> tuple[Array, Array]:
    """Return D and the standard error of ln D, shape (...).

    Both are NaN where a law has half of the neighbours or fewer.

    Args:
        value: of a quantity, shape (..., law, neighbour).
    """

    def ratio(value: Array) -> Array:
        some = np.isfinite(value).mean(axis=-1, keepdims=True) > 0.5
        value = np.where(some, value, np.nan)
        spread = np.nanvar(value, axis=-1, ddof=1).mean(axis=-1)
        return np.asarray(np.ptp(np.nanmean(value, axis=-1), axis=-1) / np.sqrt(spread))

    count = value.shape[-1]
    with np.errstate(all="ignore"), catch_warnings(action="ignore", category=RuntimeWarning):
        others = np.log([ratio(np.delete(value, i, axis=-1)) for i in range(count)])
        return ratio(value), np.sqrt((count - 1) * others.var(axis=0))


class WhenLawsMatter(Experiment):
    """Over which motors does the law change more than what is not known of the motor?"""

    says = (
        "The law matters more than what is not known of the motor in some motors and not in others, and how "
        "much goes with a dimensionless group."
    )

    def tasks(self, setups: Setups) -> Iterator[Task]:
        """Yield a task a motor; the short form has few, on four shapes."""
        del setups
        count, resonator = (2, "ritz") if self.short else (MOTORS, "finite_element")
        for number, motor in enumerate(drawn(count)):
            yield Task(f"{number:04d}", settled, (motor, resonator))

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return D by motor and quantity with the ends of its 95 % interval."""
        del setup
        data = xarray.concat(parts, "motor").assign_coords(
            law=[*LAWS], quantity=[*QUANTITIES], group=[*GROUPS]
        )
        ratio, error = over_spread(data["value"].transpose("motor", "quantity", "law", "neighbour").values)
        wide = np.exp(t.ppf(0.975, NEIGHBOURS - 1) * error)
        ends = {"ratio": ratio, "ratio_low": ratio / wide, "ratio_high": ratio * wide}
        about = {"units": "1", "long_name": "difference of laws over what is not known of the motor"}
        return data.assign({name: (("motor", "quantity"), x, about) for name, x in ends.items()})

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Return the motors with D > 1, in all and in the halves of each group, with the correlation of D."""
        rows: list[dict[str, object]] = []
        for name in QUANTITIES:
            each = data.sel(quantity=name)
            known = np.isfinite(each["ratio_low"].values)
            ratio, low, high = (each[x].values[known] for x in ("ratio", "ratio_low", "ratio_high"))
            counts = {"D > 1": ratio > 1.0, "clearly above": low > 1.0, "clearly below": high < 1.0}
            rows.append(
                {"quantity": name, "group": "all", "motors": ratio.size}
                | {key: int(which.sum()) for key, which in counts.items()}
                | dict(
                    zip(("10 %", "median", "90 %"), np.quantile(ratio, [0.1, 0.5, 0.9]).tolist(), strict=True)
                )
            )
            for group in GROUPS:
                at = each["group_value"].sel(group=group).values[known]
                upper = at > np.median(at)
                halves = {"lower half": ratio[~upper] > 1.0, "upper half": ratio[upper] > 1.0}
                # The short form has too few motors for a correlation.
                r, p = spearmanr(at, ratio) if ratio.size > 2 else (0.0, 1.0)
                rows.append(
                    {"quantity": name, "group": group, "motors": ratio.size}
                    | {key: int(which.sum()) for key, which in halves.items()}
                    | {"rank correlation": float(r), "p": float(p)}
                )
        tested = [row for row in rows if "p" in row]
        for row, p in zip(tested, holm(np.array([row["p"] for row in tested])), strict=True):
            row["p"] = float(p)
        return rows

    def draw(self, data: xarray.Dataset) -> Figure:
        """Draw D over the group that tells most, and the motors over this one and the next."""
        rows = [row for row in self.rows(data) if "p" in row]
        figure, axes = plt.subplots(2, len(QUANTITIES), figsize=(13.0, 6.6), layout="constrained")
        for (above, below), name in zip(axes.T, QUANTITIES, strict=True):
            own = sorted((row for row in rows if row["quantity"] == name), key=lambda row: row["p"])
            x, y = (data["group_value"].sel(group=row["group"]).values for row in own[:2])
            ratio, low, high = (
                data[z].sel(quantity=name).values for z in ("ratio", "ratio_low", "ratio_high")
            )
            colours = np.where(low > 1.0, "#c44e52", np.where(high < 1.0, "#4c72b0", "0.6"))
            above.vlines(x, low, high, colors=colours, linewidth=0.8)
            above.scatter(x, ratio, s=16, c=colours, zorder=2)
            above.axhline(1.0, color="0.3", linewidth=0.8)
            above.set_yscale("log")
            above.set_title(name.replace("_", " "), fontsize=10)
            above.set_ylabel("D, 95 % interval")
            below.scatter(x, y, s=24.0, c=colours)
            below.set_ylabel(own[1]["group"])
            below.set_xlabel(f"{own[0]['group']} (p = {own[0]['p']:.2g})")
            above.set_xscale(scale_of(x))
            below.set_xscale(scale_of(x))
            below.set_yscale(scale_of(y))
            for panel in (above, below):
                panel.minorticks_off()
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """State the share of motors with D > 1, and the groups that separate them."""
        sentences, rows = [], self.rows(data)
        for row in (row for row in rows if row["group"] == "all"):
            low, high = map(float, binomial_interval(row["D > 1"], row["motors"]))
            groups = [
                f"{x['group']} ({x['rank correlation']:+.2f}, p = {x['p']:.1g})"
                for x in rows
                if x["quantity"] == row["quantity"] and x.get("p", 1.0) < LEVEL
            ]
            sentences.append(
                f"{str(row['quantity']).replace('_', ' ')}: D > 1 in {row['D > 1']} of {row['motors']} "
                f"motors ({low:.0%} to {high:.0%}), clearly in {row['clearly above']}, clearly not in "
                f"{row['clearly below']}; D goes with {' and '.join(groups) or 'no group'}."
            )
        return " ".join(sentences), any(row.get("p", 1.0) < LEVEL for row in rows)


def scale_of(values: Array) -> str:
    """Return the scale of an axis, logarithmic where half of the values lie in a quarter of their range."""
    return "log" if 0.0 < 4.0 * float(np.median(values)) < values.max() else "linear"


if __name__ == "__main__":
    main(__file__)
