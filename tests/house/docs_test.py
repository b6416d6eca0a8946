"""What the manual names must be there: files, sections, commands, options, papers."""
import re
import sys
import textwrap
import unittest
from pathlib import Path

ROOT = Path(sys.argv.pop()).resolve()
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
FOLDERS = ("src", "include", "apps", "python", "tests", "bench", "examples", "scripts", "fuzz", "docs", "cmake")
SOURCES = [path for folder in ("src", "include", "apps", "python", "tests", "bench", "examples", "fuzz")
           for path in (ROOT / folder).rglob("*") if path.suffix in (".h", ".cpp", ".py")]


def code_spans(page):
    """The words between backticks outside of blocks."""
    prose = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    return re.findall(r"`([^`\n]+)`", prose)


def anchors(page):
    """The names by which links reach a page's headings."""
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")
            for heading in re.findall(r"^#+ (.*)$", page.read_text(), flags=re.MULTILINE)}


def text_below(*folders):
    return "\n".join(path.read_text() for path in SOURCES if path.relative_to(ROOT).parts[0] in folders)


class Manual(unittest.TestCase):
    def test_programs_beside_those_of_other_libraries_are_the_tested_ones(self):
        tested = "\n".join(textwrap.dedent(re.sub(r"^    ", "", path.read_text(), flags=re.MULTILINE))
                           for path in (ROOT / "tests/coming_from").glob("*.cpp"))
        shown = re.findall(r"```cpp\n(.*?)```", (ROOT / "docs/coming_from.md").read_text(), re.DOTALL)
        self.assertEqual(len(shown), 6)
        for program in shown:
            self.assertIn(program, tested)

    def test_paths_exist(self):
        missing = []
        for page in PAGES:
            for span in code_spans(page):
                if re.fullmatch(r"(%s)/[\w./-]+" % "|".join(FOLDERS), span) and not (ROOT / span).exists():
                    missing.append(f"{page.name}: {span}")
        self.assertEqual(missing, [])

    def test_source_names_exist(self):
        names = {path.name for path in SOURCES}
        missing = [f"{page.name}: {span}" for page in PAGES if page.name != "which_header.md"
                   for span in code_spans(page)
                   if re.fullmatch(r"[a-z][\w-]*\.(h|cpp|py)", span) and span not in names
                   and span not in ("x.h", "x.cpp", "x-inl.h", "largest.cpp", "foreach_target.h", "immintrin.h")]
        self.assertEqual(missing, [])

    def test_headers_have_the_functions_that_the_table_names(self):
        def path_of(header):
            return ROOT / ("src" if "/" in header else "include/proxima") / header

        missing = []
        for row in re.findall(r"^\|(.*)\|$", (ROOT / "docs/which_header.md").read_text(), flags=re.MULTILINE):
            cells = row.split("|")
            files = re.findall(r"`([\w/]+\.h)`", " ".join(cells[1:-1]))
            text = "\n".join(path_of(file).read_text() for file in files if path_of(file).exists())
            missing += [file for file in files if not path_of(file).exists()]
            missing += [f"{files}: {name}" for name in re.findall(r"`(\w+)[^`]*`", cells[-1])
                        if files and not re.search(rf"\b{name}\b", text)]
        self.assertEqual(missing, [])

    def test_links_reach_a_section(self):
        missing = []
        for page in PAGES:
            for file, section in re.findall(r"\]\(([^)#\s]*)#([^)\s]+)\)", page.read_text()):
                target = page.parent / file if file else page
                if target.suffix == ".md" and section not in anchors(target):
                    missing.append(f"{page.name}: {file}#{section}")
        self.assertEqual(missing, [])

    def test_every_page_is_linked(self):
        linked = {(page.parent / target).resolve() for page in PAGES
                  for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", page.read_text())}
        self.assertEqual([page.name for page in PAGES if page.parent.name == "docs" and page not in linked], [])

    def test_commands_exist(self):
        known = set(re.findall(r'add_subcommand\(\s*"([\w-]+)"', text_below("apps")))
        self.assertIn("octree", known)
        named = {(page.name, command) for page in PAGES
                 for command in re.findall(r"(?:^    |`|\$ )proxima (\w[\w-]*)\b", page.read_text(), flags=re.MULTILINE)}
        self.assertEqual(sorted(pair for pair in named if pair[1] not in known), [])

    def test_options_exist(self):
        # Options of CMake, of Google Benchmark, of Open MPI and of scripts/check are not the program's.
        foreign = {"--benchmark", "--build", "--component", "--install", "--prefix", "--preset", "--target", "--workflow", "--cflags", "--libs", "--changed", "--wheel",
                   "--no-isolation", "--mca", "--system-site-packages", "--no-index", "--no-deps", "--no-build-isolation"}
        code = text_below("apps", "bench") + "".join(path.read_text() for path in (ROOT / "scripts").glob("*")
                                                     if path.is_file())
        missing = sorted({f"{page.name}: {option}" for page in PAGES
                          for option in re.findall(r"(?<![\w-])--[a-z]+(?:-[a-z]+)*", page.read_text())
                          if option not in foreign and option not in code
                          and option not in ("--help", "--version")})
        self.assertEqual(missing, [])

    def test_papers_are_in_the_bibliography(self):
        keys = set(re.findall(r"^\| ([a-z][\w-]*)", (ROOT / "docs/bibliography.md").read_text(), flags=re.MULTILINE))
        cited = {(page.name, key) for page in PAGES + SOURCES
                 for key in re.findall(r"\b([a-z]+(?:-[a-z]+)?-(?:19|20)\d\d)\b", page.read_text())}
        self.assertEqual(sorted(pair for pair in cited if pair[1] not in keys), [])


if __name__ == "__main__":
    unittest.main()
