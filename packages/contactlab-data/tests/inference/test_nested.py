"""Claims on nested sampling: closed forms, quadrature, and the same bits however it is run."""

import pickle
import sys
from hashlib import sha256
from importlib import import_module
from io import BytesIO

import numpy as np
import pytest
from inference.linear import Linear
from scipy.special import logsumexp
from scipy.stats import kstest

import contactlab as cl
from contactlab.foreign import digest_of_sources
from contactlab_data.inference import nested_sampling as nested
from contactlab_data.inference.evidence import strength
from contactlab_data.inference.free_parameters import free_parameters, from_cube
from contactlab_data.inference.impact_problem import ImpactProblem, LawPredictor
from contactlab_data.inference.nested_sampling import sample
from contactlab_data.inference.synthetic import made_impacts, without_errors


class Stopped(Linear):
    """Interrupted at an evaluation."""

    def __init__(self, after):
        super().__init__()
        self.left = after

    def log_likelihood(self, values):
        self.left -= 1
        if self.left == 0:
            raise KeyboardInterrupt
        return super().log_likelihood(values)


class Counting(Linear):
    """Counts its evaluations."""

    calls = 0

    def log_likelihood(self, values):
        self.calls += 1
        return super().log_likelihood(values)


def test_evidence_mean_and_deviation_of_a_linear_model_are_its_closed_form():
    model = Linear()
    mean, covariance, log_evidence = model.closed_form()

    result = sample(model, points=200, seed=3)

    assert result.error < 0.25
    assert result.log_evidence == pytest.approx(log_evidence, abs=3.0 * result.error)
    own, spread = result.moments()
    # So far off is a mean of so many effective samples.
    assert np.abs(own - mean).max() < 4.0 * np.sqrt(covariance.max() / result.effective)
    np.testing.assert_allclose(np.sqrt(np.diag(spread)), np.sqrt(np.diag(covariance)), rtol=0.12)
    inside = result.quantiles((0.05, 0.95))
    width = 2.0 * 1.6449 * np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(inside[:, 1] - inside[:, 0], width, rtol=0.12)


def test_a_number_that_the_data_do_not_know_keeps_its_prior():
    result = sample(Linear(idle=True), points=100, seed=4)
    draws = result.samples[result.draws(int(result.effective)), 2]

    assert kstest(draws, "uniform", args=(-2.0, 4.0)).pvalue > 0.01
    assert kstest(result.samples[result.draws(200), 1], "uniform", args=(-2.0, 4.0)).pvalue < 1e-6


def test_evidence_of_impacts_is_that_of_quadrature():
    law = cl.law("newton", restitution=0.6, friction_coefficient=0.2)
    data = made_impacts(law, 5, 0.1, 2)
    free = free_parameters(law, {"restitution": (0.2, 0.9), "friction_coefficient": (0.05, 0.5)})
    problem = ImpactProblem(data, LawPredictor(law, free, ""))
    middles = (np.arange(40) + 0.5) / 40
    grid = [problem.log_likelihood(from_cube(free, (x, y))) for x in middles for y in middles]

    result = sample(problem, points=100, seed=1)

    assert result.log_evidence == pytest.approx(logsumexp(grid) - np.log(1600), abs=3.0 * result.error)


@pytest.mark.long
def test_a_number_that_fills_its_range_beside_one_that_is_well_known_costs_few_evaluations():
    # With so much friction every contact sticks: ellipsoids that hold all of it reach far out of the prior.
    law = cl.law("newton", restitution=0.86, friction_coefficient=0.54)
    data = without_errors(made_impacts(law, 60, 0.05, 63))
    free = free_parameters(law, {"restitution": (0.0, 1.0), "friction_coefficient": (0.02, 0.8)})

    result = sample(ImpactProblem(data, LawPredictor(law, free, ""), discrepancy=True), points=50, seed=63)

    low, high = result.quantiles((0.05, 0.95))[0]
    assert high - low > 0.2
    assert result.calls < 5000


