"""The window of `proxima view` as a person uses it: on a screen without a monitor, by mouse and keyboard."""
import math
import os
import resource
import struct
import subprocess
import sys
import unittest

from window_case import WindowTest
from dragged_files import DraggedFiles
from proxima_program import ProgramTest, run


class Opening(WindowTest):
    """Models that are opened from within the window: by their path, from the list, dropped on it."""

    def model(self, name, corners=3):
        """A fan of corners - 2 triangles."""
        vertices = "".join(f"v {number} {number * number} 0\n" for number in range(corners))
        return self.file(name, vertices + "".join(f"f 1 {k + 1} {k + 2}\n" for k in range(1, corners - 1)))

    def test_a_window_without_a_model_asks_for_one(self):
        folder = self.folder / "models"
        folder.mkdir()
        self.model("models/fan.obj", 7)
        self.file("models/notes.txt", "")
        window = self.open()
        window.wait(lambda state: state["files"] and state["models"] == 0, "the panel that opens models")
        window.type("path", str(folder))
        window.wait(lambda state: "fan.obj" in state["controls"], "the folder's list")
        self.assertNotIn("notes.txt", window.state()["controls"])
        window.click("../", 0.1)
        window.wait(lambda state: "models/" in state["controls"], "the folder above")
        window.click("models/", 0.1)
        window.wait(lambda state: "fan.obj" in state["controls"], "the folder again")
        window.click("fan.obj", 0.1)
        window.wait(lambda state: state["controls"]["path"]["value"] == "fan.obj", "the name in the field")
        window.click("open")
        state = window.settled()
        self.assertEqual((state["models"], state["facts"]["triangles"], state["files"]), (1, "5", False))
        self.close(window)

    def test_a_double_click_enters_one_folder_and_opens_one_model(self):
        inner = self.folder / "models" / "models"
        inner.mkdir(parents=True)
        self.model("models/fan.obj", 7)
        self.model("models/models/one.obj")
        window = self.open()
        window.type("path", str(self.folder))
        window.wait(lambda state: "models/" in state["controls"], "the folder's list")
        for _ in range(20):  # the second click may come late on a busy machine, and enter a second folder
            window.double_click("models/", 0.1)
            window.frames(10)
            window.wait(lambda state: {"fan.obj", "one.obj"} & state["controls"].keys(), "a folder within")
            if "fan.obj" in window.state()["controls"]:
                break
            window.click("../", 0.1)
            window.wait(lambda state: "fan.obj" in state["controls"], "the folder above")
            window.click("../", 0.1)
            window.wait(lambda state: "fan.obj" not in state["controls"], "the first folder")
        state = window.state()
        self.assertIn("fan.obj", state["controls"], "only one folder was entered")
        self.assertEqual((state["models"], state["files"], window.value("path")), (0, True, ""))
        for _ in range(20):  # here, too
            window.double_click("fan.obj", 0.1)
            window.frames(10)
            if window.state()["models"] > 0:
                break
        self.assertEqual(window.settled()["facts"]["triangles"], "5")
        self.close(window)

    def test_what_cannot_be_opened_is_said_and_all_goes_on(self):
        broken = self.file("broken.obj", "v 0 0 0\nf 1 2 3\n")
        window = self.open("icosphere:2", "--panel", "octree", "--budget-mb", 50)
        cells = window.settled()["facts"]["cells"]
        window.click("open...")
        window.wait(lambda state: state["files"] and "../" in state["controls"], "the panel that opens models")
        window.frames(2)
        before = window.bounds()
        for path, says in ((str(broken), "broken.obj:2"), (str(self.folder / "none.ply"), "none.ply"),
                           ("icosphere:8", "the budget is 50 MB")):
            window.type("path", path)
            said = window.wait(lambda state: says in state["problem"], f"the message about {path}")
            self.assertEqual((said["models"], said["files"]), (1, True))
        self.assertEqual(window.settled()["facts"]["cells"], cells)
        self.assertIn("hide this", window.state()["controls"])
        after = window.bounds()
        for name in ("open...", "panel", "depth", "show all", "save picture", "path", "open", "../"):
            self.assertEqual(after[name], before[name], f"the message moves {name}")
        camera = window.state()["camera"]
        window.click("hide this")
        window.wait(lambda state: state["problem"] == "" and "hide this" not in state["controls"], "no message")
        self.assertEqual(window.state()["camera"], camera)
        self.assertIsNone(window.state()["picked"], "a click on the message is none on the picture")
        self.slide(window, "depth", 0.8)
        window.click("beside those there are", 0.1)
        window.type("path", "cube")
        window.wait(lambda state: state["models"] == 2 and not state["files"], "a second model")
        self.close(window)

    def test_files_are_dropped(self):
        window = self.open("cube")
        window.settled()
        files = DraggedFiles(self.screen.environment["DISPLAY"])
        self.addCleanup(files.close)
        number = self.screen.window()
        files.drop(number, window.middle(), [self.model("one.obj", 5), self.model("two.obj")])
        window.wait(lambda state: state["models"] == 2, "the files")
        self.assertEqual(window.settled()["facts"]["triangles"], ["3", "1"], "of each")
        files.drop(number, window.middle(), [self.file("broken.stl", "solid\n facet normal 0 0 one\n")])
        window.wait(lambda state: "broken.stl" in state["problem"], "the message")
        self.assertEqual(window.state()["models"], 2)
        files.drop(number, window.middle(), [self.folder])
        window.wait(lambda state: "one.obj" in state["controls"], "the folder's list")
        self.screen.act("key", "Escape")
        window.wait(lambda state: not state["files"], "the panel's end")
        self.close(window)

    def test_loading_is_stopped(self):
        window = self.open("cube")
        window.settled()
        window.click("open...")
        window.type("path", "spaceship:3000000")
        window.wait(lambda state: state["stage"] != "", "loading")
        before = window.state()["frames"]
        window.wait(lambda state: state["frames"] > before + 2, "frames meanwhile")
        window.click("cancel")
        window.wait(lambda state: "stopped on request" in state["problem"], "the end")
        self.assertEqual(window.settled()["models"], 1)
        self.close(window)


