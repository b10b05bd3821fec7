"""The resonator's group: one beam in either basis, and faults told with the basis that was chosen."""

import numpy as np
import pytest
from support.configurations import altered, composed

from contactlab.config import ConfigurationError, build
from contactlab.config.groups import BASES
from contactlab.motor import FiniteElementResonator


def faults(changes: dict[str, object], resonator: str) -> list[str]:
    with pytest.raises(ConfigurationError) as caught:
        build(altered(changes, resonator=resonator))
    return caught.value.faults


def test_bases_describe_the_same_beam() -> None:
    sections = [composed(resonator=name)["resonator"] for name in BASES]
    own = {"basis", "shapes", "kept_modes", "static_correction", "rod_length"}
    beams = [{k: v for k, v in section.items() if k not in own} for section in sections]
    assert beams[0] == beams[1]


def test_finite_elements_build_the_converged_motor() -> None:
    setup = build(altered({"resonator.kept_modes": 2}, resonator="finite_element"))
    modes = FiniteElementResonator(kept_modes=2).modes
    assert np.array_equal(setup.motor.modes.stiffness, modes.stiffness)
    assert setup.configuration["drive"]["frequency"] == modes.natural_frequency[0]
    bare = altered(
        {"resonator.kept_modes": 2, "resonator.static_correction": False}, resonator="finite_element"
    )
    assert build(bare).motor.modes.stiffness.size == 2


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("resonator.kept_modes", 41),
        ("resonator.kept_modes", 2.5),
        ("resonator.static_correction", "yes"),
        ("resonator.shapes", 4),
    ],
)
def test_a_faulty_value_of_finite_elements_is_refused_by_its_key(key: str, value: object) -> None:
    (fault,) = faults({key: value}, "finite_element")
    assert fault.startswith(key)


@pytest.mark.parametrize("resonator", list(BASES))
def test_numbers_beyond_double_precision_are_refused(resonator: str) -> None:
    tiny: dict[str, object] = {"resonator.length": 1e-200, "placement.start": 0, "placement.end": 1e-201}
    assert faults(tiny, resonator)
