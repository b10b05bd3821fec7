"""Posterior and evidence by nested sampling (Skilling 2006, Bayesian Analysis 1, 833), by dynesty.

Live points are drawn from the prior; the least likely is replaced again and again by a more likely one, so
that the prior's volume above it shrinks by known factors, and the evidence Z is the sum of likelihood times
volume. The error of ln Z is that of those factors, sqrt(H / live points) with the information H of the data
about the parameters [nat].

Proposals are made in groups of `GROUP`, however many processes evaluate them: the same seed gives the same
bits. A checkpoint contains the likelihoods evaluated so far, as plain numbers, and no state of the sampler:
the seed repeats the sampler's path, and evaluations in the checkpoint are looked up. So a resumed run gives
the same bits as one without a stop, and a checkpoint from somebody else can run no code.
"""

import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from hashlib import sha256
from importlib import import_module
from io import BytesIO
from math import log
from pathlib import Path
from time import perf_counter
from types import SimpleNamespace
from typing import Any, Final, final
from zipfile import BadZipFile

import numpy as np

from contactlab.arrays import Array
from contactlab.processes import FORKS, forked_pool, processors
from contactlab.progress import tell_progress, untold_progress
from contactlab.results.files import whole_file
from contactlab_data.inference.free_parameters import from_cube
from contactlab_data.inference.posterior import Posterior
from contactlab_data.inference.problem import Problem

POINTS: Final = 150
"""Default number of live points."""

GROUP: Final = 8
"""Proposals made at once."""

EVERY: Final = 10.0
"""Seconds between two checkpoints."""

ENLARGED: Final = 1.5
"""Volume of the ellipsoids over that which just holds the live points."""

UNBOUNDED: Final = 40
"""Acceptance of proposals from the whole prior [%] below which they are drawn from ellipsoids."""

WORTH_A_PROCESS: Final = 1e-3
"""Seconds that a likelihood must take for processes to pay."""

_CURRENT: Final[list[Problem]] = []
"""The problem that is sampled: messages between processes do not carry it."""

_RECORDED: Final[dict[bytes, float]] = {}
"""Log likelihoods of an earlier start, by the bytes of the values; workers are forked with them."""

_EVALUATED: Final[list[tuple[Array, float]]] = []
"""Values and log likelihoods evaluated in this process since the last message to the parent."""


