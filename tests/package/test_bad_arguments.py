"""Bad arguments of every public function: a sentence that names one, and the next good call is as before."""

from collections.abc import Callable
from inspect import isfunction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.bad_arguments import assert_name_of_a_law_refused, assert_refused_by_a_sentence, laws_of

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
    "ball": {"mass": 1.0, "height": 0.0, "speed": 0.0, "velocity": 0.0, "spin": 0.0, "table": None},
    "basins": {"motor": SETUP.motor, "axes": None, "law": None, "output": None, "progress": None},
    "belt": {"mass": 1.0, "stiffness": 1.0, "weight": 1.0, "belt_mass": None, "penetration": 0.0},
    "block": {"mass": 1.0, "height": 0.0, "weight": 0.0, "load_velocity": None, "base": None},
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
    "force_curve": {
        "law": cl.HertzPenalty(), "position": -TIME, "contact_point": 0.0, "baseline": 0.0, "tilt": 0.0,
        "cantilever_stiffness": -1.0,
    },
    "hertz_stiffness": {
        "tip_radius": 1e-3, "rotor_radius": 1.0, "youngs_modulus": 2e11, "poisson_ratio": 0.3,
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
    "orbit": {
        "motor": SETUP, "law": None, "belt": None, "contact_step": None, "tolerance": None, "start": None,
        "longest": 1, "stop": None,
    },
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
    "response": {
        "motors": SETUP, "parameter": "contact.clearance", "start": 1e-6, "end": 1e-6, "law": None,
        "quantity": "gap", "belt": None, "step": 0.1, "output": None, "progress": None,
    },
    "simulate": {
        "motor": SETUP, "law": None, "duration": None, "record_interval": None, "contact_step": None,
        "tolerance": None, "until": None, "precision": 0.5, "start": None, "progress": None,
    },
    "slider": {"mass": 1.0, "tip": cl.Sawtooth(), "weight": 1.0, "load": 0.0, "penetration": 0.0},
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
    "warm": {"law": cl.Newton(), "progress": None},
    "write_modes": {"modes": BEAM.modes, "path": "nowhere/modes.csv"},
}  # fmt: skip
"""Arguments of every public function. Those that would compute for long have one that is refused at last."""


def test_every_function_has_its_line() -> None:
    # The name of a law, and the function of a friction, are positional.
    assert {name for name in cl.__all__ if isfunction(getattr(cl, name))} == {*CALLS, "law", "friction"}


@pytest.mark.parametrize("name", CALLS)
def test_a_bad_argument_is_refused_by_a_sentence(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert_refused_by_a_sentence(getattr(cl, name), CALLS[name])


@pytest.mark.parametrize(
    ("name", "argument", "kind"), [(n, *each) for n in CALLS for each in laws_of(getattr(cl, n))]
)
def test_the_name_of_a_law_is_refused_with_the_call_that_makes_it(
    name: str, argument: str, kind: str
) -> None:
    assert_name_of_a_law_refused(getattr(cl, name), CALLS[name], argument, kind)


@pytest.mark.parametrize(
    ("call", "kind", "key"),
    [
        (lambda: cl.sweep(5), TypeError, "over"),  # type: ignore[arg-type]
        (lambda: cl.build(law="newton"), TypeError, "law"),  # type: ignore[call-arg]
        (lambda: cl.build("law=newton"), TypeError, "configuration"),
        (lambda: cl.steady(SETUP, start=5), TypeError, "start"),  # type: ignore[arg-type]
        (lambda: cl.tabor_number(-1.0, 1.0, 1.0, 1.0), ValueError, "radius"),
        (lambda: cl.hertz_stiffness(1e-3, -1e-4), ValueError, "rotor_radius"),
        (lambda: cl.law_names("sticky"), ValueError, "family"),
        (lambda: cl.friction(5), TypeError, "function"),  # type: ignore[arg-type]
    ],
)
def test_a_fault_is_named(call: Callable[[], Any], kind: type[Exception], key: str) -> None:
    with pytest.raises(kind, match=key):
        call()
