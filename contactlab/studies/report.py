"""Files of a result: dataset, figures (PNG and PDF), tables (CSV and LaTeX) and one page that holds them.

The same result leaves the same bytes: no file contains a date or a path.
"""

from base64 import b64encode
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, final

import pandas
import xarray
from jinja2 import Environment, PackageLoader, StrictUndefined, Template
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.style import context

from contactlab.plot.style import STYLE
from contactlab.results.files import whole_file
from contactlab.results.netcdf import write_tree
from contactlab.results.provenance import versions
from contactlab.results.yaml_text import write_yaml
from contactlab.studies.tables import as_csv, as_html, as_latex

PAGE: Final = "report.html"

MOST_ROWS: Final = 16
"""Rows of a table that is unfolded."""

FORMATS: Final[dict[str, Any]] = {"png": {"Software": None}, "pdf": {"CreationDate": None}}
"""Formats of figures, each with the metadata that would differ from run to run."""


def styled() -> AbstractContextManager[None]:
    """Return the context in which figures are drawn in the style of the package."""
    return context(STYLE)


@final
@dataclass(frozen=True)
class Report:
    """What is written of a result.

    Args:
        name: of the study and of the dataset's file.
        question: the title of the page, unless the data have one.
        data: the dataset.
        findings, tables: what the page shows of it.
        draw: makes the figures by name, once the dataset is written.
        options: of the study, by name.
        configurations: of the setups, by label.
    """

    name: str
    question: str
    data: xarray.DataTree
    findings: list[str]
    tables: Mapping[str, pandas.DataFrame]
    draw: Callable[[], Mapping[str, Figure]]
    options: Mapping[str, Any]
    configurations: Mapping[str, Any]

    def save(self, folder: Path) -> list[str]:
        """Write the files, each whole or not at all, and return their names.

        Raises:
            OSError: the folder cannot be written to.
        """
        folder.mkdir(parents=True, exist_ok=True)
        files = [f"{self.name}.nc"]
        write_tree(self.data, folder / files[0])
        pictures = {}
        for name, figure in self.draw().items():
            files += save_figure(figure, folder, name)
            caption = str(figure.get_label() or name.replace("_", " "))
            pictures[caption] = (folder / f"{name}.png").read_bytes()
        texts = {PAGE: self.page(pictures)}
        for name, frame in self.tables.items():
            texts |= {f"{name}.csv": as_csv(frame), f"{name}.tex": as_latex(frame)}
        for name, text in texts.items():
            with whole_file(folder / name) as partial:
                partial.write_text(text, encoding="utf-8")
        return [*files, *texts]

    def page(self, pictures: Mapping[str, bytes]) -> str:
        """Return a page that contains its pictures, PNG files by caption, and refers to nothing else."""
        attributes = self.data.attrs
        return _template().render(
            title=attributes.get("title") or self.question,
            question=self.question,
            findings=self.findings,
            # Short ones are shown without being unfolded, but for reference.
            tables=[
                (caption or name, as_html(frame), len(frame) <= MOST_ROWS and not _is_reference(frame))
                for name, frame in sorted(self.tables.items(), key=lambda pair: _is_reference(pair[1]))
                for caption in [frame.attrs.get("caption")]
            ],
            pictures=[(caption, b64encode(data).decode()) for caption, data in pictures.items()],
            options=write_yaml({"study": {"name": self.name, **self.options}}),
            configurations={
                label or "configuration": write_yaml(configuration)
                for label, configuration in self.configurations.items()
            },
            versions="; ".join(f"{name.removesuffix('_version')} {attributes[name]}" for name in versions()),
            revision=attributes["git_revision"],
        )


def save_figure(figure: Figure, folder: Path, name: str) -> list[str]:
    """Write a figure as PNG and PDF, and return the names of the files."""
    with styled():
        FigureCanvasAgg(figure)
        # The layout is computed once for both formats.
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
        for kind, metadata in FORMATS.items():
            with whole_file(folder / f"{name}.{kind}") as partial:
                figure.savefig(partial, format=kind, metadata=metadata)
    return [f"{name}.{kind}" for kind in FORMATS]


def _is_reference(frame: Any) -> bool:
    return bool(frame.attrs.get("reference"))


@cache
def _template() -> Template:
    loader = PackageLoader("contactlab", "studies")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    return environment.get_template(PAGE)
