"""What the README shows must be what is there: its program, its pictures, its links."""
import re
import sys
import unittest
from pathlib import Path

ROOT = Path(sys.argv.pop()).resolve()


class Readme(unittest.TestCase):
    text = (ROOT / "README.md").read_text()

    def test_the_program_is_the_example(self):
        programs = re.findall(r"```cpp\n(.*?)```", self.text, re.DOTALL)
        self.assertEqual(programs, [(ROOT / "examples/what_is_closest.cpp").read_text()])

    def test_links_and_pictures_exist(self):
        for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]:
            prose = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
            for target in re.findall(r"\]\(([^)#]+)[^)]*\)", prose):
                if not target.startswith("http"):
                    self.assertTrue((page.parent / target).exists(), f"{page.name}: {target}")

    def test_scripts_that_it_names_can_be_run(self):
        for script in set(re.findall(r"\bscripts/\w+", self.text)):
            self.assertTrue((ROOT / script).stat().st_mode & 0o100, script)


if __name__ == "__main__":
    unittest.main()
