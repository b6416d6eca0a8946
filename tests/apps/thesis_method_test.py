"""--method thesis: answers by the structures of the thesis, held against those of the index."""
import csv
import io
import math
import random
import unittest

from proxima_program import ProgramTest


def points_text(rng, count, least, most):
    """Points in a shell about the origin."""
    points = []
    while len(points) < count:
        point = [rng.uniform(-most, most) for _ in range(3)]
        if least <= math.dist(point, (0, 0, 0)) <= most:
            points.append(point)
    return "x,y,z\n" + "".join(",".join(map(repr, point)) + "\n" for point in points)


def table(path):
    return list(csv.DictReader(io.StringIO(path.read_text())))


class Closest(ProgramTest):
    def answers(self, *options):
        out = self.folder / "out.csv"
        self.succeed("closest", "sphere:20x20", "--points", self.points, "--out", out, *options)
        return table(out)

    def setUp(self):
        super().setUp()
        self.points = self.file("points.csv", points_text(random.Random(1), 400, 1.01, 1.5))

    def test_distances_are_those_of_the_index(self):
        thesis, index = self.answers("--method", "thesis"), self.answers()
        self.assertEqual([row["index"] for row in thesis], [row["index"] for row in index])
        for ours, other in zip(thesis, index):
            self.assertAlmostEqual(float(ours["distance"]), float(other["distance"]), delta=1e-13)

    def test_a_saved_octree_gives_the_same_rows(self):
        saved = self.folder / "octree.pxv"
        built = self.answers("--method", "thesis", "--depth", "4", "--save", saved)
        self.assertEqual(self.answers("--method", "thesis", "--octree", saved), built)

    def test_points_inside_and_far_away_have_no_row(self):
        points = self.file("some.csv", "0,0,0\n0,0,1.25\n100,0,0\n")
        out = self.folder / "some_out.csv"
        result = self.json_of("closest", "sphere:20x20", "--points", points, "--method", "thesis", "--out", out)
        self.assertEqual((result["queries"], result["answered"], result["method"]), (3, 1, "thesis"))
        self.assertEqual([row["index"] for row in table(out)], ["1"])

    def test_what_it_cannot_do_is_refused(self):
        self.refuse("closest", "torus:20x10", "--points", self.points, "--method", "thesis", says="not convex")
        for option in (["--signed"], ["--lists-mb", "5"]):
            self.refuse("closest", "cube", "--points", self.points, "--method", "thesis", *option, status=2,
                        says=[option[0], "--method index"])
        self.refuse("closest", "cube", "--points", self.points, "--depth", "3", status=2, says="--method thesis")
        saved = self.folder / "octree.pxv"
        self.answers("--method", "thesis", "--save", saved)
        self.refuse("closest", "cube", "--points", self.points, "--method", "thesis", "--octree", saved,
                    says="another model")
        # As many vertices, edges and triangles, and even the same root, are not enough.
        changed = self.folder / "changed.off"
        self.succeed("repair", "sphere:20x20", "--out", changed)
        lines = changed.read_text().splitlines()
        vertices = int(lines[1].split()[0])
        for i in range(2, 2 + vertices):
            x, y, z = map(float, lines[i].split())
            lines[i] = f"{0.5 * x!r} {y!r} {z!r}"
        changed.write_text("\n".join(lines) + "\n")
        self.refuse("closest", changed, "--points", self.points, "--method", "thesis", "--octree", saved,
                    says="another model")
        broken = self.file("broken.pxv", saved.read_bytes()[:-1])
        self.refuse("closest", "sphere:20x20", "--points", self.points, "--method", "thesis", "--octree", broken,
                    says="broken.pxv")

    def test_an_octree_is_not_asked_about_vertices_without_triangles(self):
        def octahedron(name, stray):
            """A vertex that no triangle uses comes first or last."""
            corners = ["1 0 0", "-1 0 0", "0 1 0", "0 -1 0", "0 0 1", "0 0 -1"]
            corners.insert(stray, "0 0 0")
            at = [corners.index(" ".join(map(str, [sign * (axis == k) for k in range(3)])))
                  for axis in range(3) for sign in (1, -1)]
            faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
            return self.file(name, "OFF\n7 8 0\n" + "".join(f"{corner}\n" for corner in corners) + "".join(
                "3 " + " ".join(str(at[i]) for i in face) + "\n" for face in faces))

        saved = self.folder / "octahedron.pxv"
        asked = ("--point", "0,0,-1.2", "--method", "thesis")
        first, last = octahedron("first.off", 0), octahedron("last.off", 6)
        self.succeed("closest", first, *asked, "--save", saved)
        self.succeed("closest", first, *asked, "--octree", saved)
        self.refuse("closest", last, *asked, "--octree", saved, says="another model")


