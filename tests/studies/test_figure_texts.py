"""Every figure of every study: which law, pair, quantity, unit and factor its texts name."""

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure
from matplotlib.style import context
from support.pictures import boxes_in, entries_in, offsets_in, texts_in
from support.struck_discs import struck_discs
from support.tracks import write_throws

import contactlab as cl
from contactlab.measured.files import read_impacts
from contactlab.measured.series import MeasuredSeries
from contactlab.plot.style import STYLE, line_style
from contactlab.studies.characterise.figure import draw as draw_sheet
from contactlab.studies.compare.figures import draw_all
from contactlab.studies.figures import draw_paths
from contactlab.studies.orbit_figures import draw_basins, draw_branch
from contactlab.studies.registry import studies, study_class
from contactlab.studies.study import Study
from contactlab.studies.validate_figures import draw_differences, draw_errors, draw_residuals, draw_tracks

TWELVE = (
    *("lagrange_slip", "lagrange_stick", "hertz_penalty", "newton", "poisson", "stronge", "moreau_jean"),
    *("johnson", "brach", "chatterjee_ruina", "hertz_point + flores + mindlin", "archard"),
)
"""Laws by their labels."""

TIME = np.linspace(0.0, 0.2, 41)

NEWTON = "law=newton"


def driven() -> cl.Result:
    slip = 5e-6 * np.sin(2.0 * np.pi * TIME / 0.1)
    measured = {"friction_force": -2.7 * np.sign(np.cos(2.0 * np.pi * TIME / 0.1))}
    path = MeasuredSeries(TIME, measured, {}, {}, {}, "", {"slip": slip, "normal": 10.0 + 0.0 * TIME})
    dahl = ["law=composed", "law/friction=dahl"]
    return study_class("drive")(data=path)({"a": cl.build(dahl), "b": cl.build()})


def fitted() -> cl.Result:
    pytest.importorskip("dynesty", reason="There is no dynesty; pip install 'contactlab[fit]' brings it.")
    data, free = struck_discs(cl.Newton(0.2, 0.6), 20, seed=1, spread=0.05), {"law.restitution": (0.1, 0.9)}
    laws = [cl.build([f"law={name}"]) for name in ("newton", "poisson")]
    return cl.fit(laws, data=data, free=free, points=25, starts=1)


RESULTS: dict[str, Callable[[], cl.Result]] = {
    "steady": lambda: cl.steady(cl.build([NEWTON])),
    "branch": lambda: cl.branch(cl.build([NEWTON]), "drive.phase", -0.7, -0.6, step=0.5),
    "basins": lambda: cl.basins(
        cl.build([NEWTON, "contact.clearance=3 um"]),
        {"rotor_velocity": np.array([-3.0, 3.0]), "drive_phase": np.array([0.0, 0.5])},
    ),
    "characterise": lambda: cl.characterise([cl.build([NEWTON]), cl.build(["law=poisson"])]),
    "drive": driven,
    "validate": lambda: cl.validate(
        [cl.Newton(), cl.LagrangeStick()],
        data=struck_discs(cl.Newton(0.2, 0.6), 20, seed=1, spread=0.05), folds=2,
    ),
    "fit": fitted,
    "compare": lambda: cl.compare([cl.build([NEWTON]), cl.build()], refine=False, samples=0),
}  # fmt: skip
"""A small result of every study that has figures."""

RATE = "rotor velocity (rad/s)"
POSTERIOR = ("restitution", "density")
DRIVEN = ("normal force (N)", "friction force (N)", "displacement along the surface (\u00b5m)", "time (ms)")
PREDICTED = ("predicted (m/s)", "gap rate after the impact, measured (m/s)", "median, 90 % interval")
PREDICTED += ("slip velocity after the impact, measured (m/s)",)
MOTION = ("newton", "hertz_penalty")

