"""A motor of the literature: how near the laws come to its measured speed over payload and over force.

Four piezoelectric legs stand on glass below a plate and push it by their first three bending modes, at
2065, 4145 and 6283 Hz, which a sawtooth drives at once. Published are dimensions, weight, frequencies, the
vibration of a foot, the friction coefficient (measured, 0.150), and speeds over payload and towing force.

The legs move alike, so that one of them, with a quarter of weight and load, is the motor: three modes move
the foot along the glass. Seen from the body the glass is the rotor, which a bearing without stiffness
presses on the foot by the weight, with the body's mass; along the glass a tenth of that mass is its
inertia, which shortens the transient and not the speed. The tones are those that give the free foot its
measured vibration.

Not published, and drawn: modal mass and damping, the inclination of the foot's path to the glass, contact
stiffness or restitution; the friction coefficient within its scatter. Every law is calibrated with the
speeds over payload; the speeds over towing force are compared with what it then predicts.

Contact with rebounds may be chaotic, and a mean over a fifth of a second no function of its inputs. So
the best draws are repeated with the friction coefficient times 1 -+ 1e-6 and with later starts in the drive's
period. Where the speeds then differ by more than they were read to, the draw has a spread and no misfit.

Source: Liu, Ding, Wu, Wang, Chen, Rong, Song and Li, A self-moving piezoelectric actuator with high
carrying/positioning capability via bending-resonant-vibration-induced stick-slip motion, IEEE Trans. Ind.
Electron. (2024), doi:10.1109/TIE.2024.3429612: sections II and III, figures 2(a), 7(a), 7(b) and 12(c).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import radians, tan

import matplotlib.pyplot as plt
import numpy as np
import xarray
from experiment import Experiment, main, part_of
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.stats import qmc

import contactlab as cl
from contactlab.studies.study import Part, Setups, Task

FREQUENCY, NATURAL = 2065.0, np.array([2065.0, 4145.0, 6283.0])
"""Of the drive and of the bending modes [Hz]."""

BODY, GRAVITY, LEGS, FRICTION = 38.5e-3, 9.81, 4, 0.150
"""Mass without payload [kg], gravity [m/s^2], number of legs, friction coefficient (fig. 12)."""

ARC = 50e-3 / 1.162
"""Radius of the foot's path about the leg [m]: a leg of 50 mm shortens as in a cantilever's first mode."""

VIBRATION = 200.0 / 150.0
"""Voltage of the measured speeds over that of the measured vibration; the speed is linear in it (fig. 5)."""

# Displacement of the foot [um] at 150 V, one period from its minimum on, mean of two (fig. 2(a)).
TRACE = (
    "-2.9 -2.0 0.8 3.1 6.3 10.4 15.1 19.4 24.1 27.7 31.8 34.9 37.1 39.7 42.0 43.4 45.0 46.3 47.3 48.9 50.1 "
    "51.0 52.4 53.0 53.6 53.6 54.0 54.4 54.5 54.4 54.1 53.4 53.2 51.6 47.9 41.6 33.8 26.1 18.8 11.7 6.0 0.4"
)

# Payload [g], towing force [N], speed along x [mm/s], read from figure 7, to some 2 mm/s.
CARRIED = [(0, 0.0, 224.1), (200, 0.0, 212.0), (400, 0.0, 162.5)]
CARRIED += [(600, 0.0, 105.0), (800, 0.0, 64.0), (1000, 0.0, 30.0)]
TOWED = [(200, 0.10, 161.0), (200, 0.20, 93.0), (200, 0.30, 36.5), (200, 0.33, 9.9)]
TOWED += [(800, 0.20, 55.0), (800, 0.59, 38.0), (800, 0.99, 20.0), (800, 1.19, 5.0)]
POINTS = [(1e-3 * payload, force, 1e-3 * speed) for payload, force, speed in CARRIED + TOWED]
"""In SI units; the first ones, without towing force, are those of the calibration."""

UNKNOWN = {
    "friction coefficient": (0.14, 0.16, False),
    "damping ratio": (0.005, 0.03, True),
    "modal mass": (1e-3, 8e-3, True),
    "inclination": (-3.0, 3.0, False),
    "contact stiffness": (1e7, 1e10, True),
    "restitution": (0.1, 0.9, False),
}
"""Least and greatest value in 1, kg, degrees or N/m^1.5, and whether the scale is logarithmic."""

LAWS: dict[str, Callable[..., cl.ContactLaw]] = {
    "lagrange_stick": lambda **x: cl.LagrangeStick(x["friction coefficient"]),
    "newton": lambda **x: cl.Newton(x["friction coefficient"], x["restitution"]),
    "hertz_penalty": lambda **x: cl.HertzPenalty(x["contact stiffness"], x["friction coefficient"]),
    "mindlin": lambda **x: cl.Composed(
        cl.HertzPoint(x["contact stiffness"]),
        cl.Flores(restitution=x["restitution"]),
        cl.Mindlin(friction_coefficient=x["friction coefficient"]),
    ),
}
"""Laws by name; the composed one has Hertz' stiffness, Flores' damping and Mindlin's spring."""

