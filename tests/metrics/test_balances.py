"""A run that agrees with itself keeps every invariant; each way of disagreeing breaks its own."""

import re
from collections.abc import Callable

import numpy as np
import pytest
import xarray
from support.configurations import case_a_tree

import contactlab as cl
from contactlab.engine import simulate
from contactlab.laws import LAWS, LagrangeStick, MoreauJean, MultiplierLaw, Newton
from contactlab.metrics import INVARIANTS, assess
from contactlab.metrics.run import Run
from contactlab.motor import ball
from contactlab.testing import invariants_of

INTERVAL = 1e-6


def run_of(law: str = "hertz_penalty") -> xarray.DataTree:
    return case_a_tree(law, None, INTERVAL).copy(deep=True)


def broken(run: xarray.DataTree) -> set[str]:
    return {claim.statement.partition(":")[0] for claim in invariants_of(run) if not claim.holds}


@pytest.mark.parametrize("law", LAWS)
def test_case_a_keeps_every_invariant_under_every_law(law: str) -> None:
    claims = list(invariants_of(run_of(law)))
    # Where a contact begins is the law's own affair if it has limits, and an impact has no largest force.
    left_out = law == "archard" or issubclass(LAWS[law], MultiplierLaw)
    assert len(claims) == len(INVARIANTS) - left_out
    assert broken(run_of(law)) == set()


def contact(name: str, row: int, value: Callable[[float], float]) -> Callable[..., None]:
    def change(run: xarray.DataTree) -> None:
        column = run["contacts"][name].values
        column[row] = value(column[row])

    return change


def record(name: str, value: Callable[[xarray.DataTree], None]) -> Callable[..., None]:
    return lambda run: value(run[name].values)


def lower_deepest(values: np.ndarray) -> None:
    values[values.argmin()] -= 1e-7


def lose_more_at_the_end(values: np.ndarray) -> None:
    values[-1] *= 1.5


def sink_in_flight(run: xarray.DataTree) -> None:
    # The widest gap is far from every contact.
    run["gap"].values[run["gap"].values.argmax()] = -1e-8


def lengthen_into_the_next(run: xarray.DataTree) -> None:
    starts, durations = run["contacts/start_time"].values, run["contacts/duration"].values
    durations[2] = starts[3] - starts[2] + 1e-9


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (contact("separation_velocity", 4, lambda v: -abs(v)), {"closing_release"}),
        (contact("approach_velocity", 4, lambda v: -v), {"closing_release"}),
        (contact("peak_normal_force", slice(None), lambda v: v / 13.0), {"peak_deficit"}),
        (contact("normal_impulse", 4, lambda v: 1.01 * v), {"impulse_balance"}),
        (contact("friction_impulse", 4, lambda v: v + 1e-5), {"impulse_balance", "rotor_momentum"}),
        (contact("energy_loss", 4, lambda w: 1.01 * w), {"loss_balance"}),
        (record("friction_loss", lose_more_at_the_end), {"energy_residual", "loss_balance"}),
        (lengthen_into_the_next, {"phantom_contacts"}),
        (record("gap", lower_deepest), {"depth_deficit", "gap_mismatch"}),
        (sink_in_flight, {"missed_contact", "gap_mismatch"}),
    ],
)
def test_what_disagrees_is_found_and_nothing_else(
    change: Callable[[xarray.DataTree], None], expected: set[str]
) -> None:
    run = run_of()
    change(run)
    assert broken(run) == expected


def test_a_contact_of_no_length_is_a_phantom() -> None:
    run = run_of()
    rows = run["contacts"].to_dataset()
    empty = rows.isel(contact=[3]).copy(deep=True)
    empty["start_time"] -= 1e-5
    for name in ("duration", "stick_duration", "normal_impulse", "friction_impulse", "energy_loss"):
        empty[name] *= 0.0
    run["contacts"] = xarray.DataTree(xarray.concat([rows, empty], "contact"))
    assert broken(run) == {"phantom_contacts"}


def test_a_rotor_whose_load_and_damping_change_keeps_its_momentum() -> None:
    changes = "1 ms; rotor.load_torque=2 mN*m", "1.5 ms; rotor.damping=1e-4"
    text = ", ".join(map(repr, changes))
    run = cl.simulate(
        cl.build(["experiment=case_a", "solver.duration=2 ms", f"solver.changes=[{text}]"])
    ).tree
    assert assess(run, {"rotor_momentum"})["rotor_momentum"] < 1e-9
    # Without the changes its configuration is another motor's.
    other = run.copy()
    text = other.attrs["configuration"]
    other.attrs["configuration"] = re.sub(r"changes:\n(  - .*\n)+", "changes: null\n", text)
    assert assess(other, {"rotor_momentum"})["rotor_momentum"] > 1e-3


def test_the_angle_of_a_projection_is_judged_by_the_largest_damping_of_the_run() -> None:
    # Light and damped after the first tenth of the run only: its angle is off by a step of each change.
    changes = "0.2 ms; rotor.damping=1e-2"
    keys = ["law=lagrange_slip", "solver.contact_step=1 us", "solver.duration=2 ms", "rotor.damping=0"]
    keys += [f"solver.changes=['{changes}']", "rotor.inertia=2e-7", "contact.clearance=0"]
    ran = cl.simulate(cl.build(keys)).tree
    assert assess(ran, {"rotor_momentum"})["rotor_momentum"] <= INVARIANTS["rotor_momentum"].bound


def test_friction_that_is_no_digit_of_the_normal_force_is_no_momentum() -> None:
    run = run_of()
    rows, still = run["contacts"], np.zeros_like(run["rotor_velocity"].values)
    rows["friction_impulse"].values[:] = 1e-15 * rows["normal_impulse"].values
    run["rotor_velocity"].values[:], run["rotor_angle"].values[:] = still, still
    assert assess(run, {"rotor_momentum"})["rotor_momentum"] <= INVARIANTS["rotor_momentum"].bound
    rows["friction_impulse"].values[:] *= 1e6
    assert assess(run, {"rotor_momentum"})["rotor_momentum"] > 1e-4


def test_a_run_of_one_record_is_judged() -> None:
    run = run_of()
    groups = {"/": run.to_dataset().isel(time=[0]), "/contacts": run["contacts"].to_dataset(inherit=False)}
    first = xarray.DataTree.from_dict(groups)
    figures = assess(first, set(INVARIANTS))
    assert not [key for key, value in figures.items() if value > INVARIANTS[key].bound]


@pytest.mark.parametrize("law", [Newton(0.3, 0.6), MoreauJean(0.3, 0.6), LagrangeStick(0.3)])
def test_records_within_the_step_of_an_impact_lie_as_deep_as_a_constant_force_lets_them(
    law: MultiplierLaw,
) -> None:
    # A ball from 1 cm, whose impact takes a step of 1 ms: it sinks by v h / 2 at most, some 0.2 mm.
    step = 1e-3
    dropped = simulate(ball(0.1, height=0.01), law, duration=0.06, record_interval=1e-5, contact_step=step)
    deepest, speed = -dropped.series["gap"].min(), -dropped.contacts["approach_velocity"][0]
    assert 0.5 * speed * step / (1.0 + 0.6) - 1e-5 < deepest < 0.5 * speed * step
    run = Run.of_trajectory(dropped, {})
    assert assess(run, {"depth_deficit"})["depth_deficit"] == 0.0
    run.columns["gap"][run.columns["gap"].argmin()] -= speed * step
    assert assess(run, {"depth_deficit"})["depth_deficit"] > INVARIANTS["depth_deficit"].bound
