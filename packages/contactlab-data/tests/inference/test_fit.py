"""Claims on fits: from synthetic data to posterior, evidence and page, and what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray
from support.command_line import Command

import contactlab as cl
from contactlab.config import ConfigurationError
from contactlab.studies.keys import study_in
from contactlab_data.inference.synthetic import made_impacts, made_series, without_errors
from contactlab_data.measured.files import read_impacts, write_impacts

FREE = {"law.restitution": (0.1, 0.9), "contact.friction_coefficient": (0.02, 0.8)}
FEW = {"points": 25, "starts": 1}


def laws(*names, overrides=()):
    return [cl.build([f"law={name}", *overrides]) for name in names]


@pytest.fixture(scope="module")
def impacts(tmp_path_factory):
    """A file of impacts under Newton's law."""
    path = tmp_path_factory.mktemp("made") / "impacts.nc"
    setup = cl.build(["law=newton", "law.restitution=0.6", "contact.friction_coefficient=0.2"])
    write_impacts(made_impacts(setup.law, 30, 0.05, 0, setup.configuration), path)
    return path


@pytest.fixture(scope="module")
def compared(impacts):
    """The fit of the true law and of one that fits badly."""
    return cl.fit(laws("newton", "lagrange_slip"), data=impacts, free=FREE, **FEW)


@pytest.mark.long
def test_two_laws_are_compared_by_evidence_and_leave_their_posteriors(compared, tmp_path):
    result = compared
    result.save(tmp_path)

    difference = np.subtract(*(result.data[law].attrs["log_evidence"] for law in ("newton", "lagrange_slip")))
    assert difference > np.log(100.0)
    assert result.numbers["newton.law.restitution"].value == pytest.approx(0.6, abs=0.05)
    assert {"evidence", "posterior_newton", "correlation_newton"} <= {*result.tables}
    assert {"fit.nc", "report.html", "corner_newton.png", "predictions_newton.pdf", "evidence.csv"} <= {
        path.name for path in tmp_path.iterdir()
    }
    page = (tmp_path / "report.html").read_text()
    assert "http://" not in page
    with xarray.open_datatree(tmp_path / "fit.nc") as tree:
        fit = tree["newton"]
        assert json.loads(fit.attrs["truth"])["law.restitution"] == 0.6
        assert fit["posterior"]["law.restitution"].shape == (1, 1000)
        # The groups and dimensions of ArviZ.
        assert fit["posterior_predictive/velocity_after"].dims == ("chain", "draw", "impact", "direction")
        assert fit["log_likelihood/velocity_after"].dims == ("chain", "draw", "impact")
        assert fit["observed_data/velocity_after"].dims == ("impact", "direction")
        assert fit["sample_stats/lp"].shape == (1, 1000)
        row = fit["summary"].to_dataset().sel(parameter="law.restitution")
        assert float(row["low"]) < float(row["mean"]) < float(row["high"])
        assert float(row["truth"]) == 0.6


def test_the_truth_is_a_column_where_it_is_known(compared, impacts):
    known = compared.tables["posterior_newton"]
    measured = read_impacts(impacts)
    few = without_errors(measured.part(np.arange(10)))
    unknown = cl.fit(laws("poisson"), data=few, **FEW).tables["posterior"]

    assert sorted(known["truth"].tolist()) == [0.2, 0.6]
    assert "truth" not in unknown
    assert unknown["number"].tolist()[-1] == "discrepancy"


@pytest.mark.long
def test_a_rotor_velocity_shows_that_a_law_with_a_wrong_stiffness_is_wrong():
    overrides = ["law=hertz_penalty", "solver.duration=3e-4", "record.interval=1e-5", "law.stiffness=1e10"]
    data = made_series(
        cl.build([*overrides, "contact.friction_coefficient=0.3"]), ["rotor_velocity"], 0.01, 0
    )
    result = cl.fit(
        cl.build(data.configuration).with_("law.stiffness=1e9"),
        data=data,
        free={"contact.friction_coefficient": (0.1, 0.5)},
        discrepancy="both",
        points=25,
        starts=2,
    )

    fit = result.data["hertz_penalty + discrepancy"]
    assert fit.attrs["log_evidence"] > result.data["hertz_penalty"].attrs["log_evidence"] + np.log(100.0)
    assert fit["posterior_predictive/rotor_velocity"].dims == ("chain", "draw", "time")
    assert float(fit["posterior/discrepancy.rotor_velocity"].min()) > 0.0


