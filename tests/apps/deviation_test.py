"""proxima deviation as its users run it, against numbers that are known."""
import csv
import math
import struct
import unittest

from proxima_program import ProgramTest, run

WAY = ["greatest", "complete", "point_a", "point_b", "triangle_a", "triangle_b", "splits", "seconds"]
MEAN = ["mean", "root_mean_square", "mean_complete", "area", "histogram", "mean_splits", "mean_seconds"]

# Two squares over [-1, 1]^2, and a ramp.
FLAT = "OFF\n4 2 0\n-1 -1 {0}\n1 -1 {0}\n1 1 {0}\n-1 1 {0}\n3 0 1 2\n3 0 2 3\n"
RAMP = "OFF\n4 2 0\n-1 -1 0\n1 -1 1\n1 1 1\n-1 1 0\n3 0 1 2\n3 0 2 3\n"


class Measuring(ProgramTest):
    def expect_in(self, value, bounds, width):
        self.assertLessEqual(bounds[0], value)
        self.assertGreaterEqual(bounds[1], value)
        self.assertLess(bounds[1] - bounds[0], width)

    def test_parallel_squares(self):
        low = self.file("low.off", FLAT.format(0))
        high = self.file("high.off", FLAT.format(0.5))
        result = self.json_of("deviation", low, high)
        self.assertEqual(list(result), ["a", "b", "triangles_a", "triangles_b", "rotation_error", "a_to_b", "b_to_a", "hausdorff",
                                        "both_ways", "histogram_end"])
        for way in ("a_to_b", "b_to_a"):
            self.assertEqual(list(result[way]), WAY + MEAN)
            self.assertTrue(result[way]["complete"])
            for key in ("greatest", "mean", "root_mean_square"):
                self.expect_in(0.5, result[way][key], 1e-4)
            self.assertAlmostEqual(result[way]["area"], 4)
            self.assertAlmostEqual(sum(result[way]["histogram"]), 1)
        self.expect_in(0.5, result["hausdorff"], 1e-5)
        self.assertEqual(list(result["both_ways"]), ["mean", "root_mean_square", "larger_mean", "larger_root_mean_square"])
        for bounds in result["both_ways"].values():
            self.expect_in(0.5, bounds, 1e-4)

    def test_two_sided_means_count_areas(self):
        # From the small square the distance is 0; from the large one, of four times the area, it is not.
        small = self.file("small.off", FLAT.format(0))
        large = self.file("large.off", "OFF\n4 2 0\n-2 -2 0\n2 -2 0\n2 2 0\n-2 2 0\n3 0 1 2\n3 0 2 3\n")
        result = self.json_of("deviation", small, large)
        back, both = result["b_to_a"], result["both_ways"]
        for key in ("mean", "root_mean_square"):
            self.assertEqual(both[f"larger_{key}"], back[key])
            share = 0.8 if key == "mean" else math.sqrt(0.8)
            self.expect_in(share * back[key][0], [both[key][0] - 1e-12, both[key][1]], 1e-3)
            self.expect_in(share * back[key][1], [both[key][0], both[key][1] + 1e-12], 1e-3)
        text = self.succeed("deviation", small, large)
        self.assertIn("over both surfaces by area", text)
        self.assertIn("larger of both ways", text)

    def test_places(self):
        # The four corners of the large square are as far from the small one.
        small = self.file("small.off", FLAT.format(0))
        large = self.file("large.off", "OFF\n4 2 0\n-2 -2 0\n2 -2 0\n2 2 0\n-2 2 0\n3 0 1 2\n3 0 2 3\n")
        way = self.json_of("deviation", large, small, "--places", "9", "--one-sided", "--no-mean")["a_to_b"]
        self.assertEqual(list(way), WAY + ["places", "all_places"])
        self.assertTrue(way["all_places"])
        self.assertEqual(sorted(tuple(place["point_a"]) for place in way["places"]), [(-2, -2, 0), (-2, 2, 0), (2, -2, 0), (2, 2, 0)])
        for place in way["places"]:
            self.assertAlmostEqual(place["distance"], math.sqrt(2))
            self.assertAlmostEqual(math.dist(place["point_a"], place["point_b"]), math.sqrt(2))
        few = self.json_of("deviation", large, small, "--places", "3", "--one-sided", "--no-mean")["a_to_b"]
        self.assertEqual((len(few["places"]), few["all_places"]), (3, False))
        near = self.json_of("deviation", large, small, "--places", "9", "--place-spacing", "6", "--one-sided", "--no-mean")["a_to_b"]
        self.assertEqual((len(near["places"]), near["all_places"]), (1, True))
        none = self.json_of("deviation", large, large, "--places", "3", "--one-sided", "--no-mean")["a_to_b"]
        self.assertEqual((none["places"], none["all_places"]), ([], True))
        self.assertIn("there are more", self.succeed("deviation", large, small, "--places", "3", "--no-mean"))

    def test_a_pose_moves_b(self):
        low = self.file("low.off", FLAT.format(0))
        result = self.json_of("deviation", low, low, "--pose", "0,0,0.25", "--one-sided", "--no-mean")
        self.assertEqual(list(result), ["a", "b", "triangles_a", "triangles_b", "rotation_error", "a_to_b"])
        self.assertEqual(list(result["a_to_b"]), WAY)
        self.expect_in(0.25, result["a_to_b"]["greatest"], 1e-5)
        a, b = result["a_to_b"]["point_a"], result["a_to_b"]["point_b"]
        self.assertAlmostEqual(math.dist(a, b), 0.25)
        self.assertEqual(self.json_of("deviation", low, low)["hausdorff"], [0, 0])

    def test_splits_and_budget(self):
        result = self.json_of("deviation", "icosphere:2", "icosphere:3", "--one-sided", "--no-mean", "--max-splits", "10",
                              "--budget-mb", "100")["a_to_b"]
        self.assertLessEqual(result["splits"], 10)
        self.assertFalse(result["complete"])

    def test_files(self):
        ramp, flat = self.file("ramp.off", RAMP), self.file("flat.off", FLAT.format(0))
        ply, table, picture = (self.folder / name for name in ("a.ply", "h.csv", "p.png"))
        text = self.succeed("deviation", ramp, flat, "--out", ply, "--histogram", table, "--bins", "4", "--picture", picture,
                            "--size", "64x48")
        for path in (ply, table, picture):
            self.assertIn(f"wrote {path}", text)
        rows = list(csv.DictReader(table.read_text().splitlines()))
        self.assertEqual(len(rows), 4)
        for row in rows:
            self.assertAlmostEqual(float(row["A to B"]), 0.25, places=3)
        self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))
        header, body = ply.read_bytes().split(b"end_header\n")
        self.assertIn(b"property double quality", header)
        vertices = [struct.unpack_from("<3d3Bd", body, 35 * i) for i in range(4)]
        self.assertEqual([round(v[6], 12) for v in vertices], [0, 1, 1, 0])
        self.assertEqual(vertices[0][3:6], (0x44, 0x01, 0x54))
        self.assertEqual(vertices[1][3:6], (0xFD, 0xE7, 0x25))
        # It is read back as a mesh.
        self.assertEqual(self.json_of("deviation", ply, ramp, "--no-mean")["hausdorff"], [0, 0])
        self.succeed("deviation", "icosphere:1", "cube", "--one-sided", "--no-mean", "--signed", "--out", ply)
        body = ply.read_bytes().split(b"end_header\n")[1]
        inside = [struct.unpack_from("<3d3Bd", body, 35 * i)[6] for i in range(42)]
        self.assertLess(max(inside), 1e-15)
        self.assertLess(min(inside), -0.1)


    def test_a_histogram_of_equal_meshes_has_one_bin(self):
        for options, header, share in (((), "from,to,A to B,B to A", "0,0,1,1"), (("--one-sided",), "from,to,A to B", "0,0,1")):
            table = self.file("h.csv", "of an earlier run")
            text = self.succeed("deviation", "cube", "cube", "--histogram", table, *options)
            self.assertIn(f"wrote {table}", text)
            self.assertEqual(table.read_text(), f"{header}\n{share}\n")
        result = self.json_of("deviation", "cube", "cube", "--histogram", self.folder / "h.svg")
        self.assertEqual((result["histogram_end"], result["a_to_b"]["histogram"]), (0, [1]))
        self.assertNotIn("nan", (self.folder / "h.svg").read_text())


