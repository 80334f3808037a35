"""How Sphinx builds the site from the Markdown in docs (scripts/site puts it together). Nothing is fetched when it is read."""

project = "balance"
extensions = ["myst_parser"]
root_doc = "index"
exclude_patterns = ["site"]

# Links to headings work as they do where the Markdown itself is shown.
myst_heading_anchors = 4
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
highlight_language = "text"

html_theme = "furo"
html_title = "balance"
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_static_path = ["style.css"]
html_css_files = ["style.css"]
