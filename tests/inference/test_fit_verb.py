"""Claims on `contactlab fit`: from made data to posterior and page, and what it refuses."""

import json
import os
import signal
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray

from contactlab.cli import fit
from contactlab.cli.terminal import RefusalError
from contactlab.config import ConfigurationError
from contactlab.inference import nested_sampling as nested
from contactlab.inference.fit import pose, read
from contactlab.inference.law_choice import sorted_words
from contactlab.inference.result import Row
from contactlab.measured.faults import MeasurementError
from contactlab.measured.files import read_impacts, write_impacts
from contactlab.measured.series import SeriesError
from contactlab.studies.fit_page import table

pytest.importorskip("dynesty", reason="There is no dynesty; pip install 'contactlab[fit]' brings it.")

RANGES = ["law.restitution=0.1..0.9", "contact.friction_coefficient=0.02..0.8"]


def make(folder, *words):
    assert fit.main(["--synthetic", *words, "--output", str(folder)]) == 0
    return str(folder / "data.nc")


@pytest.fixture(scope="module")
def impacts(tmp_path_factory):
    """A file of impacts under Newton's law."""
    truth = ["law=newton", "law.restitution=0.6", "contact.friction_coefficient=0.2"]
    return make(tmp_path_factory.mktemp("made"), "--impacts", "30", *truth, "--noise", "0.05")


def test_two_laws_are_weighed_and_leave_posteriors_that_arviz_reads(impacts, tmp_path, capsys):
    arguments = [impacts, "law=newton,lagrange_slip", *RANGES, "--points", "40", "--starts", "2", "--output"]
    assert fit.main([*arguments, str(tmp_path / "a")]) == 0
    said = capsys.readouterr().out

    assert "The evidence for newton against lagrange_slip is decisive" in said
    assert "starts found the optimum" in said
    names = {path.name for path in (tmp_path / "a").iterdir()}
    assert {"fit.html", "posterior_newton.nc", "corner_newton.png", "predictions_newton.pdf"} <= names
    assert not [name for name in names if name.startswith(".")]
    page = (tmp_path / "a" / "fit.html").read_text()
    assert "decisive" in page
    assert "http://" not in page
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import arviz

        found = arviz.from_netcdf(tmp_path / "a" / "posterior_newton.nc")
        table = arviz.summary(found, kind="stats")
        loo = arviz.loo(found)
    assert table.loc["law.restitution", "mean"] == pytest.approx(0.6, abs=0.05)
    assert np.isfinite(loo.elpd_loo)
    posterior = found.posterior
    assert json.loads(posterior.attrs["truth"])["law.restitution"] == 0.6
    assert posterior["law.restitution"].shape == (1, 1000)
    assert found.posterior_predictive["velocity_after"].dims == ("chain", "draw", "impact", "direction")


def test_the_truth_is_a_column_where_any_is_known_and_none_elsewhere():
    known = Row("restitution", "1", 0.6, 0.61, 0.01, 0.59, 0.63, 0.65)
    unknown = Row("noise", "1", np.nan, 0.02, 0.001, 0.018, 0.022, np.nan)
    heads, first, second = table([known, unknown])
    assert heads == ["", "best", "mean", "sd", "5 %", "95 %", "truth"]
    assert first[-1] == "0.65 (outside)"
    assert second == ["noise", "", "0.02", "0.001", "0.018", "0.022", ""]
    heads, line = table([unknown])
    assert heads[-1] == "95 %"
    assert line == second[:-1]


