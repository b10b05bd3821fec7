"""`contactlab compare` on settled motors: "due to the law" is said only of what stands above all else."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray
from support.command_line import Command
from support.configurations import altered, datatree

from contactlab import build, steady
from contactlab.comparison import ComparisonError, compare
from contactlab.comparison.cause_figures import draw_causes, draw_shares
from contactlab.comparison.causes import ATTRACTORS, BASIS, CAUSES, PARAMETERS, with_causes
from contactlab.comparison.findings import conclusion, differences, headline
from contactlab.comparison.reruns import Refined, on_other_basis, refined
from contactlab.comparison.samples import Design, Factor, Samples, factors_of, left_fixed
from contactlab.comparison.scorecard import as_text, scorecard
from contactlab.comparison.settled import QUANTITIES
from contactlab.comparison.weighing import (
    CLEAR,
    Weighed,
    samples_needed,
    shares_said,
    unclear,
    weighed,
    written_share,
)
from contactlab.metrics import METRICS, Run
from contactlab.parameter import Parameter

EXACT = {"contact.friction_coefficient": 0.0, "law.stiffness": 0.0, "contact.clearance": 0.0}
"""Ranges of parameters that are known exactly."""

OPPOSITE: dict[str, object] = {"contact.clearance": 3e-6}
"""A motor that Hertz's law turns forwards and rigid stick backwards."""

COEXISTING: dict[str, object] = {
    "drive.frequency": 3400.0,
    "contact.clearance": 1.6583e-5,
    "resonator.stiffness_damping": 1e-6,
}
"""A motor that is driven above its resonance and hardly damped: it turns, or its tip never gets there."""


def recorded(law: str, **changes: object) -> xarray.DataTree:
    keys = {key.replace("__", "."): value for key, value in changes.items()}
    return datatree(altered({"solver.duration": 1e-3, "record.picture": False} | keys, law=law))


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("settled") / "out"


@pytest.fixture(scope="module")
def opposite(output: Path) -> xarray.Dataset:
    """What remains is the law: parameters that are known, starts that lead to one motion."""
    runs = [recorded(law, **OPPOSITE) for law in ("lagrange_stick", "hertz_penalty")]
    return compare(runs, output, samples=0, starts=2, ranges=EXACT)


def test_what_stands_above_all_else_is_due_to_the_law(opposite: xarray.Dataset) -> None:
    (velocity, *_) = weighed(opposite)
    assert velocity.laws == ("lagrange_stick", "hertz_penalty")
    assert velocity.values[0] < 0.0 < velocity.values[1]
    assert velocity.due_to_law
    assert velocity.apart > 2.0 * velocity.weights[BASIS] > 0.0
    assert velocity.weights[PARAMETERS] == 0.0
    said = differences(opposite)[0]
    assert said.startswith("Settled rotor velocity: -1.8")
    assert "It is due to the law: all else moves it less, the basis (1." in said


def test_the_values_are_those_of_the_steady_states(opposite: xarray.Dataset) -> None:
    setup = build(altered(OPPOSITE, law="hertz_penalty"))
    found, error = steady(setup).velocity
    value = opposite["value"].sel(law="hertz_penalty", metric="rotor_velocity")
    assert error < 1e-6 * abs(found)
    assert float(value) == pytest.approx(found, rel=1e-6)
    # The balance of a period, not of the way there.
    torque = opposite["value"].sel(law="hertz_penalty", metric="torque")
    assert abs(float(torque)) < 1e-8
    assert float(opposite["energy"].sel(term="stored_energy", law="hertz_penalty")) == pytest.approx(
        0.0, abs=1e-8 * float(opposite["drive_work"].sel(law="hertz_penalty"))
    )


def test_a_recorded_run_that_has_not_settled_is_said_before_all(opposite: xarray.Dataset) -> None:
    said = headline(opposite)
    assert said[0].startswith("The recorded motor had not settled: ")
    assert "rad/s with lagrange_stick and" in said[0]
    assert said[1] == differences(opposite)[0]


