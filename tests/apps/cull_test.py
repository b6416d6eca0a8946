"""proxima cull as its users run it, against triangles that are cut here in fractions."""
import csv
import io
import random
import unittest
from fractions import Fraction

from bad_input_test import off
from npy_tables import read_npy
from proxima_program import ProgramTest, run
from raycast_test import npy, read_png, some_mesh

KEYS = ["model", "triangles", "planes", "empty", "exact", "visible", "ranges", "visible_cells", "cells",
        "seconds", "id_seconds", "build_seconds", "bytes", "method"]


def planes_text(planes, header=False):
    return ("a,b,c,d\n" if header else "") + "".join(",".join(map(repr, plane)) + "\n" for plane in planes)


def value(plane, point):
    return sum(a * x for a, x in zip(plane, list(point) + [1]))


def is_left(planes, triangle):
    """Whether anything is left of the triangle once all planes have cut it."""
    polygon = triangle
    for plane in planes:
        cut = []
        for one, other in zip(polygon, polygon[1:] + polygon[:1]):
            a, b = value(plane, one), value(plane, other)
            if a >= 0:
                cut.append(one)
            if a * b < 0:
                cut.append([x + (y - x) * a / (a - b) for x, y in zip(one, other)])
        polygon = cut
        if not polygon:
            return False
    return True


def visible(points, triangles, planes, exact):
    planes = [[Fraction(x) for x in plane] for plane in planes]
    ids = []
    for id, corners in enumerate(triangles):
        triangle = [[Fraction(x) for x in points[v]] for v in corners]
        if exact:
            seen = is_left(planes, triangle)
        else:
            seen = all(any(value(plane, p) >= 0 for p in triangle) for plane in planes)
        if seen:
            ids.append(id)
    return ids


def some_planes(rng, count):
    """Around the middle, mostly."""
    planes = []
    while len(planes) < count:
        normal = [rng.randint(-8, 8) / 8 for _ in range(3)]
        if any(normal):
            planes.append(tuple(normal) + (rng.randint(-1, 12) / 8,))
    return planes


class Culling(ProgramTest):
    def ids(self, path):
        lines = path.read_text().splitlines()
        self.assertEqual(lines[0], "triangle")
        return [int(line) for line in lines[1:]]

    def test_sees_what_fractions_say(self):
        rng = random.Random(11)
        points, triangles = some_mesh(rng, 120)
        model = self.file("m.off", off(points, triangles))
        counts, fewer = [], 0
        for trial in range(6):
            planes = some_planes(rng, 2 + trial)
            path = self.file("f.csv", planes_text(planes, header=trial % 2 == 0))
            seen = {}
            for exact in (False, True):
                out = self.folder / "ids.csv"
                json = self.json_of("cull", model, "--frustum", path, "--out", out, *["--exact"] * exact)
                seen[exact] = self.ids(out)
                self.assertEqual(seen[exact], visible(points, triangles, planes, exact))
                self.assertEqual(list(json), KEYS)
                self.assertEqual((json["triangles"], json["planes"], json["exact"], json["visible"]),
                                 (120, len(planes), exact, len(seen[exact])))
                self.assertTrue(0 < json["ranges"] <= json["visible"])
                self.assertTrue(0 < json["visible_cells"] <= json["cells"])
                self.assertGreater(json["bytes"], 120 * 40)
            counts.append(len(seen[True]))
            fewer += len(seen[False]) - len(seen[True])
        self.assertGreater(len(set(counts)), 2)
        self.assertGreater(fewer, 0)

    def test_reads_npy_and_writes_meshes(self):
        planes = [(1.0, 0.0, 0.0, 0.25), (0.0, -1.0, 0.5, 0.25)]
        texts = [self.file("f.csv", planes_text(planes)), self.file("f.npy", npy(planes))]
        ids = set()
        for i, path in enumerate(texts):
            out = self.folder / ("ids%d.npy" % i)
            self.succeed("cull", "torus:30x20", "--frustum", path, "--out", out)
            ids.add(tuple(read_npy(out.read_bytes())))
        self.assertEqual(len(ids), 1)
        part = self.folder / "part.off.ply"
        json = self.json_of("cull", "torus:30x20", "--frustum", texts[0], "--out", part)
        self.assertEqual(json["visible"], len(ids.pop()))
        self.assertTrue(0 < json["visible"] < 1200)
        self.assertEqual(self.json_of("check", part)["triangles"], json["visible"])

    def test_sees_everything_and_nothing(self):
        around = self.file("around.csv", planes_text([(0.0, 0.0, 1.0, 9.0), (0.0, 0.0, -1.0, 9.0)]))
        away = self.file("away.csv", planes_text([(0.0, 0.0, 1.0, -9.0)]))
        against = self.file("against.csv", planes_text([(0.0, 0.0, 1.0, 0.0), (0.0, 0.0, -1.0, -0.125)]))
        got = {name: self.json_of("cull", "cube", "--frustum", self.folder / (name + ".csv"))
               for name in ("around", "away", "against")}
        self.assertEqual([got[name]["visible"] for name in got], [12, 0, 0])
        self.assertEqual([got[name]["ranges"] for name in got], [1, 0, 0])
        self.assertEqual([got[name]["visible_cells"] for name in got], [got["around"]["cells"], 0, 0])
        self.assertEqual([got[name]["empty"] for name in got], [False, False, True])
        out = ("--out", self.folder / "out.csv")
        self.assertIn("contradict", self.succeed("cull", "cube", "--frustum", against, *out))
        self.assertNotIn("contradict", self.succeed("cull", "cube", "--frustum", away, *out))
        self.assertIn("12 triangles visible (100 %)", self.succeed("cull", "cube", "--frustum", around, *out))
        self.assertEqual(self.succeed("cull", "cube", "--frustum", away), "triangle\n")
        noted = run("cull", "cube", "--frustum", against)
        self.assertEqual((noted.returncode, noted.stdout, noted.stderr.count("\n")), (0, "triangle\n", 1))
        self.assertIn("contradict", noted.stderr)
        self.assertEqual(self.succeed("cull", "cube", "--frustum", against, "--quiet"), "triangle\n")

    def test_does_not_depend_on_threads_or_depth(self):
        path = self.file("f.csv", planes_text([(1.0, 2.0, 3.0, 0.5), (-1.0, 0.5, 0.0, 0.1)]))
        texts = set()
        for arguments in (("--threads", 1), ("--threads", 3), ("--depth", 2), ("--threshold", 50)):
            out = self.folder / "ids.csv"
            self.succeed("cull", "torus:60x40", "--frustum", path, "--out", out, *arguments)
            texts.add(out.read_text())
        self.assertEqual(len(texts), 1)


