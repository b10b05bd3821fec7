"""Numbers of docs/measurements.md and of docs/measurements/: laws against what was measured.

They are made by remake.py, from the files that the page describes, and with them the figures.
"""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from shutil import copyfile
from typing import Any, Final

import numpy as np
import xarray
from all import numbers_of
from dependencies import ROOT, Recorder
from experiment import class_of, setup_of
from oblique_spheres import ObliqueSpheres, misfit_rows
from scipy.optimize import minimize

import contactlab as cl
from contactlab.arrays import Array
from contactlab.studies.compare.bootstrap import mean_intervals
from contactlab.studies.study import Result, finish, run
from contactlab_data.inference.cross_validation import laws_in
from contactlab_data.measured.files import read_impacts
from contactlab_data.studies.validate import parameters
from contactlab_data.studies.validate_figures import abscissas, binned, residuals_of

PICTURES: Final = ROOT / "docs" / "measurements"
FIGURES: Final = ("prediction_error", "paired_differences", "residuals", "impacts")

SPRING: Final = "hertz_point + flores + mindlin"
LAWS: Final = (cl.Newton(), cl.Poisson(), cl.law("composed", damping="flores", friction="mindlin"))
ARMS: Final = {"data.normal_arm": ("-15 mm", "15 mm"), "data.tangential_arm": ("-15 mm", "15 mm")}
INERTIA: Final = {"data.inertia": (0.5, 1.5)}
GEOMETRIES: Final[Mapping[str, Mapping[str, tuple[float | str, float | str]]]] = {
    "as measured": {},
    "inertia": INERTIA,
    "arms": ARMS,
    "tilt and inertia": {"data.tilt": (-0.15, 0.15), **INERTIA},
}
"""Numbers of the data that are fitted with those of the law."""

BLOCKS: Final = (1, 10, 50)
"""Impacts in a row that are resampled together."""

RATIOS, EVERY = (0.67, 1.0, 4.0), 8
"""Tangential over normal stiffness; of so many impacts one is in the comparison of laws at these ratios."""


def misfits(path: Path) -> dict[str, Any]:
    """Return misfits, in errors of digitisation, and the lowest tangential restitution of each law."""
    data = ObliqueSpheres(path=str(path)).compute(cl.build())
    laws = {str(row.pop("law")): row for row in misfit_rows(data)}
    numbers = {k: float(v) for k, v in data.attrs.items() if isinstance(v, float | np.floating)}
    return {"laws": laws, **numbers}


def of_spheres(path: Path, folder: Path) -> dict[str, Any]:
    """Return misfits and the lowest tangential restitution of each law, which the short form has too."""
    del folder
    return misfits(path)


def some_ellipses(path: Path) -> dict[str, Any]:
    """Return the mean errors of the laws whose geometry is free on one impact of a hundred."""
    some = read_impacts(path).part(np.arange(0, len(read_impacts(path)), 100))
    return {law.name: float(some.errors(some.before.velocities_after(law)).mean()) for law in LAWS}


def of_laws(data: xarray.Dataset) -> dict[str, Any]:
    """Return error, interval and group of each law, and the medians of its parameters over the folds."""
    fitted: dict[str, dict[str, float]] = {}
    for row in parameters(data):
        fitted.setdefault(row["law"], {})[row["parameter"]] = row["median"]
    laws = {}
    for label in map(str, data["law"].values):
        here = data.sel(law=label)
        low, high = map(float, here["prediction_error_interval"].values)
        numbers = {"error": float(here["prediction_error"]), "low": low, "high": high}
        kind = {"kind": str(here["kind"].item()), "group": int(here["group"])}
        laws[label] = numbers | kind | {"parameters": fitted.get(label, {})}
    return laws


def over_slip(data: xarray.Dataset) -> list[dict[str, float]]:
    """Return the measured ratio of the gap rates over the slip, and the best law's residual."""
    best = str(data["law"].values[0])
    ratio = -data["velocity_after"].values[:, 0] / data["velocity_before"].values[:, 0]
    slip = abscissas(data)["slip velocity (m/s)"]
    seen = binned(slip, ratio)
    missed = binned(slip, residuals_of(data, best)["gap rate residual (m/s)"])
    names = ("slip", "ratio", "low", "high", "missed")
    rows = zip(*seen[:4], missed.median, strict=True)
    return [{name: float(x) for name, x in zip(names, row, strict=True)} for row in rows]


def less_by(errors: Array, others: Array) -> dict[str, float]:
    """Return by how much the mean of errors is less than that of others of the same impacts, at 95 %."""
    made = mean_intervals((others - errors)[:, None], 0)
    return {
        "gain": float(made.mean[0]),
        "low": float(made.interval[0, 0]),
        "high": float(made.interval[0, 1]),
    }