def test_files_of_settled_motors_tell_causes_and_say_the_same(opposite: xarray.Dataset, output: Path) -> None:
    with xarray.open_dataset(output / "metrics.nc") as written:
        for name in ("value", "least", "greatest"):
            xarray.testing.assert_identical(written.load()[name], opposite[name])
        assert written["cause"].values.tolist() == list(CAUSES)
        assert written["quantity"].values.tolist() == list(QUANTITIES)
    page = (output / "report.html").read_text(encoding="utf-8")
    first, sentence = headline(opposite)[:2]
    assert page.index(first) < page.index(sentence) < page.index("settled motor with every law")
    assert page.index("settled motor with every law") < page.index("Scorecard")
    for name in ("settled_quantities", "contact_force", "tip_trajectory", "energy_flow", "phase_portrait"):
        assert (output / f"{name}.png").stat().st_size > 5000, name
    # Nothing was drawn, and a rotor velocity over a period says nothing.
    for name in ("variance_shares", "rotor_velocity"):
        assert not (output / f"{name}.png").exists(), name


def test_the_converged_basis_explains_the_default_motors_difference() -> None:
    runs = [recorded(law) for law in ("lagrange_stick", "hertz_penalty")]
    data = compare(runs, samples=0, starts=1, ranges=EXACT)
    velocity = weighed(data)[0]
    assert velocity.apart == pytest.approx(0.76, abs=0.01)
    assert velocity.possible == [BASIS]
    assert not velocity.due_to_law
    assert "It may be the basis (1.5), and was not weighed against what the start does" in str(velocity)
    assert "so it is not shown to be due to the law" in str(velocity)
    # On the converged basis, as the sentence after it has it.
    assert "On the other basis: -1.44 (lagrange_stick) to -1.31 rad/s (hertz_penalty)" in differences(data)[1]


@pytest.mark.long
def test_parameters_within_their_ranges_explain_what_laws_that_are_close_differ_by() -> None:
    laws = [refined(Run.of(recorded("hertz_penalty", law__stiffness=k))) for k in (1e10, 1.1e10)]
    for number, law in enumerate(laws):
        law.run = replace(law.run, label=f"law {number}")
        # Neither basis nor start shall explain it too.
        law.elsewhere = None
    factors = factors_of(laws, {})
    design = Design(laws, factors, 8)
    samples = design.samples([*design.run()])
    data = with_causes(scorecard(laws), laws, factors, samples)
    velocity = weighed(data)[0]
    assert velocity.possible == [PARAMETERS]
    assert velocity.unknown == [BASIS, ATTRACTORS]
    assert "It may be the friction coefficient, stiffness and clearance within their ranges (" in str(
        velocity
    )
    assert data.attrs["parameters"] == "friction coefficient +-33 %, stiffness +-30 %, clearance +-20 %"
    assert data.sizes["motor"] == 8 * (data.sizes["factor"] + 2)
    assert "Shares in the variance" in differences(data)[-1]
    (drawn,) = draw_shares(data).axes
    assert [words.get_text().split("\n")[0] for words in drawn.get_yticklabels()][-1] in data["factor"]


def test_a_coexisting_motion_is_said_first_and_is_no_difference_of_the_laws() -> None:
    one, other = (recorded("hertz_penalty", **COEXISTING, law__stiffness=k) for k in (1e10, 5e9))
    data = compare([one, other], samples=0, starts=5, ranges=EXACT)
    assert any("settles to more than one motion, by where it starts: " in said for said in headline(data)[:4])
    velocity = weighed(data)[0]
    assert ATTRACTORS in velocity.possible
    assert "the start (" in str(velocity)


