"""Settings of Sphinx. The source folder is that of the repository, so that its links hold."""

import sys
from importlib import metadata
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "extensions"))

project = "envlights"
author = "The envlights authors"
copyright = "the envlights authors"
release = metadata.version("envlights")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "guide_links",
    "math_markup",
    "program_facts",
    "reference_pages",
]
root_doc = "docs/index"
include_patterns = ["docs/**.md", "docs/**.rst", "notebooks/*.ipynb", "*.md"]
exclude_patterns = [
    *("README.md", "docs/examples", "docs/_build", "docs/templates"),
    *("target", "**/node_modules", "python", "src", "tests", "benchmarks", "fuzz", ".*"),
]
templates_path = [str(HERE / "templates")]

# Markdown, and notebooks with the outputs that they store.
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
myst_update_mathjax = False
nb_execution_mode = "off"
nb_merge_streams = True

# The reference: numpydoc's sections, one page for each name.
default_role = "py:obj"
autosummary_ignore_module_all = False
autodoc_typehints = "none"
autodoc_member_order = "groupwise"
numpydoc_show_class_members = False
python_use_unqualified_type_names = True
viewcode_follow_imported_members = True

sphinx_gallery_conf = {
    "examples_dirs": "docs/examples",
    "gallery_dirs": "docs/gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "plot_gallery": True,
    "abort_on_example_error": True,
    "capture_repr": (),
    "image_scrapers": ("example_pictures.scrape",),
    "copyfile_regex": "",
}

# Everything that a page loads comes with the site.
html_math_renderer = "mathml"
html_theme = "furo"
html_title = "envlights"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_extra_path = ["static/index.html"]
html_search_scorer = str(HERE / "extensions" / "scorer.js")
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}