UNUSED = {
    "lagrange_stick": {"contact stiffness", "restitution"},
    "newton": {"contact stiffness"},
    "hertz_penalty": {"restitution"},
}
"""Unknowns that a law lacks."""

DURATION, LATE = 0.3, 0.1
"""Of a run, and from when on its speed is averaged [s]."""

FLAT, LIGHT = 1e3, 0.1
"""Radius of the rotor that is the glass [m], and its inertia along its motion over the body's."""

HEAVIER = 4.0
"""Inertia over that, and duration, with which the best draw is repeated."""

DRAWS, ROUNDS = 16, 3
"""Draws of a round; each round but the first is drawn from half the range around the best draw so far."""

CANDIDATES = 3
"""Best draws of the calibration, which are repeated, and run over towing force."""

REPEATS: dict[str, tuple[float, float]] = {
    "as it is": (1.0, 0.0),
    "mu (1 - 1e-6)": (1.0 - 1e-6, 0.0),
    "mu (1 + 1e-6)": (1.0 + 1e-6, 0.0),
    "from a third of a period": (1.0, 1.0 / 3.0),
    "from two thirds": (1.0, 2.0 / 3.0),
}
"""Factor of the friction coefficient, and start of the run in periods of the drive."""

READ = 3e-3
"""To how much the measured speeds are read [m/s]: a larger spread is that of no function of the inputs."""

CALIBRATION, TEST = slice(0, len(CARRIED)), slice(len(CARRIED), None)
"""Points of the calibration and of the test."""

AGREE = 0.1
"""Misfit over the speed without load that counts as agreement."""

HEAVY = {"friction coefficient": FRICTION, "damping ratio": 0.012, "modal mass": 1.0, "inclination": 1e-6}
HEAVY |= {"contact stiffness": 1e9, "restitution": 0.5}
"""A foot that friction does not disturb, under a constant normal force."""

SHARES = (0.0, 0.1, 0.2, 0.3)
"""Of the friction force, that a load takes in the comparison with the closed form."""


def free_foot() -> NDArray[np.complex128]:
    """Return the phasors of the free foot's displacement at the three tones, at 200 V [m]."""
    trace = np.array(TRACE.split(), float)
    return np.asarray(2e-6 * VIBRATION * np.fft.rfft(trace)[1:4] / trace.size, complex)


def constant_load_speed(share: float) -> float:
    """Return the speed of a heavy body under a constant normal force and rate-independent friction [m/s].

    Friction is mu N towards the foot's velocity w(t), so that its mean balances the load F where w is above
    the speed for (1 + F / mu N) / 2 of the period: the speed is a quantile of w, whatever mu and N.

    Args:
        share: F / (mu N).
    """
    tones = 2.0 * np.pi * FREQUENCY * np.arange(1.0, 4.0)
    time = np.linspace(0.0, 1.0 / FREQUENCY, 10_000, endpoint=False)
    velocity = np.real((1j * tones * free_foot()) @ np.exp(1j * np.outer(tones, time)))
    return float(np.quantile(velocity, 0.5 * (1.0 - share)))


