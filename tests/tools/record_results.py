"""Record the results of all studies, so that changed code can be held against them.

    record_results.py record FOLDER [--part NAME]... [--items OTHER] [--first I] [--motors N] [--share S]
                                    [--workers N] [--data FOLDER] [--nudge]
    record_results.py compare BEFORE AFTER [--part NAME]... [--skip REGEX]... [--all] [--round-off FOLDER]

`record` writes one file an item, FOLDER/PART/ITEM.npz: flat names -> float64 arrays, and texts such as the
kind of a motion. An item that raises records the exception's type. Items that are there are not computed
again, so that a recording that was stopped goes on. What the items are (overrides of the command line and
arguments) is kept in FOLDER/items/PART.json. `--items BEFORE` takes those of another record, whatever has
become of `record_items`, which drew them. `--share 0.1` takes a random tenth of the items. `--nudge` makes
every tip longer by 4 eps, to see what round-off becomes in runs and studies of motors.

    impacts        every law on a grid of approach velocities and slips
    runs           random motors over all laws and parts, laws of another package, runs in pieces
    sweep          metrics over laws, phases and clearances
    steady         steady states at three steps, with orbits and multipliers
    branches       branches, basins, coexisting attractors
    fit            least squares and nested sampling of impacts and series
    validate       cross-validation on 2000 measured impacts, and measured spheres
    compare        comparisons with all causes
    characterise   data sheets

`compare` prints how many arrays have the same bits, how many deviate by more than 1e-9 of their quantity's
scale, and the quantities that do; then the items beyond, each with the deviation by round-off if a record by
`--nudge` is given, and the texts, shapes and exceptions that changed. The exit status is 1 if there is any of
these. Items that AFTER lacks are counted; `--all` makes them a failure.

After a change of the package's interface only the section "Adapters" needs an edit: each of its functions
computes one item and returns its flat results.
"""

import argparse
import io
import itertools
import json
import os
import re
import sys
import time
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / place) for place in ("experiments", "tests", "tests/fourteen_laws")]

import numpy as np  # noqa: E402 - after the number of its threads

Array = np.ndarray[Any, Any]
Values = dict[str, Any]
"""Results of one item by flat names: 'series/gap', 'posterior/mean[newton,law.restitution]'."""

Item = dict[str, Any]
"""What is computed: 'id', 'overrides' of the command line, and arguments."""

TOLERANCE = 1e-9
"""Deviation over the scale of a quantity up to which two results are equal."""

KEPT = 1000
"""Last samples of each series that are recorded, beside its sum."""

NUDGED = ("runs", "sweep", "steady", "branches", "compare", "characterise")
"""Parts whose items have a tip."""

EXPECTED = ("ConfigurationError", "NotSettledError", "BrokenOffError", "NoPeriodError", "UnboundedError")
"""Exceptions that are results of a study; the sentence of any other is printed."""

DATA = ROOT.parent / "shared" / "data"

SCALED_TOGETHER = (
    r"(series|sum|curve)/(?:\w+_(?:energy|work|loss)|energy_residual)",
    r"(series|sum|curve)/(?:normal|friction)_force",
    r"(series|sum|curve)/(?:gap|tip_(?:normal|tangential)_displacement)",
    r"(series|sum|curve)/(?:rotor_velocity|rotor_angle)",
    r"(state)/(?:least_remainder|most_remainder|total\.\w+_(?:work|loss))",
    r"(contacts|motion)/(?:normal|friction)_impulse",
    r"(contacts|motion)/(?:start_time|duration|stick_duration)",
    r"(contacts|motion)/(?:approach|separation)_velocity",
    r"(.*)/(?:total_impulse|total_friction_impulse)",
    r"(.*)/(?:energy/.*|power/.*|drive_work)",
    r"(.*)/(?:\w+_power|balance)(?:_error)?",
    r"(.*)/velocity(?:_ripple)?(?:_error)?",
)
"""Quantities with one scale: the largest magnitude in the item of all with the same pattern and group 1."""

LEAST_SCALES = {
    r"(.*/)?(share|contact_share|multiplier|roughness|closure).*": 1.0,
    r"validate/(error|prediction_error|difference).*": 1.0,
    r".*/torque.*": 1e-3,
    r".*max_penetration.*": 1e-6,
    r"(contacts/|motion/|state/contact\.)energy_loss.*": 1e-9,
}
"""Least scales where there may be round-off alone: numbers near 1, torques, depths, losses [SI]."""

