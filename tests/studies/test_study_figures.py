"""Figures of studies show what is known: no round-off, no place that nothing holds, no empty panel."""

from dataclasses import replace

import numpy as np
import pytest
import xarray

import contactlab as cl
from contactlab.metrics import Run
from contactlab.studies.characterise.study import Characterise
from contactlab.studies.compare.figures import draw_contact, draw_differences, draw_pairs, draw_paths
from contactlab.studies.compare.scorecard import CONTACTS, Reruns, motion
from contactlab.studies.orbit_figures import draw_steady

LAWS = ["newton", "hertz_penalty"]
RANGE = ["relative_difference_low", "relative_difference_high"]


def pairs_of(difference: float) -> xarray.Dataset:
    """Two laws and a third, at one operating point, with this relative difference of their velocities."""
    dims, shape = ("law", "other_law", "cell", "quantity"), (3, 3, 1, 1)
    each = difference * np.sign(np.subtract.outer(np.arange(3), np.arange(3)))
    numbers = {"relative_size": np.abs(each).astype(float), "order": np.zeros((3, 3))}
    return xarray.Dataset(
        {name: (dims, values.reshape(shape)) for name, values in numbers.items()},
        {"law": [*LAWS, "poisson"], "quantity": ["rotor_velocity"]},
        {"margin": 0.05},
    )


@pytest.mark.parametrize(("difference", "share"), [(1e-11, 2e-10), (0.2, 1.0)])
def test_a_difference_far_within_the_margin_has_no_colour(difference: float, share: float) -> None:
    image = draw_pairs(pairs_of(difference)).axes[0].images[0]
    assert 100.0 * difference / image.norm.vmax == pytest.approx(share)


def test_a_pair_whose_difference_is_not_known_is_not_drawn_as_one_without_a_difference() -> None:
    data = pairs_of(0.2)
    data["relative_size"][0, 2] = data["relative_size"][2, 0] = np.nan
    image = draw_pairs(data).axes[0].images[0]
    shown = image.get_array()
    assert [*zip(*np.nonzero(np.ma.getmaskarray(shown)), strict=True)] == [(0, 2), (2, 0)]
    assert tuple(image.cmap.get_bad()) != image.cmap(0.0)


@pytest.mark.parametrize(("pressed", "lines"), [((), 2), (("contact.preload=5",), 1)])
def test_a_rotor_that_a_preload_presses_on_the_tip_is_not_drawn_at_the_clearance(
    pressed: tuple[str, ...], lines: int
) -> None:
    setup = cl.build([*pressed, "law=newton", "solver.duration=1e-4"])
    run = Run.of_trajectory(setup.run(), setup.configuration)
    shown = motion(Reruns(replace(run, label="newton")))
    assert len(draw_paths([shown]).axes[0].lines) == lines


def test_every_motor_drawn_is_a_point_and_the_margin_a_band() -> None:
    drawn = np.linspace(-0.4, 0.2, 16)
    pair, both = ("law", "other_law", "cell", "quantity"), (2, 2, 1, 1)
    numbers = {"order": 0.0, "relative_nominal": 0.1} | dict.fromkeys(RANGE, 0.2)
    data = xarray.Dataset(
        {name: (pair, np.full(both, x)) for name, x in numbers.items()}
        | {"relative_drawn": ((*pair, "draw"), np.broadcast_to(drawn, (*both, 16)))},
        {"law": LAWS, "other_law": LAWS, "quantity": ["rotor_velocity"]},
        {"margin": 0.05},
    )
    (axes,) = draw_differences(data).axes
    np.testing.assert_allclose(axes.lines[1].get_xdata(), 100.0 * drawn)
    assert axes.patches[0].get_x() == -5.0
    assert axes.patches[0].get_width() == 10.0


def test_a_motor_without_a_curve_has_no_figure() -> None:
    sheet = xarray.Dataset({"sense": ("law", [0.0])}, {"law": ["newton"]})
    assert Characterise().figures(xarray.DataTree(sheet)) == {}


def test_a_rotor_that_symmetry_keeps_at_rest_is_drawn_at_rest() -> None:
    """Driven in the normal mode alone: the rotor's velocity is round-off, some 1e-17 rad/s."""
    pressed = ["law=newton", "contact.preload=5", "rotor.bearing_damping=300", "drive.voltage_2=0"]
    figure = draw_steady(cl.steady(cl.build(pressed)).data)
    (axes,) = [axes for axes in figure.axes if axes.get_ylabel().startswith("rotor velocity")]
    assert axes.get_ylim() == (-0.5, 0.5)


def test_impacts_that_take_no_time_do_not_set_the_axis_of_forces() -> None:
    """A force of a record with an impact is its impulse over the interval between records."""
    time = np.linspace(0.0, 3.0, 301)
    motions = []
    for law, starts, lasts, force in (("newton", [0.5, 1.5], 0.0, 0.0), ("hertz_penalty", [0.0], 2.9, 5.0)):
        normal = np.where(np.isin(time, starts) & (force == 0.0), 1e4, force)
        rows = {name: ("contact", np.ones(len(starts))) for name in CONTACTS}
        rows |= {
            "start_time": ("contact", np.array(starts)),
            "duration": ("contact", np.full(len(starts), lasts)),
        }
        series = {"normal_force": ("time", normal), "friction_force": ("time", 0.3 * normal)}
        motions.append(xarray.Dataset(rows | series, {"time": time}, {"law": law, "period": 1.0}))
    assert draw_contact(motions).axes[0].get_ylim()[1] < 100.0