class Mouse(WindowTest):
    """Turning, moving, going nearer, picking, the window's size; what is uploaded."""

    def test_camera_and_uploads(self):
        window = self.open("icosphere:4", "torus:32x16")
        state = window.settled()
        self.assertEqual(state["models"], 2)
        x, y = window.middle()
        window.frames(3)
        before = window.state()
        window.drag((x, y), (x + 90, y + 30))
        turned = window.state()
        self.assertNotEqual(turned["camera"]["azimuth"], before["camera"]["azimuth"])
        self.assertNotEqual(turned["camera"]["elevation"], before["camera"]["elevation"])
        self.assertEqual(turned["camera"]["target"], before["camera"]["target"])
        window.drag((x, y), (x + 50, y), button=3)
        moved = window.state()
        self.assertNotEqual(moved["camera"]["target"], turned["camera"]["target"])
        self.assertEqual(moved["camera"]["azimuth"], turned["camera"]["azimuth"])
        self.screen.act("mousemove", x, y, "click", 4, "click", 4)
        window.wait(lambda now: now["camera"]["distance"] < moved["camera"]["distance"], "going nearer")
        window.choose("theme", "dark")
        self.assertEqual(window.settled()["uploads"], before["uploads"], "moving uploads nothing")
        r, g, b = self.screen.picture().pixel(window.view()[0] + 8, 8)
        self.assertLess(max(r, g, b), 90, "the background is dark")

        def whole(now):
            """The frame is filled for the present direction: the target is only near the one of before."""
            aside = math.dist(now["camera"]["target"], before["camera"]["target"])
            return aside < 0.1 and now["camera"]["distance"] > 0.7 * before["camera"]["distance"]

        self.assertFalse(whole(window.state()))
        window.click("show all")
        window.wait(whole, "the whole")
        self.turn_over(window, "smooth")
        self.assertGreater(window.settled()["uploads"], before["uploads"], "other normals are uploaded")
        self.close(window)

    def test_pick_and_size(self):
        window = self.open("icosphere:4", "--size", "1280x820")
        window.settled()
        x, y = window.middle()
        self.screen.act("mousemove", x, y, "click", 1)
        window.wait(lambda state: state["picked"] is not None, "a pick")
        self.screen.act("mousemove", window.view()[0] + 5, 5, "click", 1)
        window.wait(lambda state: state["picked"] is None, "a click beside the model")

        def height():
            """Of the silhouette."""
            window.settled()
            window.frames(3)
            picture = self.screen.picture()
            left, _, width, tall = window.view()
            column = [max(abs(a - b) for a, b in zip(picture.pixel(left + width // 2, row), picture.pixel(left + 2, row)))
                      for row in range(0, tall, 2)]
            return 2 * sum(difference > 12 for difference in column)

        tall = height()
        self.screen.act("search", "--name", "Proxima", "windowsize", 900, 500)
        window.wait(lambda state: state["window"] == [900, 500] and state["view"][3] == 500, "another size")
        window.frames(3)
        self.assertLess(abs(height() / tall - 500 / 820), 0.1, "the model is as much smaller as the window is")
        self.close(window)


class Files(WindowTest):
    """What the window writes of what it shows."""

    def test_a_picture_and_a_model_are_written(self):
        picture, model = self.folder / "seen.png", self.folder / "seen.glb"
        window = self.open("icosphere:3", "--panel", "octree", "--set", "depth=3")
        window.settled()
        before = window.bounds()
        window.type("save picture as", str(picture))
        window.click("save picture")
        window.wait(lambda state: state["news"] == f"wrote {picture}", "the picture")
        width, height = struct.unpack(">II", picture.read_bytes()[16:24])
        self.assertEqual([width, height], window.state()["view"][2:])
        window.type("export glb as", str(model))
        window.click("export glb")
        window.wait(lambda state: state["news"] == f"wrote {model}", "the model")
        self.assertEqual(model.read_bytes()[:4], b"glTF")
        self.assertEqual({name: bounds for name, bounds in window.bounds().items() if name in before}, before)
        window.type("export glb as", str(self.folder / "nowhere" / "seen.glb"))
        window.click("export glb")
        state = window.wait(lambda state: state["problem"] != "", "the message")
        self.assertIn("nowhere/seen.glb", state["problem"])
        self.assertEqual(state["news"], "")
        window.click("hide this")
        window.wait(lambda state: state["problem"] == "" and "hide this" not in state["controls"], "no message")
        self.close(window)


    def test_a_file_is_finished_though_the_window_is_closed(self):
        model = self.folder / "late.glb"
        window = self.open("icosphere:6", "--panel", "octree", "--set", "depth=7")
        window.settled()
        window.type("export glb as", str(model))
        window.click("export glb")
        window.wait(lambda state: state["news"] != "", "its begin")
        self.close(window)
        self.assertEqual(model.read_bytes()[:4], b"glTF")


class FineScreen(WindowTest):
    dpi = 192

    def test_widgets_are_twice_as_large(self):
        window = self.open("cube", "--size", "600x450")
        state = window.settled()
        self.assertEqual(state["scale"], 2)
        self.assertEqual(state["window"], [1200, 900])
        self.assertGreater(state["controls"]["smooth"]["height"], 30)
        self.close(window)


class Trouble(WindowTest):
    """Cancelling, closing in the middle of work, bad models, no OpenGL."""

    def test_cancel_and_close_while_building(self):
        window = self.open("icosphere:7", "--panel", "closest")
        window.wait(lambda state: state["models"] == 1 and state["stage"] != "", "a build")
        before = window.state()["frames"]
        window.wait(lambda state: state["frames"] > before + 3, "frames in the middle of work")
        window.click("cancel")
        stopped = window.wait(lambda state: state["problem"] != "", "the end of the build")
        self.assertIn("stopped on request", stopped["problem"])
        window.click("rings", 0.8)
        window.wait(lambda state: state["stage"] != "", "another build")
        self.close(window)

    def test_broken_model(self):
        path = self.file("broken.obj", "v 0 0 0\nf 1 2 3\n")
        result = run("view", path, env=self.screen.environment)
        self.assertEqual(result.returncode, 1)
        self.assertIn("broken.obj", result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1)

    def test_a_model_beyond_memory(self):
        self.refuse("view", "icosphere:7", "--budget-mb", 100, says=["icosphere:7", "the budget is 100 MB", "coarser"],
                    env=self.screen.environment)

    def test_no_opengl_3_3(self):
        self.refuse("view", "cube", says=["OpenGL 3.3", "--picture"],
                    env={**self.screen.environment, "MESA_GL_VERSION_OVERRIDE": "2.1"})


class WithoutScreen(ProgramTest):
    """What needs no screen: a window that cannot be, and pictures."""
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}

    def test_no_display(self):
        self.refuse("view", "cube", says=["no display", "--picture"], env=self.environment)
        self.refuse("view", says=["no display", "--picture"], env=self.environment)

    def test_pictures_need_a_model_and_no_display(self):
        self.refuse("view", "--picture", self.folder / "a.png", status=2, says="MODEL", env=self.environment)
        for option, name, kind in (("--picture", "a.jpg", ".png"), ("--out", "a.obj", ".glb")):
            self.refuse("view", "cube", option, self.folder / name, says=[name, kind], env=self.environment)
        self.succeed("view", "cube", "--size", "40x30", "--picture", self.folder / "a.png", env=self.environment)

    def test_a_model_beyond_memory(self):
        self.refuse("view", "icosphere:7", "--budget-mb", 100, "--picture", self.folder / "a.png",
                    says=["icosphere:7", "the budget is 100 MB", "coarser"], env=self.environment)

    def test_a_limit_of_the_process_is_heeded(self):
        if os.environ.get("PROXIMA_SANITIZE"):
            self.skipTest("sanitizers reserve more than any limit")
        limit = 1_200_000_000
        self.refuse("view", "icosphere:8", "--picture", self.folder / "a.png", says=["icosphere:8", "the budget is 900 MB"],
                    env=self.environment, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))

    def test_devices_make_no_pictures(self):
        self.refuse("view", "cube", "--panel", "touch", "--set", "device=udp", "--picture", self.folder / "a.png",
                    says=["udp:4711", "needs the window"], env=self.environment)

    def test_machines_without_xvfb_skip_and_say_so(self):
        result = subprocess.run([sys.executable, "-B", __file__, "Mouse"], env={**self.environment, "PATH": "/nowhere"},
                                text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=100)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("skipped: not installed: Xvfb xdotool xprop", result.stdout)
        self.assertIn("OK (skipped=1)", result.stderr)


if __name__ == "__main__":
    unittest.main()