# ------------------------------------------------------------------------------------------------------------
# Adapters: the only functions that call the package.


def run_values(item: Item) -> Values:
    """Simulate a motor: last samples and sums of the series, contacts, final state, metrics."""
    import contactlab as cl

    setup = cl.build(item["overrides"])
    options = item.get("options", {})
    if "law" in item:
        run = cl.simulate(setup.motor, _foreign(item["law"]), duration=setup.duration, **options)
    elif "motor" in item:
        run = cl.simulate(getattr(cl, item["motor"])(**item["arguments"]), setup.law, **options)
    else:
        run = cl.simulate(setup, **options)
    for _ in range(1, item.get("pieces", 1)):
        run = cl.simulate(start=run, **options)
    return _of_solution(run)


def _of_solution(run: Any) -> Values:
    from contactlab.metrics import METRICS, assess

    tree = run.tree
    values: Values = {"text/ending": run.ending.name.lower(), "count/complete": run.complete}
    for name, array in tree.to_dataset(inherit=False).variables.items():
        if array.dims == ("time",):
            values[f"series/{name}"] = array.values[-KEPT:]
            values[f"sum/{name}"] = array.values.sum()
        else:
            values[f"motor/{name}"] = array.values
    for group in ("contacts", "state"):
        if group in tree.children:
            result = tree.children[group].to_dataset(inherit=False).variables
            values |= {f"{group}/{name}": array.values for name, array in result.items()}
    statistics = json.loads(tree.attrs["solver_statistics"])
    values |= {f"count/{name}": number for name, number in statistics.items()}
    for key, number in assess(tree).items():
        values["metrics/" + "share/" * (METRICS[key].units == "1") + key] = number
    for key, value in json.loads(tree.attrs["law_parameters"]).items():
        values[f"law/{key}"] = value
    return values


def _foreign(name: str) -> Any:
    """Make a law of the tests' own package, or a compliant law with its part."""
    from importlib import import_module

    import contactlab as cl

    module, kind = name.split(":")
    made = getattr(import_module(module), kind)()
    if isinstance(made, cl.NormalForce):
        made = cl.Composed(made, cl.Undamped(), cl.Coulomb(0.3))
    elif isinstance(made, cl.Friction):
        made = cl.Composed(cl.HertzPoint(), cl.Undamped(), made)
    return made


MATRICES = ([[800, 0], [0, 2800]], [[800, 500], [500, 1500]], [[28, -12], [-12, 60]])
SPEEDS = (2e-3, 0.02, 0.08, 0.4, 2.0)
SLIPS = (-1.5, -0.06, -1e-3, 0.0, 2e-3, 0.03, 0.7)
"""Impacts: Delassus matrices of motors and of a disc [1/kg], approach and slip velocities [m/s]."""


def impact_values(item: Item) -> Values:
    """Apply a law to impacts on a grid; of a compliant one the history of the contact as well."""
    import contactlab as cl

    law = _foreign(item["law"]) if "law" in item else cl.build(item["overrides"]).law
    values: Values = {}
    for speed in SPEEDS:
        every = [*itertools.product(MATRICES, SLIPS)]
        matrices, rates = [each[0] for each in every], [[-speed, each[1]] for each in every]
        result = _of_dataset(cl.impact(law, matrices, rates), "impact")
        if isinstance(law, cl.PenaltyLaw):
            result |= _of_dataset(cl.impact(law, matrices[::6], rates[::6], history=16), "history")
        # Each with a scale of its own.
        values |= {f"{name}[{speed:g}]": array for name, array in result.items()}
    return values


def tip_length(overrides: Sequence[str]) -> float:
    """Return the length of a motor's tip [m]."""
    import contactlab as cl

    return float(cl.build(overrides).motor.geometry.tip_length)


def sweep_values(item: Item) -> Values:
    """Sweep the metrics of runs."""
    import contactlab as cl
    from contactlab.metrics import METRICS

    options = item["options"]
    lines = [f"solver.duration={options['duration']}", f"record.interval={options['record_interval']}"]
    kept: dict[str, Any] = {"metrics": "all", "series": options["series"]}
    data = cl.sweep(item["over"], [*item["overrides"], *lines], **kept, workers=1)
    return _of_dataset(data, "sweep", [key for key, metric in METRICS.items() if metric.units == "1"])


