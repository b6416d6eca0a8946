"""A screen without a monitor (Xvfb, x11-utils), the mouse and the keyboard of a person (xdotool), and the window of
`proxima view`, which says in a file where its controls are and what it does."""
import json
import os
import shutil
import struct
import subprocess
import tempfile
import time
from pathlib import Path

from proxima_program import PROXIMA, environment_of_program

MISSING = [name for name in ("Xvfb", "xdotool", "xprop") if shutil.which(name) is None]
PATIENCE = 120  # seconds: for slow machines; every wait ends with what it waits for
DOUBLE_CLICK = 0.3  # seconds: ImGui takes two clicks on one point within them for a double-click


class Picture:
    """Pixels of the screen."""

    def __init__(self, path):
        data = Path(path).read_bytes()
        header = struct.unpack(">25I", data[:100])
        self.width, self.height, self._line = header[4], header[5], header[12]
        assert header[11] == 32 and header[7] == 0, "an X screen of 32 bits, the low byte first"
        self._pixels = data[header[0] + 12 * header[19]:]

    def pixel(self, x, y):
        """Red, green and blue."""
        at = y * self._line + 4 * x
        return self._pixels[at + 2], self._pixels[at + 1], self._pixels[at]

    def share(self, box, is_wanted, step=6):
        """The part of a box (x, y, width, height) whose pixels are wanted, of every step-th."""
        x, y, width, height = box
        wanted = seen = 0
        for row in range(y, y + height, step):
            for column in range(x, x + width, step):
                seen += 1
                wanted += bool(is_wanted(*self.pixel(column, row)))
        return wanted / seen


