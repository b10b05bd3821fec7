"""What binds several keys of a configuration together.

A rule gets every value that is sound in itself under its full key; values that are faulty are
absent, and a rule that misses one stays silent. So the faults of single keys and those between
keys come out together.
"""

from collections.abc import Callable, Iterator, Mapping

from contactlab.checks import SMALLEST_STEP
from contactlab.config.law_section import takes_tolerance

Values = Mapping[str, object]

BYTES_A_RECORD = 350
"""Memory that a record takes while its run is simulated and written, measured over runs of 1e6 and 1e7."""

MOST_RECORDS = 10_000_000
"""Records of one run; they take 3.5 GB of memory."""


def broken_rules(values: Values) -> list[str]:
    """A sentence for each rule that the values break."""
    return [sentence for rule in _RULES for sentence in rule(values)]


def _numbers(values: Values, *keys: str) -> tuple[float, ...] | None:
    """The numbers under the keys, or None where one is null or faulty."""
    found = [values.get(key) for key in keys]
    return None if None in found else tuple(map(float, found))  # type: ignore[arg-type]


def _stiffness_is_given_once(values: Values) -> Iterator[str]:
    keys = ("law.stiffness", "law.tip_radius")
    if not all(key in values for key in keys):
        return
    stiffness, radius = (values[key] for key in keys)
    if stiffness is None and radius is None:
        yield (
            "law.stiffness and law.tip_radius are both null; exactly one of them must be a number "
            "greater than 0. Give the stiffness in N/m^1.5 or the tip's radius in m."
        )
    if stiffness is not None and radius is not None:
        yield (
            f"law.stiffness is {stiffness:.12g} N/m^1.5 and law.tip_radius is {radius:.12g} m; "
            "exactly one of them must be a number and the other null. "
            "Set law.stiffness=null to have it computed from the radius."
        )


def _tolerance_is_for_compliant_laws(values: Values) -> Iterator[str]:
    tolerance = values.get("solver.tolerance")
    law = values.get("law.name")
    if tolerance is not None and law is not None and not takes_tolerance(str(law)):
        yield (
            f"solver.tolerance is {tolerance:g}; it must be null with law={law}, which takes steps "
            "of solver.contact_step without a tolerance. Refine solver.contact_step instead."
        )


def _patches_fit(values: Values) -> Iterator[str]:
    numbers = _numbers(values, "placement.start", "placement.end", "resonator.length")
    if numbers is None:
        return
    start, end, length = numbers
    if not start < end <= 0.5 * length:
        yield (
            f"placement.start is {start:.12g} m and placement.end is {end:.12g} m; they must "
            f"satisfy 0 m <= start < end <= {0.5 * length:.12g} m, half of resonator.length, to "
            "lie on the beam and clear of their mirror image. Shift or shorten them."
        )


def _clearance_can_be_bridged(values: Values) -> Iterator[str]:
    numbers = _numbers(values, "contact.clearance", "resonator.beam_thickness")
    if numbers is None:
        return
    clearance, thickness = numbers
    if clearance > thickness:
        yield (
            f"contact.clearance is {clearance:.12g} m; it must be at most {thickness:.12g} m, the "
            "resonator.beam_thickness: the beam's theory is linear and knows no larger motion of the tip. "
            "Bring them closer; 1e-06 m is usual."
        )


def _records_fit(values: Values) -> Iterator[str]:
    numbers = _numbers(values, "record.interval", "solver.duration")
    if numbers is None:
        return
    interval, duration = numbers
    if interval > duration:
        yield (
            f"record.interval is {interval:.12g} s; it must be at most {duration:.12g} s, the "
            "solver.duration. Record more often or run longer."
        )
    elif duration / interval > MOST_RECORDS:
        yield (
            f"record.interval is {interval:.12g} s, which makes {duration / interval:.3g} records; "
            f"it must be at least {duration / MOST_RECORDS:.3g} s, for {MOST_RECORDS} records that "
            "fit into memory. Record less often; the records do not change the motion."
        )


def _step_fits(values: Values) -> Iterator[str]:
    numbers = _numbers(values, "solver.contact_step", "solver.duration")
    if numbers is None:
        return
    step, duration = numbers
    if not SMALLEST_STEP * duration <= step <= duration:
        yield (
            f"solver.contact_step is {step:.12g} s; it must be at least "
            f"{SMALLEST_STEP * duration:.3g} s and at most {duration:.12g} s, the solver.duration. "
            "Leave it out for the law's own default."
        )


def _elastic_tensor_is_stable(values: Values) -> Iterator[str]:
    keys = ("c11", "c12", "c13", "c33")
    numbers = _numbers(values, *(f"piezoceramic.{key}" for key in keys))
    if numbers is None:
        return
    c11, c12, c13, c33 = numbers
    if not (c11 > abs(c12) and (c11 + c12) * c33 > 2.0 * c13**2):
        given = ", ".join(f"{key} = {c:g}" for key, c in zip(keys, numbers, strict=True))
        yield (
            f"piezoceramic has {given} Pa, a tensor that stores negative energy; it must satisfy "
            "c11 > |c12| and (c11 + c12) c33 > 2 c13^2. Check the constants against the datasheet."
        )


def _resonance_is_damped(values: Values) -> Iterator[str]:
    keys = ("resonator.mass_damping", "resonator.stiffness_damping", "drive.frequency")
    if any(key not in values for key in keys):
        return
    if values[keys[0]] == values[keys[1]] == 0.0 and values[keys[2]] is None:
        yield (
            "drive.frequency is null, that is the first natural frequency, where a resonator with "
            "resonator.mass_damping = resonator.stiffness_damping = 0 responds without bound; "
            "it must be a number in Hz. Give one, or give the resonator damping."
        )


_RULES: tuple[Callable[[Values], Iterator[str]], ...] = (
    _stiffness_is_given_once,
    _patches_fit,
    _elastic_tensor_is_stable,
    _resonance_is_damped,
    _clearance_can_be_bridged,
    _step_fits,
    _tolerance_is_for_compliant_laws,
    _records_fit,
)