def steady_values(item: Item) -> Values:
    """Settle a motor at three steps, with the error of the step."""
    import contactlab as cl

    result = cl.converged(cl.build(item["overrides"]), **item["options"]).details
    values: Values = {"converged/values": result.values}
    for name in ("velocity", "torque"):
        values |= _of_estimate(getattr(result, name), f"converged/{name}")
    for at, each in enumerate(result.steps):
        values |= _of_steady(each, str(at))
    return values


def _of_estimate(number: Any, name: str, label: str = "") -> Values:
    return {f"{name}{label}": number[0], f"{name}_error{label}": number[1]}


def _of_steady(state: Any, at: str) -> Values:
    label = f"[{at}]"
    values: Values = {
        f"text/kind{label}": state.kind,
        f"count/periods{label}": state.periods,
        f"count/warm_up{label}": state.warm_up,
        f"steady/closure{label}": state.closure,
    }
    for name in ("velocity", "torque", "impulse", "peak_force", "contact_share"):
        values |= _of_estimate(getattr(state, name), f"steady/{name}", label)
    for name in ("drive_work", "damping_loss", "friction_loss", "contact_loss", "load_work"):
        values |= _of_estimate(state.average(name), f"steady/power/{name}", label)
    values |= {f"motion/{name}{label}": column for name, column in state.motion.contacts.items()}
    if state.orbit is not None:
        values |= _of_orbit(state.orbit, label)
        curves = state.curves(200)
        values |= {f"curve/{name}{label}": column for name, column in curves.series.items()}
    return values


def _of_orbit(orbit: Any, label: str) -> Values:
    multipliers = orbit.multipliers
    return {
        f"orbit/state{label}": orbit.state,
        # Of a conjugate pair either may come first.
        f"orbit/multiplier_modulus{label}": np.abs(multipliers),
        f"orbit/multiplier_real{label}": multipliers.real,
        f"orbit/multiplier_imaginary{label}": np.abs(multipliers.imag),
        f"orbit/settling_time{label}": orbit.settling_time,
        f"orbit/roughness{label}": orbit.roughness,
    }


def branches_values(item: Item) -> Values:
    """Follow a branch, map basins, or find attractors."""
    import contactlab as cl

    setup, options = cl.build(item["overrides"]), item["options"]
    if item["study"] == "branch":
        data = cl.branch(setup, **options).data.to_dataset()
        data["multiplier_imaginary"] = abs(data["multiplier_imaginary"])
        return _of_dataset(data, "branch")
    if item["study"] == "basins":
        axes = {name: np.asarray(values) for name, values in item["axes"].items()}
        return _of_dataset(cl.basins(setup, axes, **options).data.to_dataset(), "basins")
    values: Values = {}
    for at, each in enumerate(cl.attractors(setup, **options)):
        values |= {f"attractor/share[{at}]": each.share} | _of_steady(each.steady, str(at))
    return values


