"""The published friction loop of a tribometer, as a file that `contactlab drive` and `fit` read.

    python experiments/tribometer.py test_data_2.txt tribometer.csv

The published file is examples/test_data_2.txt of github.com/jchristopherson/FrictionModels.jl: time [s],
normal force [uN], position [mm] and friction [uN] at 200 Hz.
"""

import sys
from pathlib import Path
from typing import Final

import numpy as np

BEGIN, END, EVERY = 20.8, 206.0, 20
"""Times of the first and last row that are kept [s], and one row of how many: it moves at the first."""

LICENCE: Final = """\
# title: A friction loop of a tribometer, measured
# source: J. Christopherson, FrictionModels.jl, examples/test_data_2.txt, commit e60a4bd2
# note: every 20th row of 20.8 s to 206 s
# licence: MIT
#
# Copyright (c) 2021 Jason Christopherson and contributors
#
# Permission is hereby granted, free of charge, to any person obtaining a copy of this software and
# associated documentation files (the "Software"), to deal in the Software without restriction, including
# without limitation the rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
# copies of the Software, and to permit persons to whom the Software is furnished to do so, subject to the
# following conditions:
#
# The above copyright notice and this permission notice shall be included in all copies or substantial
# portions of the Software.
#
# THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT
# LIMITED TO THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO
# EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER
# IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE
# USE OR OTHER DEALINGS IN THE SOFTWARE.
"""
"""The head of the file, with the notice that the licence asks for."""


def convert(published: Path, target: Path) -> None:
    """Write a part of the published record with its units and its licence."""
    time, normal, position, friction = np.loadtxt(published, skiprows=1).T
    kept = np.flatnonzero((time >= BEGIN) & (time <= END))[::EVERY]
    slip = 1e3 * (position - position[kept[0]])
    lines = ["time [s],slip [um],normal [N],friction_force [N]"]
    lines += [
        f"{time[n] - time[kept[0]]:g},{slip[n]:.4g},{1e-6 * normal[n]:.4f},{1e-6 * friction[n]:.4f}"
        for n in kept
    ]
    target.write_text(LICENCE + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    convert(*map(Path, sys.argv[1:]))
