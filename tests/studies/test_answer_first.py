"""The answer is the first line of every result, above its tables, on a terminal and in a notebook."""

import re
from collections.abc import Callable

import numpy as np
import pytest
from support.command_line import cases

import contactlab as cl
from contactlab.inference.synthetic import made_impacts
from contactlab.measured.series import MeasuredSeries
from contactlab.studies.drive import Driven
from contactlab.studies.study import Result

NEWTON = cl.build(["law=newton"])
TIME = np.linspace(0.0, 1.0, 41)
SLIP = {"slip": 1e-5 * np.sin(6.0 * TIME), "normal": np.full(41, 10.0)}
WAY = MeasuredSeries(TIME, {}, {}, {}, {}, path=SLIP)


def impacts() -> cl.Result:
    """A fit of one number to made impacts."""
    data = made_impacts(cl.Newton(restitution=0.7, friction_coefficient=0.2), 40, 0.02, seed=1)
    known = ["contact.friction_coefficient"]
    return cl.fit(cl.Newton(friction_coefficient=0.2), data=data, known=known, points=25, starts=1)


STUDIES: dict[str, tuple[Callable[[], Result], str]] = {
    "basins": (
        lambda: cl.basins(NEWTON, {"rotor_velocity": [-2.0, -1.0], "drive_phase": [0.0, 0.5]}),
        "largest_share",
    ),
    "bench": (lambda: cl.bench(cl.Newton()), "energy_created"),
    "branch": (lambda: cl.branch(NEWTON, "drive.phase", -0.7, -0.69, step=0.5), "orbit_count"),
    "characterise": (lambda: cl.characterise(NEWTON), "no_load_velocity"),
    "drive": (lambda: Driven(data=WAY)({"": NEWTON}), "friction_loss"),
    "fit": (impacts, "law.restitution"),
    "held": (lambda: cl.steady(NEWTON, belt=-1.0), "torque"),
    "steady": (lambda: cl.steady(NEWTON), "rotor_velocity"),
}


@pytest.mark.parametrize("name", cases(STUDIES, ("branch", "drive", "held", "steady")))
def test_the_answer_stands_first(name: str) -> None:
    make, quantity = STUDIES[name]
    result = make()
    first, *_ = repr(result).splitlines()
    number, percent = result.numbers[quantity].value, 100.0 * result.numbers[quantity].value
    written = [float(each.rstrip(".")) for each in re.findall(r"-?\d[\d.]*(?:e[-+]?\d+)?", first)]
    prefixes = [10.0**power for power in (-9, -6, -3, 0, 3)]
    assert any(
        x == pytest.approx(y, rel=5e-3) for x in written for y in (percent, *(number / p for p in prefixes))
    )
    assert first == result.findings[0]
    captions = [table.attrs["caption"] for table in result.tables.values() if len(table)]
    assert all(repr(result).index(first) < repr(result).index(caption) for caption in captions)
    page = result._repr_html_()
    assert page.index("<li>") < page.index("<table")


def test_an_identified_law_states_its_numbers_first() -> None:
    result = cl.identify(cl.Newton(), mass=1e-3, restitution="0.8 @ 0.5 m/s")
    assert "restitution = 0.8" in str(result).splitlines()[0]
