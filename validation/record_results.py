"""Record the results of all studies, so that changed code can be held against them.

    record_results.py record FOLDER [--only REGEX] [--items OTHER] [--share S] [--workers N]
                                    [--data FOLDER] [--nudge]
    record_results.py compare BEFORE AFTER [--only REGEX] [--skip REGEX] [--round-off FOLDER]

`record` writes one file an item, FOLDER/STUDY/ITEM.npz: all numbers of the dataset that the study gives, by
flat names, and texts such as the kind of a motion. An item that raises records the exception's type. Items
that are there are not computed again, so that a recording that was stopped goes on. What the items are (the
study, overrides of the command line, options) is kept in FOLDER/items.json; `--items BEFORE` takes those of
another record. `--share 0.1` takes a random tenth. `--nudge` makes every tip longer by 4 eps, to see what
round-off becomes.

`compare` prints for every study how many arrays have the same bits and how many deviate by more than 1e-9
of their quantity's scale; then the items beyond, each with the deviation by round-off if a record by
`--nudge` is given, and the texts, shapes and exceptions that changed. The exit status is 1 if there is any.
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
from collections import defaultdict
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from tempfile import gettempdir
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.append(str(Path(__file__).resolve().parents[1] / "experiments"))

import numpy as np
import xarray
from ellipses import convert
from random_configuration import random_configuration

import contactlab as cl
from contactlab.laws import LAWS, PARTS

Item = dict[str, Any]
"""What is computed: 'id', which begins with the study, 'overrides' of the command line, and options."""

TOLERANCE = 1e-9
"""Deviation over the scale of a quantity up to which two results are equal."""

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"

SCALED_TOGETHER = (
    r"\w+_(?:energy|work|loss)|energy_residual|least_remainder|most_remainder",
    r"(?:normal|friction)_force",
    r"gap|tip_(?:normal|tangential)_displacement",
    r"rotor_velocity|rotor_angle|(?:approach|separation)_velocity",
    r"(?:normal|friction)_impulse|total_(?:friction_)?impulse",
    r"start_time|duration|stick_duration",
    r"\w+_power|balance",
)
"""Quantities with one scale: the largest magnitude in the item of all in one group that match one pattern."""

# ------------------------------------------------------------------------------------------------------------
# Items.

SEED = 27
LONGEST = {"longest": 400}
"""Longest run without an orbit [periods of the drive]."""

EVERY_LAW = {name: [f"law={name}"] for name in LAWS if name != "composed"} | {
    f"{part}_{name}": ["law=composed", f"law/{part}={name}"]
    for part, names in PARTS.items()
    for name in names
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

WIDE = 150
"""Drawn motors that are far wider than realistic ones: a fifth of them is refused."""


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


def wide_motors() -> Iterator[tuple[int, list[str]]]:
    """Draw motors over all laws, parts and keys."""
    for number in range(WIDE):
        groups, values = random_configuration(number, SEED)
        text = [f"{group}={option}" for group, option in groups.items()]
        yield number, text + [f"{key}={'null' if x is None else repr(x)}" for key, x in values.items()]


def items() -> Iterator[Item]:
    """Every law in every study, drawn motors, bodies made in Python, measured data."""
    rng = np.random.default_rng(SEED)
    short = ["solver.duration=2e-3", "record.interval=1e-5"]
    for name, law in EVERY_LAW.items():
        yield {"id": f"impact/{name}", "overrides": law}
        yield {"id": f"simulate/{name}", "overrides": [*law, *short]}
        for number in range(3):
            yield {"id": f"simulate/{name}_{number}", "overrides": [*law, *mild_motor(rng), *short]}
        yield {"id": f"steady/{name}", "overrides": law, "options": LONGEST}
        yield {"id": f"steady/{name}_drawn", "overrides": [*law, *mild_motor(rng)], "options": LONGEST}
        yield {"id": f"characterise/{name}", "overrides": law, "options": {}}
    for number, text in wide_motors():
        yield {"id": f"simulate/wide_{number:03}", "overrides": [*text, *short]}
    some = [EVERY_LAW[name] for name in ("newton", "hertz_penalty", "normal_prony", "friction_lugre")]
    for law in some:
        name = law[-1].rpartition("=")[2]
        yield {"id": f"simulate/pieces_{name}", "overrides": [*law, "solver.duration=7e-4"], "pieces": 3}
        until = {"until": "steady", "duration": 0.5, "record_interval": 1e-4}
        yield {"id": f"simulate/until_{name}", "overrides": law, "options": until}
        for key, value in (("belt", -1.0), ("load", 1e-3), ("brake", 2e-3), ("brake", 0.01)):
            options = {**LONGEST, key: value}
            yield {"id": f"steady/{key}_{value:g}_{name}", "overrides": law, "options": options}
        options = {"parameter": "contact.clearance", "start": 1e-6, "end": 1.1e-6}
        yield {"id": f"branch/{name}", "overrides": law, "options": options}
        for body, (arguments, duration) in BODIES.items():
            run = {"options": {"duration": duration, "record_interval": duration / 2e3}}
            yield {"id": f"simulate/{body}_{name}", "overrides": law, "motor": [body, arguments]} | run
    axes = {"rotor_velocity": [-3.0, -1.0, 1.0, 3.0], "drive_phase": [0.0, 0.25, 0.5, 0.75]}
    for law in some[:2]:
        text = [*law, "contact.clearance=2.5e-6"]
        yield {"id": f"basins/{law[0][4:]}", "overrides": text, "options": {"axes": axes}}
    over = {
        "law": ["newton", "lagrange_slip", "poisson", "hertz_penalty", "archard"],
        "drive.phase": np.linspace(-3.0, 3.0, 10).tolist(),
        "contact.clearance": [0.0, 1e-6],
    }
    lines = ["solver.duration=1.5e-3", "record.interval=2e-6"]
    options = {"over": over, "series": ["rotor_velocity"], "metrics": "all", "workers": 1}
    yield {"id": "sweep/phases", "overrides": lines, "options": options}
    pair = {"laws": ["newton", "hertz_penalty"], "options": {"samples": 8, "starts": 2}}
    yield {"id": "compare/settled", "overrides": [*short]} | pair
    few = {"points": 50, "starts": 4, "seed": SEED}
    yield {"id": "fit/ellipses", "data": "ellipse_impacts.mat", "laws": ["newton", "brach"], "options": few}
    for seed in range(2):
        options = {"folds": 3, "seed": seed}
        yield {"id": f"validate/ellipses_{seed}", "data": "ellipse_impacts.mat", "options": options}


# ------------------------------------------------------------------------------------------------------------
# What a study gives.

MATRICES = ([[800, 0], [0, 2800]], [[800, 500], [500, 1500]], [[28, -12], [-12, 60]])
SPEEDS = (2e-3, 0.02, 0.08, 0.4, 2.0)
SLIPS = (-1.5, -0.06, -1e-3, 0.0, 2e-3, 0.03, 0.7)
"""Impacts: Delassus matrices of motors and of a disc [1/kg], approach and slip velocities [m/s]."""


def result_of(item: Item) -> xarray.DataTree:
    """Compute an item by the package."""
    study, options = item["id"].partition("/")[0], item.get("options", {})
    if "data" in item:
        laws = {"setups": [cl.law(name) for name in item["laws"]]} if "laws" in item else {}
        data: xarray.DataTree = getattr(cl, study)(data=data_file(item["data"]), **laws, **options).data
        return data
    text = item["overrides"]
    if study == "sweep":
        over, rest = options["over"], {key: x for key, x in options.items() if key != "over"}
        return xarray.DataTree(cl.sweep(over, text, **rest))
    if study == "compare":
        return cl.compare([cl.build([*text, f"law={law}"]) for law in item["laws"]], **options).data
    setup = cl.build(text)
    if study == "impact":
        every = [*itertools.product(MATRICES, SPEEDS, SLIPS)]
        return xarray.DataTree(cl.impact(setup.law, [m for m, *_ in every], [(-u, v) for _, u, v in every]))
    if study != "simulate":
        made: xarray.DataTree = getattr(cl, study)(setup, **options).data
        return made
    if "motor" in item:
        body, arguments = item["motor"]
        return cl.simulate(getattr(cl, body)(**arguments), setup.law, **options).tree
    run = cl.simulate(setup, **options)
    for _ in range(1, item.get("pieces", 1)):
        run = cl.simulate(start=run, **options)
    return run.tree


def flat(tree: xarray.DataTree) -> dict[str, Any]:
    """Return the numbers and single texts of a dataset by flat names, one for each label of a dimension."""
    values: dict[str, Any] = {}
    for node in tree.subtree:
        data = node.to_dataset(inherit=False)
        labelled = [str(d) for d in data.dims if d in data.coords and data[d].dtype.kind in "OU"]
        for name, variable in data.variables.items():
            inner = [dim for dim in labelled if dim in variable.dims and dim != name]
            array = variable.transpose(*inner, ...).values
            for place in np.ndindex(*(data.sizes[dim] for dim in inner)):
                labels = "".join(f"[{data[dim].values[i]}]" for dim, i in zip(inner, place, strict=True))
                key = f"{node.path}/{'share/' * (variable.attrs.get('units') == '1')}{name}{labels}"
                if array.dtype.kind in "OU":
                    texts = "|".join(map(str, np.ravel(array[place])))
                    # Sentences may be worded anew.
                    if " " not in texts:
                        values[key] = texts
                elif array.dtype.kind in "fiub":
                    # Of a conjugate pair either may come first.
                    values[key] = abs(array[place]) if "imaginary" in key else array[place]
    return values


# ------------------------------------------------------------------------------------------------------------
# Recording.


def data_file(name: str) -> Path:
    """Return the path of measured data, of a MATLAB file that of its CSV."""
    path = Path(os.environ.get("RECORD_DATA", DATA)) / name
    if path.suffix != ".mat":
        return path
    written = Path(gettempdir()) / f"{path.stem}.{os.getpid()}.csv"
    if not written.exists():
        convert(path, written)
    return written


def _write(path: Path, content: bytes) -> None:
    """Write a file, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}")
    partial.write_bytes(content)
    partial.replace(path)


