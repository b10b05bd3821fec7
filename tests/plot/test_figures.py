"""The overview of a run: what it shows, that it can be read, and that it never fails."""

import dataclasses
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
import xarray
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from support.pictures import boxes_in, offsets_in
from support.synthetic import CONFIGURATION, CONTACT_DURATION, synthetic_trajectory

import contactlab as cl
from contactlab.plot.overview import draw_overview, overview
from contactlab.plot.style import COLOURS
from contactlab.results.netcdf import to_datatree
from contactlab.trajectory import Ending


def diverged() -> xarray.DataTree:
    """A run that leaves the range of numbers."""
    whole = synthetic_trajectory(3.3e-3, ending=Ending.DIVERGED, message="The gap is no number.")
    series = {name: values.copy() for name, values in whole.series.items()}
    for name in ("tip_normal_displacement", "gap", "rotor_velocity", "normal_force"):
        series[name][-400:] *= np.exp(np.linspace(0.0, 690.0, 400))
        series[name][-5:] = np.inf, -np.inf, np.nan, np.nan, np.nan
    return to_datatree(dataclasses.replace(whole, series=series), CONFIGURATION)


def failed_at_once() -> xarray.DataTree:
    """A run with a single record."""
    whole = synthetic_trajectory(1e-6, contact=False, ending=Ending.DIVERGED)
    series = {name: values[:1] for name, values in whole.series.items()}
    trajectory = dataclasses.replace(
        whole, time=whole.time[:1], series=series, contact_mode=whole.contact_mode[:1]
    )
    return to_datatree(trajectory, CONFIGURATION)


def motionless() -> xarray.DataTree:
    """A run that nothing drives, without clearance."""
    whole = synthetic_trajectory(1e-3, contact=False)
    series = {name: np.zeros_like(values) for name, values in whole.series.items()}
    contact = {"clearance": 0.0, "tip_length": 19e-3}
    return to_datatree(dataclasses.replace(whole, series=series), CONFIGURATION | {"contact": contact})


def with_distant_rotor() -> xarray.DataTree:
    """A run whose rotor is a hundred micrometres away."""
    contact = {"clearance": 1e-4, "tip_length": 19e-3}
    return to_datatree(synthetic_trajectory(contact=False), CONFIGURATION | {"contact": contact})


CASES: dict[str, Callable[[], xarray.DataTree]] = {
    "ordinary": lambda: to_datatree(synthetic_trajectory(), CONFIGURATION),
    "without contact": lambda: to_datatree(synthetic_trajectory(contact=False), CONFIGURATION),
    "one record interval": lambda: to_datatree(synthetic_trajectory(1e-6), CONFIGURATION),
    "very short": lambda: to_datatree(synthetic_trajectory(20e-9, 1e-9), CONFIGURATION),
    "coarsely recorded": lambda: to_datatree(synthetic_trajectory(interval=1e-4), CONFIGURATION),
    "finely recorded": lambda: to_datatree(synthetic_trajectory(2e-3, 1e-8), CONFIGURATION),
    "diverged": diverged,
    "failed at once": failed_at_once,
    "motionless": motionless,
    "with a distant rotor": with_distant_rotor,
}


@pytest.fixture(scope="module")
def tree() -> xarray.DataTree:
    """An ordinary run."""
    return CASES["ordinary"]()


@pytest.fixture
def figure(tree: xarray.DataTree) -> Figure:
    """Its picture."""
    return draw_overview(tree)


def shades(axes: Axes) -> dict[str, list[tuple[float, float]]]:
    """Left and right ends of the shaded spans of a panel, by mode."""
    result = {}
    for collection in axes.collections:
        if isinstance(collection, PolyCollection) and collection.get_label() in COLOURS:
            corners = [path.vertices[:, 0] for path in collection.get_paths()]
            result[str(collection.get_label())] = [(float(c.min()), float(c.max())) for c in corners]
            colour = collection.get_facecolor()[0][:3] if corners else None
            assert colour is None or tuple(colour) == to_rgb(COLOURS[str(collection.get_label())])
    return result


@pytest.mark.parametrize("case", CASES)
def test_no_text_covers_another_or_leaves_the_picture(case: str) -> None:
    figure = draw_overview(CASES[case]())
    boxes = list(boxes_in(figure).values())
    width, height = figure.canvas.get_width_height()
    for i, box in enumerate(boxes):
        assert box.x0 >= 0.0
        assert box.x1 <= width
        assert box.y0 >= 0.0
        assert box.y1 <= height
        assert not any(box.overlaps(other) for other in boxes[:i])


@pytest.mark.parametrize("ripple", [1e-12, 1e-4, 2.5e-3])
def test_ticks_of_a_velocity_that_hardly_changes_are_read_as_they_stand(ripple: float) -> None:
    whole = synthetic_trajectory(1e-3)
    series = whole.series | {"rotor_velocity": -2.1911 + ripple * np.sin(2e4 * whole.time)}
    figure = draw_overview(to_datatree(dataclasses.replace(whole, series=series), CONFIGURATION))
    assert offsets_in(figure) == []
    boxes = list(boxes_in(figure).values())
    assert min(box.x0 for box in boxes) >= 0.0
    assert not any(box.overlaps(other) for i, box in enumerate(boxes) for other in boxes[:i])