class RefusingDeviation(ProgramTest):
    def test_bad_options(self):
        self.refuse("deviation", "cube", status=2, says="B")
        self.refuse("deviation", "cube", "cube", "--tolerance", "-1", status=2, says="--tolerance")
        self.refuse("deviation", "cube", "cube", "--tolerance", "nan", status=2, says="tolerance")
        for splits in ("-1", "12345678901234567890123"):
            self.refuse("deviation", "cube", "cube", "--max-splits", splits, status=2, says="--max-splits")
        self.refuse("deviation", "cube", "cube", "--signed", status=2, says=("--signed", "--out"))
        self.refuse("deviation", "cube", "cube", "--bins", "0", status=2, says="--bins")
        self.refuse("deviation", "cube", "cube", "--places", "257", status=2, says="--places")
        self.refuse("deviation", "cube", "cube", "--place-spacing", "nan", status=2, says="spacing")
        self.refuse("deviation", "cube", "cube", "--out", self.folder / "a.obj", says=".ply")
        self.refuse("deviation", "cube", "cube", "--histogram", self.folder / "a.txt", says=".csv")
        self.refuse("deviation", "cube", "cube", "--pose", "1,2", says="pose")
        self.refuse("deviation", "cube", "none.obj", says="none.obj")

    def test_a_histogram_without_an_area_is_refused(self):
        points = self.file("points.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
                           "property float z\nend_header\n0 0 0\n3 4 5\n")
        histogram, arguments = self.folder / "a.csv", ("deviation", points, "cube", "--points-and-lines")
        self.refuse(*arguments, "--one-sided", "--histogram", histogram, says=("a.csv", "no area", "leave --histogram out"))
        self.assertIn("wrote", run(*arguments, "--histogram", histogram).stdout)  # the cube has one
        self.assertEqual(histogram.read_text().splitlines()[0], "from,to,B to A")


if __name__ == "__main__":
    unittest.main()
