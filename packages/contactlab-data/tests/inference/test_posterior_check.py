"""Claims on the posterior predictive check: it is chi-square, rejects misfits, and comes before any odds."""

from dataclasses import replace
from math import log

import numpy as np
import pytest
import xarray
from inference.linear import SIGMA, Linear
from scipy.stats import chi2

import contactlab as cl
from contactlab.config.schema import declared_in
from contactlab.studies.compare.repeats import MARGIN
from contactlab_data.inference.candidates import Candidate
from contactlab_data.inference.evidence import compared, misfits
from contactlab_data.inference.fit import IMPROBABLE, REPLICAS, _predictive, fitted, succession
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.motor_problem import root_mean_square, series_problem
from contactlab_data.inference.synthetic import made_impacts, made_series

FRICTION = {"contact.friction_coefficient": (0.02, 0.8)}
FEW = {"points": 25, "starts": 1}


def test_the_p_value_at_fixed_numbers_is_that_of_chi_square() -> None:
    problem, truth = Linear(), np.array([0.3, 0.5])
    square = float(np.sum(problem.residuals(truth) ** 2))
    assert problem.deviance(problem.predict(truth), truth, {"y": problem.values}) == pytest.approx(
        square, rel=1e-12
    )

    _, checks = _predictive(problem, np.tile(truth, (1000, 1)), 0, problem.predict)
    exact = chi2.sf(square, 12)
    assert abs(checks["p_deviance"] - exact) < 4.0 * np.sqrt(exact * (1.0 - exact) / (1000 * REPLICAS))
    # The measurements are drawn as their replicas are.
    assert IMPROBABLE < checks["p_succession"] < 1.0 - IMPROBABLE


def test_a_misfit_that_is_no_function_has_no_best_value_and_no_odds(monkeypatch: pytest.MonkeyPatch) -> None:
    right = fitted(Candidate("line", Linear(), {}, {}, ""), **FEW)
    assert right.attrs["fits"]
    assert np.isfinite(right["summary"]["best"].values).all()
    monkeypatch.setattr(Linear, "spread", lambda *_: 2.0 * MARGIN)
    fit = fitted(Candidate("other", Linear(), {}, {}, ""), **FEW)
    assert fit.attrs["spread"] == 2.0 * MARGIN
    assert not fit.attrs["fits"]
    assert fit.attrs["best_fit"] == "{}"
    assert np.isnan(fit["summary"]["best"].values).all()
    assert "10 %" in misfits({"other": fit})["other"]
    assert not any("odds of" in line for line in compared({"line": right, "other": fit}))


def test_a_bent_line_is_rejected_by_its_succession_where_coverage_is_as_it_should_be() -> None:
    problem = Linear()
    problem.values = 0.3 + 0.5 * problem.time + 1.3 * SIGMA * np.cos(2.0 * np.pi * problem.time)
    problem.data = xarray.Dataset({"y": ("time", problem.values, {"units": "1"})}, {"time": problem.time})
    fit = fitted(Candidate("line", problem, {}, {}, ""), **FEW)

    assert fit.attrs["covers"]
    assert fit.attrs["p_succession"] < IMPROBABLE
    assert not fit.attrs["fits"]


def test_succession_is_the_largest_correlation_of_successive_residuals() -> None:
    draws = np.random.default_rng(0).standard_normal((2, 50))
    predicted = {"a": np.zeros(50), "b": np.ones(50)}
    expected = max(np.sum(x[1:] * x[:-1]) / np.sum(x**2) for x in (draws[0], draws[1] - 1.0))
    observed = dict(zip(predicted, draws, strict=True))
    assert succession(["a", "b"], predicted, np.empty(0), observed) == pytest.approx(expected, rel=1e-12)


@pytest.mark.long
def test_without_the_true_law_there_are_no_odds_and_the_page_says_so_first(tmp_path) -> None:
    truth = cl.build(["law=newton", "law.restitution=0.6", "contact.friction_coefficient=0.2"])
    data = made_impacts(truth.law, 30, 0.02, 0, truth.configuration)
    wrong, every = ["lagrange_slip", "lagrange_stick"], ["lagrange_slip", "lagrange_stick", "newton"]
    both = cl.fit([*map(cl.law, wrong)], data=data, free=FRICTION, **FEW)
    both.save(tmp_path)
    complete = cl.fit([*map(cl.law, every)], data=data, free=FRICTION, **FEW)

    evidence = [both.data[law].attrs["log_evidence"] for law in wrong]
    assert abs(evidence[0] - evidence[1]) > 100.0 * log(10.0)
    assert not any(both.data[law].attrs["fits"] for law in wrong)
    assert not any("odds of" in line for line in both.findings)
    assert both.tables["evidence"]["fits"].tolist() == ["no", "no"]
    first = both.findings[0]
    with xarray.open_datatree(tmp_path / "fit.nc") as tree:
        assert tree.attrs["comparison"].splitlines()[0] == first
    page = (tmp_path / "report.html").read_text()
    assert page.index("lagrange_slip (p = 0.000") < page.index("lagrange_stick has a larger evidence")

    assert complete.data["newton"].attrs["fits"]
    assert sum("odds of" in line for line in complete.findings) == 2


def test_a_noise_of_free_size_does_not_hide_a_wrong_motor() -> None:
    motor = ["law=hertz_penalty", "solver.duration=5e-4", "record.interval=1e-5"]
    setup = cl.build([*motor, "law.stiffness=1e10", "contact.friction_coefficient=0.3"])
    data = replace(made_series(setup, ["rotor_velocity"], 0.01, 1), errors={})
    declared = declared_in(setup.configuration)["rotor.inertia"]
    free = FreeParameter("rotor.inertia", 1e-7, 1e-4, True, declared)
    problem = series_problem(data, setup.configuration, (free,), discrepancy=False)
    inertia, size = setup.motor.rotor.inertia, root_mean_square(data.values["rotor_velocity"])
    checks = []
    for value in (inertia, 3.0 * inertia):
        noise = size * float(np.std(problem.residuals(np.array([value]))))
        checks.append(_predictive(problem, np.tile([value, noise], (40, 1)), 0, problem.predict)[1])
    right, wrong = checks

    assert min(right.values()) > 0.1
    assert wrong["p_deviance"] > 0.1
    assert wrong["p_succession"] == 0.0