class OtherQueries(ProgramTest):
    def test_rays_hit_the_same(self):
        rng = random.Random(2)
        rays = self.file("rays.csv", "".join(
            ",".join(repr(rng.uniform(-3, 3) if i < 3 else rng.uniform(-1, 1)) for i in range(6)) + "\n"
            for _ in range(500)))
        out = [self.folder / name for name in ("thesis.csv", "index.csv")]
        thesis = self.json_of("raycast", "torus:40x20", "--rays", rays, "--out", out[0], "--method", "thesis")
        index = self.json_of("raycast", "torus:40x20", "--rays", rays, "--out", out[1])
        self.assertEqual((thesis["method"], index["method"]), ("thesis", "index"))
        self.assertGreater(thesis["hits"], 10)
        self.assertEqual(out[0].read_text(), out[1].read_text())

    def test_visible_cells_list_what_is_visible(self):
        planes = self.file("planes.csv", "1,0,0,-0.25\n0,1,0,0.125\n0,0,-1,0.5\n")
        out = [self.folder / name for name in ("thesis.csv", "index.csv")]
        thesis = self.json_of("cull", "torus:40x20", "--frustum", planes, "--out", out[0], "--method", "thesis")
        index = self.json_of("cull", "torus:40x20", "--frustum", planes, "--out", out[1], "--exact")
        listed, visible = (set(path.read_text().split()) for path in out)
        self.assertLess(visible, listed)
        for key in ("visible_cells", "cells"):
            self.assertEqual(thesis[key], index[key], key)
        self.assertEqual(thesis["method"], "thesis")
        self.refuse("cull", "cube", "--frustum", planes, "--method", "thesis", "--exact", status=2, says="--exact")

    def test_meshes_meet_in_the_same_pairs(self):
        pose = self.file("pose.csv", "1,0,0,0.5,0,1,0,0.25,0,0,1,0.125\n0,-1,0,0.75,1,0,0,0,0,0,1,0\n")
        out = [self.folder / name for name in ("thesis.csv", "index.csv")]
        both = [self.json_of("intersect", "torus:40x20", "sphere:20x20", "--pose", pose, "--pairs", path, *method)
                for path, method in zip(out, (["--method", "thesis"], []))]
        self.assertEqual(out[0].read_text(), out[1].read_text())
        self.assertEqual([pose["pairs"] for pose in both[0]["poses"]], [pose["pairs"] for pose in both[1]["poses"]])
        for pose in both[0]["poses"]:
            self.assertGreaterEqual(pose["triangle_tests"], pose["pairs"])
        self.refuse("intersect", "cube", "cube", "--method", "thesis", "--distance", status=2, says="--distance")

    def test_touch_sends_patches_of_the_thesis(self):
        result = self.json_of("touch", "sphere:30x30", "--device", "hand:slide", "--seconds", "0.5",
                              "--free-running", "--method", "thesis", "--patch", "1,4")
        self.assertEqual([row["patch"] for row in result["patches"]], ["thesis 1", "thesis 4"])
        few, many = result["patches"]
        self.assertLess(few["mean_triangles"], many["mean_triangles"])
        self.assertLessEqual(many["missed_ticks"], few["missed_ticks"])
        self.refuse("touch", "torus:20x10", "--device", "hand:slide", "--method", "thesis", says="not convex")

    def test_rare_patches_are_felt_or_missed_in_words(self):
        slide = ("touch", "icosphere:3", "--device", "hand:slide", "--free-running", "--method", "thesis")
        (row,) = self.json_of(*slide, "--seconds", 3, "--collision-rate", 3)["patches"]
        self.assertGreater(row["mean_triangles"], 10)
        self.assertLess(row["waited_ticks"], 700)
        # The session is over before the second patch is due.
        short = (*slide, "--seconds", 0.2, "--collision-rate", 1)
        result = self.json_of(*short)
        self.assertEqual((result["touching_ticks"], result["patches"][0]["waited_ticks"]), (0, 200))
        self.assertIn("nothing could be felt", self.succeed(*short))

    def test_refusals_name_the_option_that_was_given(self):
        press = ("touch", "cube", "--device", "hand:press", "--method", "thesis")
        for option in (("--object", "cube"), ("--force", "penalty"), ("--record", self.folder / "r.pxt")):
            self.assertNotIn("--patch", self.refuse(*press, *option, status=2, says="--method"))


class AsPrinted(ProgramTest):
    def test_the_printed_method_lists_more_than_touches(self):
        printed = self.json_of("octree", "sphere:100x100", "--depth", "1", "--method", "minkowski", "--as-printed")
        right = self.json_of("octree", "sphere:100x100", "--depth", "1", "--method", "minkowski", "--exact")
        self.assertEqual(right["references"], 22392)
        self.assertGreater(printed["references"], 22392)
        self.refuse("octree", "cube", "--as-printed", status=2, says="--method minkowski")

    def test_edges_of_figure_5_3(self):
        edges = [self.json_of("proximity", "sphere:50x50", "--method", "thesis", "--depth", "2", *flat)["ridge_edges"]
                 for flat in ([], ["--flat", "1e-5"])]
        self.assertEqual(edges, [4950, 4850])


if __name__ == "__main__":
    unittest.main()