def leg(
    payload: float,
    force: float,
    depth: float,
    arc: float = ARC,
    heavier: float = 1.0,
    begins: float = 0.0,
    **unknown: float,
) -> cl.Motor:
    """Return a leg with its quarter of the body; it starts in free vibration on glass at rest.

    Args:
        payload, force: of the whole motor [kg], [N].
        depth: of the foot in the glass at the start [m].
        arc: radius of the foot's path about the leg [m].
        heavier: factor of the inertia along the glass.
        begins: start of the run in periods of the drive.
        unknown: values of `UNKNOWN`.
    """
    quarter = (BODY + payload) / LEGS
    rate, tones = 2.0 * np.pi * NATURAL, 2.0 * np.pi * FREQUENCY * np.arange(1.0, 4.0)
    damping = 2.0 * unknown["damping ratio"] * rate
    response = 1.0 / (rate[:, None] ** 2 - tones**2 + 1j * damping[:, None] * tones)
    along = np.full(3, unknown["modal mass"] ** -0.5)
    towards = along * tan(radians(unknown["inclination"]))
    tone_force = free_foot() / (along @ response) * np.exp(1j * tones * begins / FREQUENCY)
    steady = response * tone_force
    bent = towards @ steady.sum(1).real
    motor = cl.Motor(
        cl.NormalModes(
            stiffness=rate**2,
            damping=damping,
            coupling=np.ones((3, 1)),
            tip_displacement=towards,
            # The foot's way along the glass is -arc theta.
            tip_slope=-along / arc,
        ),
        cl.Drive(tones / (2.0 * np.pi), tone_force[None]),
        cl.ContactGeometry(tip_length=arc, rotor_radius=FLAT, clearance=0.0),
        cl.Rotor(inertia=heavier * LIGHT * quarter * FLAT**2, load_torque=force / LEGS * FLAT),
    )
    start = cl.ModalState(
        np.append(steady.sum(1).real, quarter**0.5 * (bent - depth)),
        np.append((steady @ (1j * tones)).real, 0.0),
    )
    return replace(cl.on_bearing(motor, cl.Bearing(quarter, preload=quarter * GRAVITY)), start=start)


def speed(
    name: str,
    payload: float,
    force: float,
    arc: float = ARC,
    heavier: float = 1.0,
    begins: float = 0.0,
    **unknown: float,
) -> float:
    """Return the mean speed of the motor [m/s], zero if the load pulls it back; NaN if the run breaks off.

    Args:
        name: of the law.
        payload, force, arc, heavier, begins, unknown: as of `leg`.
    """
    law = LAWS[name](**unknown)
    rigid = isinstance(law, cl.MultiplierLaw)
    weight = (BODY + payload) / LEGS * GRAVITY
    depth = -1e-9 if rigid else (weight / unknown["contact stiffness"]) ** (2.0 / 3.0)
    run = cl.simulate(
        leg(payload, force, depth, arc, heavier, begins, **unknown),
        law,
        duration=heavier * DURATION,
        record_interval=1e-4,
    )
    mean = float(run["rotor_velocity"].sel(time=slice(heavier * LATE, None)).mean()) * FLAT
    return max(mean, 0.0) if run.complete else np.nan


def values_at(places: np.ndarray) -> dict[str, float]:
    """Return the unknowns at places between 0 and 1 of their ranges."""
    ranges = zip(places.tolist(), UNKNOWN.values(), strict=True)
    numbers = [low * (high / low) ** x if log else low + (high - low) * x for x, (low, high, log) in ranges]
    return dict(zip(UNKNOWN, numbers, strict=True))


