"""The motor of a draw under each law, and the motor as configured on another basis.

Draws have the configured basis and step; what those change is computed for the motor as configured.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, Final, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup, build
from contactlab.config.groups import MODAL
from contactlab.config.nesting import flat, nested
from contactlab.steady_state.basins import reach
from contactlab.studies.compare.factors import DAMPING, FREQUENCY, POSTERIOR, START, START_KEY, Factor
from contactlab.studies.compare.posteriors import Posteriors

CONVERGED: Final = "finite_element"
"""Option of the group `resonator` with the converged basis."""

MORE_MODES: Final = 4
"""Modes that are added to a converged basis."""


def configuration_of(
    setup: Setup, factors: Sequence[Factor], draw: Array, posterior: "Posteriors | None" = None
) -> dict[str, Any]:
    """Return the configuration of a law's motor in a draw, but for the damping of `damped`."""
    settings = flat(setup.configuration)
    settings |= {FREQUENCY: None} if is_tuned(setup) else {}
    for factor, x in zip(factors, draw.tolist(), strict=True):
        if factor.name == START:
            settings[START_KEY] = x * reach(setup)
        elif factor.name == POSTERIOR and posterior:
            settings |= posterior.values(setup, x)
        elif DAMPING not in factor.keys:
            settings |= _changed(settings, factor, x)
    return nested(settings)


def _changed(settings: Mapping[str, Any], factor: Factor, x: float) -> dict[str, float]:
    """Return the numbers that a factor changes; a law without a key has none."""
    if factor.kind not in ("share", "shift"):
        return {key: x for key in factor.keys if key in settings or not key.startswith("law.")}
    if factor.keys == (FREQUENCY,) and settings[FREQUENCY] is None:
        # Relative to the resonance, which other numbers of the draw may move.
        resonance = build(nested(dict(settings))).motor.modes.natural_frequency[0]
        return {FREQUENCY: x * float(resonance)}
    some = {key: x0 for key in factor.keys if isinstance(x0 := settings.get(key), float)}
    return {key: x0 * x if factor.kind == "share" else x0 + x for key, x0 in some.items()}


def damped(setup: Setup, factors: Sequence[Factor], draw: Array) -> Setup:
    """Return a setup with the damping ratio of a draw in its first mode, and others scaled with it.

    Without damping all modes have that ratio.
    """
    for factor, x in zip(factors, draw.tolist(), strict=True):
        if DAMPING in factor.keys:
            modes = setup.motor.modes
            elastic = modes.stiffness > 0.0
            ratio = modes.damping[elastic][0] / (2.0 * np.sqrt(modes.stiffness[elastic][0]))
            if factor.kind == "share":
                damping = x * modes.damping
            elif ratio > 0.0:
                damping = x / ratio * modes.damping
            else:
                damping = 2.0 * x * np.sqrt(modes.stiffness)
            setup = replace(setup, motor=replace(setup.motor, modes=replace(modes, damping=damping)))
    return setup


def is_tuned(setup: Setup) -> bool:
    """Return whether the drive is at the first natural frequency, which it then follows."""
    return bool(setup.configuration["drive"].get("frequency") == setup.motor.modes.natural_frequency[0])


@cache
def _converged_resonator() -> dict[str, Any]:
    return dict(build([f"resonator={CONVERGED}"]).configuration["resonator"])


def on_other_basis(setup: Setup) -> tuple[dict[str, Any], str]:
    """Return the same motor on another basis, and what differs.

    That is the converged one, one with more modes if it is that, or with a mode less if it is a file's. The
    drive stays at the first natural frequency if it is there.
    """
    configuration = setup.configuration
    resonator, drive = configuration["resonator"], configuration["drive"]
    if resonator["basis"] == "ritz":
        kept = {key: value for key, value in resonator.items() if key not in ("basis", "shapes")}
        other, change = {**_converged_resonator(), **kept}, f"resonator={CONVERGED}"
    elif resonator["basis"] == MODAL:
        fewer = max(setup.motor.modes.stiffness.size - 1, 1)
        other, change = resonator | {"modes": fewer}, f"resonator.modes={fewer}"
    elif resonator["basis"] == CONVERGED:
        more = resonator["kept_modes"] + MORE_MODES
        other, change = resonator | {"kept_modes": more}, f"resonator.kept_modes={more}"
    else:
        other, change = resonator, "the same resonator"
    frequency = {"frequency": None} if is_tuned(setup) else {}
    return {**configuration, "resonator": other, "drive": drive | frequency}, change


def is_changed(setup: Setup, factor: Factor, posterior: Posteriors | None) -> bool:
    """Return whether a factor changes a law's motor; numbers and posteriors of other laws do not."""
    if factor.name == POSTERIOR and posterior:
        return bool(posterior.values(setup, 0.0))
    settings = flat(setup.configuration)
    return any(key in settings or not key.startswith("law.") for key in factor.keys)


@final
class Drawn(NamedTuple):
    """A motor to be computed under every law.

    Args:
        laws: setups, or their configurations, by law.
        factors, draw: what is changed, and where to; nothing of a motor as configured.
        posterior: of the laws' numbers.
        others: key of the motor as configured, which stands for the laws that are not here.
    """

    laws: Mapping[str, Any]
    factors: tuple[Factor, ...] = ()
    draw: Array = np.empty(0)
    posterior: "Posteriors | None" = None
    others: str = ""

    def under(self, law: str) -> Setup:
        """Return the motor under a law."""
        setup: Setup = each if isinstance(each := self.laws[law], Setup) else build(each)
        if not self.factors:
            return setup
        changed = build(configuration_of(setup, self.factors, self.draw, self.posterior))
        return damped(changed, self.factors, self.draw)
