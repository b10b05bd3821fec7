"""Figures of fits and validations: which law, pair, quantity, unit and factor their texts name."""

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import pytest
import xarray
from data_support.struck_discs import struck_discs
from data_support.tracks import write_throws
from matplotlib.figure import Figure
from matplotlib.style import context
from support.pictures import (
    assert_can_be_read,
    assert_every_law_has_a_name,
    assert_names_what_it_shows,
    entries_in,
    hidden_in,
    texts_in,
)

import contactlab as cl
from contactlab.plot.style import STYLE
from contactlab_data.measured.files import read_impacts
from contactlab_data.studies.validate_figures import (
    draw_differences,
    draw_errors,
    draw_residuals,
    draw_tracks,
)

TWELVE = (
    *("lagrange_slip", "lagrange_stick", "hertz_penalty", "newton", "poisson", "stronge", "moreau_jean"),
    *("johnson", "brach", "chatterjee_ruina", "hertz_point + flores + mindlin", "archard"),
)
"""Laws by their labels."""


def fitted() -> cl.Result:
    data, free = struck_discs(cl.Newton(0.2, 0.6), 20, seed=1, spread=0.05), {"law.restitution": (0.1, 0.9)}
    laws = [cl.build([f"law={name}"]) for name in ("newton", "poisson")]
    return cl.fit(laws, data=data, free=free, points=25, starts=1)


RESULTS: dict[str, Callable[[], cl.Result]] = {
    "validate": lambda: cl.validate(
        [cl.Newton(), cl.LagrangeStick()],
        data=struck_discs(cl.Newton(0.2, 0.6), 20, seed=1, spread=0.05),
        folds=2,
    ),
    "fit": fitted,
}

POSTERIOR = ("restitution", "density")
PREDICTED = ("predicted (m/s)", "gap rate after the impact, measured (m/s)", "median, 90 % interval")
PREDICTED += ("slip velocity after the impact, measured (m/s)",)

NAMED: dict[str, dict[str, tuple[str, ...]]] = {
    "validate": {
        "prediction_error": ("newton", "lagrange_stick", "prediction error, in parts of the velocity before"),
        "paired_differences": ("error of the row less that of the column, in thousandths of the velocity",),
        "residuals": (
            *("newton, median", "newton, quartiles", "lagrange_stick, median", "gap rate residual (m/s)"),
            *("slip residual (m/s)", "incidence (\u00b0)", "approach velocity (m/s)", "slip velocity (m/s)"),
        ),
        "impacts": (
            *("slip velocity before the impact (m/s)", "approach velocity (m/s)"),
            *("least error under any law, in parts of the velocity before",),
        ),
    },
    "fit": {
        "corner_newton": ("posterior of newton", *POSTERIOR),
        "corner_poisson": ("posterior of poisson", *POSTERIOR),
        "predictions_newton": ("newton: predictions", *PREDICTED),
        "predictions_poisson": ("poisson: predictions", *PREDICTED),
    },
}
"""What each figure of each study names."""


@cache
def result_of(study: str) -> cl.Result:
    return RESULTS[study]()


@cache
def figures_of(study: str) -> Mapping[str, Figure]:
    return result_of(study).figures


@pytest.mark.parametrize("study", NAMED)
def test_every_figure_names_what_it_shows(study: str) -> None:
    assert_names_what_it_shows(figures_of(study), NAMED[study])


@pytest.mark.parametrize("study", NAMED)
def test_every_figure_can_be_read(study: str) -> None:
    assert_can_be_read(figures_of(study))


def twelve_validated() -> xarray.Dataset:
    data = result_of("validate").data.to_dataset()
    names = [*TWELVE, *data["law"].values[2:]]
    rows = [*[0] * 12, *range(2, data.sizes["law"])]
    return data.isel(law=rows, other=rows).assign_coords(
        law=names, other=names, group=("law", range(len(rows)))
    )


@pytest.mark.parametrize("draw", [draw_errors, draw_differences])
def test_twelve_laws_have_a_name_each_that_nothing_covers(draw: Callable[[xarray.Dataset], Figure]) -> None:
    with context(STYLE):
        assert_every_law_has_a_name(draw(twelve_validated()), TWELVE)


def test_the_best_laws_of_four_groups_are_named_with_what_is_drawn_of_each() -> None:
    entries = entries_in(draw_residuals(twelve_validated()))
    assert entries == [
        f"{TWELVE[0]}, median",
        f"{TWELVE[0]}, quartiles",
        *(f"{x}, median" for x in TWELVE[1:4]),
    ]


def test_a_track_names_its_coordinates_and_breaks(tmp_path: Path) -> None:
    write_throws(tmp_path / "throws.csv", 3, 2, (1e-4, 1e-4, 1e-3), seed=9)
    tracks = read_impacts(tmp_path / "throws.csv").tracks
    assert tracks is not None
    with context(STYLE):
        figure = draw_tracks(tracks)
    assert {"position", "flight", "impact"} <= {*entries_in(figure)}
    assert {"x (m)", "y (m)", "angle (rad)", "time (s)", "track 1"} <= {*texts_in(figure)}
    assert hidden_in(figure) == []
