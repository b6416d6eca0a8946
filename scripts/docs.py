#!/usr/bin/env python3
"""Makes the documentation site, in build/docs/html: the manual, and the references of C++, C and Python from their sources.

    scripts/docs [PRESET] [--open]        builds with the preset release by default

Installs what it needs, builds the Python module, and reads the public headers with Doxygen. Every warning of Sphinx, such
as a link that leads nowhere, is an error. No network. --open shows the site in the browser.
"""
import argparse
import os
import re
import shutil
import subprocess
import sys
import webbrowser
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / "build" / "docs"
SOURCE = WORK / "source"
HEADERS = ROOT / "include" / "proxima"

DOXYGEN = """
PROJECT_NAME = Proxima
INPUT = {headers}
FILE_PATTERNS = *.h
RECURSIVE = YES
OUTPUT_DIRECTORY = {work}
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_OUTPUT = doxygen
XML_PROGRAMLISTING = NO
FILTER_PATTERNS = *.h="{python} -B {root}/docs/site/doxygen_filter.py"
STRIP_FROM_PATH = {headers}
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = PROXIMA_EXPORT= PROXIMA_HIDDEN= PROXIMA_C_API= __cplusplus
EXTRACT_ALL = YES
AUTOLINK_SUPPORT = NO
SORT_MEMBER_DOCS = NO
SHOW_INCLUDE_FILES = NO
QUIET = YES
WARNINGS = NO
"""


def run(*command, **options):
    subprocess.run([str(word) for word in command], cwd=ROOT, check=True, **options)


def write_page(name, title, words, blocks):
    page = SOURCE / "reference" / f"{name}.md"
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text("\n".join([f"# {title}", "", words, "", *blocks, ""]))


def write_reference():
    """A page for each header, one for the header for C, and one for the Python module."""
    headers = sorted(path.name for path in HEADERS.glob("*.h") if path.name not in ("proxima.h", "export.h"))
    for header in headers:
        write_page(f"cpp/{header.removesuffix('.h')}", f"proxima/{header}", "",
                   [f"```{{doxygenfile}} {header}", ":sections: briefdescription detaileddescription innerclass innernamespace "
                    "public-type public-func public-attrib public-static-func public-static-attrib typedef enum func var define",
                    "```"])
    write_page("cpp", "C++", "The public headers. `#include <proxima/proxima.h>` includes all of them.",
               ["```{toctree}", ":maxdepth: 1", "", *(f"cpp/{header.removesuffix('.h')}" for header in headers), "```"])
    write_page("c", "C", "The header `proxima/c/proxima.h`.", ["```{doxygenfile} c/proxima.h", "```"])
    write_page("python", "Python", "The module `proxima`.",
               ["```{eval-rst}", ".. automodule:: proxima", "   :members:", "   :undoc-members:", "   :imported-members:", "```", "",
                "## In place of other libraries", "", "```{eval-rst}",
                *(line for name in ("trimesh", "open3d", "igl")
                  for line in (f".. automodule:: proxima.compat.{name}", "   :members:", "")), "```"])


def main():
    parser = argparse.ArgumentParser(usage="scripts/docs [PRESET] [--open]", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("preset", nargs="?", default="release", help=argparse.SUPPRESS)
    parser.add_argument("--open", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    run("scripts/install_packages", "build", "core", "cli", "python", "docs")
    run("cmake", "--preset", options.preset, "--log-level=NOTICE", "-DPROXIMA_BUILD_PYTHON=ON")
    run("scripts/build", options.preset, "--target", "proxima_python")

    shutil.rmtree(WORK, ignore_errors=True)
    SOURCE.mkdir(parents=True)
    for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"):
        shutil.copy(ROOT / name, SOURCE)
    shutil.copytree(ROOT / "docs", SOURCE / "docs")
    shutil.copy(ROOT / "docs/site/index.md", SOURCE)
    run("doxygen", "-", input=DOXYGEN.format(headers=HEADERS, work=WORK, root=ROOT, python=sys.executable), text=True)
    write_reference()
    # What pages link to besides pages.
    for name in subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split():
        if not name.endswith(".md") and not name.startswith("docs/"):
            (SOURCE / name).parent.mkdir(parents=True, exist_ok=True)
            (SOURCE / name).symlink_to(ROOT / name)
    environment = {**os.environ, "PROXIMA_ROOT": str(ROOT), "PROXIMA_DOXYGEN": str(WORK / "doxygen"),
                   "PYTHONPATH": str(ROOT / "build" / options.preset / "python")}
    run("/usr/bin/sphinx-build", "-q", "-W", "--keep-going", "-c", ROOT / "docs/site", SOURCE, WORK / "html", env=environment)
    print(f"The site is in {WORK / 'html'}")
    if options.open:
        webbrowser.open((WORK / "html/index.html").as_uri())


if __name__ == "__main__":
    main()
