"""A fit that is killed, by its checkpoints: the same bytes as without."""

from pathlib import Path

import pytest
from support.killed import assert_the_same_when_killed


@pytest.mark.long
def test_a_fit_killed_at_random_leaves_the_same_bytes(tmp_path: Path) -> None:
    assert_the_same_when_killed(["data_support.fit_of_impacts", "killed"], tmp_path)
