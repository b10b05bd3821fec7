"""Every table and figure of the paper and the studies beyond it, and one page that shows them all.

    python experiments/all.py [NAME ...] [output=DIR]

The page, index.html, contains its pictures; it is left out where experiments are named. The results that
docs/ states are made by remake.py. Exit status 1 if a finding does not hold.
"""

import sys
from base64 import b64encode
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from experiment import CONTRADICTED, DONE, OUTPUTS, REFUSED, Experiment, class_of, perform
from jinja2 import Environment
from tqdm import tqdm

from contactlab.processes import processors
from contactlab.studies.study import Result
from contactlab.studies.tables import as_html

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
"""Experiments on the paper, in its order."""

BEYOND = (
    "identify_table1",
    "optimum_placement",
    "basis_convergence",
    "impact_step_study",
    "impact_mass",
    "drive_phase_map",
    "orbits_over_clearance",
    "impact_oscillator",
    "friction_sweep",
    "optimise_motor",
    "steady_states",
    "published_motor",
    "law_contrasts",
    "law_practice",
)
"""Experiments beyond it."""

PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>The paper, reproduced and extended</title><style>
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 0 auto; padding: 1rem; color: #222 }
img { max-width: 100%; height: auto } section { margin: 2.5rem 0 } .says { color: #555 }
.table { overflow-x: auto } table { border-collapse: collapse; font-size: 0.8rem }
td, th { padding: 0.15rem 0.6rem; text-align: right; white-space: nowrap; border-bottom: 1px solid #ddd }
</style></head><body>
<h1>The paper, reproduced and extended</h1>
<p>Andersen, Blanke and Helbo (2001), <i>Two Mode Resonator and Contact Model for Standing Wave
Piezomotor</i>. {{ sections | selectattr("holds") | list | length }} of {{ sections | length }} findings
agree with their claim.</p>
{% for section in sections %}
<section id="{{ section.name }}"><h2>{{ section.title }}</h2><p class="says">{{ section.says }}</p>
<img alt="{{ section.title }}" src="data:image/png;base64,{{ section.picture }}">
<p>{{ section.finding }} <b>This {{ "agrees with" if section.holds else "contradicts" }} the claim.</b></p>
<details><summary>Numbers</summary><div class="table">{{ section.table | safe }}</div></details>
<p><code>python experiments/{{ section.name }}.py</code></p></section>
{% endfor %}
</body></html>
"""


def page(results: Sequence[tuple[Result, Path]]) -> str:
    """Return the page: claim, figure, finding and numbers of each experiment.

    Args:
        results: each with the folder of its files.
    """
    sections = []
    for result, folder in results:
        study, about = result.study, result.data.attrs
        assert isinstance(study, Experiment)
        picture = b64encode((folder / f"{study.name}.png").read_bytes()).decode()
        table = as_html(result.tables["table"])
        sections.append({**about, "name": study.name, "picture": picture, "table": table})
    return Environment(autoescape=True).from_string(PAGE).render(sections=sections)


def numbers_of(result: Result) -> dict[str, Any]:
    """Return claim, finding, table and numbers of an experiment."""
    about, rows = result.data.attrs, result.tables["table"].to_dict("records")
    numbers = result.study.numbers(result.data)
    return {**{key: about[key] for key in ("says", "finding", "holds")}, "rows": rows, "numbers": numbers}


def main(arguments: Sequence[str]) -> int:
    """Run everything, write the page and return the exit status."""
    folder, named = OUTPUTS, []
    for word in arguments:
        if word.startswith("output="):
            folder = Path(word.removeprefix("output="))
        elif word in (*PAPER, *BEYOND):
            named.append(word)
        else:
            print(f"{word} is not understood; it must be an experiment or output=DIR.", file=sys.stderr)
            return REFUSED
    # All are imported first: a missing package is reported before any has run.
    names = [class_of(name).name for name in named or (*PAPER, *BEYOND)]
    results = []
    for name in tqdm(names, unit=" experiments", disable=None):
        result = perform(name, folder / name, workers=processors())
        results.append((result, folder / name))
        holds = results[-1][0].data.attrs["holds"]
        tqdm.write(f"{name}: the finding {'agrees with' if holds else 'CONTRADICTS'} the claim.")
    if not named:
        (folder / "index.html").write_text(page(results), encoding="utf-8")
        print(f"Written to {folder / 'index.html'}")
    return DONE if all(result.data.attrs["holds"] for result, _ in results) else CONTRADICTED


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