NAMED: dict[str, dict[str, tuple[str, ...]]] = {
    "steady": {
        "steady": (
            *("newton: periodic, rotor velocity", "normal displacement (\u00b5m)", RATE, "gap (\u00b5m)"),
            *(
                "lasting normal force (N)",
                "impulse, dots (\u00b5N s)",
                "Floquet multipliers",
                "time (\u00b5s)",
            ),
        )
    },
    "branch": {
        "branch": (
            *(
                "newton: periodic orbits over drive.phase",
                "mean rotor velocity (rad/s)",
                "drive.phase (mrad)",
            ),
            *("largest multiplier", "stable"),
        )
    },
    "basins": {
        "basins": (
            *("newton: basins of attraction", "rotor velocity at the start (rad/s)", "phase of the drive"),
            *("100 %: periodic, rotor velocity",),
        )
    },
    "characterise": {
        "characterise": (
            *("newton", "poisson", "free rotor", "torque (mN m)", "output power (mW)"),
            *("electrical efficiency (%)", "velocity in the motor's sense (rad/s)"),
        )
    },
    "drive": {
        "drive": ("hertz_point + dahl", "hertz_penalty", "measured", *DRIVEN),
        "hertz_point_dahl": (
            *("hertz_point + dahl on a prescribed path of 200 ms", "internal variable z (nm)"),
            *("slip", "stick", *DRIVEN),
        ),
        "hertz_penalty": (
            *("hertz_penalty on a prescribed path of 200 ms", "energy (\u00b5J)", "work of the path"),
            *("friction loss", "contact loss", *DRIVEN),
        ),
    },
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
    "compare": {
        "contact_force": (
            *MOTION,
            "normal force (N)",
            "friction force (N)",
            "time from touch-down (\u00b5s)",
        ),
        "tip_trajectory": (
            *(
                *MOTION,
                "tangential displacement of the tip (\u00b5m)",
                "normal displacement (\u00b5m)",
                "rotor",
            ),
        ),
        "energy_flow": ("work of the drive", "viscous damping", "energy in one drive period (\u00b5J)"),
        "phase_portrait": (*MOTION, "gap rate (m/s)", "slip velocity (m/s)", "gap (\u00b5m)"),
    },
}
"""What each figure of each study names."""

WITHOUT = {"bench", "report", "synthetic", "sweep", "verify"}
"""Studies without figures."""


@cache
def result_of(study: str) -> cl.Result:
    return RESULTS[study]()


@cache
def figures_of(study: str) -> Mapping[str, Figure]:
    return result_of(study).figures


def test_every_study_with_figures_stands_in_the_table() -> None:
    own = {name for name in studies() if study_class(name).__module__.startswith("contactlab.")}
    having = {name for name in own if study_class(name).figures is not Study.figures}
    assert having == {*NAMED} == {*RESULTS}


@pytest.mark.parametrize("study", NAMED)
def test_every_figure_names_what_it_shows(study: str) -> None:
    figures = figures_of(study)
    assert {*figures} == {*NAMED[study]}
    for name, wanted in NAMED[study].items():
        texts, ticks = texts_in(figures[name]), ticks_in(figures[name])
        for text in wanted:
            assert any(text in each for each in [*texts, *ticks]), (name, text, texts)


@pytest.mark.parametrize("study", NAMED)
def test_every_figure_can_be_read(study: str) -> None:
    """One way to write units, no offset at ticks, no text on another, no caption that is a file's name."""
    for name, figure in figures_of(study).items():
        assert not [text for text in texts_in(figure) if "(um)" in text or "(uJ)" in text], name
        assert offsets_in(figure) == [], name
        assert hidden_in(figure) == [], name
        assert figure.get_label().replace("_", " ") not in ("", name.replace("_", " ")), name


def ticks_in(figure: Figure) -> list[str]:
    """The names at the ticks of all axes."""
    return [label.get_text().replace("\n", " ") for axes in figure.axes for label in axes.get_yticklabels()]


def hidden_in(figure: Figure) -> list[tuple[str, str]]:
    """Pairs of texts that cover each other."""
    boxes = list(boxes_in(figure).items())
    return [(a, b) for i, (a, box) in enumerate(boxes) for b, other in boxes[:i] if box.overlaps(other)]


def twelve_sheets() -> Figure:
    sheet = result_of("characterise").data.to_dataset().isel(law=[0] * 12).assign_coords(law=[*TWELVE])
    return draw_sheet(sheet)


def twelve_paths() -> Figure:
    data = result_of("drive").data
    return draw_paths(dict.fromkeys(TWELVE, data["hertz_penalty"]), data["measured"].to_dataset())


def twelve_validated() -> xarray.Dataset:
    data = result_of("validate").data.to_dataset()
    names = [*TWELVE, *data["law"].values[2:]]
    rows = [*[0] * 12, *range(2, data.sizes["law"])]
    return data.isel(law=rows, other=rows).assign_coords(
        law=names, other=names, group=("law", range(len(rows)))
    )


def twelve_compared() -> dict[str, Figure]:
    data = result_of("compare").data
    card = data.to_dataset().isel(law=[0] * 12).assign_coords(law=[*TWELVE])
    motion = data["motion_2"].to_dataset(inherit=False)
    motions = {f"motion_{n}": motion.assign_attrs(law=law) for n, law in enumerate(TWELVE, 1)}
    return draw_all(xarray.DataTree.from_dict({"/": card} | motions))


