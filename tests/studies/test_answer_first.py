"""The answer is the first line of every result, above its tables, on a terminal and in a notebook."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas
import pytest
from support.command_line import cases
from support.results import assert_quantity_first

import contactlab as cl
from contactlab.studies.drive import Driven

NEWTON = cl.build(["law=newton"])
TIME = np.linspace(0.0, 1.0, 41)


def driven() -> cl.Result:
    """A law on a path, from a file."""
    path = {"time [s]": TIME, "slip [m]": 1e-5 * np.sin(6.0 * TIME), "normal [N]": np.full(41, 10.0)}
    with TemporaryDirectory() as folder:
        pandas.DataFrame(path).to_csv(Path(folder) / "path.csv", index=False)
        return Driven(data=Path(folder) / "path.csv")({"": NEWTON})


STUDIES: dict[str, tuple[Callable[[], cl.Result], str]] = {
    "basins": (
        lambda: cl.basins(NEWTON, {"rotor_velocity": [-2.0, -1.0], "drive_phase": [0.0, 0.5]}),
        "largest_share",
    ),
    "branch": (lambda: cl.branch(NEWTON, "drive.phase", -0.7, -0.69, step=0.5), "orbit_count"),
    "characterise": (lambda: cl.characterise(NEWTON), "no_load_velocity"),
    "drive": (driven, "friction_loss"),
    "held": (lambda: cl.steady(NEWTON, belt=-1.0), "torque"),
    "steady": (lambda: cl.steady(NEWTON), "rotor_velocity"),
}


@pytest.mark.parametrize("name", cases(STUDIES, ("branch", "drive", "held", "steady")))
def test_the_answer_stands_first(name: str) -> None:
    make, quantity = STUDIES[name]
    assert_quantity_first(make(), quantity)