def misfit(speeds: np.ndarray, part: slice) -> np.ndarray:
    """Return the root mean square error over a part of the points [m/s], shape (draw,)."""
    measured = np.array(POINTS)[part, 2]
    return np.asarray(np.sqrt(np.mean((speeds[..., part] - measured) ** 2, axis=-1)))


def repeated(name: str, place: np.ndarray, heavier: float = 1.0) -> np.ndarray:
    """Return the speeds of a draw at all points [m/s], shape (repeat, point)."""
    values, mu = values_at(place), "friction coefficient"
    rows = [
        [speed(name, *point[:2], heavier=heavier, begins=begins, **values | {mu: values[mu] * factor})
         for point in POINTS]
        for factor, begins in REPEATS.values()
    ]  # fmt: skip
    return np.array(rows)


def calibrated(name: str, draws: int, rounds: int, candidates: int) -> Part:
    """Return the calibration of all draws of a law, and the repeated runs of the best ones at all points.

    The short form has one candidate, without more inertia.
    """
    places, speeds = np.empty((0, len(UNKNOWN))), np.empty((0, len(CARRIED)))
    for number in range(rounds):
        new = qmc.LatinHypercube(len(UNKNOWN), seed=number).random(draws)
        if number:
            centre = places[np.nanargmin(misfit(speeds, CALIBRATION))]
            new = np.clip(centre + (new - 0.5) * 0.5**number, 0.0, 1.0)
        rows = [
            [speed(name, *point[:2], **values_at(place)) for point in POINTS[CALIBRATION]] for place in new
        ]
        places, speeds = np.vstack([places, new]), np.vstack([speeds, rows])
    first = np.argsort(misfit(speeds, CALIBRATION))[:candidates]
    again = [repeated(name, places[i]) for i in first]
    worst = [misfit(runs, CALIBRATION).max() for runs in again]
    heavier = np.full_like(again[0], np.nan)
    if rounds > 1:
        heavier = repeated(name, places[first[np.argsort(worst)[0]]], HEAVIER)
    missing = [np.nan if key in UNUSED.get(name, ()) else 1.0 for key in UNKNOWN]
    data = {
        "draws": (("draw", "calibration_point"), speeds),
        "speed": (("candidate", "repeat", "point"), np.array(again)),
        "value": (
            ("candidate", "unknown"),
            np.array([[*values_at(places[i]).values()] for i in first]) * missing,
        ),
        "heavier": (("repeat", "point"), heavier),
    }
    return part_of(xarray.Dataset(data).expand_dims(law=[name]))


