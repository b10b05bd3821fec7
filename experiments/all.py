"""Every table and figure of the paper and the studies beyond it, and one page that shows them all.

    python experiments/all.py [output=DIR]

The page, index.html, holds its pictures itself. Exit status 1 if a finding does not hold.
"""

import sys
from base64 import b64encode
from collections.abc import Sequence
from html import escape
from importlib import import_module
from pathlib import Path

from harness import CONTRADICTED, DONE, NINE_DIGITS, Result, perform
from tqdm import tqdm

PAPER = (
    "table1_placement",
    "table2_friction_signs",
    "fig3_mode_curvature",
    "fig4_trajectories",
    "fig7_constrained_trajectories",
    "fig8_rotor_velocity",
    "fig9_normal_force",
    "fig10_sticking",
)
"""In the paper's order."""

BEYOND = (
    "identify_table1",
    "optimum_placement",
    "basis_convergence",
    "impact_step_study",
    "drive_phase_map",
    "orbits_over_clearance",
    "impact_oscillator",
    "friction_sweep",
    "law_comparison",
    "optimise_motor",
    "steady_states",
)
STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 0 auto; padding: 1rem; color: #222 }
img { max-width: 100%; height: auto }
.table { overflow-x: auto } table { border-collapse: collapse; font-size: 0.8rem }
td, th { padding: 0.15rem 0.6rem; text-align: right; white-space: nowrap; border-bottom: 1px solid #ddd }
.holds { color: #00623f } .not { color: #a33c00 } .says { color: #555 } section { margin: 2.5rem 0 }
"""


def page(results: Sequence[Result]) -> str:
    """The page: what the paper says, the picture, the numbers, what we find."""
    inside = sum(result.holds for result in results)
    parts = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>",
        "<meta name='viewport' content='width=device-width, initial-scale=1'>",
        f"<title>The paper, reproduced and extended</title><style>{STYLE}</style></head><body>",
        "<h1>The paper, reproduced and extended</h1>",
        "<p>Andersen, Blanke and Helbo (2001), <i>Two Mode Resonator and Contact Model for Standing Wave "
        f"Piezomotor</i>. {inside} of {len(results)} findings hold.</p>",
        *(section(result) for result in results),
        "</body></html>",
    ]
    return "\n".join(parts)


def section(result: Result) -> str:
    """One experiment on the page."""
    picture = b64encode((result.folder / "figure.png").read_bytes()).decode()
    mark, word = ("holds", "Holds") if result.holds else ("not", "Does not hold")
    table = result.rows.to_html(index=False, border=0, float_format=NINE_DIGITS)
    return (
        f"<section id='{result.name}'><h2>{escape(result.title)}</h2>"
        f"<p class='says'>{escape(result.says)}</p>"
        f"<img alt='{escape(result.title)}' src='data:image/png;base64,{picture}'>"
        f"<p><b class='{mark}'>{word}.</b> {escape(result.sentence)}</p>"
        f"<details><summary>Numbers</summary><div class='table'>{table}</div>"
        f"</details><p><code>python experiments/{result.name}.py</code></p></section>"
    )


def main(arguments: Sequence[str]) -> int:
    """Run everything and write the page; returns the exit status."""
    folder = Path("outputs") / "experiments"
    for word in arguments:
        if not word.startswith("output="):
            print(f"{word} is not understood; the one argument is output=DIR.", file=sys.stderr)
            return 2
        folder = Path(word.removeprefix("output="))
    # All of them first: one that lacks a package says so before any has run.
    modules = {name: import_module(name) for name in (*PAPER, *BEYOND)}
    results = []
    for name, module in tqdm(modules.items(), unit=" experiments", disable=None):
        results.append(perform(module, folder / name))
        tqdm.write(f"{name}: {'holds' if results[-1].holds else 'DOES NOT HOLD'}")
    (folder / "index.html").write_text(page(results), encoding="utf-8")
    print(f"Written to {folder / 'index.html'}")
    return DONE if all(result.holds for result in results) else CONTRADICTED


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
