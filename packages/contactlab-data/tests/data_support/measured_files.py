"""A small file of measured impacts, whose lines may be others."""

from pathlib import Path

BODY = {
    "title": "# title: Two drops",
    "mass_x": "# mass_x: 40 g",
    "mass_y": "# mass_y: 40 g",
    "mass_turn": "# mass_turn: 1.8e-5 kg m^2",
    "normal_x": "# normal_x: 0",
    "normal_y": "# normal_y: 1",
    "normal_turn": "# normal_turn: 2 mm",
    "tangential_x": "# tangential_x: 1",
    "tangential_y": "# tangential_y: 0",
    "tangential_turn": "# tangential_turn: 30 mm",
    "header": "before_x [m/s],before_y [m/s],before_turn [rad/s],"
    "after_x [m/s],after_y [m/s],after_turn [rad/s]",
    "first": "0.5,-2,0,0.32,1.05,2.3",
    "second": "0.1,-1.9,-3,0.09,1.03,-2.5",
}


def body_file(folder: Path, **changed: str) -> Path:
    """Write the file of the bodies with other lines; an empty one is left out."""
    path = folder / "drops.csv"
    path.write_text("".join(f"{line}\n" for line in (BODY | changed).values() if line))
    return path
