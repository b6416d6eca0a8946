"""Sphinx's settings for the documentation site; scripts/docs says how it is built."""
import logging
import os
import re
from pathlib import Path

from sphinx.errors import ExtensionError

ROOT = Path(os.environ["PROXIMA_ROOT"])

project = "Proxima"
author = "the Proxima authors"
release = re.search(r"^project\(proxima\s+VERSION\s+([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.MULTILINE)[1]
project_copyright = ""

extensions = ["myst_parser", "breathe", "sphinx.ext.autodoc"]
root_doc = "index"
exclude_patterns = ["docs/site"]

myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]

breathe_projects = {"proxima": os.environ["PROXIMA_DOXYGEN"]}
breathe_default_project = "proxima"
breathe_show_include = False
breathe_default_members = ("members", "undoc-members")
breathe_domain_by_file_pattern = {"c/proxima.h": "c"}
cpp_id_attributes = ["PROXIMA_EXPORT", "PROXIMA_HIDDEN"]
c_id_attributes = ["PROXIMA_C_API"]
primary_domain = "cpp"
highlight_language = "none"

autodoc_member_order = "bysource"
autodoc_typehints = "signature"

html_theme = "furo"
html_title = f"Proxima {release}"
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_theme_options = {"navigation_with_keys": True}
html_static_path = html_css_files = ["site.css"]


def write_as_rst(_app, _what, _name, _object, _options, lines):
    """Docstrings are plain text, as help() shows them: what is indented stays as it is."""
    text = []
    inside = False
    for line in lines:
        indented = line.startswith("    ")
        if indented and not inside:
            text += ["::", ""]
        elif line.strip() and not indented and inside:
            text.append("")
        if line.strip():
            inside = indented
        text.append(line if indented else re.sub(r"([*_|\\])", r"\\\1", line))
    lines[:] = text


def without_the_inner_module(_app, _what, _name, _object, _options, signature, returns):
    """Classes by the names that they have for users; `object` says nothing of what docstrings say."""
    def shown(text):
        return text and re.sub(r"self: [\w.]+(, )?|: object|proxima\._core\.", "", text)

    return shown(signature), None if returns == "object" else shown(returns)


def is_no_namespace(record):
    """The page of each header declares the namespace again, of which Sphinx 5 warns."""
    return not record.getMessage().endswith("Declaration is '.. cpp:type:: proxima'.")


def follow_dark_windows(app, exception):
    """Debian's furo has lost the rule that takes its dark colours where the window is dark, so that only programs were."""
    if exception is not None:
        return
    furo = Path(app.outdir, "_static/styles/furo.css").read_text()
    if "prefers-color-scheme" not in furo:
        dark = re.search(r'body\[data-theme="dark"\] (\{.*?\})', furo, re.DOTALL)
        if dark is None:
            raise ExtensionError("furo.css has no rule for body[data-theme=\"dark\"]: see follow_dark_windows in conf.py")
        own = Path(app.outdir, "_static/site.css")
        own.write_text((Path(__file__).parent / "site.css").read_text() +
                       f'@media (prefers-color-scheme: dark) {{ body:not([data-theme="light"]) {dark[1]} }}\n')


def setup(app):
    logging.getLogger("sphinx.sphinx.domains.cpp").addFilter(is_no_namespace)
    app.connect("autodoc-process-docstring", write_as_rst)
    app.connect("autodoc-process-signature", without_the_inner_module)
    app.connect("build-finished", follow_dark_windows)
