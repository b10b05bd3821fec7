"""Pictures of the gallery: those that no pyplot manages, as `Solution.plot` gives, and their style."""

from typing import Any, Final

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

from contactlab.plot.style import STYLE

DPI: Final = 140.0


def scraped(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figures that a script has in its names, and give their directives."""
    names = block_vars["example_globals"]
    saved = []
    for name, item in list(names.items()):
        if isinstance(item, Figure) and item.canvas.manager is None:
            path = next(block_vars["image_path_iterator"])
            item.savefig(path, dpi=DPI)
            saved.append(path)
            # It is shown where it was made, and not again.
            del names[name]
    return str(figure_rst(saved, gallery_conf["src_dir"]))


def styled(gallery_conf: dict[str, Any], name: str) -> None:
    """Begin every script with the style of the project's pictures."""
    plt.close("all")
    plt.rcdefaults()
    plt.rcParams.update({**STYLE, "figure.figsize": (6.2, 3.2), "savefig.dpi": DPI, "figure.dpi": DPI})
