"""The pictures of README and the home page are there, small, and those that their script makes."""

from pathlib import Path

import numpy as np
import pytest
import readme_pictures
from PIL import Image, ImageSequence

STATIC = readme_pictures.STATIC


def frames_of(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.array(
            [np.asarray(each.convert("RGB"), dtype=float) for each in ImageSequence.Iterator(image)]
        )


@pytest.mark.parametrize(("name", "most"), [("motor.gif", 700_000), ("laws.png", 200_000)])
def test_a_picture_is_small_and_has_a_ground_of_its_own(name: str, most: int) -> None:
    assert (STATIC / name).stat().st_size < most
    with Image.open(STATIC / name) as image:
        # It stands on light and on dark pages.
        assert image.convert("RGBA").getchannel("A").getextrema() == (255, 255)


@pytest.mark.long
def test_the_motor_ends_where_it_begins_and_moves_between() -> None:
    frames = frames_of(STATIC / "motor.gif")
    assert len(frames) == readme_pictures.FRAMES
    # The scene, without the cursor and the numbers beside it.
    scene = frames[:, 70:290]
    steps = [np.abs(scene[k] - scene[k - 1]).mean() for k in range(len(scene))]
    assert steps[0] < np.max(steps[1:])
    assert np.abs(scene[len(scene) // 4] - scene[0]).mean() > 2.0 * steps[0]


@pytest.mark.long
def test_the_pictures_are_those_that_the_script_makes(tmp_path: Path) -> None:
    readme_pictures.main(tmp_path)
    for name in ("motor.gif", "laws.png"):
        made, there = frames_of(tmp_path / name), frames_of(STATIC / name)
        assert made.shape == there.shape
        # Another machine rounds otherwise, which moves an edge by a shade.
        assert np.abs(made - there).mean() < 0.5
