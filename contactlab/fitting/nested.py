"""Posterior and evidence by nested sampling (Skilling 2006, Bayesian Analysis 1, 833), by dynesty.

Live points are drawn from the prior; again and again the least likely is replaced by one of the prior that is
more likely, so that the prior's volume above shrinks by known factors, and the evidence Z is the sum of
likelihood times volume. The error of ln Z is that of those factors, sqrt(H / live points) with the
information H of the data about the parameters [nat].

Proposals are made in groups of `GROUP`, however many processes evaluate them: the same seed gives the same
bits. A run that is stopped goes on from its last checkpoint, with the same bits as one that never was.
"""

import multiprocessing
import pickle
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from math import log
from pathlib import Path
from time import perf_counter
from typing import Any, Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.fitting.model import Model, log_likelihood
from contactlab.fitting.parameters import Free, from_cube
from contactlab.processes import START_METHOD, begin_worker, processors

POINTS: Final = 150
"""Live points where nothing is said."""

GROUP: Final = 8
"""Proposals made at once."""

EVERY: Final = 10.0
"""Seconds between two checkpoints."""

UNBOUNDED: Final = 40
"""Share of proposals from the whole prior that are taken [%], below which they are drawn from ellipsoids."""

WORTH_A_PROCESS: Final = 1e-3
"""Seconds that a likelihood must take for processes to pay."""

MISSING: Final = (
    "Posteriors need the packages dynesty and arviz, which are not installed. Install them with: pip install "
    "'contactlab[fit]' (in a clone: pip install -e '.[fit]')."
)

TINY: Final = 1e-12
"""Evidence that is not missing any more, in ln Z."""

Advance = Callable[[float], object]

_CURRENT: Final[list[Model]] = []
"""The model that is sampled: checkpoints and messages between processes do not carry it."""


class NoSamplerError(RuntimeError):
    """What samples is not installed; the message is a sentence."""


@final
@dataclass(frozen=True, eq=False)
class Posterior:
    """What nested sampling found.

    Args:
        free: what was free.
        samples: all points in their order [SI], shape (sample, parameter).
        log_likelihood: of each, shape (sample,).
        log_weight: logarithm of each one's share in the posterior, shape (sample,).
        log_evidence, error: ln Z and its standard deviation.
        information: of the data about the parameters [nat].
        calls: how often the likelihood was asked.
        points, seed: as asked for.
    """

    free: tuple[Free, ...]
    samples: Array
    log_likelihood: Array
    log_weight: Array
    log_evidence: float
    error: float
    information: float
    calls: int
    points: int
    seed: int

    @property
    def effective(self) -> float:
        """How many independent draws the samples are worth, after Kish: 1 over the sum of squared weights."""
        return float(1.0 / np.sum(np.exp(self.log_weight) ** 2))

    def draws(self, count: int) -> Array:
        """Give samples of equal weight in random order, shape (count, parameter); the same every time."""
        generator = np.random.default_rng([self.seed, 1])
        # Systematic: each stands as often as its share says, but for one.
        steps = (np.arange(count) + generator.random()) / count
        chosen = np.searchsorted(np.cumsum(np.exp(self.log_weight)), steps)
        found: Array = self.samples[np.minimum(chosen, len(self.samples) - 1)]
        return found[generator.permutation(count)]

    def quantiles(self, shares: Iterable[float]) -> Array:
        """Give the quantiles of each parameter [SI], shape (parameter, share)."""
        found = []
        for column in self.samples.T:
            order = np.argsort(column, kind="stable")
            reached = np.cumsum(np.exp(self.log_weight[order]))
            found.append(np.interp(list(shares), reached, column[order]))
        return np.array(found).reshape(len(self.free), -1)

    def moments(self) -> tuple[Array, Array]:
        """Give mean, shape (parameter,), and covariance [SI], shape (parameter, parameter)."""
        weights = np.exp(self.log_weight)
        mean = weights @ self.samples
        off = self.samples - mean
        return mean, np.asarray((off * weights[:, None]).T @ off)


