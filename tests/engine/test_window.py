"""Contacts cut to the window of the records, of runs that go on and of slices of a run."""

from functools import cache

import numpy as np
import pytest
from support.motors import case_a, every_law

from contactlab.engine import simulate
from contactlab.laws import ContactLaw
from contactlab.trajectory import Trajectory
from contactlab.window import cut_to_window

INTERVAL = 1e-6
WHOLE = 4e-4
CONTACTS = [*((law, None) for law in every_law()), (every_law()[1], 1e-6)]
"""Laws with the steps of time stepping; None is collocated."""
contacts = pytest.mark.parametrize(("law", "step"), CONTACTS, ids=lambda x: getattr(x, "title", None))


def run(law: ContactLaw, step: float | None, duration: float, **options: object) -> Trajectory:
    options.setdefault("record_interval", INTERVAL)
    return simulate(case_a(), law, duration=duration, contact_step=step, **options)  # type: ignore[arg-type]


@cache
def whole_run(law: ContactLaw, step: float | None) -> Trajectory:
    return run(law, step, WHOLE)


def cuts_within_a_contact(law: ContactLaw, step: float | None) -> list[int]:
    """Records at a third and at two thirds of the first contact that lasts for some records."""
    rows = whole_run(law, step).contacts
    for start, duration in zip(rows["start_time"], rows["duration"], strict=True):
        if duration > 6.0 * INTERVAL and start + duration < WHOLE:
            return [round((start + share * duration) / INTERVAL) for share in (1 / 3, 2 / 3)]
    pytest.skip("no contact of the law lasts")


def columns_of(run: Trajectory, span: slice = slice(None)) -> dict[str, np.ndarray]:
    every = {**run.series, "time": run.time, "contact_mode": run.contact_mode}
    return {name: values[span] for name, values in every.items()}


@contacts
def test_the_parts_of_a_contact_are_the_whole_contact(law: ContactLaw, step: float | None) -> None:
    first_cut, second_cut = cuts_within_a_contact(law, step)
    first = run(law, step, first_cut * INTERVAL)
    # A window that begins and ends in the contact, and one that begins in it.
    second = run(law, step, (second_cut - first_cut) * INTERVAL, start=first.state)
    third = run(law, step, WHOLE - second_cut * INTERVAL, start=second.state)
    parts = [
        {name: values[i] for name, values in each.contacts_within.items()}
        for each, i in ((first, -1), (second, 0), (third, 0))
    ]
    assert second.contacts_within["start_time"].size == 1
    i = int(np.searchsorted(whole_run(law, step).contacts["start_time"], first_cut * INTERVAL)) - 1
    whole = {name: values[i] for name, values in whole_run(law, step).contacts.items()}
    for name in ("duration", "stick_duration", "normal_impulse", "friction_impulse", "energy_loss"):
        total = sum(part[name] for part in parts)
        scale = sum(abs(part[name]) for part in parts) or 1.0
        assert total == pytest.approx(whole[name], abs=1e-9 * scale), name
    for name in ("peak_normal_force", "max_penetration"):
        # The forces where it is cut are among those of the parts.
        assert max(part[name] for part in parts) == pytest.approx(whole[name], rel=1e-3), name
        assert all(part[name] > 0.0 or whole[name] == 0.0 for part in parts), name
    for part, each in zip(parts, (first, second, third), strict=True):
        assert np.isnan(part["approach_velocity"]) == (each is not first)
        assert np.isnan(part["separation_velocity"]) == (each is not third)
    begins = [part["start_time"] for part in parts[1:]]
    assert begins == pytest.approx([second.time[0], third.time[0]], rel=1e-12)
    joined = first.followed_by(second).followed_by(third)
    assert not joined.part
    later = second.followed_by(third).contacts_within
    assert later["normal_impulse"][0] == pytest.approx(
        parts[1]["normal_impulse"] + parts[2]["normal_impulse"], rel=1e-9
    )


@contacts
def test_the_peak_of_a_part_is_that_of_its_records(law: ContactLaw, step: float | None) -> None:
    first = run(law, step, cuts_within_a_contact(law, step)[1] * INTERVAL)
    rest = run(law, step, WHOLE - first.duration, start=first.state, record_interval=0.1 * INTERVAL)
    part = {name: values[0] for name, values in rest.contacts_within.items()}
    inside = rest.time[1:] <= part["start_time"] + part["duration"]
    largest = float(rest.series["normal_force"][1:][inside].max())
    lasting = part.get("peak_lasting_force", part["peak_normal_force"])
    assert largest <= lasting * (1.0 + 1e-6)
    # Time stepping holds its force, and so does a mean over a hundredth of a contact.
    assert largest == pytest.approx(lasting, rel=0.05)
    assert part["peak_normal_force"] < np.inf


@contacts
@pytest.mark.parametrize("edges", [(0, 1), (1, None), (0, None), (None, 0)])
def test_a_slice_of_a_run_has_the_parts_that_its_records_tell(
    law: ContactLaw, step: float | None, edges: tuple[int | None, int | None]
) -> None:
    cuts = cuts_within_a_contact(law, step)
    span = slice(*(None if edge is None else cuts[edge] + i for i, edge in enumerate(edges)))
    whole = whole_run(law, step)
    columns = columns_of(whole, span)
    rows = cut_to_window(columns, whole.contacts, {})
    time = columns["time"]
    impulse = float(columns["normal_force"][1:] @ np.diff(time))
    assert rows["normal_impulse"].sum() == pytest.approx(impulse, rel=1e-9)
    lost = np.ptp(columns["friction_loss"]) + np.ptp(columns["contact_loss"])
    assert rows["energy_loss"].sum() == pytest.approx(lost, rel=1e-6)
    assert rows["start_time"].min() >= time[0]
    assert (rows["start_time"] + rows["duration"]).max() <= time[-1] * (1.0 + 1e-12)
    touched = rows["duration"].sum()
    assert touched == pytest.approx(INTERVAL * np.count_nonzero(columns["contact_mode"][1:]), abs=1e-5)