WITH_TWELVE: dict[str, Callable[[], Figure]] = {
    "data sheet": twelve_sheets,
    "paths": twelve_paths,
    "errors": lambda: draw_errors(twelve_validated()),
    "differences of errors": lambda: draw_differences(twelve_validated()),
    **{name: lambda name=name: twelve_compared()[name] for name in NAMED["compare"]},
}  # fmt: skip


@pytest.mark.parametrize("name", WITH_TWELVE)
def test_twelve_laws_have_a_name_each_that_nothing_covers(name: str) -> None:
    with context(STYLE):
        figure = WITH_TWELVE[name]()
        assert hidden_in(figure) == []
        width, height = figure.canvas.get_width_height()
        for text, box in boxes_in(figure).items():
            assert min(box.x0, box.y0) >= 0.0, text
            assert box.x1 <= width, text
            assert box.y1 <= height, text
    names = [*entries_in(figure), *ticks_in(figure)]
    assert {*TWELVE} <= {each.partition(",")[0] for each in names}


@pytest.mark.parametrize("name", ["data sheet", "paths", "tip_trajectory", "phase_portrait", "contact_force"])
def test_twelve_laws_are_distinct_without_colours(name: str) -> None:
    with context(STYLE):
        figure = WITH_TWELVE[name]()
    lines = [line for axes in figure.axes for line in axes.lines]
    looks = {
        line.get_label().partition(",")[0]: (line.get_linestyle(), line._dash_pattern, line.get_marker())
        for line in lines
    }
    assert len({repr(looks[law]) for law in TWELVE}) == 12


def test_a_law_without_a_curve_is_named_as_one() -> None:
    sheet = result_of("characterise").data.to_dataset().copy(deep=True)
    for name in ("torque", "velocity"):
        sheet[name][1] = np.nan
    sheet["kind"][1] = ""
    with context(STYLE):
        entries = entries_in(draw_sheet(sheet))
    assert entries == ["newton", "poisson, no curve", "free rotor"]


def test_twenty_eight_lines_are_distinct_without_colours() -> None:
    looks = [line_style(number) for number in range(28)]
    assert len({(repr(look["linestyle"]), look.get("marker")) for look in looks}) == 28


def test_the_best_laws_of_four_groups_are_named_with_what_is_drawn_of_each() -> None:
    entries = entries_in(draw_residuals(twelve_validated()))
    assert entries == [
        f"{TWELVE[0]}, median",
        f"{TWELVE[0]}, quartiles",
        *(f"{x}, median" for x in TWELVE[1:4]),
    ]


def test_terms_of_the_energy_and_basins_are_distinct_without_colours() -> None:
    (bars,) = figures_of("compare")["energy_flow"].axes
    hatches = {each.get_label(): each.patches[0].get_hatch() for each in bars.containers}
    assert len(hatches) > 1
    assert len({*hatches.values()}) == len(hatches)
    basins = result_of("basins").data.to_dataset().isel(attractor=[0, 0]).copy()
    basins["label"][0] = 1
    with context(STYLE):
        (axes,) = draw_basins(basins).axes
    assert len({line.get_marker() for line in axes.lines}) == 2
    assert sum(line.get_xdata().size for line in axes.lines) == basins["label"].size


def test_a_branch_of_a_held_rotor_says_what_holds_it_and_draws_its_torque() -> None:
    data = result_of("branch").data.to_dataset().assign_attrs(belt=-1.5)
    data["torque"] = data["rotor_velocity"]
    texts = texts_in(draw_branch(data))
    assert "newton: periodic orbits over drive.phase, rotor held at -1.5 rad/s" in texts
    assert "mean torque (N m)" in texts


def test_a_track_names_its_coordinates_and_breaks(tmp_path: Path) -> None:
    write_throws(tmp_path / "throws.csv", 3, 2, (1e-4, 1e-4, 1e-3), seed=9)
    tracks = read_impacts(tmp_path / "throws.csv").tracks
    assert tracks is not None
    with context(STYLE):
        figure = draw_tracks(tracks)
    assert {"position", "flight", "impact"} <= {*entries_in(figure)}
    assert {"x (m)", "y (m)", "angle (rad)", "time (s)", "track 1"} <= {*texts_in(figure)}
    assert hidden_in(figure) == []


def test_small_changes_of_a_large_number_have_ticks_that_are_read_as_they_stand() -> None:
    with context(STYLE):
        figure = Figure()
        figure.subplots().plot([0.0, 1.0], [-2.19110625, -2.1911062])
    assert offsets_in(figure) == []
    assert matplotlib.rcParams["axes.formatter.useoffset"]
