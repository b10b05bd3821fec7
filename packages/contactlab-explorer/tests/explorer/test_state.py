"""What a page shows, without a browser: states, links, sliders, texts and pictures."""

import math
import pickle
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml

import contactlab as cl
from contactlab_explorer.pictures import approach, pictures, saved
from contactlab_explorer.scales import position, steps_of, value_at
from contactlab_explorer.state import MOST, VIEWS, History, State, laws, options_of


@pytest.fixture(scope="module")
def state() -> State:
    return State(cl.build(["law=newton"]), laws=("newton", "hertz_penalty"))


def test_every_law_and_part_that_is_offered_can_be_chosen(state: State) -> None:
    for law in laws():
        setup = state.with_laws([law]).setup(law)
        assert setup.law.name == options_of(law)["law"]
        assert any(key.startswith("law.") or "@" not in key for key in state.with_laws([law]).sliders)


@pytest.mark.parametrize("view", VIEWS)
def test_sliders_are_the_declared_numbers_of_what_is_seen(state: State, view: str) -> None:
    shown = replace(state, view=view).sliders
    declared = state.base.numbers()
    assert shown["law.restitution@newton"].meaning == declared["law.restitution"].meaning
    assert shown["contact.friction_coefficient"].usual == declared["contact.friction_coefficient"].usual
    assert "law.stiffness@hertz_penalty" in shown
    assert ("drive.voltage_1" in shown) == (view == "motor")
    assert ("impact.mass" in shown) == (view == "impact")
    # What is read from files, and what only a solver has, has none.
    assert not any(key.startswith(("solver.", "record.")) or "file" in key for key in shown)


def test_a_slider_goes_from_end_to_end_and_comes_back(state: State) -> None:
    for view in VIEWS:
        for key, number in replace(state, view=view).sliders.items():
            assert number.usual is not None
            most = steps_of(number)
            assert (value_at(number, 0), value_at(number, most)) == number.usual
            steps = [value_at(number, step) for step in range(most + 1)]
            # Each step is another number, and comes back to its place.
            assert all(a < b for a, b in pairwise(steps)), key
            assert all(map(number.parameter.admits, steps)), key
            assert [position(number, value) for value in steps] == [*range(most + 1)], key


def test_a_number_of_a_law_is_its_own_and_puts_it_first(state: State) -> None:
    other = state.with_number("law.stiffness@hertz_penalty", 2e10).with_number("drive.voltage_1", 80.0)
    assert other.laws == ("hertz_penalty", "newton")
    assert other.setup("hertz_penalty").law == cl.HertzPenalty(stiffness=2e10)
    assert other.setup("newton").law == cl.Newton()
    assert other.setup("newton").source["drive"]["voltage_1"] == 80.0


@pytest.mark.parametrize("view", VIEWS)
def test_a_link_restores_the_state(state: State, view: str) -> None:
    shown = replace(state, view=view).with_number("law.restitution@newton", 0.1 + 0.2)
    assert state.of_query(shown.query()) == shown


def test_a_link_sets_nothing_that_is_not_declared(state: State) -> None:
    query = {
        "view": "files",
        "laws": "nothing,poisson,poisson,newton,johnson,hertz_penalty,lagrange_stick",
        "resonator.file": "/etc/passwd",
        "solver.duration": "1e9",
        "drive.voltage_1": "nan",
        "drive.phase": "__import__('os')",
        "law.restitution@newton": "0.25",
    }
    read = state.of_query(query)
    assert read.view == "motor"
    assert read.laws == ("poisson", "newton", "johnson", "hertz_penalty")
    assert len(read.laws) == MOST
    assert dict(read.numbers) == {"law.restitution@newton": 0.25}


def test_undo_goes_back_by_whole_moves_of_one_slider(state: State) -> None:
    history = History(state)
    for value in (10.0, 20.0, 30.0):
        history.change(history.state.with_number("drive.voltage_1", value))
    history.change(history.state.with_number("drive.phase", 0.5))
    history.change(history.state.with_laws(["poisson"]))
    undone = []
    while history.undo():
        undone.append((history.state.laws, dict(history.state.numbers)))
    both = ("newton", "hertz_penalty")
    assert undone == [
        (both, {"drive.voltage_1": 30.0, "drive.phase": 0.5}),
        (both, {"drive.voltage_1": 30.0}),
        (both, {}),
    ]


@pytest.mark.parametrize("law", ["newton", "friction/dahl"])
def test_the_texts_make_what_is_seen(state: State, law: str) -> None:
    seen = state.with_laws([law]).with_number("drive.voltage_1", 80.0)
    texts, setup = seen.texts(law), seen.setup(law)
    names: dict[str, cl.Setup] = {}
    exec(texts["python"], names)
    assert names["setup"].configuration == setup.configuration
    assert cl.build(yaml.safe_load(texts["yaml"])).configuration == setup.configuration
    assert "drive.voltage_1=80.0" in texts["bash"].split()


@pytest.mark.parametrize("view", ["path", "impact"])
def test_the_python_of_a_law_by_itself_gives_the_points_that_are_drawn(state: State, view: str) -> None:
    seen = replace(state, view=view, laws=("newton",))
    names: dict[str, object] = {}
    exec(seen.texts("newton")["python"], names)
    drawn = pictures(seen, "newton")
    if view == "impact":
        table = names["table"]
        assert isinstance(table, cl.impacts.xarray.Dataset)
        assert [y for _, y in drawn["restitution"]] == table["restitution"].values.tolist()
    else:
        loop = names["loop"]
        assert isinstance(loop, cl.Solution)
        assert [y for _, y in drawn["loop"]][-1] == loop["friction_force"].values[-1]