def example(**weights: float) -> Weighed:
    all_weights = dict.fromkeys(CAUSES, 0.0) | {key.replace("_", " "): x for key, x in weights.items()}
    metric = METRICS["rotor_velocity"]
    return Weighed(metric, ("stick", "hertz"), (-2.95, -2.19), all_weights, "the clearance", ())


@pytest.mark.parametrize("cause", CAUSES)
def test_each_cause_alone_withholds_the_law(cause: str) -> None:
    below, above, unknown = (
        replace(example(), weights=example().weights | {cause: x}) for x in (0.5, 0.8, np.nan)
    )
    assert below.due_to_law
    assert "It is due to the law" in str(below)
    for one in (above, unknown):
        assert not one.due_to_law
        assert "so it is not shown to be due to the law." in str(one)
    assert above.possible == [cause]
    assert unknown.unknown == [cause]


def test_what_it_may_be_is_named_largest_first_with_numbers() -> None:
    said = str(example(parameters=0.9, basis=1.6, start=0.1))
    assert said == (
        "Settled rotor velocity: -2.95 (stick) to -2.19 rad/s (hertz), 0.76 apart. It may be the basis (1.6) "
        "or the clearance within its range (0.9), so it is not shown to be due to the law."
    )
    # Of the numerical errors three times count.
    assert f"the numerical error ({CLEAR:g} times 0.3)" in str(example(numerical_error=0.9))


def test_a_quick_look_claims_nothing() -> None:
    runs = [recorded(law, **OPPOSITE) for law in ("newton", "hertz_penalty")]
    data = compare(runs, refine=False)
    assert "Nothing is known of what else could explain it" in differences(data)[0]
    assert np.isnan(data["numerical_error"]).all()
    assert float(data["value"].sel(law="hertz_penalty", metric="rotor_velocity")) == pytest.approx(
        1.17, abs=0.01
    )


def test_a_file_of_ones_own_is_not_known_to_have_settled() -> None:
    own = recorded("hertz_penalty").to_dataset(inherit=False)[["rotor_velocity", "rotor_angle"]]
    own.attrs = {"law": "bench"}
    data = compare([xarray.DataTree(own), recorded("newton", **OPPOSITE)], refine=False)
    assert not any("Settled" in said for said in differences(data) if "bench" in said)
    assert headline(data)[1] == "bench is taken as recorded: whether its motor has settled is not known."
    assert conclusion(data)
    assert "bench" in as_text(data)


def settled_law(**changes: object) -> Refined:
    """A law as `refined` leaves it, without the work."""
    law = Refined(Run.of(recorded("hertz_penalty", **changes)))
    law.seconds = [0.1, 0.1]
    return law


def test_the_same_bits_by_any_number_of_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    law = settled_law(**OPPOSITE)
    factors = factors_of([law], {})
    assert [factor.name for factor in factors] == ["friction coefficient", "stiffness", "clearance", "step"]
    design = Design([law], factors, 1)
    answers = []
    for workers in (1, 2):
        monkeypatch.setattr(Design, "workers", workers)
        answers.append(design.samples([*design.run()]).values)
    np.testing.assert_array_equal(*answers)
    assert np.isfinite(answers[0]).all()


def test_ranges_are_those_that_the_runs_state_and_those_that_are_given() -> None:
    stated = settled_law(uncertainty__clearance_spread=0.05, uncertainty__friction_spread=0.0)
    named = {f.name: f.spread for f in factors_of([stated], {"law.stiffness": 0.1, "rotor.inertia": 0.02})}
    assert named == {"stiffness": 0.1, "clearance": 0.05, "rotor.inertia": 0.02, "step": 0.0}
    with pytest.raises(ComparisonError) as refused:
        factors_of([stated], {"rotor.mass": 0.1, "contact.clearance": 1.5})
    assert [fault.split(";")[0] for fault in refused.value.faults] == [
        "The range of rotor.mass is given, which is no number of any run compared",
        "The range of contact.clearance is 1.5",
    ]
    # The drawn scales fill the range evenly.
    drawn = Factor("x", ("contact.clearance",), 0.2).at(np.array([0.0, 0.5, 1.0]))
    np.testing.assert_allclose(drawn, [0.8, 1.0, 1.2])