def fit_values(item: Item) -> Values:
    """Fit laws by least squares and nested sampling."""

    import contactlab as cl
    from contactlab.cli.study import setups_of
    from contactlab.inference.fit import candidates_of, fitted
    from contactlab.inference.least_squares import best_fit
    from contactlab.inference.nested_sampling import Posterior
    from contactlab.measured.files import read_measurements

    data = _made(item["made"]) if "made" in item else read_measurements(data_file(item["data"]))
    lines = item["overrides"]
    free = {key: ends.split("..") for key, _, ends in (x.partition("=") for x in lines) if ".." in ends}
    rest = [line for line in lines if ".." not in line and "," not in line]
    over = [line for line in lines if "," in line]
    setups = setups_of(rest, over, getattr(data, "configuration", {}))
    candidates = candidates_of(
        data,
        setups or {"": cl.build(data.configuration)},
        free,
        discrepancy=item.get("discrepancy", "off"),
        degrees_of_freedom=item.get("degrees_of_freedom", np.inf),
    )
    values: Values = {}
    options = item["options"]
    for each in candidates:
        label, problem = each.label, each.problem
        tree = fitted(each, **options)
        about, sampled = tree.attrs, tree["weighted_samples"].to_dataset()
        result = Posterior(
            problem.free,
            sampled["value"].values,
            sampled["log_likelihood"].values,
            sampled["log_weight"].values,
            *(about[name] for name in ("log_evidence", "log_evidence_error", "information", "calls")),
            points=0,
            seed=0,
        )
        names = [single.name for single in result.free]
        columns: Values = {}
        if problem.parameters:
            best = best_fit(
                problem.residuals,
                problem.parameters,
                options.get("starts", 16),
                options.get("seed", 0),
                step=problem.step,
            )
            columns["least_squares/value"] = best.values
            values |= {
                f"least_squares/costs[{label}]": best.costs,
                f"least_squares/singular_values[{label}]": best.singular_values,
                f"count/hits[{label}]": best.hits,
                f"text/undetermined[{label}]": ", ".join(best.undetermined),
            }
        mean, covariance = result.moments()
        columns |= {
            "posterior/mean": mean,
            "posterior/deviation": np.sqrt(np.diag(covariance)),
            "posterior/quantiles": result.quantiles((0.05, 0.5, 0.95)),
        }
        for quantity, column in columns.items():
            # Numbers of the noise are free in the posterior alone.
            pairs = zip(names, column, strict=False)
            values |= {f"{quantity}[{label},{name}]": number for name, number in pairs}
        values |= {
            f"posterior/log_evidence[{label}]": result.log_evidence,
            f"posterior/log_evidence_error[{label}]": result.error,
            f"posterior/information[{label}]": result.information,
            f"posterior/log_likelihood[{label}]": result.log_likelihood,
            f"posterior/share_inside[{label}]": about["coverage"],
            f"count/evaluations[{label}]": result.calls,
        }
    return values


def _made(how: Mapping[str, Any]) -> Any:
    """Make measurements by a known law."""
    import contactlab as cl
    from contactlab.inference.synthetic import made_impacts, made_series

    setup = cl.build(how["overrides"])
    if "impacts" in how:
        return made_impacts(setup.law, how["impacts"], how["noise"], how["seed"], setup.configuration)
    return made_series(setup, how["series"], how["noise"], how["seed"])


def validate_values(item: Item) -> Values:
    """Cross-validate laws on measured impacts, or predict the rebounds of spheres."""
    if item["data"].endswith(".csv"):
        from oblique_spheres import study as spheres

        return _of_dataset(spheres(data_file(item["data"])), "spheres")
    import contactlab as cl

    data = cl.validate(data=data_file(item["data"]), **item["options"]).data.to_dataset()
    return _of_dataset(data, "validate")


def compare_values(item: Item) -> Values:
    """Compare laws in one motor."""
    import contactlab as cl

    setups = [cl.build([*item["overrides"], *law]) for law in item["laws"]]
    sources = [cl.simulate(setup) for setup in setups] if item.get("recorded") else setups
    data = cl.compare(sources, **item["options"]).data.to_dataset(inherit=False)
    data = data.drop_vars(["judges_law", "drawn", "class"], errors="ignore")
    return _of_dataset(data, "compare", data["metric"].values[data["units"].values == "1"].tolist())


def characterise_values(item: Item) -> Values:
    """Make the data sheet of a motor."""
    import contactlab as cl

    data = cl.characterise(cl.build(item["overrides"])).data.to_dataset().isel(law=0, drop=True)
    return _of_dataset(data.drop_vars("reason"), "sheet")


QUANTITIES = ("metric", "quantity", "term")
"""Dimensions whose labels are quantities."""

LABELS = ("law", "other", "other_law", "cell", "basis", "factor", "parameter")
"""Dimensions whose labels tell arrays of one quantity apart, so that their order does not matter."""

TEXTS = ("kind", "status", "role", "undetermined", "at_end")
"""Variables that are texts; sentences and labels are left out."""


