"""Every figure of every study: which law, pair, quantity, unit and factor its texts name."""

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib
import numpy as np
import pandas
import pytest
import xarray
from matplotlib.figure import Figure
from matplotlib.style import context
from support.pictures import (
    assert_can_be_read,
    assert_every_law_has_a_name,
    assert_names_what_it_shows,
    entries_in,
    offsets_in,
    texts_in,
)

import contactlab as cl
from contactlab.plot.style import STYLE, line_style
from contactlab.studies.characterise.figure import draw as draw_sheet
from contactlab.studies.compare.figures import draw_all
from contactlab.studies.figures import draw_paths
from contactlab.studies.orbit_figures import draw_basins, draw_branch
from contactlab.studies.registry import studies, study_class
from contactlab.studies.study import Study

TWELVE = (
    *("lagrange_slip", "lagrange_stick", "hertz_penalty", "newton", "poisson", "stronge", "moreau_jean"),
    *("johnson", "brach", "chatterjee_ruina", "hertz_point + flores + mindlin", "archard"),
)
"""Laws by their labels."""

TIME = np.linspace(0.0, 0.2, 41)

NEWTON = "law=newton"


def driven() -> cl.Result:
    slip = 5e-6 * np.sin(2.0 * np.pi * TIME / 0.1)
    friction = -2.7 * np.sign(np.cos(2.0 * np.pi * TIME / 0.1))
    table = {
        "time [s]": TIME,
        "slip [m]": slip,
        "normal [N]": 10.0 + 0.0 * TIME,
        "friction_force [N]": friction,
    }
    dahl = ["law=composed", "law/friction=dahl"]
    with TemporaryDirectory() as folder:
        pandas.DataFrame(table).to_csv(Path(folder) / "path.csv", index=False)
        return study_class("drive")(data=Path(folder) / "path.csv")({"a": cl.build(dahl), "b": cl.build()})


RESULTS: dict[str, Callable[[], cl.Result]] = {
    "steady": lambda: cl.steady(cl.build([NEWTON])),
    "branch": lambda: cl.branch(cl.build([NEWTON]), "drive.phase", -0.7, -0.6, step=0.5),
    "basins": lambda: cl.basins(
        cl.build([NEWTON, "contact.clearance=3 um"]),
        {"rotor_velocity": np.array([-3.0, 3.0]), "drive_phase": np.array([0.0, 0.5])},
    ),
    "characterise": lambda: cl.characterise([cl.build([NEWTON]), cl.build(["law=poisson"])]),
    "drive": driven,
    "response": lambda: cl.response(
        cl.oscillator(1.0, 1e4, damping=10.0, gap=1.0, force=1.0),
        "drive.frequency",
        15.0,
        17.0,
        law=cl.HertzPenalty(stiffness=1e9),
    ),
    "compare": lambda: cl.compare([cl.build([NEWTON]), cl.build()], refine=False, samples=0),
}  # fmt: skip
"""A small result of every study that has figures."""

RATE = "rotor velocity (rad/s)"
DRIVEN = ("normal force (N)", "friction force (N)", "displacement along the surface (\u00b5m)", "time (ms)")
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
    "response": {
        "response": (
            *("hertz_penalty", "without contact", "phase (degrees)", "drive.frequency (Hz)"),
            *("amplitude of the tip normal displacement (mm)",),
        )
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
    assert_names_what_it_shows(figures_of(study), NAMED[study])


@pytest.mark.parametrize("study", NAMED)
def test_every_figure_can_be_read(study: str) -> None:
    assert_can_be_read(figures_of(study))


def twelve_sheets() -> Figure:
    sheet = result_of("characterise").data.to_dataset().isel(law=[0] * 12).assign_coords(law=[*TWELVE])
    return draw_sheet(sheet)


def twelve_paths() -> Figure:
    data = result_of("drive").data
    return draw_paths(dict.fromkeys(TWELVE, data["hertz_penalty"]), data["measured"].to_dataset())


def twelve_compared() -> dict[str, Figure]:
    data = result_of("compare").data
    card = data.to_dataset().isel(law=[0] * 12).assign_coords(law=[*TWELVE])
    motion = data["motion_2"].to_dataset(inherit=False)
    motions = {f"motion_{n}": motion.assign_attrs(law=law) for n, law in enumerate(TWELVE, 1)}
    return draw_all(xarray.DataTree.from_dict({"/": card} | motions))


WITH_TWELVE: dict[str, Callable[[], Figure]] = {
    "data sheet": twelve_sheets,
    "paths": twelve_paths,
    **{name: lambda name=name: twelve_compared()[name] for name in NAMED["compare"]},
}  # fmt: skip


@pytest.mark.parametrize("name", WITH_TWELVE)
def test_twelve_laws_have_a_name_each_that_nothing_covers(name: str) -> None:
    with context(STYLE):
        assert_every_law_has_a_name(WITH_TWELVE[name](), TWELVE)


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


def test_small_changes_of_a_large_number_have_ticks_that_are_read_as_they_stand() -> None:
    with context(STYLE):
        figure = Figure()
        figure.subplots().plot([0.0, 1.0], [-2.19110625, -2.1911062])
    assert offsets_in(figure) == []
    assert matplotlib.rcParams["axes.formatter.useoffset"]