def test_a_law_of_ones_own_has_varied_what_it_declares_and_the_rest_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Two springs in series, of which the first declares how well it is known."""
    hertz = Refined(Run.of(recorded("hertz_penalty")))
    springs = {"name": "two_springs", "k1": 2e7, "k2": 3e7}
    hertz.run = replace(hertz.run, label="hertz_penalty")
    configuration = {**hertz.run.configuration, "law": springs}
    own = Refined(replace(hertz.run, label="two_springs", configuration=configuration))
    declared = {
        "law.k1": Parameter("k1", "N m-1", "stiffness", above=0.0, spread=0.4),
        "law.k2": Parameter("k2", "N m-1", "stiffness", above=0.0),
    }
    monkeypatch.setattr("contactlab.comparison.samples.declared_in", lambda _: declared)
    factors = factors_of([own], {})
    named = {factor.name: (factor.keys, factor.spread) for factor in factors}
    assert named["law.k1"] == (("law.k1",), 0.4)
    assert "stiffness" not in named
    assert left_fixed(own.run, factors, {}) == ["k2"]
    assert left_fixed(own.run, factors, {"law.k2": 0.0}) == []
    with_hertz = factors_of([hertz, own], {})
    assert left_fixed(hertz.run, with_hertz, {}) == []
    data = with_causes(scorecard([hertz, own]), [hertz, own], with_hertz, None)
    # "stiffness +-30 %" is not of the law that has no such parameter.
    assert "stiffness +-30 %" in str(data["varied"].values[0])
    assert "stiffness" not in str(data["varied"].values[1])
    assert data["not_varied"].values.tolist() == ["", "k2"]
    assert "k2 of two_springs" in " ".join(differences(data))


def test_shares_of_levels_and_ranges_are_those_of_the_closed_form() -> None:
    """y = a l + b x + c l x of a level l: variances a^2 2/3, b^2 s^2/3, of both together c^2 2/3 s^2/3."""
    factors = (Factor("law", levels=3), Factor("x", ("contact.clearance",), 0.3), Factor("step", levels=3))
    design = Design([settled_law()] * 3, factors, 512)
    level, x = design.drawn[:, 0] - 1.0, design.drawn[:, 1] - 1.0
    a, b, c = 1.0, 4.0, 3.0
    y = a * level + b * x + c * level * x
    parts = np.array([a**2 * 2.0 / 3.0, b**2 * 0.03, c**2 * 2.0 / 3.0 * 0.03])
    samples = Samples(
        factors, 512, design.drawn, np.column_stack([y, *[np.full(y.size, np.nan)] * 3]), ("",) * y.size
    )
    first, total = samples.shares()
    np.testing.assert_allclose(first[0, :, 0], [*parts[:2] / parts.sum(), 0.0], atol=0.03)
    np.testing.assert_allclose(total[0, :, 0], [*(parts[:2] + parts[2]) / parts.sum(), 0.0], atol=0.03)
    assert np.all(total[0, :, 1] <= total[0, :, 0] + 1e-12)
    assert not unclear(*total[0, 0, 1:])
    assert unclear(0.0, 0.9)
    # A share of 0.89 to which 0.57 to 1.33 belong is not known.
    assert unclear(0.57, 1.33)
    assert not unclear(-0.05, 0.03)
    assert written_share(-0.01, -0.05, 0.03) == "below 0.03"
    # The width of a mean falls with the root of the samples, here from 0.76 to below 0.3.
    assert samples_needed(np.array([[0.89, 0.57, 1.33]]), 32) == 256
    # Rows without a steady state are left out.
    holed = replace(samples, values=np.where(np.arange(y.size)[:, None] == 5, np.nan, samples.values))
    np.testing.assert_allclose(holed.shares()[1][0, :, 0], total[0, :, 0], atol=0.1)


def test_figures_draw_no_share_beyond_one_and_none_that_the_samples_do_not_tell() -> None:
    laws, quantities = ["a", "b"], list(QUANTITIES)
    value = np.array([[-2.0, 3.0, 0.95, 0.5], [-1.9, 3.1, 0.0, 0.5]])
    moved = np.broadcast_to(value[:, None, :], (2, len(CAUSES), 4))
    estimates = np.array([[0.89, 0.57, 1.33], [0.3, 0.2, 0.35]])
    data = xarray.Dataset(
        {
            "value": (("law", "metric"), value),
            "least": (("law", "cause", "quantity"), moved - 0.04),
            "greatest": (("law", "cause", "quantity"), moved + 0.04),
            **{
                name: (("quantity", "factor", "estimate"), np.broadcast_to(estimates, (4, 2, 3)))
                for name in ("first_order", "total_order")
            },
        },
        coords={
            "law": laws,
            "kind": ("law", ["periodic", "periodic"]),
            "metric": quantities,
            "quantity": quantities,
            "cause": list(CAUSES),
            "factor": ["basis", "law"],
            "motor": np.arange(32 * 4),
        },
    )
    # Three times the numerical error of 0.04 is 1.07.
    ends = [
        x
        for bars in draw_causes(data).axes[quantities.index("stick_share")].collections
        for segment in bars.get_segments()
        for x in segment[:, 0]
    ]
    assert (min(ends), max(ends)) == (0.0, pytest.approx(1.0))
    (axes,) = draw_shares(data).axes
    assert sorted(bar.get_width() for bar in axes.patches) == [0.3, 0.3]
    said = shares_said(data)
    assert "law 0.30 (0.20 to 0.35)" in said
    assert "0.89" not in said
    assert "32 samples do not tell the share of basis; about 256 would" in said


def test_the_other_basis_is_the_converged_one_whose_first_frequency_the_drive_follows() -> None:
    given, words = on_other_basis(build(altered({}, law="hertz_penalty")))
    there = build(given)
    assert words == "with resonator=finite_element"
    assert there.motor.drive.frequency[0] == there.motor.modes.natural_frequency[0] == pytest.approx(2137.53)
    assert given["resonator"]["length"] == pytest.approx(57e-3)
    # One that is given stays.
    fixed, _ = on_other_basis(build(altered({"drive.frequency": 3000.0}, law="hertz_penalty")))
    assert build(fixed).motor.drive.frequency[0] == 3000.0
    more, words = on_other_basis(there)
    assert more["resonator"]["kept_modes"] == given["resonator"]["kept_modes"] + 4
    assert words.startswith("with resonator.kept_modes ")


def test_the_command_says_it_first(
    opposite: xarray.Dataset, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    asked: dict[str, object] = {}

    def compared(*_: object, **options: object) -> xarray.Dataset:
        asked.update(options)
        return opposite

    monkeypatch.setattr("contactlab.cli.compare.compare", compared)
    ranges = ("--range", "contact.clearance=0.1", "--range", "rotor.inertia=0")
    status, out, err = command("compare", "here", "--samples", "16", *ranges)
    assert (status, err) == (0, "")
    assert out.index("had not settled") < out.index("Settled rotor velocity") < out.index("must be")
    assert out.isascii()
    assert asked["ranges"] == {"contact.clearance": 0.1, "rotor.inertia": 0.0}
    assert (asked["samples"], asked["transient"], asked["refine"]) == (16, False, True)
    assert "has no share" in command("compare", "here", "--range", "contact.clearance")[2]


def test_a_number_of_samples_that_is_none_is_refused() -> None:
    with pytest.raises(ComparisonError, match="samples is 3; it must be a power of two"):
        compare([], samples=3)