def sample(
    model: Model,
    *,
    points: int = POINTS,
    seed: int = 0,
    checkpoint: Path | None = None,
    workers: int | None = None,
    one_mode: bool = False,
    advance: Advance = bool,
) -> Posterior:
    """Sample the posterior of a model.

    Args:
        model: what is free in it has a prior; there must be something.
        points: live points; the evidence's error falls with their root, the work grows as they do.
        seed: the same seed gives the same bits, whatever the number of processes.
        checkpoint: file in which a run that is stopped leaves how far it has come; one that is there is gone
            on with.
        workers: processes at work; None is one a processor where that pays.
        one_mode: draw proposals from one ellipsoid, not several: quicker where no posterior has two modes.
        advance: told the share that is done.

    Raises:
        NoSamplerError: dynesty is not installed.
    """
    available()
    from dynesty import NestedSampler

    _CURRENT[:] = [model]
    with _pool(model, workers) as pool:
        sampler = _restored(checkpoint, pool)
        resumed = sampler is not None
        if sampler is None:
            sampler = NestedSampler(
                _log_likelihood,
                _from_cube,
                len(model.free),
                nlive=points,
                rstate=np.random.default_rng(seed),
                pool=pool,
                queue_size=GROUP,
                use_pool={"update_bound": False},
                bound="single" if one_mode else "multi",
                first_update={"min_ncall": points, "min_eff": UNBOUNDED},
            )
        if not sampler.added_live:
            with warnings.catch_warnings():
                # Of proposals that are few among many: the evaluations are counted and told.
                warnings.filterwarnings("ignore", "The enlargement factor", UserWarning)
                sampler.run_nested(
                    print_func=_Watch(advance),
                    checkpoint_file=None if checkpoint is None else str(checkpoint),
                    checkpoint_every=EVERY,
                    resume=resumed,
                )
        found = sampler.results
    log_weight = np.asarray(found["logwt"] - found["logz"][-1])
    # They add up to one but for round-off.
    log_weight = log_weight - np.logaddexp.reduce(log_weight)
    return Posterior(
        model.free,
        np.asarray(found["samples"]),
        np.asarray(found["logl"]),
        log_weight,
        float(found["logz"][-1]),
        float(found["logzerr"][-1]),
        float(found["information"][-1]),
        int(np.sum(found["ncall"])),
        points,
        seed,
    )


def available() -> None:
    """Refuse to go on, by a NoSamplerError, where dynesty or ArviZ is not installed."""
    if any(find_spec(name) is None for name in ("dynesty", "arviz")):
        raise NoSamplerError(MISSING)


def _log_likelihood(values: Array) -> float:
    return log_likelihood(_CURRENT[0], values)


def _from_cube(shares: Array) -> Array:
    return from_cube(_CURRENT[0].free, shares)


@final
class _Here:
    """Maps in this process, as a pool of processes does in others."""

    @staticmethod
    def map(work: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
        return [work(item) for item in items]


@contextmanager
def _pool(model: Model, workers: int | None) -> Iterator[Any]:
    """Give what maps: processes where a likelihood takes long enough, else this one."""
    middle = from_cube(model.free, np.full(len(model.free), 0.5))
    # The first loads the compiled code.
    log_likelihood(model, middle)
    began = perf_counter()
    log_likelihood(model, middle)
    pays = perf_counter() - began > WORTH_A_PROCESS
    count = workers or (processors() if pays else 1)
    if count < 2 or START_METHOD is None:
        yield _Here()
        return
    # From Python 3.12 on, of threads (those of the linear algebra) that a fork does not have.
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "This process", DeprecationWarning)
        pool = multiprocessing.get_context(START_METHOD).Pool(count, begin_worker)
    with pool:
        yield pool


def _restored(checkpoint: Path | None, pool: Any) -> Any:
    """Give the sampler of a checkpoint; None where there is none that can be read."""
    from dynesty import NestedSampler

    if checkpoint is None or not checkpoint.exists():
        return None
    try:
        return NestedSampler.restore(str(checkpoint), pool=pool)
    # A file that was cut, or of another version.
    except (OSError, EOFError, pickle.UnpicklingError, AttributeError, ImportError, RuntimeError):
        return None


@final
class _Watch:
    """Tells the share that is done, by the evidence that may still be missing: it falls evenly by factors."""

    def __init__(self, advance: Advance) -> None:
        self._advance = advance
        self._first = 0.0

    def __call__(self, found: Any, _iteration: int, _calls: int, **others: Any) -> None:
        missing, limit = max(float(found.delta_logz), TINY), float(others["dlogz"])
        self._first = max(self._first, missing)
        if others.get("add_live_it") is not None or self._first <= limit:
            self._advance(1.0)
        else:
            self._advance(min(log(self._first / missing) / log(self._first / limit), 1.0))