def recorded(item: Item, folder: Path) -> str:
    """Compute one item and write its file; returns the exception, empty for none, and the seconds."""
    began, fault = time.perf_counter(), ""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            values = flat(result_of(item))
        except Exception as error:
            fault, values = f"{type(error).__name__}: {error}"[:120], {"exception": type(error).__name__}
    arrays: dict[str, Any] = {
        k: x if isinstance(x, str) else np.array(x, np.float64) for k, x in values.items()
    }
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    _write(folder / f"{item['id']}.npz", stream.getvalue())
    return f"{time.perf_counter() - began:.1f} s {fault}"


def _nudged(item: Item) -> Item:
    length = cl.build(item["overrides"]).motor.geometry.tip_length * (1.0 + 4.0 * float(np.finfo(float).eps))
    return item | {"overrides": [*item["overrides"], f"contact.tip_length={length!r}"]}


def record(options: argparse.Namespace) -> int:
    """Compute what is missing; returns the exit status."""
    if options.data:
        os.environ["RECORD_DATA"] = str(options.data.resolve())
    place = options.folder / "items.json"
    source = place if place.exists() or options.items is None else options.items / "items.json"
    every = json.loads(source.read_text(encoding="utf-8")) if source.exists() else [*items()]
    if not place.exists():
        _write(place, json.dumps(every, indent=1).encode())
    chosen = [item for item in every if re.search(options.only, item["id"])]
    picks = np.random.default_rng(0).random(len(chosen)) < options.share
    left = []
    for item in itertools.compress(chosen, picks):
        if "data" in item and not data_file(item["data"]).exists():
            print(f"{item['id']} is skipped: there is no {item['data']}")
        elif not (options.folder / f"{item['id']}.npz").exists():
            left.append(_nudged(item) if options.nudge and "overrides" in item else item)
    print(f"{len(left)} of {len(every)} items to compute", flush=True)
    with ProcessPoolExecutor(options.workers) as pool:
        futures = {pool.submit(recorded, item, options.folder): item["id"] for item in left}
        for count, future in enumerate(as_completed(futures), 1):
            print(f"{count}/{len(left)} {futures[future]}: {future.result()}", flush=True)
    return 0


