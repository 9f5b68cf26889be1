"""How is the site built? The guide in docs/ and a page for each module from its docstrings.

``make docs`` writes it to ``build/docs``; a test builds it with every warning an error.
"""

from lrsr import __version__

project = "lrsr"
author = project_copyright = "the lrsr authors"
release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.apidoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
]
apidoc_modules = [
    {
        "path": "../lrsr",
        "destination": "api",
        "separate_modules": True,
        "include_private": False,
        "automodule_options": {"members", "show-inheritance"},
    }
]
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
napoleon_google_docstring = True
napoleon_use_ivar = True  # attributes of a dataclass are described once
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3
suppress_warnings = [
    "myst.xref_missing",  # links to files of the repository work there, not on the site
    "ref.python",  # a name that several modules have, such as Colour
]

html_theme = "furo"
html_title = f"lrsr {release}"
exclude_patterns = ["api/modules.rst"]  # the list that api/lrsr.rst begins with
