"""Bad arguments of the functions that this package adds: a sentence that names one."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from support.bad_arguments import assert_name_of_a_law_refused, assert_refused_by_a_sentence, laws_of

import contactlab as cl

CALLS: dict[str, dict[str, Any]] = {
    "bench": {"setups": [], "output": None, "progress": None, "workers": 0},
    "fit": {"setups": (), "data": "nowhere.csv", "output": None, "progress": None},
    "identify": {
        "law": cl.Newton(), "mass": 1e-3, "restitution": "0.8 @ 0.5 m/s", "contact_time": None,
        "materials": None, "radius": None, "friction_angle": None, "free": None, "tolerance": 1e-6,
    },
    "validate": {"setups": (), "data": "nowhere.csv", "output": None, "progress": None},
    "read_impacts": {"path": "nowhere.csv"},
    "read_measurements": {"path": "nowhere.csv"},
    "write_impacts": {"impacts": None, "path": "nowhere/impacts.csv"},
}  # fmt: skip
"""Arguments of functions. Those that would compute for long have one that is refused at last."""


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
        (lambda: cl.bench([]), ValueError, "law"),
        (lambda: cl.bench("newton"), TypeError, "setups"),
        (lambda: cl.fit(data=None), TypeError, "data"),
        (lambda: cl.identify(cl.Newton(), restitution=(0.7, 3e9), mass=1e-3), ValueError, "speed"),
    ],
)
def test_a_fault_is_named(call: Callable[[], Any], kind: type[Exception], key: str) -> None:
    with pytest.raises(kind, match=key):
        call()