# ------------------------------------------------------------------------------------------------------------
# Comparing.


def _scale_key(name: str) -> str:
    """Return what the quantities of one scale have in common; an error has the scale of its number."""
    group, _, quantity = name.partition("[")[0].rpartition("/")
    quantity = re.sub(r"_(?:error|interval)\b", "", quantity)
    for at, pattern in enumerate(SCALED_TOGETHER):
        if re.fullmatch(pattern, quantity):
            return f"{group} {at}"
    return re.sub(r"_(?:error|interval)\b", "", name)


def deviations(old: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, float]:
    """Return the largest difference over the scale by name; infinite where a shape or a NaN differs."""
    scales: dict[str, float] = defaultdict(float)
    for name, array in old.items():
        least = 1.0 if "/share/" in name else 0.0
        sizes = np.abs(array[np.isfinite(array)])
        scales[_scale_key(name)] = max(scales[_scale_key(name)], least, float(sizes.max(initial=0.0)))
    result = {}
    for name in old.keys() & new.keys():
        before, after, scale = old[name], new[name], scales[_scale_key(name)]
        here = np.isfinite(before)
        if before.shape != after.shape or not np.array_equal(before[~here], after[~here], equal_nan=True):
            result[name] = np.inf
            continue
        size = float(np.nan_to_num(np.abs(before[here] - after[here]), nan=np.inf).max(initial=0.0))
        result[name] = size / scale if scale > 0.0 else np.inf if size > 0.0 else 0.0
    return result


