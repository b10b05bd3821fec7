"""Comparisons of known truth: what page, tables and figures of `compare` say of laws that a test makes."""

from collections.abc import Callable, Mapping, Sequence

import matplotlib.container
import numpy as np
import pytest
import xarray
from support.configurations import altered

import contactlab as cl
from contactlab.studies.compare.factors import USUAL
from contactlab.studies.compare.figures import draw_all
from contactlab.studies.compare.laws import grid_of, run_of_setup
from contactlab.studies.compare.page import findings, tables
from contactlab.studies.compare.paired import ALONE, EQUAL, TOGETHER, UNTESTED
from contactlab.studies.compare.pairs import Design, with_pairs
from contactlab.studies.compare.priors import Distribution
from contactlab.studies.compare.repeats import MARGIN
from contactlab.studies.compare.scorecard import Reruns, scorecard

THREE = ("newton", "poisson", "hertz_penalty")
TWELVE = (
    *("lagrange_slip", "lagrange_stick", "hertz_penalty", "newton", "poisson", "stronge", "moreau_jean"),
    *("johnson", "brach", "chatterjee_ruina", "lagrange_ageing", "archard"),
)

Value = Callable[[str, Mapping[str, float]], Sequence[float]]
"""Quantities of a motor by its law and what is drawn of it; nothing of a motor as configured."""


def compared(
    value: Value,
    laws: Sequence[str] = THREE,
    quantities: Sequence[str] = ("rotor_velocity",),
    samples: int = 64,
    exact: Sequence[str] = (),
    margin: float = MARGIN,
) -> xarray.Dataset:
    """Return the comparison of laws whose settled motors have these values."""
    setups = [cl.build(altered({}, law=law)) for law in laws]
    grid, vary = grid_of(setups), dict[str, Distribution](dict.fromkeys(exact, 0.0))
    design, parts = Design.of(grid, vary, samples, quantities, None), {}
    for key, motor in (design.nominal() | design.drawn(0, samples)).items():
        drawn = dict(zip([factor.name for factor in motor.factors], motor.draw.tolist(), strict=True))
        values = np.array([value(law, drawn) for law in motor.laws], float)
        both = {
            "value": (("law", "quantity"), values),
            "error": (("law", "quantity"), np.zeros(values.shape)),
        }
        dataset = xarray.Dataset(both | {"failure": ("law", [""] * len(values))})
        parts[key] = xarray.DataTree(dataset)
    card = scorecard([Reruns(run_of_setup(law, x, law)) for law, x in grid.first.items()], [])
    return with_pairs(card.assign_attrs(limits=""), design, parts, margin)


def by_sense(law: str, drawn: Mapping[str, float]) -> list[float]:
    """Return a velocity that the sense of the start moves both ways under one of three laws."""
    sense = np.sign(drawn.get("initial velocity", 1.0))
    return [{"newton": 1.0, "poisson": 1.08, "hertz_penalty": 1.0 + 0.4 * sense}[law]]


def test_the_pair_that_stands_for_all_is_the_one_that_differs_most_in_either_sense() -> None:
    """Its median with signs is near zero, as it is as often faster as slower."""
    data = compared(by_sense)
    size = data["relative_size"].isel(quantity=0, cell=0)
    both = size.sel(law="newton", other_law="hertz_penalty"), size.sel(law="newton", other_law="poisson")
    assert both[0] == pytest.approx(0.5 * (0.4 / 1.4 + 0.4), abs=0.1)
    assert both[1] == pytest.approx(0.08 / 1.08)
    (sentence,) = [text for text in findings(data) if text.startswith("Farthest apart")]
    # Against poisson it is 0.48 of 1.08 and 0.32 of 1.4.
    assert "hertz_penalty" in sentence
    frame = tables(data)["turning"].set_index(["law", "against"])
    assert {*frame.index} == {("newton", "hertz_penalty"), ("poisson", "hertz_penalty")}
    assert (frame["turns with"] == "initial velocity").all()
    assert frame["largest share"].to_numpy() == pytest.approx(1.0)


@pytest.mark.parametrize(("law", "other"), [("newton", "hertz_penalty"), ("stronge", "brach")])
@pytest.mark.parametrize("factor", ["damping ratio", "voltage"])
def test_the_picture_of_what_turns_an_order_shows_its_pair_its_quantity_and_its_factor(
    law: str, other: str, factor: str
) -> None:
    """Twelve laws: a factor turns the order of two in speed, the phase all amplitudes."""
    middle = {"damping ratio": 0.02, "voltage": 1.0}[factor]

    def value(name: str, drawn: Mapping[str, float]) -> list[float]:
        above = drawn.get(factor, middle) > middle
        speeds = {law: 2.0 + above, other: 3.0 - above}
        # Irregular as the motion of lagrange_slip is, it is not a law that turns against itself.
        noise = np.sin(1e6 * sum(drawn.values())) if name == "lagrange_slip" else 0.0
        return [speeds.get(name, 5.0) + noise, 1.0 + drawn.get("phase", 0.0)]

    data = compared(value, TWELVE, ("rotor_velocity", "tip_normal_amplitude"))
    itself = np.arange(len(TWELVE))
    assert (data["outcome"].values[itself, itself] == UNTESTED).all()
    assert np.isnan(data["factor_share"].values[itself, itself]).all()
    assert (data["order"].values[itself, itself] == EQUAL).all()
    figures = draw_all(xarray.DataTree(data))
    (axes,) = figures["turning"].axes
    title = axes.get_title().replace("\n", " ").split()
    assert {law, other} <= {*title}
    assert "speed" in title
    assert axes.get_xlabel().startswith(factor)
    # In each half one outcome is certain.
    lines = [x for x in axes.containers if isinstance(x, matplotlib.container.ErrorbarContainer)]
    greater = next(x for x in lines if x.get_label() == "greater")
    assert sorted(greater.lines[0].get_ydata()) == [0.0, 0.0, 1.0, 1.0]
    # The table of all pairs has the size of every one, and none of a law with itself.
    (image,) = figures["pairs"].axes[0].images
    size = np.asarray(image.get_array())
    a, b = TWELVE.index(law), TWELVE.index(other)
    assert size[a, b] == size[b, a] == pytest.approx(100.0 / 3.0)
    assert (np.diagonal(size) == 0.0).all()
    # Differences are those of the first law against each other one.
    assert TWELVE[0] in figures["differences"].axes[0].get_xlabel()
    assert [x.get_text() for x in figures["differences"].axes[0].get_yticklabels()] == [*TWELVE[1:]]