def sample(
    problem: Problem,
    *,
    points: int = POINTS,
    seed: int = 0,
    checkpoint: Path | None = None,
    workers: int | None = None,
    single_mode: bool = False,
) -> Posterior:
    """Sample the posterior of a problem.

    Args:
        problem: with at least one free number.
        points: live points; the error of the evidence falls with their root, the cost is proportional.
        seed: the same seed gives the same bits, whatever the number of processes.
        checkpoint: file of the likelihoods evaluated so far, from which an interrupted run resumes.
        workers: processes; None is one a processor where that pays.
        single_mode: draw proposals from one ellipsoid, not several: quicker where no posterior has two modes.

    A damaged checkpoint is reported by a warning, and the run starts again.
    """
    # Imported here: help needs no sampler. By name: a fit's digest has its version, not its sources.
    dynesty = import_module("dynesty")

    _CURRENT[:] = [problem]
    record = _Record(checkpoint)
    _RECORDED.clear()
    _RECORDED.update(zip((row.tobytes() for row in record.values), record.log_likelihood, strict=True))
    with _mapping(problem, workers) as mapping, ExitStack() as at_end:
        # What is evaluated is kept, also of a run that is interrupted.
        at_end.callback(record.write)

        def recorded(work: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
            """Return the results in the order of the items, and record the likelihoods."""
            results = []
            for result, evaluated in mapping(partial(_with_evaluations, work), items):
                results.append(result)
                record.add(evaluated)
            return results

        sampler = dynesty.NestedSampler(
            _log_likelihood,
            _from_cube,
            len(problem.free),
            nlive=points,
            rstate=np.random.default_rng(seed),
            pool=SimpleNamespace(map=recorded),
            queue_size=GROUP,
            use_pool={"update_bound": False},
            bound="single" if single_mode else "multi",
            # By bootstrap they may become so large that nearly no proposal lies in the prior.
            bootstrap=0,
            enlarge=ENLARGED,
            first_update={"min_ncall": points, "min_eff": UNBOUNDED},
        )
        sampler.run_nested(print_func=_Left(points))
        outcome = sampler.results
    log_weight = np.asarray(outcome["logwt"] - outcome["logz"][-1])
    # They add up to one but for round-off.
    log_weight = log_weight - np.logaddexp.reduce(log_weight)
    return Posterior(
        "nested sampling",
        problem.free,
        np.asarray(outcome["samples"]),
        np.asarray(outcome["logl"]),
        log_weight,
        float(outcome["logz"][-1]),
        float(outcome["logzerr"][-1]),
        float(outcome["information"][-1]),
        int(np.sum(outcome["ncall"])),
        points,
        seed,
    )


@final
class _Left:
    """Tells what is left to do after each iteration.

    The volume shrinks by 1/points an iteration, in its logarithm, and the sampling ends where the logarithm
    of the evidence would grow by the limit only: r iterations are left with exp(-r/points) of what it may
    still grow, d, where that is small, and d points before.
    """

    def __init__(self, points: int) -> None:
        self._points = points

    def __call__(self, results: Any, iteration: int, calls: int, **others: Any) -> None:
        grows, limit = float(results.delta_logz), float(others.get("dlogz") or 0.01)
        if not grows > 0.0:
            return
        left = self._points * (max(grows - 1.0, 0.0) + max(log(min(grows, 1.0) / min(limit, 1.0)), 0.0))
        what = f"nested sampling: {calls} evaluations, evidence left {grows:.3g} (ends at {limit:.2g})"
        tell_progress(what, iteration / (iteration + left) if iteration + left > 0.0 else 0.0)


def _log_likelihood(values: Array) -> float:
    known = _RECORDED.get(values.tobytes())
    if known is not None:
        return known
    with untold_progress():
        outcome = _CURRENT[0].log_likelihood(values)
    _EVALUATED.append((np.array(values), outcome))
    return outcome


def _with_evaluations(work: Callable[[Any], Any], item: Any) -> tuple[Any, list[tuple[Array, float]]]:
    """Return the result of a piece of work and the likelihoods that were evaluated for it."""
    _EVALUATED.clear()
    return work(item), list(_EVALUATED)


def _from_cube(shares: Array) -> Array:
    return from_cube(_CURRENT[0].free, shares)


@contextmanager
def _mapping(problem: Problem, workers: int | None) -> Iterator[Callable[..., Iterable[Any]]]:
    """Yield a function that maps: by processes if a likelihood takes long enough, else in this one."""
    middle = from_cube(problem.free, np.full(len(problem.free), 0.5))
    # The first loads the compiled code.
    problem.log_likelihood(middle)
    began = perf_counter()
    problem.log_likelihood(middle)
    pays = perf_counter() - began > WORTH_A_PROCESS
    count = workers or (processors() if pays else 1)
    if count < 2 or not FORKS:
        yield map
        return
    with forked_pool(count) as pool:
        yield pool.map


@final
class _Record:
    """Likelihoods evaluated so far, in a file: an .npz, then the SHA-256 digest of its name and content.

    Args:
        path: of the file; None keeps nothing.
    """

    def __init__(self, path: Path | None) -> None:
        self._path, self._written = path, perf_counter()
        self.values: list[Array] = []
        self.log_likelihood: list[float] = []
        if path is None or not path.exists():
            return
        try:
            content, size = path.read_bytes(), sha256().digest_size
            if self._digest(content[:-size]) != content[-size:]:
                raise ValueError("its digest differs")
            with np.load(BytesIO(content[:-size]), allow_pickle=False) as stored:
                self.values, self.log_likelihood = list(stored["values"]), stored["log_likelihood"].tolist()
        except (OSError, EOFError, ValueError, KeyError, BadZipFile) as error:
            warnings.warn(f"'{path}' is damaged ({error}); the fit starts again.", stacklevel=3)

    def _digest(self, content: bytes) -> bytes:
        assert self._path is not None
        return sha256(self._path.name.encode() + content).digest()

    def add(self, evaluated: Iterable[tuple[Array, float]]) -> None:
        """Add evaluations; write the file if the last one is older than `EVERY`."""
        for values, outcome in evaluated:
            self.values.append(values)
            self.log_likelihood.append(outcome)
        if perf_counter() - self._written > EVERY:
            self.write()

    def write(self) -> None:
        """Write the file, whole or not at all."""
        if self._path is None or not self.values:
            return
        stream = BytesIO()
        np.savez(stream, values=np.array(self.values), log_likelihood=np.array(self.log_likelihood))
        stream.write(self._digest(stream.getvalue()))
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(self._path) as partial:
            partial.write_bytes(stream.getvalue())
        self._written = perf_counter()
