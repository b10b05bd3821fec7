"""Changes of a motor during a run: `solver.changes=['10 ms; drive.voltage_1=0; drive.voltage_2=0']`."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from contactlab.config.faults import ConfigurationError
from contactlab.quantity import UnitError, to_si

CHANGEABLE: Final = ("drive.", "rotor.load_torque", "rotor.damping", "contact.preload")
"""Keys that may change, by what they begin with: the coordinates and the law remain."""

KEY: Final = "solver.changes"


def changed(
    values: Mapping[str, Any], changes: Sequence[str], duration: float
) -> Iterator[tuple[float, dict[str, Any]]]:
    """Yield the times of changes [s], and the whole configuration from each on.

    Args:
        values: the configuration at the start.
        changes: a text each, 'TIME; KEY=VALUE; KEY=VALUE', where TIME is in seconds or has a unit.
        duration: of the run [s]; changes lie within it, in their order.

    Raises:
        ConfigurationError: a text that is no change, a time that does not lie between the one before and the
            duration, or a key that cannot change.
    """
    now, before = {**values, "solver": {**values.get("solver", {}), "changes": None}}, 0.0
    for text in changes:
        when, *pairs = (part.strip() for part in text.split(";"))
        try:
            time = to_si(when, "s")
        except UnitError as error:
            raise ConfigurationError(f"{KEY} has '{text}', whose time is '{when}', {error}.") from error
        if not before < time < duration:
            bounds = f"greater than {before:g} s and less than the solver.duration, {duration:g} s"
            raise ConfigurationError(f"{KEY} has '{text}', whose time is {time:g} s; it must be {bounds}.")
        if not pairs:
            raise ConfigurationError(f"{KEY} has '{text}', without a change; it must be TIME; KEY=VALUE.")
        changed_here = set[str]()
        for pair in pairs:
            key, sign, value = (part.strip() for part in pair.partition("="))
            group, _, name = key.partition(".")
            if (
                not sign
                or not key.startswith(CHANGEABLE)
                or key == "drive.signal"
                or name not in now.get(group, ())
            ):
                names = ", ".join(CHANGEABLE)
                raise ConfigurationError(f"{KEY} has '{pair}'; it must be KEY=VALUE of {names}.")
            if now[group][name] is None and key == "contact.preload":
                raise ConfigurationError(f"{KEY} has '{pair}'; contact.preload must be there from the start.")
            if key in changed_here:
                raise ConfigurationError(f"{KEY} has '{text}', with {key} twice; it must occur once.")
            changed_here.add(key)
            now[group] = {**now[group], name: value}
        yield time, now.copy()
        before = time
