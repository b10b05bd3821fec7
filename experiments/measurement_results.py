"""Numbers of docs/measurements.md: laws against the spheres and the ellipses that were measured.

    python experiments/measurement_results.py SPHERES ELLIPSES [--output FILE] [--cache DIR]

SPHERES and ELLIPSES are the files that the page describes. Writes docs/results/measurements.json,
with which a test compares the page. It takes an hour on one core; an interrupted run goes on from its cache.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray
from oblique_spheres import ObliqueSpheres, misfit_rows

import contactlab as cl
from contactlab.inference.bootstrap import mean_intervals
from contactlab.inference.cross_validation import laws_in
from contactlab.studies.validate import parameters

RESULTS: Final = Path(__file__).resolve().parents[1] / "docs" / "results" / "measurements.json"

SPRING: Final = "hertz_point + flores + mindlin"
LAWS: Final = ("newton", "poisson", "composed")
PARTS: Final = {"law/damping": "flores", "law/friction": "mindlin"}
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


def of_spheres(path: Path) -> dict[str, Any]:
    """Return misfits, in errors of digitisation, and the lowest tangential restitution of each law."""
    data = ObliqueSpheres(path=str(path)).compute(cl.build())
    laws = {str(row.pop("law")): row for row in misfit_rows(data)}
    numbers = {k: float(v) for k, v in data.attrs.items() if isinstance(v, float | np.floating)}
    return {"laws": laws, **numbers}


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


def of_ellipses(path: Path, cache: Path) -> dict[str, Any]:
    """Return held-out errors of all laws, and of three with free numbers of the geometry."""
    data = cl.validate(path, folder=cache / "laws").data.to_dataset()
    laws = laws_in(data)
    upper = np.triu_indices(laws.sizes["law"], 1)
    p_values = laws["p_value"].sel(other=laws["law"].values).values[upper]
    alone = laws["difference_interval"].sel(other=laws["law"].values).values[upper]
    errors = data["error"].sel(law="poisson").values
    result: dict[str, Any] = {
        "impacts": data.sizes["impact"],
        "left out": int(data.attrs["left_out"]),
        "laws": of_laws(data),
        "pairs": {
            "all": p_values.size,
            "distinct": int((p_values <= 0.05).sum()),
            "distinct without correction": int((alone.prod(axis=1) > 0.0).sum()),
        },
        "unexplained": {
            "observed": int(data["unexplained"].sum()),
            "expected at most": float(data.attrs["unexplained_by_noise"]),
        },
        "autocorrelation of poisson's errors": float(np.corrcoef(errors[:-1], errors[1:])[0, 1]),
        "half-width of poisson's interval": {
            str(block): float(
                mean_intervals(errors[:, None], 0, blocks=np.arange(errors.size) // block).half[0]
            )
            for block in BLOCKS
        },
        "geometry": {},
    }
    patch = cl.validate(
        path, "composed", fixed={**PARTS, "law/friction": "microslip"}, folder=cache / "microslip"
    )
    result["laws"] |= of_laws(laws_in(patch.data.to_dataset()))
    for name, free in GEOMETRIES.items():
        kept = cache / name.replace(" ", "_")
        made = cl.validate(path, LAWS, free=free, fixed=PARTS, folder=kept).data.to_dataset()
        apart = made["difference"].sel(law="poisson", other=SPRING)
        low, high = made["difference_interval"].sel(law="poisson", other=SPRING).values
        gain = {"gain": float(apart), "low": float(low), "high": float(high)}
        p_value = float(made["p_value"].sel(law="poisson", other=SPRING))
        result["geometry"][name] = {"laws": of_laws(made), "mindlin less poisson": gain | {"p": p_value}}
    return result


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the file of results."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("spheres", type=Path)
    parser.add_argument("ellipses", type=Path)
    parser.add_argument("--output", type=Path, default=RESULTS)
    parser.add_argument("--cache", type=Path, default=Path("measurement_results"))
    chosen = parser.parse_args(arguments)
    results = {"spheres": of_spheres(chosen.spheres), "ellipses": of_ellipses(chosen.ellipses, chosen.cache)}
    chosen.output.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(results, indent=1, default=float)
    chosen.output.write_text(text.replace("NaN", "null") + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