class PublishedMotor(Experiment):
    """How near do contact laws come to the measured speed of a published motor over payload and force?"""

    says = (
        "Nothing: the paper has no measurements. The claim is that a law whose unpublished numbers are "
        "calibrated with speeds over payload predicts those over towing force within a tenth of the speed "
        "without load, and that these speeds are functions of the numbers."
    )

    def tasks(self, setups: Setups) -> Iterator[Task]:
        """Yield a task a law; the short form has one law and two draws."""
        del setups
        sizes = (2, 1, 1) if self.short else (DRAWS, ROUNDS, CANDIDATES)
        for name in ["hertz_penalty"] if self.short else LAWS:
            yield Task(name, calibrated, (name, *sizes))

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return the speeds with the measured ones, misfits, and the closed form of a constant load."""
        del setup
        data = xarray.concat(parts, "law")
        data.speed.attrs["units"] = "m s-1"
        payload, force, measured = np.array(POINTS).T
        data = data.assign_coords(
            unknown=[*UNKNOWN],
            repeat=[*REPEATS],
            payload=("point", payload, {"units": "kg"}),
            force=("point", force, {"units": "N"}),
            share=[*SHARES],
        )
        units = {"units": "m s-1"}
        data["measured"] = "point", measured, units
        data["published_model"] = "point", [published_model(*point[:2]) for point in POINTS], units
        for name, part in PARTS.items():
            data[name] = ("law", "candidate", "repeat"), misfit(data.speed.values, part), units
            data[f"{name}_heavier"] = ("law", "repeat"), misfit(data.heavier.values, part), units
        data["spread"] = ("law", "candidate"), spread_of(data.speed.values), units
        data["spread_heavier"] = "law", spread_of(data.heavier.values), units
        friction = FRICTION * (BODY + 0.2) * GRAVITY
        runs = [speed("hertz_penalty", 0.2, share * friction, FLAT, **HEAVY) for share in SHARES]
        data["constant_load_run"] = "share", runs, units
        data["constant_load"] = "share", [constant_load_speed(share) for share in SHARES], units
        return data

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Return a row a law and inertia: spreads, misfits as they came, loads moved, the best draw."""
        rows: list[dict[str, object]] = []
        for law in data.law.values:
            item = best(data, law)
            for suffix, inertia in INERTIAS.items():
                speeds = item[suffix[1:] or "speed"].transpose("repeat", "point").values
                moved = (speeds[:, TEST] > READ).sum(axis=1)
                row: dict[str, object] = {"law": str(law), "inertia over the first": inertia}
                for by, which in CHANGED.items():
                    row[f"largest difference, {by} [mm/s]"] = 1e3 * float(spread_of(speeds[which]))
                row |= {"least loads moved": int(moved.min()), "most loads moved": int(moved.max())}
                for part in PARTS:
                    values = 1e3 * item[f"{part}{suffix}"].values
                    row[f"{part} misfit from [mm/s]"] = values.min()
                    row[f"{part} misfit to [mm/s]"] = values.max()
                row["runs that break off"] = int(np.isnan(speeds).sum())
                values = item.value.to_series()
                rows.append(row | {str(key): values[key] for key in UNKNOWN})
        return rows

    def numbers(self, data: xarray.DataTree) -> dict[str, float]:
        """Return the speed without load, the authors' misfits, and the speed of the closed form [mm/s]."""
        own = {part: float(misfit(data.published_model.values, at)) for part, at in PARTS.items()}
        off = np.abs(data.constant_load_run.values / data.constant_load.values - 1.0).max()
        return {
            "measured without load": 1e3 * float(data.measured[0]),
            **{f"published model, {part}": 1e3 * own[part] for part in PARTS},
            "closed form without load": 1e3 * float(data.constant_load[0]),
            "largest error of the closed form [%]": 100.0 * float(off),
        }

    def draw(self, data: xarray.Dataset) -> Figure:
        """Draw a column a law: measured speeds over payload above, over towing force below."""
        laws = data.law.values
        figure, axes = plt.subplots(
            2,
            len(laws),
            figsize=(max(1.9 * len(laws), 3.8), 4.2),
            sharey="row",
            squeeze=False,
            layout="constrained",
        )
        for (above, below), law in zip(axes.T, laws, strict=True):
            above.set_title(str(law))
            draw_points(above, data, law, data.force == 0.0, "payload", "C0", "payload (kg)")
            for payload, colour in ((0.2, "C1"), (0.8, "C2")):
                there = np.isclose(data.payload, payload)
                draw_points(below, data, law, there, "force", colour, "towing force (N)")
        axes[0, 0].set_ylabel("speed (mm/s)")
        axes[1, 0].set_ylabel("speed (mm/s)")
        axes[0, 0].set_ylim(0.0, 400.0)
        axes[1, 0].set_ylim(0.0, 400.0)
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=5)
        points = [axes[1, 0].plot([], [], f"C{i}o")[0] for i in (1, 2)]
        axes[1, 0].legend(points, ["200 g", "800 g"])
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Return spread or misfits of every law, beside those of the published model."""
        free, agree, texts = float(data.measured[0]), [], []
        for law in data.law.values:
            item = best(data, law)
            both = [("", "speed"), *([("_heavier", "heavier")] if np.isfinite(item.heavier).all() else [])]
            spread = max(float(item[f"spread{suffix}"]) for suffix, _ in both)
            if not spread <= READ:
                texts.append(f"{law} no misfit but a spread of {1e3 * spread:.0f}")
                continue
            misfits = [float(item[f"{part}{suffix}"].max()) for suffix, _ in both for part in PARTS]
            texts.append(f"{law} {1e3 * misfits[0]:.0f} and {1e3 * misfits[1]:.0f}")
            if max(misfits) <= AGREE * free:
                agree.append(str(law))
        own = [1e3 * float(misfit(data.published_model.values, part)) for part in PARTS.values()]
        steady = 1e3 * float(data.constant_load[0])
        sentence = (
            f"The best of {data.sizes['draw']} draws of the unpublished numbers misses the speeds over "
            f"payload (calibration) and over towing force (test), in mm/s of {1e3 * free:.0f} without load, "
            f"by: {', '.join(texts)}; the published model, not calibrated, by {own[0]:.0f} and "
            f"{own[1]:.0f}. A spread is the largest difference of a speed over {len(REPEATS)} repetitions, "
            f"with the friction coefficient times 1 -+ 1e-6 or other starts, above {1e3 * READ:.0f} mm/s. "
            f"Within a tenth in both, and with {HEAVIER:.0f} times the inertia: "
            f"{', '.join(agree) or 'none'}. Under a constant normal force the measured vibration, "
            f"undisturbed, gives {steady:.0f} mm/s under rate-independent friction."
        )
        return sentence, bool(agree)


PARTS, INERTIAS = {"calibration": CALIBRATION, "test": TEST}, {"": 1.0, "_heavier": HEAVIER}
"""Parts of the points, and inertias over the first by what their variables end with."""

CHANGED = {"friction coefficient": [0, 1, 2], "start": [0, 3, 4]}
"""Places in `REPEATS` by what differs between them."""


def spread_of(speeds: np.ndarray) -> np.ndarray:
    """Return the largest difference of repeated speeds over all points [m/s], NaN where a run breaks off."""
    return np.asarray(np.ptp(speeds, axis=-2).max(axis=-1))


def published_model(payload: float, force: float) -> float:
    """Return the speed of the authors' model [m/s], straight lines of figures 7(a) and 7(b)."""
    if force == 0.0:
        return 0.264 - 0.198 * payload
    return 0.236 - 0.566 * force if payload < 0.5 else 0.078 - 0.047 * force