def test_the_force_and_impulse_of_a_period_are_those_of_the_orbit(state: State) -> None:
    rigid, compliant = (pictures(state, law) for law in state.laws)
    orbit = cl.orbit(state.setup("newton"))
    # A stem of a rigid impact: from zero up to its impulse, and no force.
    (at, zero), (_, top), gap = rigid["impulse"]
    assert (zero, gap, rigid["force"]) == (0.0, [None, None], [])
    assert 0.0 < at < 1.0
    assert top == pytest.approx(1e6 * orbit.impulse.value, rel=1e-9)
    assert compliant["impulse"] == []
    force = np.array(compliant["force"], float)
    mean = cl.orbit(state.setup("hertz_penalty")).average("normal_force").value
    assert force[1:, 1].mean() == pytest.approx(mean, rel=1e-6)
    # A path of the tip that closes, and powers that balance.
    assert rigid["tip"][0] == pytest.approx(rigid["tip"][-1], abs=1e-4)
    (_, work), *losses = rigid["energy"]
    assert work == pytest.approx(sum(power for _, power in losses), rel=1e-6)


def test_the_way_to_the_steady_state_ends_near_it(state: State) -> None:
    way = approach(state, "newton")["approach"]
    steady = cl.orbit(state.setup("newton")).velocity.value
    assert way[0] == [0.0, 0.0]
    assert way[-1][1] == pytest.approx(steady, rel=0.02)


def test_the_loop_of_sliding_friction_is_a_rectangle(state: State) -> None:
    seen = replace(state, view="path", laws=("newton",))
    seen = seen.with_number("path.load", 5.0).with_number("path.amplitude", 1e-6)
    forces = [y for _, y in pictures(seen, "newton")["loop"]]
    # mu N in both directions, and 4 mu N A lost in a cycle.
    assert (min(forces), max(forces)) == pytest.approx((-1.5, 1.5), rel=1e-9)
    assert float(pictures(seen, "newton")["said"].split()[1]) == pytest.approx(4 * 1.5 * 1e-6, rel=1e-3)


def test_restitution_over_speed_is_newtons(state: State) -> None:
    seen = replace(state, view="impact").with_number("law.restitution@newton", 0.7)
    assert [y for _, y in pictures(seen, "newton")["restitution"]] == pytest.approx([0.7] * 60)


def test_what_is_saved_is_a_run_and_a_figure(state: State, tmp_path: Path) -> None:
    (file := tmp_path / "run.nc").write_bytes(saved(state, "newton", "run.nc"))
    assert cl.load(file).setup == state.setup("newton")
    assert saved(state, "newton", "run.png").startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="run"):
        saved(replace(state, view="impact"), "newton", "run.nc")


def test_a_stop_ends_a_picture(state: State) -> None:
    for compute in (pictures, approach):
        with pytest.raises(cl.StoppedError):
            compute(state, "newton", lambda: True)


def test_a_state_goes_to_another_process_and_is_the_same(state: State) -> None:
    other = pickle.loads(pickle.dumps(state))
    assert not other.base.made_in_python
    assert pictures(other, "newton") == pictures(state, "newton")


def test_points_that_are_no_numbers_are_gaps() -> None:
    from contactlab_explorer.pictures import points

    assert points(np.array([0.0, 1.0]), np.array([math.nan, 2.0])) == [[None, None], [1.0, 2.0]]


def test_a_plant_has_its_own_sliders_and_pictures_over_a_period() -> None:
    amplitude, frequency = 1e-4, 60.0
    words = ["law=newton", "plant=ball", f"plant.table.amplitude={amplitude}"]
    ball = State(cl.build([*words, f"plant.table.frequency={frequency}", "law.restitution=0.3"]))
    declared = ball.base.numbers()
    groups = {key.partition(".")[0] for key in ball.sliders}
    assert groups == {"law", "contact", "plant"}
    assert {key for key in ball.sliders if key.startswith("contact")} == {"contact.friction_coefficient"}
    assert {key for key in ball.sliders if key.startswith("plant")} == {
        key for key, number in declared.items() if key.startswith("plant") and number.usual is not None
    }
    drawn = pictures(ball.with_number("plant.table.frequency", 70.0), "newton")
    under, body, gap = (np.array(drawn[name], float) for name in ("under", "position", "gap"))
    # Over an orbit of whole periods of the table, which was moved, and above it by the gap.
    turns = under[-1, 0] / (1e3 / 70.0)
    assert turns == pytest.approx(round(turns)) != 0.0
    assert np.abs(under[:, 1]).max() == pytest.approx(1e6 * amplitude, rel=1e-2)
    assert body[:, 1] - under[:, 1] == pytest.approx(gap[:, 1], abs=1e-9)
    assert "tip" not in drawn
    # Nothing drives this one, which falls and is drawn over its run.
    falling = State(cl.build(["law=newton", "plant=ball", "plant.height=1 mm"]))
    drawn = pictures(falling, "newton")
    time, height = np.array(drawn["position"], float).T
    flies = time < 1e3 * math.sqrt(2e-3 / 9.81)
    assert height[flies] == pytest.approx(1e3 - 0.5 * 9.81 * time[flies] ** 2, abs=1e-6)
    assert "simulate" in falling.texts("newton")["python"]
    assert "steady" in ball.texts("newton")["bash"]