def test_a_composed_law_is_named_by_its_parts() -> None:
    whole, law = synthetic_trajectory(1e-3), cl.Composed(damping=cl.Flores(restitution=0.5))
    tree = to_datatree(dataclasses.replace(whole, law=law), CONFIGURATION)
    assert draw_overview(tree).texts[0].get_text().startswith("hertz_point + flores + coulomb: 3 contacts")


def test_an_incomplete_run_says_so_in_its_title() -> None:
    title = draw_overview(diverged()).texts[0]
    assert title.get_text().endswith("incomplete: diverged")
    assert title.get_color() == COLOURS["fault"]


def test_slip_and_stick_are_shaded_in_both_panels_and_named(figure: Figure) -> None:
    _, _, gap, force = figure.axes
    assert shades(gap) == shades(force)
    assert {mode: len(spans) for mode, spans in shades(gap).items()} == {"slip": 6, "stick": 3}
    legend = gap.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["slip", "stick"]
    colours = [patch.get_facecolor()[:3] for patch in legend.get_patches()]
    assert colours == [to_rgb(COLOURS["slip"]), to_rgb(COLOURS["stick"])]


def test_shades_begin_and_end_with_the_contacts(figure: Figure, tree: xarray.DataTree) -> None:
    slip = sorted(shades(figure.axes[2])["slip"])
    starts = (tree["contacts"]["start_time"].values[-3:] - 5e-3) / 1e-6
    np.testing.assert_allclose([left for left, _ in slip[::2]], starts)
    ends = starts + CONTACT_DURATION / 1e-6
    np.testing.assert_allclose([right for _, right in slip[1::2]], ends)


def test_the_force_is_drawn_as_the_steps_whose_area_is_the_impulse(figure: Figure) -> None:
    x, y = figure.axes[3].lines[0].get_data()
    x, y = np.asarray(x), np.asarray(y)
    # Horizontal over every interval, vertical between two.
    assert np.all((np.diff(x) == 0.0) | (np.diff(y) == 0.0))
    impulse = 2.0 / np.pi * 9.0 * CONTACT_DURATION
    assert np.sum(y[1::2] * (x[1::2] - x[::2])) * 1e-6 == pytest.approx(3.0 * impulse, rel=1e-9)


def test_path_and_rotor_share_one_scale_and_one_origin(figure: Figure, tree: xarray.DataTree) -> None:
    axes = figure.axes[1]
    figure.canvas.draw()
    (x0, y0), (x1, y1) = axes.transData.transform([(0.0, 0.0), (1.0, 1.0)])
    assert x1 - x0 == pytest.approx(y1 - y0, rel=1e-6)
    x, y = (np.asarray(values) * 1e-6 for values in axes.lines[0].get_data())
    slope = tree["tip_slope"].values[-x.size :]
    u = tree["tip_normal_displacement"].values[-x.size :]
    np.testing.assert_allclose(x, -19e-3 * np.sin(slope), atol=1e-15)
    np.testing.assert_allclose(y, u + 19e-3 * (np.cos(slope) - 1.0), atol=1e-15)


def test_the_arc_is_the_circle_of_the_rotor(figure: Figure) -> None:
    x, y = (np.asarray(values) for values in figure.axes[1].lines[-1].get_data())
    radius, clearance = 25e3, 1.0
    distance = np.hypot(x, y - clearance - radius)
    np.testing.assert_allclose(distance, radius, rtol=1e-12)
    assert y.min() == pytest.approx(clearance)


def test_a_distant_rotor_is_named_instead_of_drawn() -> None:
    axes = draw_overview(with_distant_rotor()).axes[1]
    assert axes.get_title(loc="right") == "path of the tip end, rotor at 100 µm"
    assert axes.get_ylim()[1] < 10.0


def test_records_far_apart_are_points() -> None:
    _, path, gap, _ = draw_overview(CASES["coarsely recorded"]()).axes
    assert path.lines[0].get_linestyle() == "None"
    assert gap.lines[1].get_marker() == "o"


def test_drawing_leaves_the_settings_of_the_caller_alone(tree: xarray.DataTree) -> None:
    before = dict(mpl.rcParams)
    draw_overview(tree)
    assert dict(mpl.rcParams) == before


def test_drawing_needs_no_pyplot() -> None:
    code = "import sys, contactlab.plot.overview; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_same_run_leaves_the_same_picture(tree: xarray.DataTree, tmp_path: Path) -> None:
    for name in ("first.png", "second.png"):
        overview(tree, tmp_path / name)
    assert (tmp_path / "first.png").read_bytes() == (tmp_path / "second.png").read_bytes()


def test_the_velocity_panel_says_whether_the_run_has_settled_and_shows_to_what() -> None:
    """The rotor approaches -2 rad/s exponentially."""
    whole = synthetic_trajectory(duration=0.05, interval=1e-5, contact=False)
    gone = np.exp(-whole.time / 0.01)
    series = whole.series | {
        "rotor_velocity": -2.0 * (1.0 - gone),
        "rotor_angle": -2.0 * (whole.time - 0.01 * (1.0 - gone)),
    }
    axes = draw_overview(to_datatree(dataclasses.replace(whole, series=series))).axes[0]
    assert axes.get_title(loc="right").startswith("settled: without contact, \u22121.9998")
    assert np.isclose(axes.lines[-1].get_ydata()[0], -2.0, rtol=1e-2)
    assert axes.get_ylim()[0] < -2.0