class Pictures(ProgramTest):
    def test_set_off_what_is_visible(self):
        share = []
        for offset in (-9.0, 0.0, 9.0):
            path = self.file("f.csv", planes_text([(1.0, 0.0, 0.0, offset)]))
            out = self.folder / "p.png"
            self.succeed("cull", "icosphere:3", "--frustum", path, "--picture", out, "--depth", 3)
            width, height, rows = read_png(out.read_bytes())
            self.assertEqual((width, height), (1280, 960))
            # The legend stands to the right.
            pixels = [rows[y][3 * x:3 * x + 3] for y in range(0, height, 8) for x in range(0, width * 3 // 4, 8)]
            share.append(sum(p[0] > p[2] + 60 for p in pixels) / len(pixels))
        self.assertEqual(share[0], 0)
        self.assertGreater(share[1], 0.02)
        self.assertGreater(share[2], 1.1 * share[1])


class Cameras(ProgramTest):
    def test_a_model_that_no_camera_can_see_is_refused(self):
        for size in (1e-300, 1e-155, 1e151, 1e308):
            model = self.file("model.off", f"OFF\n3 1 0\n0 0 0\n{size} 0 0\n0 0 {size}\n3 0 1 2\n")
            for command in ("cull", "raycast"):
                self.refuse(command, model, "--view", "20,30", says=("model.off", "camera", "scale"))
        for size in (1e-149, 1e149):
            model = self.file("model.off", f"OFF\n3 1 0\n0 0 0\n{size} 0 0\n0 0 {size}\n3 0 1 2\n")
            self.assertGreater(self.json_of("raycast", model, "--view", "20,30", "--size", "40x40")["hits"], 100)

    def test_cull_what_their_rays_hit(self):
        """All that a camera's rays hit is visible, and little more where nothing hides it."""
        model = "icosphere:3"
        for camera in (("--view", "front"), ("--eye", "1.5,0.2,0.1", "--fov", "20"), ("--eye", "0,0,0", "--target", "1,2,3"),
                       ("--eye", "2,2,2", "--target", "0,1,0", "--fov", "15", "--size", "300x100")):
            with self.subTest(camera):
                size = () if "--size" in camera else ("--size", "200x150")
                hits = {int(row["triangle"]) for row in csv.DictReader(io.StringIO(
                    self.succeed("raycast", model, *size, *camera, "--out", "-"))) if row["triangle"] != "-1"}
                out = self.folder / "v.csv"
                self.succeed("cull", model, *size, *camera, "--exact", "--out", out)
                seen = {int(line) for line in out.read_text().split() if line.isdigit()}
                self.assertTrue(hits)
                self.assertLessEqual(hits, seen)
                if camera[0] == "--eye" and camera[1] == "0,0,0":  # from within a convex mesh nothing is hidden
                    self.assertLess(len(seen), 1.2 * len(hits) + 10)

    def test_go_without_planes(self):
        path = self.file("f.csv", "1,0,0,0\n")
        ids = self.folder / "ids.csv"
        self.succeed("cull", "torus:20x10", "--frustum", path, "--out", ids)
        for options in (("--out", "-"), (), ("--quiet",)):
            self.assertEqual(self.succeed("cull", "torus:20x10", "--frustum", path, *options), ids.read_text())
        report = self.succeed("cull", "torus:20x10", "--frustum", path, "--picture", self.folder / "p.png")
        self.assertIn(" triangles visible", report)
        self.refuse("cull", "cube", "--frustum", path, "--out", "-", "--json", "-", says="stdout")
        self.refuse("cull", "cube", status=2, says=("--plane", "--frustum", "--view"))
        for planes in (("--frustum", path), ("--plane", "1,0,0,0")):
            self.refuse("cull", "cube", *planes, "--view", "top", status=2, says=("--plane", "--frustum", "--view"))
            for option in (("--size", "30x30"), ("--up", "x")):
                self.refuse("cull", "cube", *planes, *option, status=2, says=(option[0], "--picture"))

    def test_a_size_alone_is_a_camera(self):
        self.assertEqual(self.succeed("cull", "torus:20x10", "--size", "40x30"),
                         self.succeed("cull", "torus:20x10", "--size", "40x30", "--view", "0,20"))


class Planes(ProgramTest):
    def test_on_the_command_line_are_those_of_a_file(self):
        rng = random.Random(13)
        for count in (1, 2, 5):
            planes = some_planes(rng, count)
            path = self.file("f.csv", planes_text(planes))
            options = [part for plane in planes for part in ("--plane", ",".join(map(repr, plane)))]
            for exact in ((), ("--exact",)):
                expected = self.succeed("cull", "torus:30x20", "--frustum", path, *exact)
                self.assertEqual(self.succeed("cull", "torus:30x20", *options, *exact), expected)
            self.assertEqual(self.json_of("cull", "torus:30x20", *options)["planes"], count)
        self.assertTrue(1 < expected.count("\n") < 1200)

    def test_that_are_none(self):
        for plane, says in (("1,2,3", "3 numbers"), ("1,2,3,nan", "finite"), ("a,b,c,d", "no number"), ("0,0,0,1", "plane 1")):
            self.refuse("cull", "cube", "--plane", "1,0,0,0", "--plane", plane, says=("--plane", says))
        path = self.file("f.csv", "1,0,0,0\n")
        self.refuse("cull", "cube", "--plane", "1,0,0,0", "--frustum", path, status=2, says=("--plane", "--frustum"))


class Refusing(ProgramTest):
    def test_bad_volumes(self):
        for text, says in (("0,0,0,1\n", "plane 0"), ("1,0,0,1\n0,0,0,0\n", "plane 1"), ("1,2,3\n", "f.csv"),
                           ("nan,0,0,1\n", "f.csv"), ("", "f.csv"), ("a,b,c,d\n", "f.csv"),
                           ("1,0,0,1\n" * 1025, "1024")):
            self.refuse("cull", "cube", "--frustum", self.file("f.csv", text), says=["f.csv", says])
        self.refuse("cull", "cube", "--frustum", self.folder / "absent.csv", says="absent.csv")

    def test_wrong_options(self):
        path = self.file("f.csv", "1,0,0,0\n")
        self.refuse("cull", "cube", "--frustum", path, "--depth", 99, status=2)
        self.refuse("cull", "cube", "--frustum", path, "--out", self.folder / "x.txt", says="x.txt")
        self.refuse("cull", "cube", "--frustum", path, "--picture", self.folder / "x.jpg", says=".png")
        same = self.folder / "same.png"
        self.refuse("cull", "cube", "--frustum", path, "--picture", same, "--json", same, says="same.png")
        self.refuse("cull", self.folder / "absent.ply", "--frustum", path, says="absent.ply")


if __name__ == "__main__":
    unittest.main()