def _of_dataset(data: Any, prefix: str, shares: Sequence[str] = ()) -> Values:
    """Flatten a dataset: an array or a text for each combination of labels.

    Args:
        data: a dataset.
        prefix: first part of the names.
        shares: quantities of the order of 1.
    """
    values: Values = {}
    for name, variable in data.variables.items():
        text = variable.dtype.kind in "OUS"
        if (name in data.dims and (text or name in LABELS)) or (text and name not in TEXTS):
            continue
        inner = [dim for dim in (*QUANTITIES, *LABELS) if dim in variable.dims and dim in data.coords]
        known = [[str(label) for label in data[dim].values] for dim in inner]
        array = variable.transpose(*inner, ...).values
        for place in np.ndindex(*map(len, known)):
            labels = [column[i] for column, i in zip(known, place, strict=True)]
            pairs = [*zip(inner, labels, strict=True)]
            path = [str(name), *(label for dim, label in pairs if dim in QUANTITIES)]
            path = [f"share/{each}" if each in shares else each for each in path]
            message = ",".join(f"{dim}={label}" for dim, label in pairs if dim in LABELS)
            full = "/".join(["text" if text else prefix, *path]) + (f"[{message}]" if message else "")
            values[full] = "|".join(map(str, np.ravel(array[place]))) if text else array[place]
    return values


COMPUTED: dict[str, Callable[[Item], Values]] = {
    "impacts": impact_values,
    "runs": run_values,
    "sweep": sweep_values,
    "steady": steady_values,
    "branches": branches_values,
    "fit": fit_values,
    "validate": validate_values,
    "compare": compare_values,
    "characterise": characterise_values,
}

# ------------------------------------------------------------------------------------------------------------
# Recording.


def data_file(name: str) -> Path:
    """Return the path of measured data."""
    return Path(os.environ.get("RECORD_DATA", DATA)) / name


def items_of(part: str, folder: Path, other: Path | None) -> list[Item]:
    """Return the items of a part: those of the record, else of another one, else drawn; and write them."""
    place = folder / "items" / f"{part}.json"
    source = place if place.exists() or other is None else other / "items" / f"{part}.json"
    if source.exists():
        items: list[Item] = json.loads(source.read_text(encoding="utf-8"))
    else:
        from record_items import DRAWN

        items = [*DRAWN[part]()]
    if not place.exists():
        _write(place, json.dumps(items, indent=1).encode())
    return items


def _write(path: Path, content: bytes) -> None:
    """Write a file, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    partial.write_bytes(content)
    partial.replace(path)


def recorded(part: str, item: Item, folder: Path, nudge: bool) -> tuple[str, float]:
    """Compute one item and write its file; returns the exception's type, empty for none, and the seconds."""
    began, fault = time.perf_counter(), ""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            values = COMPUTED[part](_nudged(item) if nudge else item)
        except Exception as error:
            fault = type(error).__name__
            values = {"text/exception": fault}
            if fault not in EXPECTED:
                print(f"{part} {item['id']}: {fault}: {error}", flush=True)
    arrays: dict[str, Any] = {
        name: x if isinstance(x, str) else np.array(x, np.float64) for name, x in values.items()
    }
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    _write(folder / part / f"{item['id']}.npz", stream.getvalue())
    return fault, time.perf_counter() - began


def _nudged(item: Item) -> Item:
    length = tip_length(item["overrides"]) * (1.0 + 4.0 * float(np.finfo(float).eps))
    return item | {"overrides": [*item["overrides"], f"contact.tip_length={length!r}"]}


def record(options: argparse.Namespace) -> int:
    """Compute what is missing, part by part; returns the exit status."""
    if options.data:
        os.environ["RECORD_DATA"] = str(options.data.resolve())
    for part in options.part or (NUDGED if options.nudge else COMPUTED):
        items = items_of(part, options.folder, options.items)
        last = None if options.motors is None else options.first + options.motors
        chosen = items[options.first : last]
        picks = np.random.default_rng(0).random(len(chosen)) < options.share
        # One at the least.
        picks[:1] |= not picks.any()
        left = []
        for item, pick in zip(chosen, picks, strict=True):
            needed = [*item.get("measured", []), *([item["data"]] if "data" in item else [])]
            if absent := [name for name in needed if not data_file(name).exists()]:
                print(f"{part}: {item['id']} is skipped: there is no {', '.join(absent)}")
            elif pick and not (options.folder / part / f"{item['id']}.npz").exists():
                left.append(item)
        print(f"{part}: {len(left)} of {len(items)} items to compute", flush=True)
        _record_all(part, left, options)
    return 0


def _record_all(part: str, items: Sequence[Item], options: argparse.Namespace) -> None:
    """Compute items in processes, in their order."""
    began = time.perf_counter()
    with ProcessPoolExecutor(options.workers) as pool:
        futures = {pool.submit(recorded, part, item, options.folder, options.nudge): item for item in items}
        for count, future in enumerate(as_completed(futures), 1):
            fault, seconds = future.result()
            print(f"{part} {count}/{len(items)} {futures[future]['id']}: {seconds:.1f} s {fault}", flush=True)
    print(f"{part}: {time.perf_counter() - began:.0f} s", flush=True)