def at_ratios(path: Path) -> dict[str, Any]:
    """Return the least mean error of a Hertz contact with some frictions, on one impact of `EVERY`.

    With each comes by how much it is less than with Coulomb's cone.
    """
    impacts = read_impacts(path)
    some = impacts.part(np.arange(0, len(impacts), EVERY))
    frictions: dict[str, Callable[[float], cl.Friction]] = {"coulomb": cl.Coulomb}
    for ratio in RATIOS:
        frictions[f"mindlin {ratio:g}"] = partial(cl.Mindlin, stiffness_ratio=ratio)
        frictions[f"microslip {ratio:g}"] = partial(cl.Microslip, stiffness_ratio=ratio)

    def least(friction: Callable[[float], cl.Friction]) -> Array:
        def errors(x: Array) -> Array:
            law = cl.Composed(cl.HertzPoint(), cl.Flores(x[0]), friction(x[1]))
            return some.errors(some.before.velocities_after(law, 1e-4))

        options = {"xatol": 1e-3, "fatol": 1e-5, "maxfev": 50}
        start = (0.55, 0.18)
        return errors(minimize(lambda x: errors(x).mean(), start, method="Nelder-Mead", options=options).x)

    errors = {name: least(friction) for name, friction in frictions.items()}
    means = {name: float(each.mean()) for name, each in errors.items()}
    cone = errors.pop("coulomb")
    return means | {f"{name} before coulomb": less_by(each, cone) for name, each in errors.items()}


def of_ellipses(path: Path, folder: Path) -> dict[str, Any]:
    """Return held-out errors of all laws, and of three with free numbers of the geometry."""
    made = cl.validate((), data=path, output=folder / "laws")
    for name in FIGURES:
        copyfile(folder / "laws" / f"{name}.png", PICTURES / f"ellipses_{name}.png")
    data = made.data.to_dataset()
    laws, impacts = laws_in(data), read_impacts(path)
    gap_rate, slip = impacts.velocity_before.T
    upper = np.triu_indices(laws.sizes["law"], 1)
    p_values = laws["p_value"].sel(other=laws["law"].values).values[upper]
    alone = laws["difference_interval"].sel(other=laws["law"].values).values[upper]
    errors = data["error"].sel(law="poisson").values
    blocks = {str(n): np.arange(errors.size) // n for n in BLOCKS}
    newton, brach = (data["error"].sel(law=law).values for law in ("newton", "brach"))
    # Laws are sorted by their error.
    best, geometry = laws["error"].values[0], {}
    for name, free in GEOMETRIES.items():
        fitted = cl.validate(
            LAWS, data=path, output=folder / name.replace(" ", "_"), free=free
        ).data.to_dataset()
        pair = fitted[["difference", "difference_interval", "p_value"]].sel(law="poisson", other=SPRING)
        low, high = map(float, pair["difference_interval"].values)
        gain = {"gain": float(pair["difference"]), "low": low, "high": high, "p": float(pair["p_value"])}
        rigid, other = (fitted["error"].sel(law=law).values for law in ("poisson", "newton"))
        geometry[name] = {
            "laws": of_laws(fitted),
            "mindlin before poisson": gain,
            "poisson before newton": less_by(rigid, other),
            "poisson before all as measured": less_by(rigid, best),
        }
    return {
        "impacts": data.sizes["impact"],
        "left out": int(data.attrs["left_out"]),
        "error without change": float(impacts.errors(impacts.velocity_before).mean()),
        "approach": {"least": -float(gap_rate.max()), "greatest": -float(gap_rate.min())},
        "largest incidence": float(np.degrees(np.arctan2(np.abs(slip), -gap_rate)).max()),
        "laws": of_laws(data),
        "brach before newton": less_by(brach, newton),
        "over slip": over_slip(data),
        "pairs": {
            "all": p_values.size,
            "distinct": int((p_values <= 0.05).sum()),
            "distinct alone": int((alone.prod(axis=1) > 0.0).sum()),
        },
        "unexplained": {
            "observed": int(data["unexplained"].sum()),
            "by noise": float(data.attrs["unexplained_by_noise"]),
        },
        "correlation of neighbours": float(np.corrcoef(errors[:-1], errors[1:])[0, 1]),
        "half-width": {
            n: float(mean_intervals(errors[:, None], 0, blocks=b).half[0]) for n, b in blocks.items()
        },
        "geometry": geometry,
        "stiffness ratio": at_ratios(path),
    }


def under_every_law(name: str, source: Path) -> Result:
    """Return an experiment on measured friction; the loop of the tribometer is a part of the project."""
    options: dict[str, Any] = {} if name == "friction_loop" else {"path": str(source)}
    return run(class_of(name)(**options), {"": setup_of(name)})


def of_friction(name: str) -> tuple[Callable[[Path, Path], dict[str, Any]], Callable[[Path], dict[str, Any]]]:
    """Return what makes a section on measured friction, and its short form, which has the same numbers."""

    def made(source: Path, folder: Path) -> dict[str, Any]:
        result = under_every_law(name, source)
        numbers = numbers_of(result)
        # What draws decides no number.
        Recorder.stop()
        finish(result, folder)
        copyfile(folder / f"{name}.png", PICTURES / f"{name}.png")
        return numbers

    return made, lambda source: numbers_of(under_every_law(name, source))


SECTIONS: Final = {
    "ellipses": (of_ellipses, some_ellipses),
    "spheres": (of_spheres, misfits),
    **{name: of_friction(name) for name in ("friction_loop", "joint_friction", "velocity_steps")},
}
"""What makes a section, and its short form."""
