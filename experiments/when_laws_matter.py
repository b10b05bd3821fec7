"""When does the contact law matter, over drawn motors, against what is not known of each?

Every motor is drawn: friction, damping, clearance, phase, detuning, voltage, stiffness of the contact, angle
of the contact, inertia of the rotor. Its laws have one coefficient of restitution at one speed. Around it lie
`NEIGHBOURS` motors as near as a workshop knows it, the same for every law. Of a quantity Q under laws a and b

    D = max_ab |mean(Q_a) - mean(Q_b)| / sqrt(mean_a var(Q_a)),

mean and variance over the neighbours: the law matters where D > 1, more than what is not known of the motor.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from math import pi
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main, part_of
from matplotlib.figure import Figure
from scipy.stats import fisher_exact, qmc
from variations import tip_phasors

import contactlab as cl
from contactlab.config.nesting import flat, nested
from contactlab.inference.calibration import Datum, calibrated
from contactlab.inference.multiple import holm
from contactlab.inference.paired import binomial_interval
from contactlab.steady_state import BrokenOffError, NotSettledError
from contactlab.studies.compare.laws import delassus_at_rest
from contactlab.studies.study import Part, Setups, Task

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

NEIGHBOURS, CHUNK = 4, 2
"""Motors around each, a power of two; motors of one task."""

QUANTITIES: Final = {"rotor_velocity": "rad s-1", "stall_torque": "N m"}

GROUPS: Final = (
    "friction coefficient",
    "damping ratio",
    "clearance over amplitude",
    "phase",
    "detuning",
    "contact time over period",
    "normal over tangential amplitude",
    "coupling",
    "inertia over tip's",
)
"""Dimensionless: time of an impact at 0.1 m/s over the period of the first tone, amplitudes of the free tip,
D_nt / sqrt(D_nn D_tt), and J D_tt' / R^2 with the tip's own mobility D_tt' along the rotor."""

SEED, LEVEL = 0, 0.05


def drawn(count: int) -> list[dict[str, float]]:
    """Return motors by the names of `RANGES`."""
    uniform = qmc.Sobol(len(RANGES), seed=SEED).random(count)
    columns = []
    for at, (low, high, logarithmic) in zip(uniform.T, RANGES.values(), strict=True):
        columns.append(low * (high / low) ** at if logarithmic else low + (high - low) * at)
    return [dict(zip(RANGES, row, strict=True)) for row in np.transpose(columns).tolist()]


def around(motor: Mapping[str, float]) -> list[dict[str, float]]:
    """Return the neighbours of a motor."""
    shares = 2.0 * qmc.Sobol(len(KNOWN), seed=SEED).random(NEIGHBOURS) - 1.0
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
    number = calibrated(made.law, datum, np.diag(np.diag(delassus_at_rest(made.motor))))
    assert number is not None
    return cl.build(nested(settings | {f"law.{number[0].name}": number[1]}))


def groups_of(motor: Mapping[str, float], setup: cl.Setup) -> list[float]:
    """Return the dimensionless groups of a motor, of its compliant law, in the order of `GROUPS`."""
    made, d = setup.motor, delassus_at_rest(setup.motor)
    normal, lean = tip_phasors(made.modes, made.drive)
    along = made.geometry.tip_length * float(np.abs(lean).sum())
    time = Datum("contact_time", 1.0, RESTITUTION.speed).measured(setup.law, np.diag(np.diag(d)))
    tangential = made.rows_at_rest[1]
    own = float(tangential @ tangential)
    derived = {
        "contact time over period": time * float(made.drive.frequency[0]),
        "normal over tangential amplitude": float(np.abs(normal).sum()) / along,
        "coupling": abs(d[0, 1]) / np.sqrt(d[0, 0] * d[1, 1]),
        "inertia over tip's": made.rotor.inertia * own / made.geometry.rotor_radius**2,
    }
    return [float({**motor, **derived}[name]) for name in GROUPS]


def observed(setup: cl.Setup) -> list[float]:
    """Return the quantities of a settled motor; NaN where it does not settle."""
    try:
        return [cl.steady(setup).details.velocity[0], cl.steady(setup, belt=0.0).details.torque[0]]
    except (BrokenOffError, NotSettledError):
        return [np.nan] * len(QUANTITIES)


def settled(motors: Sequence[Mapping[str, float]], resonator: str) -> Part:
    """Return quantities of motors, neighbours and laws, and the motors' groups."""
    values, groups = [], []
    for motor in motors:
        neighbours = around(motor)
        values.append([[observed(setup_of(law, each, resonator)) for each in neighbours] for law in LAWS])
        groups.append(
            groups_of(motor, setup_of("flores", {**motor, "restitution": RESTITUTION.value}, resonator))
        )
    return part_of(
        xarray.Dataset(
            {
                "value": (("motor", "law", "neighbour", "quantity"), values),
                "group_value": (("motor", "group"), groups),
            }
        )
    )


