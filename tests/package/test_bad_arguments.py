"""Bad arguments of every public function: a sentence that names one, and the next good call is as before."""

import traceback
from collections.abc import Callable
from inspect import isfunction, signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contactlab as cl

TIME = np.linspace(0.0, 1e-3, 21)
SETUP = cl.build(["solver.duration=50 us"])
BEAM = cl.RitzResonator()
CHAIN = 1e8 * (2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1))

CALLS: dict[str, dict[str, Any]] = {
    "add_residual_modes": {
        "modes": BEAM.modes, "mass": np.diag([BEAM.tip_mass, BEAM.tip_inertia]),
        "flexibility": np.diag([1e-7, 0.01]), "voltage_response": None, "damping": None,
    },
    "at_rest": {"motor": cl.ball(1e-3), "law": cl.HertzPenalty()},
    "attractors": {"motor": SETUP, "count": 1, "seed": 0, "law": None, "velocity": None, "longest": 1},
    "ball": {"mass": 1.0, "height": 0.0, "speed": 0.0, "velocity": 0.0, "spin": 0.0, "gravity": 9.81},
    "basins": {"motor": SETUP.motor, "axes": None, "law": None, "output": None, "progress": None},
    "belt": {"mass": 1.0, "stiffness": 1.0, "weight": 1.0, "belt_mass": None, "penetration": 0.0},
    "bench": {"setups": [], "output": None, "progress": None, "workers": 0},
    "block": {"mass": 1.0, "height": 0.0, "weight": 0.0, "load_velocity": None, "touching": False},
    "branch": {
        "motor": SETUP, "parameter": "contact.clearance", "start": 1e-6, "end": 1e-6, "law": None,
        "belt": None, "step": 0.1, "output": None, "progress": None,
    },
    "build": {"configuration": ["law=newton"], "config_dir": None},
    "cantilever": {"length": 0.1, "material": None, "modes": 4, "damping_ratio": 0.0, "gap": 0.0},
    "characterise": {"motors": [], "law": None, "output": None, "progress": None},
    "collect": {"directory": "nowhere", "output": None, "series": (), "metrics": ()},
    "compare": {"sources": [], "law": None, "output": None, "progress": None},
    "converged": {"motor": SETUP, "law": None, "start": None, "output": None, "longest": 1},
    "drive": {
        "law": cl.HertzPenalty(), "time": TIME, "gap": -1e-6, "slip": 1e-6 * np.sin(6e3 * TIME), "degree": 3,
        "period": None, "touching": False, "duration": None, "record_interval": None, "tolerance": -1.0,
        "progress": None,
    },
    "fit": {"setups": (), "data": "nowhere.csv", "output": None, "progress": None},
    "hertz_stiffness": {
        "tip_radius": 1e-3, "rotor_radius": 1.0, "youngs_modulus": 2e11, "poisson_ratio": 0.3,
    },
    "identify": {
        "law": cl.Newton(), "mass": 1e-3, "restitution": "0.8 @ 0.5 m/s", "contact_time": None,
        "materials": None, "radius": None, "friction_angle": None, "free": None, "tolerance": 1e-6,
    },
    "impact": {
        "law": cl.Newton(), "delassus": [[1.0, 0.0], [0.0, 3.5]], "velocity_before": [-1.0, 0.5],
        "tolerance": None, "history": 0,
    },
    "law_names": {"family": ""},
    "load": {"path": "nowhere.nc"},
    "normal_impact": {"law": cl.Newton(), "speed": [0.1], "mass": 2e-3, "tolerance": None},
    "on_bearing": {"motor": SETUP.motor, "bearing": cl.Bearing(0.1, 1.0)},
    "oscillator": {"mass": 1.0, "stiffness": 1.0, "damping": 0.0, "gap": 0.0, "frequency": 1.0},
    "read_modes": {"path": "nowhere.csv", "tip_length": 1.0, "most": None},
    "read_universal": {
        "path": "nowhere.unv", "node": 1, "coupling": np.ones((1, 1)), "towards": (0.0, 1.0, 0.0),
        "along": (1.0, 0.0, 0.0), "tip_length": 1.0,
    },
    "reduced": {
        "mass": np.eye(3), "stiffness": CHAIN, "uy": np.eye(3)[2], "ux": np.eye(3)[2],
        "coupling": np.eye(3)[:, :1], "modes": 1, "damping_ratio": 0.01, "tip_length": 1e15,
        "static_correction": True, "points": None,
    },
    "simulate": {
        "motor": SETUP, "law": None, "duration": None, "record_interval": None, "contact_step": None,
        "tolerance": None, "until": None, "precision": 0.5, "start": None, "progress": None,
    },
    "steady": {
        "motor": SETUP, "law": None, "contact_step": None, "tolerance": None, "start": None, "refine": False,
        "output": None, "progress": None, "longest": 1,
    },
    "sweep": {
        "over": {"law": []}, "base": (), "study": None, "metrics": None, "series": (), "output": None,
        "workers": 1, "progress": None,
    },
    "tabor_number": {
        "radius": 1e-3, "effective_modulus": 1e9, "work_of_adhesion": 0.1, "equilibrium_distance": 1e-9,
    },
    "validate": {"setups": (), "data": "nowhere.csv", "output": None, "progress": None},
    "write_modes": {"modes": BEAM.modes, "path": "nowhere/modes.csv"},
}  # fmt: skip
"""Arguments of every public function. Those that would compute for long have one that is refused at last."""

