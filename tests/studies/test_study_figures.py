"""Figures of studies show what is known: no round-off, no place that nothing holds, no empty panel."""

from dataclasses import replace

import numpy as np
import pytest
import xarray

import contactlab as cl
from contactlab.metrics import Run
from contactlab.studies.characterise.study import Characterise
from contactlab.studies.compare.figures import draw_contact, draw_pairs, draw_paths, draw_quantities
from contactlab.studies.compare.scorecard import CONTACTS, Reruns, motion
from contactlab.studies.steady_figure import draw as draw_steady

LAWS = ["newton", "hertz_penalty"]


def pairs_of(difference: float, error: float) -> xarray.Dataset:
    """Two laws at one operating point, with this difference of their velocities and its numerical error."""
    dims, shape = ("law", "other_law", "cell", "quantity"), (2, 2, 1, 1)
    each = difference * np.array([[0.0, 1.0], [-1.0, 0.0]])
    numbers = {"difference": each, "difference_error": np.full((2, 2), error), "order": np.zeros((2, 2))}
    return xarray.Dataset(
        {name: (dims, values.reshape(shape)) for name, values in numbers.items()},
        {"law": LAWS, "quantity": ["rotor_velocity"]},
    )


@pytest.mark.parametrize(("error", "share"), [(1e-3, 1e-8), (1e-13, 1.0)])
def test_a_difference_within_its_numerical_error_has_no_colour(error: float, share: float) -> None:
    image = draw_pairs(pairs_of(1e-11, error)).axes[0].images[0]
    assert 1e-11 / image.norm.vmax == pytest.approx(share)


@pytest.mark.parametrize(("pressed", "lines"), [((), 2), (("contact.preload=5",), 1)])
def test_a_rotor_that_a_preload_presses_on_the_tip_is_not_drawn_at_the_clearance(
    pressed: tuple[str, ...], lines: int
) -> None:
    setup = cl.build([*pressed, "law=newton", "solver.duration=1e-4"])
    run = Run.of_trajectory(setup.run(), setup.configuration)
    shown = motion(Reruns(replace(run, label="newton")))
    assert len(draw_paths([shown]).axes[0].lines) == lines


def test_a_quantity_that_no_law_has_takes_no_panel() -> None:
    nominal = np.ones((2, 1, 1, 1, 2))
    nominal[..., 1] = np.nan
    data = xarray.Dataset(
        {
            "nominal": (("law", "cell", "basis", "step", "quantity"), nominal),
            "drawn": (("draw", "factor"), np.empty((0, 1))),
            "drawn_value": (("law", "cell", "draw", "quantity"), np.empty((2, 1, 0, 2))),
        },
        {
            "law": LAWS,
            "basis": ["as configured"],
            "factor": ["basis"],
            "quantity": ["rotor_velocity", "rms_current"],
            "quantity_units": ("quantity", ["rad s-1", "A"]),
        },
    )
    assert sum(axes.get_visible() for axes in draw_quantities(data).axes) == 1


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