class WhenLawsMatter(Experiment):
    """Over which motors does the law change more than what is not known of the motor?"""

    says = (
        "The law matters more than what is not known of the motor in some motors and not in others, and a "
        "dimensionless group separates them apart."
    )

    def tasks(self, setups: Setups) -> Iterator[Task]:
        """Yield tasks of `CHUNK` motors each; the short form has few motors, on four shapes."""
        del setups
        count, resonator = (2, "ritz") if self.short else (64, "finite_element")
        motors, chunk = drawn(count), 1 if self.short else CHUNK
        for first in range(0, count, chunk):
            yield Task(f"{first:04d}", settled, (motors[first : first + chunk], resonator))

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return D by motor and quantity; NaN where half of a law's neighbours or more do not settle."""
        del setup
        data = xarray.concat(parts, "motor").assign_coords(
            law=[*LAWS], quantity=[*QUANTITIES], group=[*GROUPS]
        )
        value = data["value"].values
        known = np.isfinite(value).mean(axis=2) > 0.5
        with np.errstate(all="ignore"):
            mean, spread = (
                np.where(known, function(np.ma.masked_invalid(value), axis=2).filled(np.nan), np.nan)
                for function in (np.ma.mean, np.ma.var)
            )
        pairs = [np.abs(mean[:, a] - mean[:, b]) for a, b in combinations(range(len(LAWS)), 2)]
        ratio = np.max(pairs, axis=0) / np.sqrt(spread.mean(axis=1))
        none = (~known).any(axis=1)
        about = {"units": "1", "long_name": "difference of laws over what is not known of the motor"}
        return data.assign(
            ratio=(("motor", "quantity"), ratio, about), unsettled=(("motor", "quantity"), none)
        )

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Return the shares of motors with D > 1 in the lower and the upper third of each group."""
        return [
            {"quantity": name, "group": group, "lower third": low, "upper third": high, "p (Holm)": p}
            for name, group, low, high, p in self.thirds(data)
        ]

    def thirds(self, data: xarray.Dataset) -> list[tuple[str, str, str, str, float]]:
        """Return those shares with Fisher's exact p-value, corrected over groups and quantities."""
        rows: list[tuple[str, str, str, str]] = []
        p_values = []
        for name in QUANTITIES:
            ratio = data["ratio"].sel(quantity=name).values
            known = np.isfinite(ratio)
            for group in GROUPS:
                at = data["group_value"].sel(group=group).values[known]
                order = np.argsort(at, kind="stable")
                size = max(known.sum() // 3, 1)
                above = (ratio[known] > 1.0)[order]
                counts = [int(above[:size].sum()), int(above[-size:].sum())]
                p_values.append(float(fisher_exact([[c, size - c] for c in counts]).pvalue))
                ends = at[order][[size - 1, -size]]
                texts = [f"{c} of {size}" for c in counts]
                rows.append(
                    (name, group, f"{texts[0]} (to {ends[0]:.3g})", f"{texts[1]} (from {ends[1]:.3g})")
                )
        corrected = holm(np.array(p_values))
        return [(*row, float(p)) for row, p in zip(rows, corrected, strict=True)]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Draw D over the groups that tell most, a column a quantity."""
        rows = self.thirds(data)
        figure, axes = plt.subplots(
            2, len(QUANTITIES), figsize=(9.0, 6.4), layout="constrained", sharey="col"
        )
        for column, name in zip(axes.T, QUANTITIES, strict=True):
            most = sorted((row for row in rows if row[0] == name), key=lambda row: row[4])[: len(column)]
            ratio = data["ratio"].sel(quantity=name).values
            for panel, row in zip(column, most, strict=True):
                at = data["group_value"].sel(group=row[1]).values
                panel.scatter(at, ratio, s=14, c=np.where(ratio > 1.0, "#c44e52", "#4c72b0"))
                panel.axhline(1.0, color="0.4", linewidth=0.8)
                panel.set_yscale("log")
                if at.min() > 0.0 and at.max() > 20.0 * at.min():
                    panel.set_xscale("log")
                panel.set_xlabel(f"{row[1]} (p = {row[4]:.2g})")
            column[0].set_title(name.replace("_", " "), fontsize=10)
            for panel in column:
                panel.set_ylabel("D")
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """State the share of motors with D > 1, and the groups that tell."""
        sentences, separates = [], False
        rows = self.thirds(data)
        for name in QUANTITIES:
            ratio = data["ratio"].sel(quantity=name).values
            known = int(np.isfinite(ratio).sum())
            count = int((ratio > 1.0).sum())
            low, high = map(float, binomial_interval(count, known))
            groups = [row for row in rows if row[0] == name and row[4] < LEVEL]
            separates = separates or bool(groups)
            separating = (
                "; ".join(f"{group}: {lower}, {upper}" for _, group, lower, upper, _ in groups)
                or "no group separates"
            )
            sentences.append(
                f"{name.replace('_', ' ')}: D > 1 in {count} of {known} motors ({low:.0%} to {high:.0%}), "
                f"{ratio.size - known} more have a law without a steady state; {separating}."
            )
        return " ".join(sentences), separates


if __name__ == "__main__":
    main(__file__)
