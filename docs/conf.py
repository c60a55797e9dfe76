"""Settings of Sphinx for the site of these pages, which `python docs/build_site.py` builds."""

import sys
import tomllib
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
PROJECT = tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text("utf-8"))["project"]

project = PROJECT["name"]
version = release = PROJECT["version"]
copyright = "2026, the rpr-cusps authors"
language = "en"

extensions = ["myst_parser", "mathml"]
myst_enable_extensions = ["dollarmath"]
myst_dmath_allow_space = False
html_math_renderer = "mathml"
myst_heading_anchors = 3
nitpicky = True
highlight_language = "text"

html_theme = "furo"
html_title = f"{project} {version}"
html_static_path = ["theme"]
html_css_files = ["pages.css"]
html_search_scorer = str(Path(__file__).with_name("theme") / "scorer.js")
html_use_index = False
html_domain_indices = False
html_copy_source = False
FONTS = {"font-stack": "system-ui, sans-serif", "font-stack--monospace": "ui-monospace, monospace"}
html_theme_options = {"light_css_variables": FONTS, "footer_icons": []}