NO_NUMBER_OR_OBJECT: list[Any] = [
    *(None, True, 5, -1.0, np.nan, 1j, "newton", "10 mol", b"x", object(), cl.Newton, cl.Newton()),
    *([], [None], (1, 2), {}, {"a": object()}, {1: 2}, SETUP.motor),
    *(np.zeros(1), np.zeros((2, 2, 2)), np.array(["x"])),
]  # fmt: skip
"""Values of every kind: each is a bad one of most arguments."""

DOCUMENTED = (TypeError, ValueError, OSError, RuntimeError)
"""What public functions raise, subclasses of the package's own among them."""


def raised_by(function: Callable[..., Any], arguments: dict[str, Any]) -> Exception | None:
    """Return what a call raises."""
    try:
        function(**arguments)
    except Exception as error:
        return error
    return None


def is_refusal(error: Exception) -> bool:
    """Return whether an exception is raised by a statement of the package, or names a file."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    own = f"{Path(cl.__file__).parent}" in last.filename and (last.line or "").startswith("raise")
    return isinstance(error, DOCUMENTED) and (own or (isinstance(error, OSError) and bool(error.filename)))


def test_every_function_has_its_line() -> None:
    # The name of a law is positional.
    assert {name for name in cl.__all__ if isfunction(getattr(cl, name))} == {*CALLS, "law"}


@pytest.mark.parametrize("name", CALLS)
def test_a_bad_argument_is_refused_by_a_sentence(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    function: Callable[..., Any] = getattr(cl, name)
    for argument in CALLS[name]:
        for value in NO_NUMBER_OR_OBJECT:
            if error := raised_by(function, CALLS[name] | {argument: value}):
                assert is_refusal(error), (argument, value, repr(error))
                assert str(error).strip(), (argument, value)
    good = cl.impact(cl.Newton(restitution=0.8), [[1.0, 0.0], [0.0, 3.5]], [-1.0, 0.0])
    assert good["velocity_after"].values.tolist() == [[0.8, 0.0]]
    assert cl.build().motor.geometry.clearance == 1e-6


def laws_of(name: str) -> list[tuple[str, Any]]:
    """Return the arguments of a public function that take a law, each with its annotation."""
    annotations = {x.name: str(x.annotation) for x in signature(getattr(cl, name)).parameters.values()}
    return [(x, text) for x, text in annotations.items() if "ContactLaw" in text]


@pytest.mark.parametrize(("name", "argument", "kind"), [(n, *each) for n in CALLS for each in laws_of(n)])
def test_the_name_of_a_law_is_refused_with_the_call_that_makes_it(
    name: str, argument: str, kind: str
) -> None:
    many: list[Any] = [["newton"], [cl.Poisson(), "newton"]] if "Sequence" in kind else []
    many += [{"mine": "newton"}] if "Mapping" in kind else []
    for value in ["newton", *many]:
        with pytest.raises(TypeError, match=rf"{argument}\b.*contactlab\.law\('newton'\)"):
            getattr(cl, name)(**CALLS[name] | {argument: value})


@pytest.mark.parametrize(
    ("call", "kind", "key"),
    [
        (lambda: cl.bench([]), ValueError, "law"),
        (lambda: cl.bench("newton"), TypeError, "setups"),  # type: ignore[arg-type]
        (lambda: cl.sweep(5), TypeError, "over"),  # type: ignore[arg-type]
        (lambda: cl.build(law="newton"), TypeError, "law"),  # type: ignore[call-arg]
        (lambda: cl.build("law=newton"), TypeError, "configuration"),
        (lambda: cl.steady(SETUP, start=5), TypeError, "start"),  # type: ignore[arg-type]
        (lambda: cl.fit(data=None), TypeError, "data"),
        (lambda: cl.tabor_number(-1.0, 1.0, 1.0, 1.0), ValueError, "radius"),
        (lambda: cl.hertz_stiffness(1e-3, -1e-4), ValueError, "rotor_radius"),
        (lambda: cl.law_names("sticky"), ValueError, "family"),
    ],
)
def test_a_fault_is_named(call: Callable[[], Any], kind: type[Exception], key: str) -> None:
    with pytest.raises(kind, match=key):
        call()
