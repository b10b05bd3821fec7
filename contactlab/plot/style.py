"""How every picture of an experiment or a comparison looks."""

from pathlib import Path
from typing import Final

STYLE: Final = Path(__file__).with_name("paper.mplstyle")
"""A style sheet of matplotlib."""
