"""Every metric of runs that begin, end or lie in a contact, and of a contact that never opens."""

from functools import cache

import numpy as np
import pytest

from contactlab import config
from contactlab.metrics import INVARIANTS, METRICS, Run, assess
from contactlab.results.netcdf import to_datatree
from contactlab.results.summary import summarise
from contactlab.simulation import Solution
from contactlab.trajectory import Trajectory

LAWS = ("hertz_penalty", "lagrange_stick")
INTERVAL = 1e-6


@cache
def parts(law: str, pressed: bool) -> list[Trajectory]:
    """A run in four parts: until a contact, in it, to a later one, and to the end."""
    options = ["contact.preload=5", "rotor.bearing_damping=300"] if pressed else []
    setup = config.build([f"law={law}", "solver.duration=2e-3", *options])
    whole = setup.run(record_interval=INTERVAL)
    touching = np.flatnonzero(whole.contact_mode[1:] * whole.contact_mode[:-1])
    first = int(touching[3]) + 1
    cuts = [first, first + 5, int(touching[2 * touching.size // 3]) + 1, whole.time.size - 1]
    runs: list[Trajectory] = []
    for before, cut in zip([0, *cuts], cuts, strict=False):
        start = {"start": runs[-1].state} if runs else {}
        duration = (cut - before) * INTERVAL
        runs.append(setup.run(duration=duration, record_interval=INTERVAL, **start))
    return runs


windows = [(law, pressed, number) for law in LAWS for pressed in (False, True) for number in range(4)]


@pytest.mark.parametrize(("law", "pressed", "number"), windows)
def test_no_window_breaks_an_invariant(law: str, pressed: bool, number: int) -> None:
    run = parts(law, pressed)[number]
    configuration = config.build([f"law={law}"]).configuration
    tree = to_datatree(run, configuration)
    for values in (assess(tree), assess(Run.of_trajectory(run, configuration))):
        failed = [key for key in INVARIANTS if METRICS[key].verdict(values[key]) == "fail"]
        assert not failed
        assert values["contact_time"] <= run.duration * (1.0 + 1e-9)
        assert not values["total_impulse"] > 1.0001 * np.sum(run.series["normal_force"][1:]) * INTERVAL
    assert "N s" in summarise(tree)


@pytest.mark.parametrize(("law", "pressed"), [(law, pressed) for law in LAWS for pressed in (False, True)])
def test_sums_of_windows_are_those_of_the_whole(law: str, pressed: bool) -> None:
    runs = parts(law, pressed)
    whole = runs[0]
    for run in runs[1:]:
        whole = whole.followed_by(run)
    for key in ("total_impulse", "total_friction_impulse", "contact_time"):
        values = [assess(Run.of_trajectory(run, {}), {key})[key] for run in (*runs, whole)]
        assert np.nansum(values[:-1]) == pytest.approx(values[-1], rel=1e-9), key


@pytest.mark.parametrize(("law", "pressed"), [(law, pressed) for law in LAWS for pressed in (False, True)])
def test_a_slice_of_a_file_breaks_no_invariant(law: str, pressed: bool) -> None:
    runs = parts(law, pressed)
    whole = runs[0].followed_by(runs[1]).followed_by(runs[2]).followed_by(runs[3])
    tree = to_datatree(whole, config.build([f"law={law}"]).configuration)
    cuts = np.cumsum([round(run.duration / INTERVAL) for run in runs])
    for first, last in ((cuts[0], cuts[1]), (cuts[0], cuts[2]), (0, cuts[1])):
        part = tree.copy()
        part.dataset = tree.to_dataset(inherit=False).isel(time=slice(int(first), int(last) + 1))
        values = assess(part)
        assert not [key for key in INVARIANTS if METRICS[key].verdict(values[key]) == "fail"]
        force = part["normal_force"].values[1:] @ np.diff(part["time"].values)
        assert values["total_impulse"] == pytest.approx(force, rel=1e-9)
    assert Solution(tree).contacts.sizes["contact"] >= 1


def test_the_force_of_a_rigid_contact_is_told_apart_from_its_impacts() -> None:
    run = parts("lagrange_stick", False)[2]
    values = assess(Run.of_trajectory(run, config.build(["law=lagrange_stick"]).configuration))
    assert np.isnan(values["peak_force"])
    assert 0.0 < values["peak_lasting_force"] < np.inf
    assert values["largest_impact"] == run.contacts_within["largest_impact"].max() > 0.0
    assert values["equivalent_impact_force"] > 0.0
    assert values["impact_gain"] == pytest.approx(0.0, abs=1e-6)
    compliant = assess(Run.of_trajectory(parts("hertz_penalty", False)[2], {}))
    assert compliant["peak_lasting_force"] == compliant["peak_force"]
    assert np.isnan(compliant["largest_impact"])