def test_two_factors_that_turn_an_order_together_are_named_together() -> None:
    def value(law: str, drawn: Mapping[str, float]) -> list[float]:
        unequal = (drawn.get("voltage", 1.0) > 1.0) != (drawn.get("phase", 0.0) > 0.0)
        return [1.0 + 0.5 * unequal * (law == "newton") + 0.25 * (law == "hertz_penalty")]

    data = compared(value, ("newton", "hertz_penalty"))
    role = data["factor_role"].isel(law=0, other_law=1, cell=0, quantity=0).to_series()
    assert {*role[role == TOGETHER].index} == {"voltage", "phase"}
    assert ALONE not in role.to_numpy()
    assert "turning" not in draw_all(xarray.DataTree(data))
    assert {*tables(data)["turning"]["turns with"].iloc[0].split(" with ")} == {"voltage", "phase"}
    (sentence,) = [text for text in findings(data) if text.startswith("The outcome turns")]
    assert all(name in sentence for name in ("voltage", "phase"))


def test_laws_that_differ_by_round_off_are_one_and_others_are_not() -> None:
    """Newton and Poisson have the same digits but the last; a margin of zero sees no order in these."""

    def value(law: str, drawn: Mapping[str, float]) -> list[float]:
        speed = 1.0 + 0.1 * drawn.get("phase", 0.0)
        return [speed * {"newton": 1.0, "poisson": 1.0 + 1e-13, "lagrange_stick": 1.1}[law]]

    data = compared(value, ("newton", "poisson", "lagrange_stick"), margin=0.0)
    same = data.sel(law="newton", other_law="poisson")
    assert (same["outcome"] == EQUAL).all()
    assert (same["relative_drawn"] == 0.0).all()
    assert (same["difference"] == 0.0).all()
    (sentence,) = [text for text in findings(data) if "nine digits" in text]
    assert "newton and poisson" in sentence
    assert "lagrange_stick" not in sentence


def test_what_no_motor_has_is_no_quantity() -> None:
    """The current of electrodes without capacitance is neither an order nor one of the claims."""
    quantities = ("rotor_velocity", "rms_current", "tip_normal_amplitude")
    data = compared(lambda law, drawn: [*by_sense(law, drawn), np.nan, 1.0], quantities=quantities)
    assert list(data["quantity"].values) == ["rotor_velocity", "tip_normal_amplitude"]
    assert "rms_current" in data.attrs["notes"]
    assert {*tables(data)["pairs"]["quantity"]} == {"rotor velocity", "tip normal amplitude"}
    alone = compared(lambda law, drawn: [*by_sense(law, drawn), 1.0], quantities=quantities[::2])
    np.testing.assert_array_equal(data["p_value"], alone["p_value"])


def test_a_basis_on_which_nothing_turns_has_no_difference() -> None:
    """With a mode less the rotor may stand still, which is no agreement of the laws."""
    data = compared(by_sense)
    assert np.isfinite(data["relative_other"]).all()
    setups = [cl.build(altered({}, law=law)) for law in THREE]
    design = Design.of(
        grid_of(setups), dict.fromkeys((x.keys[0] for x in USUAL), 0.0), 0, ["rotor_velocity"], None
    )
    parts = {}
    for key in design.nominal():
        still = key.endswith("basis")
        values = np.full((3, 1), 1e-9) if still else np.array([[1.0], [1.1], [1.2]])
        both = {name: (("law", "quantity"), x) for name, x in (("value", values), ("error", 0.0 * values))}
        parts[key] = xarray.DataTree(xarray.Dataset(both | {"failure": ("law", [""] * 3)}))
    card = scorecard([Reruns(run_of_setup(law, x, law)) for law, x in design.grid.first.items()], [])
    without = with_pairs(card.assign_attrs(limits=""), design, parts, MARGIN)
    assert np.isnan(without["relative_other"]).all()
    assert not any("-0" in text or "basis" in text for text in findings(without))


@pytest.mark.parametrize(("samples", "few"), [(0, False), (16, True), (32, False)])
def test_draws_that_can_show_no_order_are_announced_before_the_work(samples: int, few: bool) -> None:
    """Five quantities of two laws by one look take 24 draws of one outcome, and by two looks 27."""
    study = cl.Compare(samples=samples)
    setups = {law: cl.build(altered({}, law=law)) for law in ("newton", "hertz_penalty")}
    assert bool(study.notice(setups)) == few
    assert not cl.Compare(samples=16).notice({"newton": setups["newton"]})