def read(path: Path, skip: str = "") -> tuple[dict[str, Any], dict[str, str]]:
    """Return the arrays and the texts in the file of an item, without names of a pattern."""
    with np.load(path, allow_pickle=False) as file:
        values = {name: file[name] for name in file if not (skip and re.search(skip, name))}
    texts = {name: str(x) for name, x in values.items() if x.dtype.kind == "U"}
    return {name: x for name, x in values.items() if name not in texts}, texts


def compare(options: argparse.Namespace) -> int:
    """Compare two records; returns 1 where anything is beyond the tolerance or has changed."""
    counts: dict[str, list[int]] = defaultdict(lambda: [0, 0, 0, 0])
    lines = []
    for path in sorted(options.before.glob("*/*.npz")):
        name = path.relative_to(options.before).with_suffix("").as_posix()
        other = options.after / f"{name}.npz"
        if not other.exists() or not re.search(options.only, name):
            continue
        (old, texts), (new, others) = read(path, options.skip), read(other, options.skip)
        sizes = deviations(old, new)
        beyond = {key: size for key, size in sizes.items() if size > TOLERANCE}
        count = counts[name.partition("/")[0]]
        bits = sum(np.array_equal(old[key], new[key], equal_nan=True) for key in sizes)
        for i, number in enumerate((1, len(sizes), bits, len(beyond))):
            count[i] += number
        changed = [f"{key}: {texts.get(key)} -> {others.get(key)}" for key in texts.keys() | others.keys()]
        changed = [each for each in changed if len({*each.partition(": ")[2].split(" -> ")}) > 1]
        if missing := sorted(old.keys() ^ new.keys()):
            changed.append(f"{len(missing)} quantities are missing or new: {', '.join(missing[:4])}")
        lines += [f"changed: {name}: {each}" for each in changed]
        if beyond:
            apart = options.round_off and options.round_off / f"{name}.npz"
            alone = deviations(old, read(apart)[0]) if apart and apart.exists() else {}
            worst = sorted(beyond, key=lambda key: -beyond[key])[:4]
            known = {key: f" (round-off {alone[key]:.1e})" for key in worst if key in alone}
            text = ", ".join(f"{key} {beyond[key]:.1e}{known.get(key, '')}" for key in worst)
            lines.append(f"beyond: {name}, {len(beyond)} arrays: {text}")
    for study, (number, arrays, bits, out) in counts.items():
        print(f"{study}: {number} items, {arrays} arrays: {bits} same bits, {out} beyond {TOLERANCE:g}")
    print(*lines, "DEVIATIONS" if lines else "nothing beyond", sep="\n")
    return int(bool(lines))


def main() -> int:
    """Read the arguments and run a subcommand."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    commands = parser.add_subparsers(required=True)
    single = commands.add_parser("record", help="compute and write what is missing")
    single.add_argument("folder", type=Path)
    single.add_argument("--items", type=Path, help="record whose items are computed")
    single.add_argument("--share", type=float, default=1.0, help="random share of the items")
    single.add_argument("--workers", type=int, default=2)
    single.add_argument("--data", type=Path, help=f"folder of measured data; default: {DATA}")
    single.add_argument("--nudge", action="store_true", help="make every tip longer by 4 eps")
    single.set_defaults(work=record)
    two = commands.add_parser("compare", help="hold a record against another")
    two.add_argument("before", type=Path)
    two.add_argument("after", type=Path)
    two.add_argument("--skip", default="", metavar="REGEX", help="quantities to leave out")
    two.add_argument("--round-off", type=Path, help="record made by --nudge")
    two.set_defaults(work=compare)
    for each in (single, two):
        each.add_argument("--only", default="", metavar="REGEX", help="items to take, as steady/")
    options = parser.parse_args()
    status: int = options.work(options)
    return status


if __name__ == "__main__":
    sys.exit(main())