class Screen:
    """An X server of its own. \\pre not MISSING"""

    def __init__(self, dpi=96):
        """Dots per inch as desktops say them, by a property of the root window."""
        self._folder = tempfile.TemporaryDirectory()
        read, write = os.pipe()
        self._server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", "1400x1000x24", "-nolisten", "tcp", "-noreset", "-fbdir",
             self._folder.name],
            pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()
        assert number, "Xvfb did not start"
        self.environment = {**os.environ, "DISPLAY": f":{number}", "LIBGL_ALWAYS_SOFTWARE": "1"}
        subprocess.run(["xprop", "-root", "-f", "RESOURCE_MANAGER", "8s", "-set", "RESOURCE_MANAGER", f"Xft.dpi:\t{dpi}\n"],
                       env=self.environment, check=True, timeout=PATIENCE)

    def close(self):
        self._server.terminate()
        self._server.wait()
        self._folder.cleanup()

    def picture(self):
        return Picture(Path(self._folder.name) / "Xvfb_screen0")

    def window(self, name="Proxima"):
        """The number of the window of that name."""
        found = subprocess.run(["xdotool", "search", "--name", name], env=self.environment, check=True, timeout=PATIENCE,
                               stdout=subprocess.PIPE, text=True)
        return int(found.stdout.split()[0])

    def act(self, *words):
        """Mouse and keyboard, as xdotool has them."""
        subprocess.run(["xdotool", *map(str, words)], env=self.environment, check=True, timeout=PATIENCE,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


class Window:
    """proxima view on a screen."""

    def __init__(self, screen, folder, *arguments):
        self.screen = screen
        self._file = Path(folder) / "state.json"
        size = [] if "--size" in arguments else ["--size", "640x900"]  # the processor draws every pixel
        self._program = subprocess.Popen(
            [PROXIMA, "view", *map(str, arguments), *size, "--state", str(self._file), "--gl-debug"],
            env=environment_of_program(screen.environment), text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self._clicked = 0.0  # when a click was seen last
        self.wait(lambda state: state["frames"] > 2, "the first frames")

    def state(self):
        try:
            return json.loads(self._file.read_text())
        except FileNotFoundError:
            return {"frames": 0, "controls": {}, "settled": False, "models": 0}

    def wait(self, is_so, what):
        """The first state for which is_so(state) holds; fails after PATIENCE."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            state = self.state()
            if is_so(state):
                return state
            if self._program.poll() is not None:
                raise AssertionError(f"the window is gone before {what}: {self._program.communicate()}")
            time.sleep(0.02)
        raise AssertionError(f"{what} did not come: {json.dumps(self.state())[:3000]}")

    def settled(self):
        return self.wait(lambda state: state["models"] > 0 and state["settled"], "rest")

    def frames(self, count=4):
        """So many more frames were drawn."""
        begin = self.state()["frames"]
        return self.wait(lambda state: state["frames"] >= begin + count, "more frames")

    def point_of(self, control, part=0.5):
        found = self.wait(lambda state: control in state["controls"], f"the control {control}")["controls"][control]
        return round(found["x"] + part * found["width"]), round(found["y"] + 0.5 * found["height"])

    def bounds(self):
        """x, y, width and height of all controls but the one that hides messages."""
        return {name: (found["x"], found["y"], found["width"], found["height"])
                for name, found in self.state()["controls"].items() if name != "hide this"}

    def click(self, control, part=0.5):
        """The mouse goes to a control, to that part of its width, and clicks."""
        x, y = self.point_of(control, part)
        self.screen.act("mousemove", x, y)
        self.frames(2)  # a widget must see the mouse before the click
        time.sleep(max(0.0, self._clicked + 1.2 * DOUBLE_CLICK - time.monotonic()))
        self._press_and_let_go()

    def double_click(self, control, part=0.5):
        """Two clicks on one point, as fast as a person's."""
        x, y = self.point_of(control, part)
        self.screen.act("mousemove", x, y)
        self.frames(2)
        self.screen.act("click", "--repeat", 2, "--delay", 100, 1)
        self.frames(2)
        self._clicked = time.monotonic()

    def _press_and_let_go(self):
        self.screen.act("mousedown", 1)
        self.frames(2)
        self._clicked = time.monotonic()
        self.screen.act("mouseup", 1)
        self.frames(2)

    def choose(self, control, word):
        """Opens a menu and clicks a word of it."""
        self.click(control)
        self.frames(3)  # until the menu has its position
        self.click(f"{control}={word}")
        self.wait(lambda state: state["controls"][control]["value"] == word, f"{control} {word}")

    def value(self, control):
        return self.state()["controls"][control]["value"]

    def type(self, control, text):
        """Replaces the text of a field, and presses Enter."""
        self.click(control, 0.3)
        self.screen.act("keydown", "ctrl")
        self.press("a")
        self.screen.act("keyup", "ctrl")
        for part in range(0, len(text), 8):  # ImGui takes as many characters as come in a frame
            self.screen.act("type", "--delay", 30, text[part:part + 8])
            self.frames(2)
        self.wait(lambda state: state["controls"].get(control, {}).get("value") == text, f"{control} {text}")
        self.press("Return")

    def press(self, key):
        """For as long as ImGui takes to see it."""
        self.screen.act("keydown", key)
        self.frames(2)
        self.screen.act("keyup", key)
        self.frames(2)

    def drag(self, start, end, button=1):
        self.screen.act("mousemove", *start)
        self.frames(2)
        self.screen.act("mousedown", button)
        self.frames(2)
        for part in (0.3, 0.7, 1.0):
            self.screen.act("mousemove", *(round(a + part * (b - a)) for a, b in zip(start, end)))
            self.frames(1)
        self.screen.act("mouseup", button)
        self.frames(2)

    def view(self):
        """x, y, width, height of the models' picture."""
        return tuple(self.state()["view"])

    def middle(self):
        x, y, width, height = self.view()
        return x + width // 2, y + height // 2

    def end(self):
        """Exit status and what it said, once it has ended."""
        _, said = self._program.communicate(timeout=PATIENCE)
        return self._program.returncode, said

    def quit(self):
        self.screen.act("mousemove", *self.middle(), "key", "q")
        return self.end()

    def kill(self):
        if self._program.poll() is None:
            self._program.kill()
        self._program.communicate()
