"""The animation of a run: it shows the run's geometry and forces, repeats itself, and refuses in words."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray
from PIL import Image
from support.pictures import boxes_in, entries_in, offsets_in, texts_in
from support.synthetic import CONFIGURATION, FREQUENCY, PEAK_FORCE, synthetic_trajectory

from contactlab.laws.base import FREE, SLIP, STICK
from contactlab.plot.animation import LONGEST, Animation, _pitch, write_gif
from contactlab.plot.recording import Film, UnfitRunError, film_of, recording_of
from contactlab.results.netcdf import to_datatree

PERIOD = 1.0 / FREQUENCY


def film(frames: int = 100, tree: xarray.DataTree | None = None, end: float = 5e-3) -> Film:
    run = recording_of(tree or to_datatree(synthetic_trajectory(), CONFIGURATION))
    return film_of(run, max(end - 2.0 * PERIOD, 0.0), end, frames)


def centre(shown: Film) -> np.ndarray:
    return np.array((0.0, shown.run.radius))


def test_a_tip_without_a_gap_touches_the_circle_wherever_it_is() -> None:
    shown = film()
    x = np.linspace(-3e-6, 3e-6, 7)
    distance = np.hypot(*(shown.tip_end(x, np.zeros(7)) - centre(shown)).T)
    assert distance == pytest.approx(shown.run.radius, rel=1e-14)


def test_the_drawn_gap_is_the_magnified_gap() -> None:
    shown = film()
    drawing = Animation(shown, 10.0)
    for number in (0, 30, 60, 90):
        drawing.frame(number)
        end = drawing.tip.get_xy()[0]
        gap = np.hypot(*(end - centre(shown))) - shown.run.radius
        assert gap == pytest.approx(shown.magnification * shown.gap[number], abs=1e-12)


def test_a_tip_that_sticks_travels_with_the_marks() -> None:
    shown = film()
    moved = dataclasses.replace(
        shown, angle=shown.angle * 0.0 + 1e-4, tangential=shown.tangential * 0.0 + 25e-3 * 1e-4
    )
    drawing = Animation(moved, 10.0)
    drawing.frame(0)
    end = moved.tip_end(moved.tangential[:1], np.zeros(1))[0]
    marks = np.array([segment[0] for segment in drawing.marks.get_segments()])
    assert np.min(np.hypot(*(marks - end).T)) < 1e-12


def test_the_arrow_is_proportional_to_the_force() -> None:
    shown = film()
    drawing = Animation(shown, 10.0)
    scales = []
    for number in np.flatnonzero(shown.normal > 0.01 * PEAK_FORCE):
        drawing.frame(int(number))
        foot, apex = drawing.tip.get_xy()[0], drawing.arrow.get_xy()[0]
        force = shown.force_on_rotor(int(number))
        assert np.hypot(*force) == pytest.approx(np.hypot(shown.normal[number], shown.friction[number]))
        scales.append((apex - foot) / force)
    assert np.ptp(scales) == pytest.approx(0.0, abs=1e-9 * np.max(scales))
    assert np.max(scales) == pytest.approx(LONGEST * shown.size / shown.peak)


@pytest.mark.parametrize("depth", [0.0, 1.0, 2.0])
def test_every_arrow_ends_in_the_scene(depth: float) -> None:
    """The tip of a motor that is pressed together stands in the rotor, as deep as the vibration reaches."""
    shown = film()
    deepest = depth * 0.05 * shown.size / shown.magnification
    drawing = Animation(dataclasses.replace(shown, gap=shown.gap - deepest), 10.0)
    assert drawing.arrow.axes is not None
    (left, right), (low, high) = drawing.arrow.axes.get_xlim(), drawing.arrow.axes.get_ylim()
    for number in range(len(drawing)):
        drawing.frame(number)
        x, y = drawing.arrow.get_xy().T
        assert left < x.min() <= x.max() < right
        assert low < y.min() <= y.max() < high


def test_the_force_on_the_rotor_pushes_it_away_from_the_tip_and_against_the_force_on_the_tip() -> None:
    shown = dataclasses.replace(
        film(1), tangential=np.zeros(1), normal=np.array([2.0]), friction=np.array([0.5])
    )
    assert shown.force_on_rotor(0) == pytest.approx([-0.5, 2.0])


@pytest.mark.parametrize("frames", [2, 7, 100, 2000])
def test_mean_forces_add_up_to_the_impulses(frames: int) -> None:
    shown = film(frames)
    interval = (shown.run.end - shown.run.start) / frames
    # Two contacts lie in two drive periods.
    impulse = 2.0 * 2.0 / np.pi * PEAK_FORCE * 60e-6
    assert shown.normal.sum() * interval == pytest.approx(impulse, rel=1e-9)


@pytest.mark.parametrize("frames", [100, 333, 2000])
def test_there_is_force_in_contact_and_nowhere_else(frames: int) -> None:
    shown = film(frames)
    assert set(shown.mode) == {FREE, SLIP, STICK}
    assert not shown.normal[shown.mode == FREE].any()
    assert (shown.normal[shown.mode == STICK] > 0.5 * PEAK_FORCE).all()


def test_the_motion_stays_in_the_picture() -> None:
    shown = film()
    drawing = Animation(shown, 10.0)
    scene = drawing.marks.axes
    for number in range(0, 100, 9):
        drawing.frame(number)
        for patch in (drawing.tip.get_xy()[:1], drawing.arrow.get_xy()):
            inside = scene.transAxes.inverted().transform(scene.transData.transform(patch))
            assert ((inside > 0.0) & (inside < 1.0)).all()


def test_a_film_names_law_quantities_and_units_and_no_text_covers_another() -> None:
    figure = Animation(film(), 10.0).figure
    texts = texts_in(figure)
    for text in ("hertz_penalty: 1 s shows", "normal force (N)", "velocity of the rotor (rad/s)", "\u00b5s"):
        assert any(text in each for each in texts), text
    assert {*entries_in(figure)} == {"slip", "stick"}
    assert offsets_in(figure) == []
    boxes = list(boxes_in(figure).values())
    assert not any(box.overlaps(other) for i, box in enumerate(boxes) for other in boxes[:i])


def test_frames_do_not_depend_on_their_order() -> None:
    drawing = Animation(film(), 10.0)
    first = drawing.frame(40)
    drawing.frame(70)
    assert np.array_equal(drawing.frame(40), first)
    assert not np.array_equal(drawing.frame(70), first)


def test_the_marks_of_a_motor_that_turns_evenly_end_where_they_begin() -> None:
    shown = film(100)
    angle = -2.3 * shown.run.series["time"]
    even = dataclasses.replace(shown.run, series={**shown.run.series, "rotor_angle": angle})
    # The first frame lies an interval after the beginning, which is what the last one repeats.
    whole = film_of(even, even.start, even.end, 100)
    turned = whole.magnification * 2.3 * (even.end - even.start)
    fives = turned / (5.0 * _pitch(whole))
    assert round(fives) >= 1
    assert fives == pytest.approx(round(fives), rel=1e-12)
    assert _pitch(whole) == pytest.approx(0.06 * whole.size / even.radius, rel=0.5)


def test_a_gif_shows_every_frame_in_one_palette(tmp_path: Path) -> None:
    drawing = Animation(film(6), 1.0)
    write_gif(drawing, 10.0, tmp_path / "run.gif")
    with Image.open(tmp_path / "run.gif") as image:
        assert image.n_frames == 6
        for number in range(6):
            image.seek(number)
            shown, drawn = np.asarray(image.convert("RGB")).astype(int), drawing.frame(number)[:, :, :3]
            white = (drawn == 255).all(axis=2)
            assert (shown[white] == 255).all()
            assert np.mean(np.abs(shown - drawn).max(axis=2) < 4) > 0.99


def diverged() -> xarray.DataTree:
    whole = synthetic_trajectory()
    series = {name: values.copy() for name, values in whole.series.items()}
    for values in series.values():
        values[-100:] = np.nan
    return to_datatree(dataclasses.replace(whole, series=series), CONFIGURATION)


@pytest.mark.parametrize(
    "make",
    [
        diverged,
        lambda: to_datatree(synthetic_trajectory(contact=False), CONFIGURATION),
        lambda: to_datatree(synthetic_trajectory(interval=1e-4), CONFIGURATION),
        lambda: to_datatree(synthetic_trajectory(2e-3, 1e-7), CONFIGURATION),
    ],
    ids=["diverged", "without contact", "coarsely recorded", "finely recorded"],
)
def test_every_run_can_be_drawn(make: Callable[[], xarray.DataTree]) -> None:
    tree = make()
    drawing = Animation(film(20, tree, float(tree["time"][-1])), 10.0)
    assert {drawing.frame(number).shape for number in range(20)} == {(640, 800, 4)}


def test_a_part_that_has_diverged_is_refused() -> None:
    with pytest.raises(UnfitRunError, match="has diverged between"):
        film_of(recording_of(diverged()), 4.95e-3, 5e-3, 10)
