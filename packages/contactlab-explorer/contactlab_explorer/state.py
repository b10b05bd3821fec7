"""What a page shows, as plain data: a view, up to four laws and numbers; into a link, and out of it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, Final, final

import contactlab as cl
from contactlab.config.numbers import Number
from contactlab.parameter import declared_fields
from contactlab_explorer.motions import Dropping, Rubbing

MOTIONS: Final[dict[str, type[Rubbing] | type[Dropping]]] = {"path": Rubbing, "impact": Dropping}
"""Motions of a law by itself, by view."""

VIEWS: Final = {"motor": "a motor", **{name: motion.title for name, motion in MOTIONS.items()}}
"""Titles of the views."""

MOST: Final = 4
"""Laws side by side."""

PARTS: Final = "normal", "friction"
"""Families of which every part is offered, in a composed law that is else the default."""

OF_MOTOR: Final = "drive", "contact", "rotor", "resonator", "piezoceramic", "placement"
"""Groups of a motor that have sliders, in their order."""

PLANT: Final = "plant"
"""Group of a small plant, whose numbers stand for those of the motor; and what is seen of it."""

FRICTION: Final = "contact.friction_coefficient"
"""The number of the contact that a law by itself has too."""


@lru_cache(maxsize=1)
def laws() -> list[str]:
    """Return the names of all laws, and of parts in a composed law as 'friction/dahl'."""
    parts = [f"{family}/{name}" for family in PARTS for name in cl.law_names(family)]
    return [*cl.law_names(), *parts]


def options_of(law: str) -> dict[str, str]:
    """Return the options that choose a law.

    >>> options_of("friction/dahl")
    {'law': 'composed', 'law/friction': 'dahl'}
    """
    family, _, part = law.rpartition("/")
    return {"law": "composed", f"law/{family}": part} if family else {"law": part}


@final
@dataclass(frozen=True)
class State:
    """What a page shows.

    Args:
        base: the motor or small plant as the command has it, which no page changes but by numbers and laws.
        view: of `VIEWS`.
        laws: of `laws()`, one to four; the first is the one that was touched last.
        numbers: values in SI by key; those of a law have the law behind them, 'law.restitution@newton'.
    """

    base: cl.Setup
    view: str = "motor"
    laws: tuple[str, ...] = ("newton",)
    numbers: Mapping[str, float] = field(default_factory=dict)

    def with_number(self, key: str, value: float) -> "State":
        """Return the state with another number; that of a law puts this law first."""
        law = key.partition("@")[2]
        order = sorted(self.laws, key=lambda each: each != law) if law else self.laws
        return replace(self, numbers={**self.numbers, key: value}, laws=tuple(order))

    def with_laws(self, chosen: list[str]) -> "State":
        """Return the state with other laws, the first four that exist; of none, with its own."""
        known = tuple(dict.fromkeys(each for each in chosen if each in laws()))[:MOST]
        return replace(self, laws=known or self.laws)

    def values(self, law: str) -> dict[str, float]:
        """Return the numbers of the setup under a law that are set, by their keys in a configuration."""
        split = ((key.partition("@"), value) for key, value in self.numbers.items())
        return {
            key: x for (key, _, of), x in split if of in ("", law) and key.partition(".")[0] not in MOTIONS
        }

    def setup(self, law: str) -> cl.Setup:
        """Return what runs under a law.

        Raises:
            ConfigurationError: a number is refused; the sentence of the check.
        """
        return chosen(self.base, law).with_(self.values(law))

    @property
    def views(self) -> dict[str, str]:
        """Titles of the views; a small plant has its name in place of the motor's."""
        plant = self.base.motor.plant
        return VIEWS if plant is None else {**VIEWS, "motor": f"a {plant.name}"}

    @property
    def scene(self) -> str:
        """What is drawn: the view, or `PLANT` where that of a motor has a small plant."""
        is_plant = self.view == "motor" and self.base.motor.plant is not None
        return PLANT if is_plant else self.view

    @property
    def motion(self) -> Any:
        """The prescribed motion of the view.

        Raises:
            ValueError: a number is refused.
        """
        before = f"{self.view}."
        own = {key.removeprefix(before): x for key, x in self.numbers.items() if key.startswith(before)}
        return MOTIONS[self.view](**own)

    @cached_property
    def sliders(self) -> dict[str, Number]:
        """All numbers that have sliders in this view, by key, with the values that are set."""
        found, groups = {}, {"motor": OF_MOTOR, PLANT: (PLANT,)}.get(self.scene, ())
        for law in self.laws:
            for key, number in chosen(self.base, law).numbers().items():
                group = key.partition(".")[0]
                if group == "law":
                    found[f"{key}@{law}"] = number
                elif key == FRICTION or group in groups:
                    found[key] = number
        if self.view in MOTIONS:
            kind: type = MOTIONS[self.view]
            for name, each in declared_fields(kind).items():
                assert each.parameter is not None
                key = f"{self.view}.{name}"
                found[key] = Number(key, each.default, each.default, each.parameter, (), False)
        return {
            key: replace(number, value=self.numbers.get(key, number.value))
            for key, number in found.items()
            if number.usual is not None
        }

    def query(self) -> dict[str, str]:
        """Return the state as the query of a link."""
        numbers = {key: repr(value) for key, value in self.numbers.items()}
        return {"view": self.view, "laws": ",".join(self.laws), **numbers}

    def of_query(self, query: Mapping[str, str]) -> "State":
        """Return the state of a link: what it does not name, or what is no declared number, is left out."""
        view = query.get("view", self.view)
        state = replace(self, view=view if view in VIEWS else self.view)
        state = state.with_laws(query.get("laws", "").split(","))
        numbers = dict(self.numbers)
        for key in state.sliders.keys() & query.keys():
            try:
                value = float(query[key])
            except ValueError:
                continue
            if math.isfinite(value):
                numbers[key] = value
        return replace(state, numbers=numbers)

    def texts(self, law: str) -> dict[str, str]:
        """Return command, Python and YAML that make what is seen under a law, by language."""
        setup = self.setup(law)
        if self.view == "motor":
            repeats = has_period(setup)
            python = f"{setup.python()}{'state = cl.orbit' if repeats else 'run = cl.simulate'}(setup)\n"
            command = setup.command("steady" if repeats else "")
            return {"bash": f"{command}\n", "python": python, "yaml": setup.yaml()}
        motion = self.motion
        lines = [setup.python().replace("\n", "\nimport numpy as np\n", 1), "law = setup.law\n"]
        if self.view == "path":
            cycle = f"{motion.amplitude!r} * np.sin(2.0 * np.pi * {motion.frequency!r} * time)"
            lines += [
                f"time = np.linspace(0.0, {float(motion.time[-1])!r}, {motion.time.size})\n",
                f"loop = cl.drive(law, time, normal={motion.load!r}, slip={cycle})\n",
            ]
        else:
            lines += [
                f"speed = np.geomspace({motion.slowest!r}, {motion.fastest!r}, {motion.speeds.size})\n",
                f"table = cl.normal_impact(law, speed, mass={motion.mass!r})\n",
            ]
        return {"python": "".join(lines), "yaml": setup.yaml()}