# ------------------------------------------------------------------------------------------------------------
# Comparing.


def scales_of(values: Mapping[str, Array]) -> dict[str, float]:
    """Return the scale of every quantity: the largest magnitude of its group in the item, or the least."""
    groups: dict[str, float] = defaultdict(float)
    keys = {name: _scale_key(name) for name, array in values.items() if array.dtype.kind == "f"}
    for name, key in keys.items():
        finite = np.abs(values[name][np.isfinite(values[name])])
        least = [size for pattern, size in LEAST_SCALES.items() if re.fullmatch(pattern, name)]
        groups[key] = max(groups[key], *least, float(finite.max(initial=0.0)))
    return {name: groups[key] for name, key in keys.items()}


def _scale_key(name: str) -> str:
    """Return what the quantities of one scale have in common; an error has the scale of its number."""
    for at, pattern in enumerate(SCALED_TOGETHER):
        if result := re.fullmatch(pattern, name.partition("[")[0]):
            return f"{at} {result[1]}"
    return re.sub(r"_(?:error|interval)\b", "", name)


def deviation(before: Array, after: Array, scale: float) -> float:
    """Return the largest difference over the scale; infinite where a shape or a missing number differs."""
    if before.shape != after.shape:
        return np.inf
    here, there = np.isfinite(before), np.isfinite(after)
    if not np.array_equal(before[~here], after[~there], equal_nan=True) or not np.array_equal(here, there):
        return np.inf
    size = float(np.abs(before[here] - after[here]).max(initial=0.0))
    return size / scale if scale > 0.0 else np.inf if size > 0.0 else 0.0


def same_bits(before: Array, after: Array) -> bool:
    """Return whether two arrays are the same to the last bit; every NaN is one."""
    if before.shape != after.shape:
        return False
    equal = (before == after) & (np.signbit(before) == np.signbit(after))
    return bool(np.all(equal | (np.isnan(before) & np.isnan(after))))


def read(path: Path, skip: Sequence[str] = ()) -> dict[str, Array]:
    """Read the file of an item without quantities of some patterns."""
    with np.load(path, allow_pickle=False) as file:
        return {name: file[name] for name in file if not any(re.search(each, name) for each in skip)}


class Comparison:
    """What became of the arrays of one part.

    Attributes:
        sizes: deviations over the scale, by quantity.
        bits: how many arrays of a quantity are the same to the last bit.
        beyond: deviations beyond the tolerance, by item and name.
        changed: items by what has changed: a text, an exception, a quantity that is missing or new.
    """

    def __init__(self) -> None:
        self.sizes: dict[str, list[float]] = defaultdict(list)
        self.bits: Counter[str] = Counter()
        self.beyond: dict[str, dict[str, float]] = defaultdict(dict)
        self.changed: dict[str, list[str]] = defaultdict(list)

    def add(self, item: str, old: Mapping[str, Array], new: Mapping[str, Array]) -> None:
        """Compare one item."""
        scales = scales_of(old)
        if "text/exception" in {**old, **new}:
            # One of them has no numbers.
            old, new = ({"exception": each.get("text/exception", np.array("none"))} for each in (old, new))
        for word, names in (("missing", old.keys() - new.keys()), ("new", new.keys() - old.keys())):
            if quantities := sorted({name.partition("[")[0] for name in names}):
                first = ", ".join(quantities[:4]) + ", ..." * (len(quantities) > 4)
                self.changed[f"{len(quantities)} quantities are {word}: {first}"].append(item)
        for name in old.keys() & new.keys():
            quantity = name.partition("[")[0]
            if old[name].dtype.kind == new[name].dtype.kind == "f":
                size, same = deviation(old[name], new[name], scales[name]), same_bits(old[name], new[name])
                if size > TOLERANCE:
                    self.beyond[item][name] = size
            else:
                size, same = 0.0, str(old[name]) == str(new[name])
                if not same:
                    self.changed[f"{quantity}: {old[name]} -> {new[name]}"].append(item)
            self.sizes[quantity].append(size)
            self.bits[quantity] += same

    def show(self, title: str, alone: Callable[[str], dict[str, float]]) -> None:
        """Print quantities, items beyond the tolerance and changes, the worst first.

        Args:
            title: of the part.
            alone: gives for an item the deviations by round-off.
        """
        arrays, out = sum(map(len, self.sizes.values())), sum(map(len, self.beyond.values()))
        print(
            f"\n{title}, {arrays} arrays: {sum(self.bits.values())} same bits, {out} beyond {TOLERANCE:g}; "
            f"{sum(map(len, self.changed.values()))} changes"
        )
        within = []
        for quantity, sizes in sorted(self.sizes.items(), key=lambda pair: -max(pair[1])):
            if max(sizes) > TOLERANCE:
                print(
                    f"  {quantity:45} {len(sizes):6} arrays, {self.bits[quantity]:6} same bits, "
                    f"{sum(size > TOLERANCE for size in sizes):5} beyond, largest {max(sizes):.1e}"
                )
            elif self.bits[quantity] < len(sizes):
                within.append(f"{quantity} {max(sizes):.1e}")
        if within:
            print(f"  within: {len(within)} quantities, largest {', '.join(within[:4])}")
        for item, result in sorted(self.beyond.items(), key=lambda pair: -max(pair[1].values())):
            own = alone(item)
            worst = sorted(result, key=lambda name: -result[name])[:4]
            known = {name: f" (round-off {size:.1e})" for name, size in own.items()}
            names = ", ".join(f"{name} {result[name]:.1e}{known.get(name, '')}" for name in worst)
            print(f"  beyond: {item}, {len(result)} arrays: {names}")
        for message, items in self.changed.items():
            names = ", ".join(items[:8]) + ", ..." * (len(items) > 8)
            print(f"  changed in {len(items)}: {message} ({names})")


