"""What binds several keys of a configuration together.

A rule gets values that are sound in themselves and stays silent where one is absent, so that the faults of
single keys and those between keys come out together.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import Any

from contactlab.checks import SMALLEST_STEP
from contactlab.config.faults import ConfigurationError
from contactlab.laws.base import PenaltyLaw
from contactlab.laws.declaration import SHARED
from contactlab.laws.registry import law_class, takes_shared

Values = Mapping[str, Any]
Rule = Callable[..., Iterator[str]]

BYTES_A_RECORD = 350
"""Memory that a record takes while its run is simulated and written, measured over runs of 1e6 and 1e7."""

MOST_RECORDS = 10_000_000
"""Records of one run; they take 3.5 GB of memory."""

FRICTION = f"contact.{SHARED}"
"""The key that laws share, and some law of another package may not have."""

_RULES: dict[tuple[str, ...], Rule] = {}


def broken_rules(values: Values) -> list[str]:
    """Give a sentence for each rule that the values, by full key, break."""
    return [
        sentence
        for keys, rule in _RULES.items()
        if all(key in values for key in keys)
        for sentence in rule(*(values[key] for key in keys))
    ]


def _binds(*keys: str) -> Callable[[Rule], Rule]:
    """Register a rule that is given the values of the keys."""
    return partial(_RULES.setdefault, keys)


@_binds("placement.start", "placement.end", "resonator.length")
def _patches_fit(start: float, end: float, length: float) -> Iterator[str]:
    if not start < end <= 0.5 * length:
        yield (
            f"placement.start is {start:.12g} m and placement.end is {end:.12g} m; they must "
            f"satisfy 0 m <= start < end <= {0.5 * length:.12g} m, half of resonator.length, to "
            "lie on the beam and clear of their mirror image. Shift or shorten them."
        )


@_binds(*(f"piezoceramic.{key}" for key in ("c11", "c12", "c13", "c33")))
def _elastic_tensor_is_stable(c11: float, c12: float, c13: float, c33: float) -> Iterator[str]:
    if not (c11 > abs(c12) and (c11 + c12) * c33 > 2.0 * c13**2):
        yield (
            f"piezoceramic has c11 = {c11:g}, c12 = {c12:g}, c13 = {c13:g}, c33 = {c33:g} Pa, a tensor "
            "that stores negative energy; it must satisfy c11 > |c12| and (c11 + c12) c33 > 2 c13^2. "
            "Check the constants against the datasheet."
        )


@_binds("contact.clearance", "resonator.beam_thickness")
def _clearance_can_be_bridged(clearance: float, thickness: float) -> Iterator[str]:
    if clearance > thickness:
        yield (
            f"contact.clearance is {clearance:.12g} m; it must be at most {thickness:.12g} m, the "
            "resonator.beam_thickness: the beam's theory is linear and knows no larger motion of the tip. "
            "Bring them closer; 1e-06 m is usual."
        )


@_binds("solver.contact_step", "solver.duration")
def _step_fits(step: float | None, duration: float) -> Iterator[str]:
    if step is not None and not SMALLEST_STEP * duration <= step <= duration:
        yield (
            f"solver.contact_step is {step:.12g} s; it must be at least "
            f"{SMALLEST_STEP * duration:.3g} s and at most {duration:.12g} s, the solver.duration. "
            "Leave it out for the law's own default."
        )


@_binds("solver.tolerance", "law.name")
def _tolerance_is_for_compliant_laws(tolerance: float | None, law: str) -> Iterator[str]:
    if tolerance is not None and not issubclass(law_class(law), PenaltyLaw):
        yield (
            f"solver.tolerance is {tolerance:g}; it must be null with law={law}, which takes steps "
            "of solver.contact_step without a tolerance. Refine solver.contact_step instead."
        )


@_binds("record.interval", "solver.duration")
def _records_fit(interval: float, duration: float) -> Iterator[str]:
    said = f"record.interval is {interval:.12g} s"
    if interval > duration:
        yield (
            f"{said}; it must be at most {duration:.12g} s, the solver.duration. Record more often or run "
            "longer."
        )
    elif duration / interval > MOST_RECORDS:
        yield (
            f"{said}, which makes {duration / interval:.3g} records; it must be at least "
            f"{duration / MOST_RECORDS:.3g} s, for {MOST_RECORDS} records that fit into memory. Record less "
            "often; the records do not change the motion."
        )


@_binds("sweep.keep", "sweep.chunk", "sweep.workers")
def _processes_are_for_metrics(keep: str, chunk: int | None, workers: int | None) -> Iterator[str]:
    for name, given in {"chunk": chunk, "workers": workers}.items():
        if keep == "runs" and given is not None:
            yield (
                f"sweep.{name} is {given} and every run leaves its folder; it must come with "
                "sweep.keep=metrics. Leave it out; hydra/launcher=joblib runs folders side by side."
            )


def idle_friction(laws: Iterable[Values]) -> str:
    """Tell which of the laws to run, by their sections, the shared friction coefficient is none of.

    A ConfigurationError says that it is none of any, so that nothing depends on what was set.
    """
    takes: dict[str, bool] = {}
    for law in laws:
        name = str(law["name"])
        takes[name] = takes.get(name, True) and takes_shared(law_class(name), law)
    idle = ", ".join(name for name, taken in takes.items() if not taken)
    words = f"{FRICTION} is set, but law={idle} has no friction coefficient of that name"
    if idle and not any(takes.values()):
        raise ConfigurationError(
            [f"{words}; it must be left out. Set the keys of the law, or choose another one."]
        )
    return f"{words}: what it gives does not depend on it." if idle else ""
