"""The documentation as a site: `scripts/docs` builds it into build/site. Pages are the Markdown files here; the API page comes from docstrings."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
project = "matpoint"
release = re.search(r"project\(matpoint VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
root_doc = "README"
exclude_patterns = ["images"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = f"matpoint {release}"
autodoc_member_order = "bysource"
autodoc_typehints = "description"
napoleon_google_docstring = True
# Links out of this folder (sources, shipped cases) are for readers of the repository; a site has no such files.
suppress_warnings = ["myst.xref_missing"]