@pytest.mark.long
def test_the_same_seed_gives_the_same_bits_by_any_number_of_processes_and_after_a_stop(tmp_path, monkeypatch):
    whole = sample(Linear(), points=25, seed=9, workers=1)
    others = sample(Linear(), points=25, seed=9, workers=2)
    monkeypatch.setattr(nested, "EVERY", -1.0)
    checkpoint = tmp_path / "checkpoint"
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            sample(Stopped(150), points=25, seed=9, checkpoint=checkpoint)
    resumed = sample(Linear(), points=25, seed=9, checkpoint=checkpoint)
    again = sample(counted := Counting(), points=25, seed=9, checkpoint=checkpoint, workers=1)
    # All but the two of the clock were in the checkpoint.
    assert counted.calls == 2

    for other in (others, resumed, again):
        assert other.samples.tobytes() == whole.samples.tobytes()
        assert other.log_evidence == whole.log_evidence
        assert other.draws(100).tobytes() == whole.draws(100).tobytes()
    assert sample(Linear(), points=25, seed=10).samples.tobytes() != whole.samples.tobytes()


class Crafted:
    """Creates a file when it is unpickled."""

    def __init__(self, place):
        self.place = place

    def __reduce__(self):
        return open, (str(self.place), "w")


def test_a_checkpoint_is_never_unpickled(tmp_path):
    checkpoint, trace = tmp_path / "checkpoint", tmp_path / "trace"
    crafted = np.array([Crafted(trace)], dtype=object)
    stream = BytesIO()
    np.savez(stream, values=crafted, log_likelihood=crafted)
    digest = sha256(checkpoint.name.encode() + stream.getvalue()).digest()
    whole = sample(Linear(), points=25, seed=9)
    for content in (pickle.dumps(Crafted(trace)), stream.getvalue(), stream.getvalue() + digest):
        checkpoint.write_bytes(content)

        with pytest.warns(UserWarning, match="checkpoint"):
            result = sample(Linear(), points=25, seed=9, checkpoint=checkpoint)

        assert result.samples.tobytes() == whole.samples.tobytes()
        assert not trace.exists()


@pytest.mark.long
def test_a_damaged_checkpoint_is_announced_and_begun_anew(tmp_path):
    checkpoint = tmp_path / "checkpoint"
    whole = sample(Linear(), points=25, seed=9, checkpoint=checkpoint)
    content, draws = checkpoint.read_bytes(), np.random.default_rng(1)
    damaged = [b"", b"half of a file", content[: len(content) // 2], content[:-1], content + b"x"]
    for place in draws.integers(len(content), size=3):
        damaged.append(
            content[:place] + bytes([content[place] ^ 1 << draws.integers(8)]) + content[place + 1 :]
        )
    other = tmp_path / "other"
    for each in [*damaged, content]:
        # The last is that of another fit.
        path = checkpoint if each is not content else other
        path.write_bytes(each)

        with pytest.warns(UserWarning, match=path.name):
            result = sample(Linear(), points=25, seed=9, checkpoint=path)

        assert result.samples.tobytes() == whole.samples.tobytes()


@pytest.mark.parametrize(
    ("difference", "error", "word"),
    [(9.0, 0.3, "decisive"), (-4.0, 0.3, "very strong"), (2.5, 0.3, "strong"), (1.5, 0.3, "substantial"),
     (1.0, 0.01, ""), (5.0, 2.0, "")],
)  # fmt: skip
def test_a_bayes_factor_is_significant_above_three_and_above_three_of_its_errors(difference, error, word):
    assert strength(difference, error) == word


def test_the_code_of_a_fit_is_the_same_before_and_after_the_first_sampling(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An interrupted fit goes on in the process that began it, which has the sampler by then."""
    import_module("dynesty")
    after = digest_of_sources(cl.Fit)
    monkeypatch.delitem(sys.modules, "dynesty")
    assert digest_of_sources(cl.Fit) == after
