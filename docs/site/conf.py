"""Sphinx's configuration of the site (scripts/site.sh)."""
import json
import os
import pathlib

root = pathlib.Path(__file__).resolve().parents[2]

project = "procam"
author = "procam maintainers"
copyright = "procam contributors"
release = os.environ.get("PROCAM_VERSION", "")
version = release

extensions = ["myst_parser", "sphinx.ext.graphviz"]
graphviz_output_format = "svg"

# The headings' anchors are those of GitHub, which the documents link.
myst_heading_anchors = 6
myst_all_links_external = False
suppress_warnings = [
    "misc.highlighting_failure",  # JSON with comments, output of programs
    "myst.header",  # a document may begin below its first level
]

html_theme = "furo"
html_title = f"procam {release}"
html_static_path = [str(root / "docs/site/static")]
html_extra_path = [os.environ.get("PROCAM_SITE_EXTRA", "")] if os.environ.get("PROCAM_SITE_EXTRA") else []
html_css_files = ["procam.css"]
html_copy_source = False
html_show_sourcelink = False
html_last_updated_fmt = None
templates_path = [str(root / "docs/site/templates")]
html_sidebars = {
    "**": [
        "sidebar/brand.html",
        "sidebar/search.html",
        "sidebar/scroll-start.html",
        "sidebar/navigation.html",
        "sidebar/scroll-end.html",
        "versions.html",
    ]
}
html_theme_options = {"navigation_with_keys": True}
pygments_style = "tango"
primary_domain = "cpp"
highlight_language = "none"
nitpicky = False
toc_object_entries = False


def sort_search_index(app, exception):
    """Sphinx 5 writes the titles in the order in which its processes end: each build would have another file."""
    file = pathlib.Path(app.outdir) / "searchindex.js"
    if exception or not file.exists():
        return
    start, end = "Search.setIndex(", ")"
    index = json.loads(file.read_text()[len(start) : -len(end)])
    for places in index["alltitles"].values():
        places.sort(key=json.dumps)
    file.write_text(start + json.dumps(index, sort_keys=True) + end)


def setup(app):
    app.connect("build-finished", sort_search_index)