def chosen(base: cl.Setup, law: str) -> cl.Setup:
    """Return a base under a law with the law's own numbers; that of the base keeps those of the base."""
    return base if base.law.name == law else base.with_(options_of(law))


def has_period(setup: cl.Setup) -> bool:
    """Return whether what drives a setup repeats itself, so that there is a steady state to compute."""
    try:
        return setup.motor.drive.period > 0.0
    except cl.NoPeriodError:
        return False


@final
class History:
    """States of a page, the last of which is undone first."""

    def __init__(self, state: State) -> None:
        self._past, self.state = list[State](), state

    def change(self, state: State) -> None:
        """Go to another state; numbers of one slider in a row are undone together."""
        if state == self.state:
            return
        if not (self._past and _moved(self.state, state) == _moved(self._past[-1], self.state) != ""):
            self._past.append(self.state)
        self.state = state

    def undo(self) -> bool:
        """Go back to the state before the last change; return whether there was one."""
        if not self._past:
            return False
        self.state = self._past.pop()
        return True


def _moved(before: State, after: State) -> str:
    """Return the key by which two states differ; empty where it is another difference."""
    if (before.view, sorted(before.laws)) != (after.view, sorted(after.laws)):
        return ""
    keys = before.numbers.keys() | after.numbers.keys()
    moved = [key for key in keys if before.numbers.get(key) != after.numbers.get(key)]
    return moved[0] if len(moved) == 1 else ""
