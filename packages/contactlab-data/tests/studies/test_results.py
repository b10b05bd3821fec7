"""Results of fits, validations and made measurements: read back from their files, the answer first."""

from collections.abc import Callable
from pathlib import Path

import pytest
from data_support.struck_discs import struck_discs
from support.command_line import cases
from support.results import assert_quantity_first, assert_read_again

import contactlab as cl
from contactlab_data.inference.synthetic import made_impacts

STUDIES: dict[str, Callable[[Path], cl.Result]] = {
    "fit": lambda folder: cl.fit(
        cl.build(["law=newton"]),
        data=struck_discs(cl.Newton(0.2, 0.6), 20, seed=1, spread=0.05),
        free={"law.restitution": (0.1, 0.9), "contact.friction_coefficient": (0.02, 0.8)},
        output=folder,
        points=25,
    ),
    "validate": lambda folder: cl.validate(
        [cl.build([f"law={name}"]) for name in ("newton", "poisson")],
        data=struck_discs(cl.Newton(0.2, 0.6), 20, seed=1),
        folds=2,
        output=folder,
    ),
    "synthetic": lambda folder: cl.Synthetic(impacts=20)(cl.build(["law=newton"]), output=folder),
}


@pytest.mark.parametrize("name", cases(STUDIES, ("synthetic",)))
def test_the_file_alone_gives_the_result_and_the_same_files(name: str, tmp_path: Path) -> None:
    assert_read_again(STUDIES[name], name, tmp_path)


@pytest.mark.long
def test_the_answer_of_a_bench_stands_first() -> None:
    assert_quantity_first(cl.bench(cl.Newton()), "energy_created")


@pytest.mark.long
def test_the_answer_of_a_fit_stands_first() -> None:
    data = made_impacts(cl.Newton(restitution=0.7, friction_coefficient=0.2), 40, 0.02, seed=1)
    known = ["contact.friction_coefficient"]
    law = cl.Newton(friction_coefficient=0.2)
    assert_quantity_first(cl.fit(law, data=data, known=known, points=25, starts=1), "law.restitution")


def test_an_identified_law_states_its_numbers_first() -> None:
    result = cl.identify(cl.Newton(), mass=1e-3, restitution="0.8 @ 0.5 m/s")
    assert "restitution = 0.8" in str(result).splitlines()[0]
