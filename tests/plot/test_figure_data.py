"""What is drawn is what was recorded."""

import numpy as np
import pytest
from support.synthetic import CONFIGURATION, CONTACT_DURATION, FREQUENCY, STICK_SHARE, synthetic_trajectory

import contactlab as cl
from contactlab.plot.overview import PERIODS
from contactlab.plot.recording import COLUMNS, Recording, contact_spans, envelope, recording_of
from contactlab.results.netcdf import Groups, to_groups


def spans_of(
    time: list[float], mode: list[int], rows: list[tuple[float, float, float]]
) -> dict[str, list[list[float]]]:
    """Spans for records and for contacts of start, duration and stick duration."""
    table = np.array(rows, dtype=float).reshape(-1, 3)
    names = ("start_time", "duration", "stick_duration")
    contacts = {name: table[:, i] for i, name in enumerate(names)}
    spans = contact_spans({"time": np.array(time), "contact_mode": np.array(mode)}, contacts)
    return {name: values.tolist() for name, values in spans.items()}


def test_a_contact_is_shaded_from_touch_down_to_release() -> None:
    spans = spans_of([0, 1, 2, 3, 4], [0, 1, 1, 0, 0], [(0.75, 1.5, 0.0)])
    assert spans == {"slip": [[0.75, 2.25]], "stick": []}


def test_modes_change_half_way_between_two_records() -> None:
    spans = spans_of([0, 1, 2, 3, 4], [0, 1, 2, 2, 1], [(0.75, 3.5, 1.8)])
    assert spans == {"slip": [[0.75, 1.5], [3.5, 4.25]], "stick": [[1.5, 3.5]]}


@pytest.mark.parametrize(("stick", "mode"), [(0.3, "stick"), (0.1, "slip")])
def test_a_contact_between_two_records_takes_the_mode_of_its_larger_part(stick: float, mode: str) -> None:
    spans = spans_of([0, 1, 2], [0, 0, 0], [(1.25, 0.5, stick)])
    assert spans[mode] == [[1.25, 1.75]]
    assert sum(map(len, spans.values())) == 1


def test_contacts_that_follow_each_other_stay_apart() -> None:
    spans = spans_of([0, 1, 2, 3], [1, 1, 2, 1], [(0, 1.25, 0), (1.5, 1.0, 1), (2.75, 1, 0)])
    assert spans == {"slip": [[0, 1.25], [2.75, 3.75]], "stick": [[1.5, 2.5]]}


@pytest.mark.parametrize("interval", [1e-6, 7e-6, 100e-6])
def test_spans_add_up_to_the_time_in_contact_at_any_record_interval(interval: float) -> None:
    run = recording_of(to_groups(synthetic_trajectory(interval=interval), CONFIGURATION))
    spans = np.concatenate(list(contact_spans(run.series, run.contacts).values()))
    spans = spans[np.argsort(spans[:, 0])]
    assert np.sum(spans[:, 1] - spans[:, 0]) == pytest.approx(float(run.contacts["duration"].sum()))
    assert np.all(spans[1:, 0] >= spans[:-1, 1] - 1e-15)


def test_stick_is_shaded_where_it_was_to_half_a_record() -> None:
    run = recording_of(to_groups(synthetic_trajectory(), CONFIGURATION))
    stick = contact_spans(run.series, run.contacts)["stick"]
    expected = run.contacts["start_time"][:, None] + CONTACT_DURATION * np.array(STICK_SHARE)
    np.testing.assert_allclose(stick, expected, atol=0.51e-6)


def shown(groups: Groups) -> Recording:
    """The last periods of a run."""
    run = recording_of(groups)
    return run.between(run.end - PERIODS * run.period, run.end)


def test_the_window_is_the_last_three_drive_periods() -> None:
    window = shown(to_groups(synthetic_trajectory(), CONFIGURATION))
    assert window.end == 5e-3
    assert window.end - window.start == pytest.approx(3.0 / FREQUENCY)
    assert window.series["time"][0] <= window.start < window.series["time"][1]
    assert window.contacts["start_time"].size == 3
    assert not window.coarse


def test_an_envelope_loses_no_peak() -> None:
    x = np.linspace(0.0, 1.0, 300_001)
    y = np.sin(x)
    y[[1234, 200_000]] = 7.0, -7.0
    short_x, short_y = envelope(x, y)
    assert short_x.size <= 4 * COLUMNS
    assert np.all(np.diff(short_x) >= 0.0)
    for index, peak in ((1234, 7.0), (200_000, -7.0)):
        assert abs(short_x[short_y == peak] - x[index]) <= 1.0 / COLUMNS
    assert (short_x[0], short_y[0]) == (x[0], y[0])
    assert (short_x[-1], short_y[-1]) == (x[-1], y[-1])


def test_an_envelope_draws_no_slope_across_a_step() -> None:
    x = np.linspace(0.0, 1.0, 300_001)
    y = np.where(x < 0.5, 0.0, 1.0)
    short_x, short_y = envelope(x, y)
    between = (short_x > 0.5 + 1.0 / COLUMNS) | (short_x < 0.5 - 1.0 / COLUMNS)
    np.testing.assert_array_equal(short_y[between], short_x[between] > 0.5)


@pytest.mark.parametrize("interval", [1e-6, 1e-7])
def test_an_impact_has_an_impulse_and_no_force_at_any_record_interval(interval: float) -> None:
    """A ball that bounces under its weight and comes to rest: stems of m v (1 + e), then the weight."""
    ball, law = cl.ball(1e-3, height=1e-9, gravity=9.81), cl.Newton(restitution=0.5)
    run = cl.simulate(ball, law, duration=2e-4, record_interval=interval)
    recording = recording_of(run.to_xarray())
    times, impulses = recording.impacts
    speeds = np.sqrt(2.0 * 9.81 * 1e-9) * 0.5 ** np.arange(times.size)
    np.testing.assert_allclose(impulses[:5], 1.5e-3 * speeds[:5], rtol=1e-6)
    lasting = recording.series["lasting_force"]
    assert lasting.max() <= 9.81e-3 * (1.0 + 1e-9)
    assert lasting[-1] == pytest.approx(9.81e-3, rel=1e-6)
    shown = {axes.get_ylabel(): axes for axes in run.plot().axes}
    assert shown["lasting force (N)"].get_ylim()[1] < 0.02
    stems = shown["impulse, dots (nN s)"].lines[0]
    np.testing.assert_allclose(np.sort(stems.get_ydata()), 1e9 * np.sort(impulses))
    # The line of the force lies on the wide stems, and ends below the largest.
    assert shown["lasting force (N)"].get_zorder() > shown["impulse, dots (nN s)"].get_zorder()
    assert not shown["lasting force (N)"].patch.get_visible()
    assert shown["impulse, dots (nN s)"].collections[-1].get_linewidth()[0] > 2.0
    assert lasting.max() / shown["lasting force (N)"].get_ylim()[1] < 0.7
    assert stems.get_ydata().max() / shown["impulse, dots (nN s)"].get_ylim()[1] > 0.9
    # All of the normal impulse is in one or the other.
    total = impulses.sum() + (lasting[1:] * np.diff(recording.time)).sum()
    assert total == pytest.approx(float(run.contacts["normal_impulse"].sum()), rel=1e-9)


def test_a_compliant_law_has_no_axis_of_impulses() -> None:
    run = cl.simulate(cl.build(), duration=5e-4)
    assert [axes.get_ylabel() for axes in run.plot().axes][-1] == "normal force (N)"
    assert recording_of(run.to_xarray()).impacts is None
