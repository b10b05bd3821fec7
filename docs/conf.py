"""How Sphinx builds the documentation: `python -m sphinx -W -n --keep-going docs build/site`.

Nothing is fetched: formulas are MathML, the theme brings its fonts, and no index of another site is read.
"""

import sys
import tomllib
from pathlib import Path

from pygments.lexers import TextLexer
from sphinx.application import Sphinx

import contactlab

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "extensions"))

import kept_pages  # noqa: E402

project = "contactlab"
author = "The contactlab developers"
copyright = author  # noqa: A001
version = release = contactlab.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_gallery.gen_gallery",
    "math_markup",
    "made_pages",
    "followed_pages",
    "docstrings",
    "whole_site",
]
exclude_patterns = ["gallery/**", "extensions/**", "tools/**", "sg_execution_times.rst"]
# Names of the code stand in single backticks, in docstrings as in Markdown.
default_role = "code"
highlight_language = "none"

myst_enable_extensions = ["dollarmath"]
# Links to headings, page.md#heading, are those of a repository browser.
myst_heading_anchors = 4

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
# Imported for type checkers alone.
nitpick_ignore = [("py:class", "Figure")]

# Its scripts run again where they, or the code, have changed.
CODE = kept_pages.digest()
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",
    "filename_pattern": "/plot_",
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": ("gallery_figures.scraped", "matplotlib"),
    "reset_modules": ("gallery_figures.styled",),
    "capture_repr": (),
    "abort_on_example_error": True,
    "run_stale_examples": not kept_pages.is_current(HERE / "examples", CODE),
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_signature": False,
    "write_computation_times": False,
}

# Where the project is hosted stands in its metadata alone, once it is.
metadata = tomllib.loads((HERE.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]

html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = "contactlab"
html_favicon = "static/logo.svg"
html_static_path = ["static"]
html_css_files = ["contactlab.css"]
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {
    "logo": {
        "text": "contactlab",
        "image_light": "_static/logo.svg",
        "image_dark": "_static/logo.svg",
        "alt_text": "",
    },
    "show_prev_next": True,
    "header_links_before_dropdown": 7,
    "show_nav_level": 2,
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "external_links": [{"name": name, "url": url} for name, url in metadata.get("urls", {}).items()],
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
# It has no pages beside it.
html_sidebars = {"index": []}


def setup(app: Sphinx) -> None:
    """Let tables of text in pages be called what they are, and note what the gallery was made by."""
    app.add_lexer("csv", TextLexer)
    # By now it has been made, or the build has failed.
    app.connect("env-before-read-docs", lambda *_: kept_pages.keep(HERE / "examples", CODE))
