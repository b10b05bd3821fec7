"""A plan and a state are read as they were written, and nothing else is taken for one."""

import json
from dataclasses import asdict, replace
from typing import Any

import pytest

from contactlab.sweeps.batch import Outputs
from contactlab.sweeps.dataset import Axis
from contactlab.sweeps.plan import Plan
from contactlab.sweeps.reading import read_json
from contactlab.sweeps.state import Job, State
from contactlab.variables import CONTACT_MODE

STATE = State("complete", Job("k", ("a=1",), {"law": "newton", "law/x": None}, {"solver": {"duration": 1.0}}))
PLAN = Plan(
    axes=(Axis("contact.clearance", (0.0, 1e-6), "m", "clearance"), Axis("law", ("newton", "brach"))),
    samples=False,
    outputs=Outputs(("peak_force",), ("internal_wear",), (CONTACT_MODE,)),
    groups=("law",),
    choices=(("newton",), ("brach",)),
    bases=({"solver": {"until": None}}, {}),
    keep="runs",
)


@pytest.mark.parametrize("written", [STATE, PLAN, replace(STATE, reason="über"), replace(PLAN, chunk=3)])
def test_what_was_written_is_read_to_the_last_bit(written: Any) -> None:
    assert read_json(type(written), json.dumps(asdict(written))) == written


def test_what_another_version_has_written_beside_it_is_left_out() -> None:
    assert read_json(State, json.dumps({**asdict(STATE), "times": [1.0]})) == STATE


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        (State, ""),
        (State, b"\xff"),
        (State, "[]"),
        (State, "[" * 100_000),
        (State, '{"state": "complete"}'),
        (State, '{"state": 1, "job": {}}'),
        (State, '{"state": "complete", "job": {"overrides": "a=1"}}'),
        (State, '{"state": "complete", "job": {"choices": {"law": 1}}}'),
        (Plan, json.dumps({**asdict(PLAN), "keep": "nothing"})),
        (Plan, json.dumps({**asdict(PLAN), "chunk": 1.5})),
        (Plan, json.dumps({**asdict(PLAN), "samples": 0})),
        (Plan, json.dumps({**asdict(PLAN), "choices": [[None]]})),
    ],
)
def test_what_is_something_else_is_refused(kind: type, text: str | bytes) -> None:
    with pytest.raises(ValueError, match=r"."):
        read_json(kind, text)
