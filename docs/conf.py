"""Settings of Sphinx: `make docs` builds the pages of this folder and the reference into build/docs."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

from reference_pages import write_pages  # noqa: E402

write_pages(HERE / "api")

project = "medialbench"
author = "The medialbench authors"
copyright = "The medialbench authors, MIT licence"
release = version = version_of("medialbench")

extensions = [
    "myst_parser",  # Markdown
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_click",
    "links",  # these three are in _ext
    "mathml",
    "signatures",
]
exclude_patterns = ["_ext"]
suppress_warnings = ["toc.not_readable"]  # tests/test_documentation.py says which pages may be missing
default_role = "py:obj"
language = "en"

# pages
myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["math"]  # the form that GitHub shows, too
myst_heading_anchors = 4

# reference
autodoc_class_signature = "mixed"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
maximum_signature_line_length = 80
add_module_names = False
toc_object_entries_show_parents = "hide"
numpydoc_show_class_members = False  # autodoc lists them
numpydoc_xref_param_type = False

# appearance
html_theme = "furo"
html_title = f"medialbench {release}"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["medialbench.css"]
html_copy_source = False
html_show_sphinx = False
pygments_style = "default"
pygments_dark_style = "monokai"
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#1f5fa8", "color-brand-content": "#1f5fa8"},
    "dark_css_variables": {"color-brand-primary": "#7db7f0", "color-brand-content": "#7db7f0"},
}
