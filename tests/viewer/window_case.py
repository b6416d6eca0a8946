"""A test of the window of `proxima view`: a screen without a monitor, and a person's acts that end with what they change."""
import re
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "apps"))

import xvfb_screen  # noqa: E402
from proxima_program import SANITIZED, ProgramTest  # noqa: E402
from xvfb_screen import Screen, Window  # noqa: E402


class WindowTest(ProgramTest):
    """Gives each test a screen."""
    dpi = 96

    @classmethod
    def setUpClass(cls):
        if xvfb_screen.MISSING:
            why = f"not installed: {' '.join(xvfb_screen.MISSING)} (group test of packages.txt)"
            print("skipped:", why, flush=True)  # ctest reads it
            raise unittest.SkipTest(why)
        cls.screen = Screen(cls.dpi)
        cls.addClassCleanup(cls.screen.close)

    def open(self, *arguments):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        window = Window(self.screen, folder.name, *arguments)
        self.addCleanup(window.kill)
        return window

    def close(self, window):
        status, said = window.quit()
        if SANITIZED:  # it names reports that are left out, too, and Mesa's compiled shaders are no file
            said = re.sub("LLVMSymbolizer: error reading file: .*\n", "", said)
        self.assertEqual((status, said), (0, ""))

    def share(self, window, is_wanted):
        """Of the models' picture, once it rests."""
        window.settled()
        window.frames(3)
        return self.screen.picture().share(window.view(), is_wanted)

    def turn_over(self, window, control):
        before = window.value(control)
        window.click(control, 0.1)
        window.wait(lambda state: state["controls"][control]["value"] != before, f"a change of {control}")

    def slide(self, window, control, part):
        before = window.value(control)
        window.click(control, part)
        window.wait(lambda state: state["controls"][control]["value"] != before, f"a change of {control}")
        self.assertEqual(window.settled()["problem"], "")
