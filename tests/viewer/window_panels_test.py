"""Every panel of the window of `proxima view`: its main controls, by mouse and keyboard, and what they change in the
picture."""
import unittest

from window_case import WindowTest


def is_red(r, g, b):
    return r > 120 and r > g + 60 and r > b + 60


def is_green(r, g, b):
    return g > 60 and g > r + 25 and g > b + 10


def is_blue(r, g, b):
    return b > 90 and b > r + 40 and b > g + 15


def is_yellow(r, g, b):
    return r > 120 and g > 90 and b < 0.6 * g


def is_no_background(r, g, b):
    """The background is light and nearly gray."""
    return max(r, g, b) < 215 or max(r, g, b) - min(r, g, b) > 25


class Panels(WindowTest):
    def test_octree(self):
        window = self.open("icosphere:3", "--panel", "octree")
        few = int(window.settled()["facts"]["cells"])
        self.slide(window, "depth", 0.6)
        self.assertGreater(int(window.state()["facts"]["cells"]), few)
        red = self.share(window, is_red)
        self.assertGreater(red, 0.05, "the deepest cells are red")
        self.turn_over(window, "boundary")
        self.assertLess(self.share(window, is_red), 0.2 * red)
        self.turn_over(window, "inner")
        window.choose("colour by", "class")
        self.turn_over(window, "mesh")
        self.assertGreater(self.share(window, is_green), 0.01, "inner cells are green")
        self.turn_over(window, "cut plane")
        self.assertGreater(self.share(window, is_green), 0.05, "their slice is filled")
        self.slide(window, "cut at", 0.7)
        window.choose("subdivision", "uniform")
        self.slide(window, "depth", 0.3)
        state = window.settled()
        self.assertEqual(int(state["facts"]["leaves"]), 8 ** int(window.value("depth")))
        self.assertEqual(sum(int(state["facts"][name]) for name in ("boundary", "inner", "outer")),
                         int(state["facts"]["leaves"]))
        window.choose("method", "separating-axis")
        self.turn_over(window, "two pass")
        self.assertEqual(window.settled()["problem"], "")
        self.close(window)

    def test_minkowski(self):
        window = self.open("cube", "--panel", "minkowski")
        window.settled()
        self.assertEqual(window.state()["facts"]["facets"], "26")
        for color, name in ((is_red, "red"), (is_green, "green")):
            self.assertGreater(self.share(window, color), 0.01, name)
        self.turn_over(window, "copies of B")
        self.turn_over(window, "normals")
        self.slide(window, "pushed", 0.2)
        window.choose("B", "ball")
        self.assertNotEqual(window.settled()["facts"]["facets"], "26")
        before = window.value("pushed")
        self.turn_over(window, "play")
        window.wait(lambda state: state["controls"]["pushed"]["value"] != before, "the animation")
        self.turn_over(window, "play")
        self.close(window)

    def test_voronoi_and_closest(self):
        window = self.open("icosphere:2", "--panel", "voronoi")
        self.assertEqual(window.settled()["facts"]["region"], "drawn")
        window.choose("feature", "face")
        self.assertGreater(self.share(window, is_yellow), 0.01, "regions of faces are yellow")
        self.assertGreater(self.share(window, is_green), 0.0005, "the leaf is green")
        self.screen.act("mousemove", *window.middle(), "click", 1)
        window.wait(lambda state: state["picked"] is not None, "a pick")
        self.assertIn(window.settled()["facts"]["feature"].split()[0], ("vertex", "edge", "face"))

        window.choose("panel", "closest")
        state = window.settled()
        distance = float(state["facts"]["distance"])
        self.assertGreater(self.share(window, is_blue), 0.003, "the patch is blue")
        handle = state["handles"][0]
        start = round(handle["x"]), round(handle["y"])
        window.drag(start, (start[0] + 60, start[1] - 40))
        window.wait(lambda now: now["settled"] and now["handles"][0]["at"] != handle["at"], "the cursor's move")
        self.assertGreater(float(window.settled()["facts"]["distance"]), distance)
        self.slide(window, "rings", 0.6)
        self.close(window)

    def test_rays_and_culling(self):
        window = self.open("icosphere:4", "--panel", "rays")
        self.assertEqual(window.settled()["facts"]["triangles hit"], "2")
        self.assertGreater(self.share(window, is_yellow), 0.0008, "lit cells are yellow")
        window.choose("weight", "chord")
        self.turn_over(window, "occupied only")
        self.assertGreater(int(window.settled()["facts"]["cells along the ray"]), int(window.state()["facts"]["shown"]))
        window.choose("panel", "culling")
        state = window.settled()
        visible = int(state["facts"]["visible"].split()[0])
        self.assertTrue(0 < visible < int(state["facts"]["triangles"]))
        self.assertGreater(self.share(window, is_red), 0.002, "the volume is red")
        self.assertGreater(self.share(window, is_green), 0.002, "visible leaves are green")
        window.choose("mode", "exact")
        self.assertLessEqual(int(window.settled()["facts"]["visible"].split()[0]), visible)
        self.slide(window, "field of view", 0.4)
        self.assertGreater(int(window.settled()["facts"]["visible"].split()[0]), visible)
        self.close(window)

    def test_intersection(self):
        window = self.open("icosphere:3", "torus:32x16", "--panel", "intersection")
        self.assertEqual(window.settled()["facts"]["meet"], "yes")
        self.assertGreater(self.share(window, is_yellow), 0.002, "their triangles are yellow")
        self.assertGreater(self.share(window, is_red), 0.001, "leaves of the first are red")
        self.slide(window, "position x", 0.95)
        self.assertEqual(window.settled()["facts"]["meet"], "no")
        self.assertLess(self.share(window, is_yellow), 0.0005)
        self.close(window)

    def test_touch(self):
        window = self.open("icosphere:3")
        window.settled()
        window.choose("panel", "touch")  # the last word of the longest menu
        window.wait(lambda state: "servo rate" in state["facts"], "the servo loop's rate")
        window.wait(lambda now: float(now["facts"]["force"].split()[0]) > 0.1, "a force")
        self.assertGreater(float(window.state()["facts"]["servo rate"].split()[0]), 0)
        self.assertGreater(self.share(window, is_red), 0.0002, "the force is red")
        self.assertGreater(self.share(window, is_yellow), 0.0001, "the proxy is yellow")
        handle = window.state()["handles"][0]
        x, y, width, height = window.view()
        window.drag((round(handle["x"]), round(handle["y"])), (x + width - 30, 30))
        window.wait(lambda now: now["facts"]["contact"] == "free", "the hand's way out")
        # Where the drag began, and at once: a click, not the second half of a double click.
        self.screen.act("mousemove", *window.middle(), "click", 1)
        window.wait(lambda now: now["facts"]["contact"] != "free", "contact at the point that was clicked")
        self.slide(window, "stiffness", 0.2)
        window.wait(lambda now: "servo rate" in now["facts"], "another servo loop")
        # A device that is not there: the panel says so, and the mouse has it again.
        window.choose("device", "hd")
        window.wait(lambda now: "libHD.so" in now["problem"], "what became of it")
        window.type("library", "/nowhere/libHD.so")
        window.wait(lambda now: "/nowhere/libHD.so" in now["problem"], "the device's message")
        window.choose("device", "mouse")
        window.wait(lambda now: now["problem"] == "" and "servo rate" in now["facts"], "the mouse's servo loop")
        self.close(window)


    def test_every_panel_shows_something_of_its_own(self):
        window = self.open("icosphere:4", "torus:48x24")
        window.settled()
        before = None
        for panel in ("octree", "minkowski", "voronoi", "closest", "rays", "culling", "intersection", "touch", "model"):
            window.choose("panel", panel)
            state = window.settled()
            self.assertEqual((state["panel"], state["problem"]), (panel, ""))
            self.assertGreater(self.share(window, is_no_background), 0.02, f"{panel}: the picture is empty")
            x, y, width, height = window.view()
            picture = self.screen.picture()
            shown = [picture.pixel(column, row) for row in range(y, y + height, 9) for column in range(x, x + width, 9)]
            self.assertNotEqual(shown, before, f"{panel}: the picture is that of the panel before")
            before = shown
            legend = [name for name in window.state()["controls"] if name.startswith("legend ")]
            self.assertEqual(bool(legend), panel != "model", f"{panel}: {legend}")
        self.close(window)

    def test_controls_without_effect_are_disabled(self):
        window = self.open("icosphere:2", "--panel", "octree")
        window.settled()
        self.assertEqual(window.state()["controls"]["cut at"]["needs"], "cut plane=on")
        at = window.value("cut at")
        window.click("cut at", 0.8)
        window.frames(4)
        self.assertEqual(window.value("cut at"), at)
        self.turn_over(window, "cut plane")
        self.assertEqual(window.state()["controls"]["cut at"]["needs"], "")
        self.slide(window, "cut at", 0.8)
        self.close(window)


if __name__ == "__main__":
    unittest.main()
