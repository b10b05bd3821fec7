"""Where the measurements of others are, beside the project."""

from pathlib import Path

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
ELLIPSES = SHARED / "ellipse_impacts.mat"
SPHERES = SHARED / "sphere_impacts.csv"