@pytest.mark.parametrize(
    ("names", "options", "named"),
    [
        (["newton"], {"free": {"law.restitution": (0.9, 0.1)}}, "law.restitution"),
        (["newton"], {"free": {"law.restitutoin": (0, 1)}}, "law.restitutoin"),
        (["newton", "poisson"], {"free": {"law.stiffness": (1, 2)}}, "law.stiffness"),
        (["newton"], {"free": {"rotor.inertia": (1e-7, 1e-5)}}, "rotor.inertia"),
        (["newton"], {"free": {"solver.duration": (1, 2)}}, "solver.duration"),
        ([], {"free": {"law.restitution": (0, 1)}}, "law"),
        (["newton"], {"free": FREE, "known": ["law.restitution"]}, "law.restitution"),
        (["newton"], {"series": ["gap"]}, "study.series"),
        (["newton"], {"noise": "free", "discrepancy": "on"}, "discrepancy"),
    ],
)
def test_what_cannot_be_fitted_is_refused_with_its_key(impacts, tmp_path, names, options, named):
    with pytest.raises(ConfigurationError, match=named):
        cl.fit(laws(*names), data=impacts, output=tmp_path / "out", **options)

    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "kind"),
    [({"noise": -1.0}, ValueError), ({"noise": 2.0}, ValueError), ({"student": "none"}, TypeError)],
)
def test_noise_is_a_number_or_free(impacts, tmp_path, options, kind):
    with pytest.raises(kind, match=next(iter(options))):
        cl.fit(laws("newton"), data=impacts, output=tmp_path / "out", **options)

    with pytest.raises(ConfigurationError, match=f"study.{next(iter(options))}"):
        study_in({"name": "fit", **options})
    assert study_in({"name": "fit", "noise": "free", "student": "4"}).noise == "free"


def test_a_file_that_is_not_there_is_refused(impacts, tmp_path):
    with pytest.raises(ConfigurationError, match="none"):
        cl.fit(laws("newton"), data=tmp_path / "none.nc")
    with pytest.raises(TypeError, match="setups"):
        cl.fit(str(impacts))


@pytest.mark.long
def test_several_laws_have_free_numbers_of_their_own(impacts):
    dent = cl.build(["law=composed", "law/normal=walton_braun", "law.normal.loading_stiffness=1e7"])
    free = {"contact.friction_coefficient": (0.02, 0.8)}
    known = ["law.normal.loading_stiffness"]
    result = cl.fit([*laws("newton"), dent], data=impacts, free=free, known=known, **FEW)
    newton, composed = (fit["summary"]["parameter"].values.tolist() for fit in result.data.children.values())

    assert {*newton} == {"contact.friction_coefficient", "law.restitution"}
    assert "law.normal.unloading_stiffness" in composed
    assert "law.normal.loading_stiffness" not in composed
    assert "law.normal.loading_stiffness" in result.data["newton"].attrs["findings"]


@pytest.mark.long
def test_no_odds_are_stated_where_the_stated_noise_is_far_too_small(impacts):
    result = cl.fit(laws("newton", "lagrange_slip"), data=impacts, free=FREE, noise=0.0025, **FEW)

    assert not any("odds of" in line for line in result.findings)
    assert not result.data["newton"].attrs["covers"]


def test_the_verbs_make_data_and_fit_them(command: Command) -> None:
    status, _, _ = command("synthetic", "law=newton", "law.restitution=0.6", "impacts=20", "noise=0.05")
    assert status == 0
    overrides = ["law=newton", "law.restitution=0.1..0.9", "points=25", "starts=1", "output=here"]
    status, out, _ = command("fit", "synthetic/synthetic.nc", *overrides)
    assert status == 0
    assert "law.restitution" in out
    assert Path("here/fit.nc").exists()
    assert not Path("here/tasks").exists()


@pytest.mark.parametrize("word", ["drive.phase=1", "contact.clearance=2 um", "solver.duration=1"])
def test_a_command_refuses_what_impacts_do_not_depend_on(command: Command, impacts, word) -> None:
    status, _, error = command("fit", str(impacts), "law=newton", word, "output=no")
    assert status == 2
    assert word.partition("=")[0] in error
    assert not Path("no").exists()


def test_setups_of_one_law_are_named_by_their_labels(impacts):
    poor, good = (laws("newton", overrides=[f"law.restitution={e}"])[0] for e in (0.1, 0.6))
    free = {"contact.friction_coefficient": (0.02, 0.8)}
    setups, known = {"poor": poor, "good": good}, ["law.restitution"]
    result = cl.fit(setups, data=impacts, free=free, known=known, **FEW)
    evidence = {label: fit.attrs["log_evidence"] for label, fit in result.data.children.items()}
    assert evidence["good"] > evidence["poor"] + np.log(100.0)


@pytest.mark.parametrize("method", ["nested", "least_squares"])
def test_the_page_has_least_squares_before_nested_sampling_begins(impacts, tmp_path, monkeypatch, method):
    from contactlab_data.studies import fit as module

    def interrupted(*_, **_others):
        raise KeyboardInterrupt

    monkeypatch.setattr(module, "sampled", interrupted)
    options = {"data": impacts, "free": FREE, "output": tmp_path / "out", "method": method}
    if method == "nested":
        with pytest.raises(KeyboardInterrupt):
            cl.fit(laws("newton"), **options)
        result = cl.load(tmp_path / "out" / "fit.nc")
    else:
        result = cl.fit(laws("newton"), **options)
        assert not (tmp_path / "out" / "tasks").exists()
    assert (tmp_path / "out" / "report.html").exists()
    assert result.data["newton"].attrs["method"] == "least squares"
    assert result.numbers["law.restitution"].value == pytest.approx(0.6, abs=0.05)
    assert result.tables["held_out"]["held out"].tolist() == [f"fold {i}" for i in range(1, 6)]


def test_of_least_squares_no_odds_follow(impacts):
    result = cl.fit(laws("newton", "lagrange_slip"), data=impacts, free=FREE, method="least_squares")
    evidence = result.tables["evidence"].set_index("law")
    assert not any("odds of" in line for line in result.findings)
    assert evidence["held out"]["newton"] < evidence["held out"]["lagrange_slip"]