def best(data: xarray.Dataset, law: str) -> xarray.Dataset:
    """Return the candidate of a law whose largest misfit of the calibration is the smallest."""
    item = data.sel(law=law)
    return item.isel(candidate=int(np.argsort(item.calibration.max("repeat", skipna=False).values)[0]))


def draw_points(
    ax: Axes, data: xarray.Dataset, law: str, which: xarray.DataArray, x: str, colour: str, label: str
) -> None:
    """Draw measured speeds, the best draw with its spread, and the range of draws over payload or force."""
    chosen = data.isel(point=np.flatnonzero(which)).sortby(x)
    over, runs = chosen[x].values, 1e3 * best(chosen, law).speed
    if x == "payload":
        every = 1e3 * data.sel(law=law).draws.isel(draw=slice(0, DRAWS))
        ax.fill_between(over, *every.quantile([0.0, 1.0], "draw").values, color="0.9", label="all draws")
    ax.fill_between(
        over, *runs.quantile([0.0, 1.0], "repeat").values, color=colour, alpha=0.3, label="spread"
    )
    ax.plot(over, runs[0], color=colour, label="best draw")
    ax.plot(over, 1e3 * chosen.published_model, ":", color="0.4", label="published model")
    ax.plot(over, 1e3 * chosen.measured, "o", color=colour, markeredgecolor="black", label="measured")
    ax.set_xlabel(label)


if __name__ == "__main__":
    main(__file__)
