"""The text at the end of a run says what the run holds, in units that are handy to read."""

import dataclasses

import numpy as np
import pytest
from support.motors import default_motor, hertz
from support.synthetic import CONFIGURATION, synthetic_trajectory

from contactlab.engine import simulate
from contactlab.results.netcdf import to_datatree
from contactlab.results.summary import prefixed, summarise, summary_of


@pytest.mark.parametrize("clearance", [1e-6, 3e-5])
def test_the_free_reach_is_what_a_settled_tip_bridges(clearance: float) -> None:
    made = simulate(default_motor(clearance=clearance), hertz(), duration=6e-5, record_interval=5e-6)
    # A run that has settled, with nothing to touch.
    far = simulate(default_motor(clearance=3e-5), hertz(), duration=0.2, record_interval=5e-6)
    reach = 3e-5 - far.series["gap"][-2000:].min()
    assert to_datatree(made).attrs["free_reach"] == pytest.approx(reach, rel=2e-3)


def test_a_summary_has_the_law_contacts_forces_and_ledger_of_the_run() -> None:
    result = summary_of(to_datatree(synthetic_trajectory(), CONFIGURATION))
    assert {"law", "contacts", "rotor velocity", "peak normal force"} <= result.keys()
    assert result["peak normal force"] == "9 N"


@pytest.mark.parametrize("records", [1, 2])
def test_a_run_of_hardly_any_record_divides_by_nothing(records: int) -> None:
    whole = synthetic_trajectory(contact=False)
    trajectory = dataclasses.replace(
        whole,
        time=whole.time[:records],
        series={name: np.zeros(records) for name in whole.series},
        contact_mode=whole.contact_mode[:records],
    )
    summarise(to_datatree(trajectory, CONFIGURATION), wall_time=0.0)


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (2.0, "2 s"),
        (7200.0, "7200 s"),
        (4e-16, "4e-16 s"),
        (0.9999999e-3, "1 ms"),
        (248.31e-6, "248.3 µs"),
        (-2e-3, "-2 ms"),
        (0.0, "0 s"),
    ],
)
def test_a_time_is_read_in_its_own_unit(size: float, text: str) -> None:
    assert prefixed(size, "s") == text