def compare(options: argparse.Namespace) -> int:
    """Compare two records; returns 1 where anything is beyond the tolerance or has changed."""
    holds = True
    for part in options.part or COMPUTED:
        before = {path.stem: path for path in sorted((options.before / part).glob("*.npz"))}
        both = {item: path for item in before if (path := options.after / part / f"{item}.npz").exists()}
        result = Comparison()
        for item, path in both.items():
            result.add(item, read(before[item], options.skip), read(path, options.skip))

        def alone(item: str, part: str = part, before: dict[str, Path] = before) -> dict[str, float]:
            path = options.round_off and options.round_off / part / f"{item}.npz"
            if not path or not path.exists():
                return {}
            old, new = read(before[item]), read(path)
            known = {name: size for name, size in scales_of(old).items() if name in new}
            return {name: deviation(old[name], new[name], size) for name, size in known.items()}

        if before:
            result.show(f"{part}: {len(both)} of {len(before)} items", alone)
        holds &= not result.beyond and not result.changed and not (options.all and len(both) < len(before))
    print("\nnothing beyond" if holds else "\nDEVIATIONS")
    return int(not holds)


def main() -> int:
    """Read the arguments and run a subcommand."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    commands = parser.add_subparsers(required=True)
    single = commands.add_parser("record", help="compute and write what is missing")
    single.add_argument("folder", type=Path)
    single.add_argument("--items", type=Path, help="record whose items are computed")
    single.add_argument("--first", type=int, default=0, help="place of the first item of each part")
    single.add_argument("--motors", type=int, help="how many items of each part; default: all")
    single.add_argument("--share", type=float, default=1.0, help="random share of the items")
    single.add_argument("--workers", type=int, default=2)
    single.add_argument("--data", type=Path, help=f"folder of measured data; default: {DATA}")
    single.add_argument("--nudge", action="store_true", help="make every tip longer by 4 eps")
    single.set_defaults(work=record)
    two = commands.add_parser("compare", help="hold a record against another")
    two.add_argument("before", type=Path)
    two.add_argument("after", type=Path)
    two.add_argument("--skip", action="append", default=[], metavar="REGEX", help="quantities to leave out")
    two.add_argument("--all", action="store_true", help="items that AFTER lacks are a failure")
    two.add_argument("--round-off", type=Path, help="record made by --nudge")
    two.set_defaults(work=compare)
    for each in (single, two):
        each.add_argument("--part", action="append", choices=[*COMPUTED], help="default: all")
    options = parser.parse_args()
    status: int = options.work(options)
    return status


if __name__ == "__main__":
    sys.exit(main())