@pytest.mark.long
def test_the_same_fit_leaves_the_same_bytes(impacts, tmp_path):
    for name in ("a", "b"):
        fit.main(
            [
                impacts,
                "law=newton",
                *RANGES[:1],
                "--points",
                "25",
                "--starts",
                "2",
                "--output",
                str(tmp_path / name),
            ]
        )

    for file in ("fit.html", "posterior.nc"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


@pytest.mark.long
def test_a_fit_that_was_stopped_is_gone_on_with_by_the_same_command(impacts, tmp_path, monkeypatch, capsys):
    arguments = [impacts, "law=newton", *RANGES[:1], "--points", "25", "--starts", "2", "--output"]
    fit.main([*arguments, str(tmp_path / "whole")])
    with xarray.open_dataset(tmp_path / "whole" / "posterior.nc", group="posterior") as posterior:
        asked_whole = 2 + int(posterior.attrs["calls"])
    monkeypatch.setattr(nested, "EVERY", -1.0)
    asked, calls = nested.log_likelihood, []

    def counting(model, values):
        calls.append(values)
        if len(calls) == 150:
            # As Ctrl-C does at a terminal.
            os.kill(os.getpid(), signal.SIGINT)
        return asked(model, values)

    monkeypatch.setattr(nested, "log_likelihood", counting)
    with pytest.raises(KeyboardInterrupt, match="the same command goes on"):
        fit.main([*arguments, str(tmp_path / "stopped")])
    assert [path.suffix for path in (tmp_path / "stopped").iterdir()] == [".checkpoint"]
    assert 150 <= len(calls) < 200
    fit.main([*arguments, str(tmp_path / "stopped")])

    # It did not begin anew.
    assert len(calls) < asked_whole + 100
    whole, stopped = (tmp_path / name / "posterior.nc" for name in ("whole", "stopped"))
    assert whole.read_bytes() == stopped.read_bytes()


@pytest.mark.long
def test_a_rotor_velocity_says_that_a_law_with_a_wrong_stiffness_is_wrong(tmp_path, capsys):
    words = ["law=hertz_penalty", "solver.duration=3e-4", "record.interval=1e-5", "law.stiffness=1e10"]
    data = make(tmp_path / "made", *words, "contact.friction_coefficient=0.3")
    words = [data, "contact.friction_coefficient=0.1..0.5", "law.stiffness=1e9", "--discrepancy", "both"]
    assert fit.main([*words, "--points", "25", "--starts", "2", "--output", str(tmp_path)]) == 0

    said = capsys.readouterr().out
    assert "The evidence for hertz_penalty + discrepancy against hertz_penalty is decisive" in said
    with xarray.open_datatree(tmp_path / "posterior_hertz_penalty_discrepancy.nc") as found:
        assert found["posterior_predictive/rotor_velocity"].dims == ("chain", "draw", "time")
        assert float(found["posterior/discrepancy.rotor_velocity"].min()) > 0.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["law=newton", "law.restitution=0.9..0.1"], "the end must be greater than the start"),
        (["law=newton", "law.restitution=0.5..1.5"], "both must be at least 0 and at most 1, and 1.5 is not"),
        (["law=newton", "law.restitutoin=0..1"], "Did you mean law.restitution"),
        (
            ["law=newton,poisson", "law.stiffness=1..2"],
            "There is no number law.stiffness under any of these laws",
        ),
        (
            ["law=newton", "rotor.inertia=1e-7..1e-5"],
            "rotor.inertia=1e-7..1e-5 is none of a law, and impacts are of the law alone",
        ),
        (["law=newton", "drive.phase=1"], "drive.phase=1 is none of a law, and impacts are of the law alone"),
        (["law=newton", "solver.duration=1"], "or contact.friction_coefficient. Leave it out."),
        (["law=newton,poisson", "law.stiffness=1"], "law.stiffness"),
        (["law.restitution=0..1"], "The data tell no law; name one"),
        (["law=newton,newton"], "law=newton is given twice"),
        (["law=newtn"], "newton"),
        (["law=newton", "law.restitution=a..b"], "has an end which is not a number"),
        (["law=newton", "--series", "gap"], "the data are impacts"),
        (
            ["law=newton", "--noise", "free", "--discrepancy", "on"],
            "noise and discrepancy cannot be told apart",
        ),
    ],
)
def test_what_cannot_be_fitted_is_refused_in_a_sentence_and_leaves_nothing(impacts, tmp_path, words, said):
    with pytest.raises(RefusalError) as refused:
        fit.main([impacts, *words, "--output", str(tmp_path / "out")])

    assert said in str(refused.value)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["law=newton"], "there is no file; the first word must be one"),
        (["data.nc", "--points", "3"], "--points is 3, it must be at least 25"),
        (["data.nc", "--noise", "-1"], "--noise is -1, it must be greater than 0"),
        (["data.nc", "--impacts", "3"], "it must come with --synthetic"),
        (["--synthetic", "--discrepancy", "on"], "--discrepancy is of a fit"),
    ],
)
def test_options_that_do_not_fit_are_refused(capsys, words, said):
    with pytest.raises(SystemExit):
        fit.main(words)

    assert said in capsys.readouterr().err


def test_a_file_that_is_not_there_and_missing_packages_are_refused(tmp_path, monkeypatch):
    with pytest.raises(RefusalError, match="No such file"):
        fit.main([str(tmp_path / "none.nc"), "law=newton", "--output", str(tmp_path / "out")])
    monkeypatch.setattr(nested, "find_spec", {}.get)
    with pytest.raises(RefusalError, match=r"pip install 'contactlab\[fit\]'"):
        fit.main([str(tmp_path / "none.nc"), "law=newton", "--output", str(tmp_path / "out")])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["solver.duration=1"], "a fit, which takes its times from the data, has nothing of that"),
        (["record.interval=1e-6..2e-6"], "record.interval=1e-6..2e-6 says how runs are made or kept"),
        (["hydra.run.dir=x"], "--output DIR says where its files go"),
    ],
)
def test_words_that_have_no_say_in_a_fit_of_series_are_refused(tmp_path, words, said):
    data = tmp_path / "data.nc"
    velocity = ("time", np.linspace(0.0, 1.0, 8), {"units": "rad/s"})
    time = ("time", np.linspace(0.0, 1e-4, 8), {"units": "s"})
    xarray.Dataset({"rotor_velocity": velocity}, {"time": time}).to_netcdf(data)
    with pytest.raises(RefusalError) as refused:
        fit.main([str(data), "law=newton", *words, "--output", str(tmp_path / "out")])

    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--impacts", "5", "law=newton", "rotor.inertia=1e-6"], "impacts are of the law alone"),
        (["record.picture=false"], "a measured series has nothing of that"),
    ],
)
def test_words_that_have_no_say_in_made_data_are_refused(tmp_path, words, said):
    with pytest.raises(RefusalError, match=said):
        fit.main(["--synthetic", *words, "--output", str(tmp_path / "out")])

    assert not (tmp_path / "out").exists()


