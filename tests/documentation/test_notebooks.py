"""The notebooks that the site has to download run from their first cell to their last."""

import json
import subprocess
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest
from page_blocks import blocks, notebook

ROOT = Path(__file__).resolve().parents[2]
GALLERY = sorted((ROOT / "docs" / "gallery").glob("plot_*.py"))[:3]
"""The build of the site runs all; what a notebook is made of is in each."""


def run(cells: list[dict[str, Any]]) -> dict[str, Any]:
    """Run the cells of a notebook in the present folder and return its names."""
    names: dict[str, Any] = {"__name__": "__main__"}
    for cell in cells:
        source = "".join(cell["source"])
        if cell["cell_type"] == "code" and source.startswith("%%bash\n"):
            subprocess.run(["bash", "-e"], input=source.partition("\n")[2], text=True, check=True)
        elif cell["cell_type"] == "code":
            exec(compile(source.replace("%matplotlib inline", ""), "<cell>", "exec"), names)
    return names


def test_the_notebook_of_a_page_runs_what_the_page_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (
        "# A page\n\n<!-- not run: never -->\n```bash\nexit 1\n```\n\nWrite:\n\n```bash\necho 3 > n\n```\n\n"
        "```text\n```\n\n```python\nimport numpy as np\nn = int(np.loadtxt('n'))\n```\n"
        "<!-- picture: n.png, a number -->\nEnd.\n"
    )
    monkeypatch.chdir(tmp_path)
    made = json.loads(json.dumps(notebook(page)))
    assert [cell["cell_type"] for cell in made["cells"]] == [
        "markdown", "code", "markdown", "code", "markdown", "markdown"
    ]  # fmt: skip
    assert run(made["cells"])["n"] == 3
    assert "exit 1" in made["cells"][0]["source"]
    assert made["cells"][-2]["source"] == "![a number](n.png)"


def test_the_notebook_of_the_tutorial_has_the_blocks_that_the_build_follows() -> None:
    text = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")
    cells = [cell["source"] for cell in notebook(text)["cells"] if cell["cell_type"] == "code"]
    assert [cell.removeprefix("%%bash\n").strip() for cell in cells] == [b.code.strip() for b in blocks(text)]


@pytest.mark.long
@pytest.mark.parametrize("script", GALLERY, ids=lambda script: script.stem)
def test_the_notebook_of_a_gallery_script_runs(
    script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gallery = pytest.importorskip("sphinx_gallery.notebook", reason="needs sphinx-gallery")
    parser = pytest.importorskip("sphinx_gallery.py_source_parser")
    no_cells = dict.fromkeys(("first_notebook_cell", "last_notebook_cell"))
    plain = dict.fromkeys(("pypandoc", "promote_jupyter_magic", "notebook_images"), False)
    configuration = no_cells | plain
    _, script_blocks = parser.split_code_and_text_blocks(script)
    made = gallery.jupyter_notebook(script_blocks, configuration, str(tmp_path))
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("Agg")
    assert run(made["cells"])["cl"].__name__ == "contactlab"
    plt.close("all")