def test_data_that_are_made_tell_their_own_times(tmp_path, capsys):
    make(tmp_path, "law=newton", "solver.duration=1e-4", "record.interval=1e-5")

    assert f"contactlab fit {tmp_path}/data.nc law=newton`" in capsys.readouterr().out


def fitted(data, tmp_path, *words):
    """Fit with few points and return the attributes of each posterior by law."""
    folder = tmp_path / "out"
    assert fit.main([data, *words, "--points", "25", "--starts", "1", "--output", str(folder)]) == 0
    found = {}
    for path in folder.glob("posterior*.nc"):
        with xarray.open_dataset(path, group="posterior") as posterior:
            found[posterior.attrs["law"]] = posterior.attrs | {"names": {*posterior.data_vars}}
    return found


@pytest.mark.long
def test_every_law_of_a_race_has_its_own_free_numbers_and_a_composed_one_stands_beside_others(
    impacts, tmp_path
):
    ranges = ["contact.friction_coefficient=0.02..0.8"]
    parts = ["law/normal=walton_braun", "law.normal.loading_stiffness=1e7"]
    found = fitted(impacts, tmp_path, "law=newton,composed", *parts, *ranges)

    assert found["newton"]["names"] == {"contact.friction_coefficient", "law.restitution"}
    assert "law.normal.unloading_stiffness" in found["composed"]["names"]
    assert "law.normal.loading_stiffness" not in found["composed"]["names"]
    assert "law.normal.loading_stiffness" in found["newton"]["findings"]


def test_no_odds_and_a_warning_where_the_stated_noise_is_far_too_small(impacts, tmp_path, capsys):
    fitted(impacts, tmp_path, "law=newton,lagrange_slip", *RANGES, "--noise", "0.0025")
    said = capsys.readouterr().out

    assert "decisive" not in said
    assert "odds of" not in said
    assert said.count("Warning") == 2


def test_copies_of_impacts_are_warned_of_and_recorded(impacts, tmp_path, capsys):
    once = read_impacts(impacts)
    twice = once.part(np.repeat(np.arange(len(once)), 2))
    twice = replace(twice, number=np.arange(1, len(twice) + 1))
    write_impacts(twice, tmp_path / "twice.csv")
    fitted(str(tmp_path / "twice.csv"), tmp_path, "law=newton", *RANGES)
    assert "30 of 60 impacts" in capsys.readouterr().err


def test_series_in_csv_are_those_of_netcdf(tmp_path):
    time, velocity = np.linspace(0.0, 1e-4, 9), np.linspace(0.0, 2.0, 9)
    rows = "\n".join(f"{1e3 * t!r},{v!r}" for t, v in zip(time.tolist(), velocity.tolist(), strict=True))
    path = tmp_path / "series.csv"
    path.write_text(f"time [ms],rotor_velocity [rad/s]\n{rows}\n")
    found = read(path)

    np.testing.assert_allclose(found.time, time, rtol=1e-14)
    np.testing.assert_array_equal(found.values["rotor_velocity"], velocity)
    path.write_text(f"time [ms],rotor_velocity [m]\n{rows}\n")
    with pytest.raises(SeriesError):
        read(path)
    with pytest.raises(MeasurementError, match="series"):
        read_impacts(path)


def posed(data, *words):
    """Pose the questions of a fit by their labels."""
    questions = pose(read(Path(data)), sorted_words(words), "off", "data")
    return {question.label: question for question in questions}


def test_parts_of_a_composed_law_are_all_posed_and_never_twice(impacts):
    race = ["law=newton,composed", "law/normal=thornton", "law/friction=mindlin"]
    assert set(posed(impacts, *race, "law/normal=walton_braun")) == {
        "newton",
        "thornton + mindlin",
        "walton_braun + mindlin",
    }
    for again in ("law/normal=thornton", "law/normal=walton_braun,walton_braun", "law/friction=mindlin"):
        with pytest.raises(ConfigurationError):
            posed(impacts, *race, again)


def test_the_truth_is_that_of_a_composed_law_of_the_same_parts(tmp_path):
    data = make(
        tmp_path, "--impacts", "5", "law=composed", "law/damping=flores", "law.damping.restitution=0.7"
    )
    questions = posed(data, "law=newton,composed", "law/damping=flores,hunt_crossley")

    flores, other = (questions[f"hertz_point + {name} + coulomb"] for name in ("flores", "hunt_crossley"))
    assert flores.truth["law.damping.restitution"] == 0.7
    assert other.truth == {}
    assert questions["newton"].truth == {}
