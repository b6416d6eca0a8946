"""proxima intersect as its users run it; pairs against separating axes in whole numbers."""
import csv
import io
import json
import math
import random
import struct
import unittest

from bad_input_test import off, tetrahedron
from mesh_oracle import cross, dot, sub
from npy_tables import npy, read_npy
from proxima_program import ProgramTest, run
from raycast_test import some_mesh

IDENTITY = (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
POSE_KEYS = ["intersecting", "pairs", "contained", "seconds"]


def shifted(x, y, z):
    return (1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z)


def text_of(poses):
    return "".join(",".join(map(repr, pose)) + "\n" for pose in poses)


def quarter_turn(x, y, z):
    """About z, then moved: exact in doubles."""
    return (0, -1, 0, x, 1, 0, 0, y, 0, 0, 1, z)


def turned(axis, angle):
    """About an axis, and moved a little."""
    size = math.sqrt(sum(x * x for x in axis))
    x, y, z = (n / size for n in axis)
    c, s, d = math.cos(angle), math.sin(angle), 1 - math.cos(angle)
    return (c + d * x * x, d * x * y - s * z, d * x * z + s * y, 0.25, d * x * y + s * z, c + d * y * y, d * y * z - s * x, 0.5,
            d * x * z - s * y, d * y * z + s * x, c + d * z * z, -0.25)


def moved(point, pose):
    """In units of 1/64, whole for the coordinates and poses of these tests."""
    result = [64 * (sum(pose[4 * row + k] * point[k] for k in range(3)) + pose[4 * row + 3]) for row in range(3)]
    assert all(x == int(x) for x in result)
    return [int(x) for x in result]


def meet(a, b):
    """Two triangles with areas: no axis separates them."""
    sides = [[sub(t[(i + 1) % 3], t[i]) for i in range(3)] for t in (a, b)]
    normals = [cross(s[0], s[1]) for s in sides]
    axes = normals + [cross(p, q) for p in sides[0] for q in sides[1]]
    axes += [cross(n, p) for n, s in zip(normals, sides) for p in s]
    for axis in axes:
        low, high = ([dot(axis, p) for p in t] for t in (a, b))
        if max(low) < min(high) or max(high) < min(low):
            return False
    return True


class Meeting(ProgramTest):
    def test_pairs_are_those_of_whole_numbers_in_csv_and_npy(self):
        rng = random.Random(7)
        meshes = [some_mesh(rng, 25) for _ in range(2)]
        a, b = (self.file(name, off(*mesh)) for name, mesh in zip(("a.off", "b.off"), meshes))
        poses = [IDENTITY, shifted(0.5, -0.25, 1), quarter_turn(-1, 0.5, 0), shifted(40, 0, 0)]
        path = self.file("poses.csv", "r00,r01,r02,tx,r10,r11,r12,ty,r20,r21,r22,tz\n" + text_of(poses))
        out = self.folder / "pairs.csv"
        result = self.json_of("intersect", a, b, "--pose", path, "--pairs", out)
        triangles = [[[points[v] for v in t] for t in faces] for points, faces in meshes]
        truth = []
        for number, pose in enumerate(poses):
            there = [[moved(p, pose) for p in t] for t in triangles[1]]
            here = [[moved(p, IDENTITY) for p in t] for t in triangles[0]]
            truth += [(number, i, k) for i, t in enumerate(here) for k, s in enumerate(there) if meet(t, s)]
        rows = list(csv.reader(io.StringIO(out.read_text())))
        self.assertEqual(rows[0], ["pose", "a", "b"])
        self.assertEqual([tuple(map(int, row)) for row in rows[1:]], truth)
        self.assertGreater(len(truth), 20)
        self.assertEqual(list(result), ["a", "b", "triangles_a", "triangles_b", "build_seconds", "method", "rotation_error", "poses"])
        for number, pose in enumerate(result["poses"]):
            self.assertEqual(list(pose)[:4], POSE_KEYS)
            self.assertEqual(pose["pairs"], sum(row[0] == number for row in truth))
            self.assertEqual(pose["intersecting"], pose["pairs"] > 0)
        out = self.folder / "pairs.npy"
        self.succeed("intersect", a, b, "--pose", path, "--pairs", out)
        self.assertEqual([tuple(row) for row in read_npy(out.read_bytes())], truth)

    def test_says_what_is_inside(self):
        small = self.file("small.off", "OFF\n4 4 0\n0 0 0\n.1 0 0\n0 .1 0\n0 0 .1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n")
        poses = self.file("poses.csv", text_of([IDENTITY, shifted(1.05, 0, 0), shifted(5, 0, 0)]))
        answers = self.json_of("intersect", small, "cube", "--pose", poses)["poses"]
        self.assertEqual([pose["contained"] for pose in answers], ["A_in_B", "none", "none"])
        self.assertEqual([pose["intersecting"] for pose in answers], [False, True, False])
        poses = self.file("poses.csv", text_of([IDENTITY, shifted(0.95, 0, 0), shifted(5, 0, 0)]))
        answers = self.json_of("intersect", "cube", small, "--pose", poses)["poses"]
        self.assertEqual([pose["contained"] for pose in answers], ["B_in_A", "none", "none"])
        self.assertEqual(answers[0]["inside_method"], "crossings")
        self.assertIn("A is inside of B", self.succeed("intersect", small, "cube", "--out", self.folder / "rows.csv"))

    def test_contour_of_two_spheres_is_a_circle(self):
        poses = self.file("poses.csv", text_of([shifted(1, 0, 0), shifted(0, 1, 0), shifted(3, 0, 0)]))
        out = self.folder / "contour.obj"
        answers = self.json_of("intersect", "sphere:30x30", "sphere:30x30", "--pose", poses, "--contour", out)["poses"]
        self.assertEqual([pose["contour"]["lines"] for pose in answers], [1, 1, 0])
        for pose in answers[:2]:
            self.assertEqual(pose["contour"]["closed"], 1)
            self.assertAlmostEqual(pose["contour"]["length"], 2 * math.pi * math.sqrt(0.75), delta=0.1)
        points, lines, objects = [], [], []
        for line in out.read_text().splitlines():
            kind, *rest = line.split()
            {"v": points, "l": lines, "o": objects}[kind].append(rest)
        self.assertEqual(objects, [["pose_0"], ["pose_1"], ["pose_2"]])
        self.assertEqual(len(lines), 2)
        for axis, line in zip((0, 1), lines):
            self.assertEqual(line[0], line[-1], "closed")
            for number in line:
                at = [float(x) for x in points[int(number) - 1]]
                self.assertAlmostEqual(at[axis], 0.5, delta=0.02)
                self.assertAlmostEqual(sum(x * x for x in at), 1, delta=0.02)

    def test_says_how_far_apart(self):
        # A corner of the second cube is nearest to an edge, a corner and a face of the first one.
        turned = [[1, 0, 0], [0, math.cos(math.pi / 4), -math.sin(math.pi / 4)], [0, math.sin(math.pi / 4), math.cos(math.pi / 4)]]
        shifts = [(3, 0, 0), (3, 4, 5), (0, 0, 4), (1, 1, 1)]
        poses = [shifted(*shifts[0]), shifted(*shifts[1]), shifted(0, 0, 0), shifted(*shifts[3])]
        poses[2] = [x for row, z in zip(turned, shifts[2]) for x in (*row, z)]
        path = self.file("poses.csv", text_of(poses))
        plain, corner, edge, meeting = self.json_of("intersect", "cube", "cube", "--pose", path, "--distance")["poses"]
        self.assertEqual([plain["separation"], plain["closest_b"][0] - plain["closest_a"][0]], [1, 1])
        self.assertEqual(corner["separation"], math.sqrt(1 + 4 + 9))
        self.assertEqual([corner["closest_a"], corner["closest_b"]], [[1, 1, 1], [2, 3, 4]])
        self.assertEqual([corner["feature_a"], corner["feature_b"]], ["vertex", "vertex"])
        self.assertAlmostEqual(edge["separation"], 3 - math.sqrt(2), delta=1e-15)
        self.assertEqual([meeting["separation"], meeting["intersecting"]], [0, True])
        self.assertEqual(meeting["closest_a"], meeting["closest_b"])
        report = self.succeed("intersect", "cube", "cube", "--pose", path, "--distance", "--out", self.folder / "rows.npy")
        self.assertIn("separation 1 between", report)

    def test_says_how_far_apart_at_any_scale(self):
        far = [1e149, 1e155, 1e300, 1.79e308]
        path = self.file("far.csv", text_of([shifted(x, 0, 0) for x in far]))
        for x, answer in zip(far, self.json_of("intersect", "cube", "cube", "--pose", path, "--distance")["poses"]):
            self.assertAlmostEqual(answer["separation"] / x, 1, delta=1e-15)
            self.assertEqual([abs(answer["closest_a"][0]), answer["intersecting"]], [1, False])
        for size in (1e-160, 1e-200, 1e-300):
            corners = [(0, 0, 0), (size, 0, 0), (0, size, 0), (0, 0, size)]
            model = self.file("tiny.off", off(corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]))
            path = self.file("near.csv", text_of([shifted(3 * size, 0, 0), shifted(size, 0, 0)]))
            apart, meeting = self.json_of("intersect", model, model, "--pose", path, "--distance")["poses"]
            self.assertAlmostEqual(apart["separation"] / size, 2, delta=1e-14)
            self.assertAlmostEqual(apart["closest_b"][0] / size, 3, delta=1e-14)
            self.assertEqual(meeting["separation"], 0)

    def test_counts_cells_and_draws_them(self):
        poses = self.file("poses.csv", text_of([shifted(1, 0, 0)]))
        out = self.folder / "spheres.png"
        pose, = self.json_of("intersect", "sphere:30x30", "sphere:30x30", "--pose", poses, "--cells",
                             "--picture", out)["poses"]
        cells = pose["cells"]
        self.assertEqual(list(cells), ["pairs", "a", "b", "triangles_a", "triangles_b", "tests", "seconds"])
        self.assertTrue(50 < cells["triangles_a"] < 600, "of 1,740")
        self.assertGreater(cells["pairs"], cells["a"])
        self.assertEqual(struct.unpack(">II", out.read_bytes()[16:24]), (1280, 960))


class Poses(ProgramTest):
    """One pose in every spelling."""
    MATRIX = (0.0, -1.0, 0.0, 1.5, 1.0, 0.0, 0.0, 0.25, 0.0, 0.0, 1.0, 0.0)

    def pairs(self, pose):
        out = self.folder / "pairs.csv"
        done = run("intersect", "torus:9x5", "spaceship:1300", "--pose", pose, "--pairs", out, "--json", "-")
        self.assertEqual(done.returncode, 0, done.stderr)
        error = json.loads(done.stdout)["rotation_error"]
        self.assertEqual("nearest rotations" in done.stderr, error > 0)
        return error, out.read_text()

    def test_every_spelling_is_the_same(self):
        half = math.sqrt(0.5)
        rows = {
            "12": self.MATRIX, "16": self.MATRIX + (0.0, 0.0, 0.0, 1.0), "7": (1.5, 0.25, 0.0, 0.0, 0.0, half, half)}
        expected = self.pairs(self.file("12.csv", text_of([rows["12"]])))
        self.assertEqual(expected[0], 0)
        self.assertGreater(expected[1].count("\n"), 20)
        for name, row in rows.items():
            with self.subTest(name):
                self.assertEqual(self.pairs(",".join(map(repr, row))), expected)
                self.assertEqual(self.pairs(self.file("row.txt", " ".join(map(repr, row)) + "\n")), expected)
        self.assertEqual(self.pairs("1.5,0.25,0@0,0,2,90"), expected)
        turned = self.file("named.csv", "qw,qx,qy,qz,tx,ty,tz\n%r,0,0,%r,1.5,0.25,0\n" % (half, half))
        self.assertEqual(self.pairs(turned), expected)
        for shape, row in (("(12,)", rows["12"]), ("(3, 4)", rows["12"]), ("(1, 3, 4)", rows["12"]), ("(4, 4)", rows["16"]),
                           ("(1, 4, 4)", rows["16"]), ("(1, 7)", rows["7"])):
            with self.subTest(shape):
                self.assertEqual(self.pairs(self.file("pose.npy", npy([row], shape=shape))), expected)
        columns = [self.MATRIX[4 * row + column] for column in range(4) for row in range(3)]
        self.assertEqual(self.pairs(self.file("pose.npy", npy([columns], shape="(3, 4)").replace(b"False", b"True "))), expected)
        self.assertEqual(self.pairs("0.5,0,0"), self.pairs(",".join(map(repr, shifted(0.5, 0, 0)))))

    def test_several_of_each(self):
        poses = [self.MATRIX, IDENTITY, shifted(0.25, 0, 0)]
        expected = self.pairs(self.file("poses.csv", text_of(poses)))
        fourth = (0.0, 0.0, 0.0, 1.0)
        for shape, rows in (("(3, 12)", poses), ("(3, 3, 4)", poses), ("(3, 4, 4)", [p + fourth for p in poses])):
            self.assertEqual(self.pairs(self.file("poses.npy", npy(rows, shape=shape))), expected)

    def test_rounded_rotations_are_taken_and_named(self):
        turn = turned((1.0, 2.0, -0.5), 0.7)
        exact = ",".join(map(repr, turn))
        for digits, most in ((6, 1e-5), (4, 1e-3)):
            pose = ",".join("%.*f" % (digits, x) for x in turn)
            error, pairs = self.pairs(pose)
            self.assertTrue(1e-9 < error < most)
            rows = self.folder / "rows.csv"
            self.assertIn("nearest rotations", self.succeed("intersect", "cube", "cube", "--pose", pose, "--out", rows))
            noted = run("intersect", "cube", "cube", "--pose", pose)
            self.assertEqual((noted.returncode, noted.stdout, noted.stderr.count("\n")), (0, rows.read_text(), 1))
            self.assertIn("nearest rotations", noted.stderr)
            self.assertEqual(self.succeed("intersect", "cube", "cube", "--pose", pose, "--quiet"), rows.read_text())
        self.succeed("intersect", "cube", "cube", "--pose", exact)
        quaternion = self.succeed("intersect", "cube", "cube", "--pose", "0,0,0,0,0,0,1.0001", "--out", rows)
        self.assertIn("up to 0.0001 off (R^T R from the identity, or a quaternion's length from 1)", quaternion)
        single = self.file("pose.npy", npy([turn], "<f4", shape="(3, 4)"))
        self.assertTrue(1e-9 < self.pairs(single)[0] < 1e-6)
        self.assertLess(self.pairs(exact)[0], 1e-9)

    def test_axes_of_any_length(self):
        usual = self.succeed("intersect", "cube", "cube", "--pose", "0.7,0.1,0@3,0,4,30")
        for axis in ("3e300,0,4e300", "3e-200,0,4e-200", "0.9e308,0,1.2e308", "15e-323,0,20e-323"):
            self.assertEqual(self.succeed("intersect", "cube", "cube", "--pose", f"0.7,0.1,0@{axis},30"), usual, axis)

    def test_what_is_no_pose(self):
        for text, says in (("1,2", "is no pose"), ("1,2,3@0,0,0,90", "axis"), ("1,2,3@0,0,90", "is no pose"),
                           ("0,0,0,1,1,1,1", "length 2"), (",".join(map(str, IDENTITY)) + ",0,0,1,1", "last row")):
            self.refuse("intersect", "cube", "cube", "--pose", text, says=says)


class Rows(ProgramTest):
    def test_rows_go_to_stdout(self):
        poses = self.file("poses.csv", "0,0,0\n5,0,0\n")
        rows = self.folder / "rows.csv"
        self.succeed("intersect", "cube", "octahedron", "--pose", poses, "--out", rows)
        for options in (("--out", "-"), (), ("--quiet",)):
            self.assertEqual(self.succeed("intersect", "cube", "octahedron", "--pose", poses, *options), rows.read_text())
        for output in (("--pairs", "p.csv"), ("--contour", "c.obj"), ("--picture", "p.png")):
            report = self.succeed("intersect", "cube", "octahedron", "--pose", poses, output[0], self.folder / output[1])
            self.assertIn("1 of 2 poses intersect", report)
        self.refuse("intersect", "cube", "cube", "--out", "-", "--json", "-", says="stdout")
        for option in ("--depth", "--threshold"):
            self.refuse("intersect", "cube", "cube", option, 3, status=2, says=(option, "--cells"))

    def test_a_row_per_pose(self):
        small = self.file("small.off", tetrahedron(0.25))
        poses = self.file("poses.csv", text_of([shifted(x, 0, 0) for x in (0, 0.5, 3, 1.5)]))
        distance = ["separation", "ax", "ay", "az", "bx", "by", "bz", "triangle_a", "triangle_b"]
        cells = ["cell_pairs", "cells_a", "cells_b", "cell_triangles_a", "cell_triangles_b"]
        for options in ((), ("--distance",), ("--cells",), ("--distance", "--cells")):
            table, numbers = self.folder / "rows.csv", self.folder / "rows.npy"
            report = self.json_of("intersect", small, "cube", "--pose", poses, "--out", table, *options)["poses"]
            self.succeed("intersect", small, "cube", "--pose", poses, "--out", numbers, *options)
            rows = list(csv.DictReader(io.StringIO(table.read_text())))
            self.assertEqual([tuple(map(float, row.values())) for row in rows],
                             [tuple(row) for row in read_npy(numbers.read_bytes())])
            self.assertEqual(list(rows[0]), ["pose", "intersecting", "pairs", "contained"]
                             + distance * ("--distance" in options) + cells * ("--cells" in options))
            for i, (row, pose) in enumerate(zip(rows, report)):
                self.assertEqual(int(row["pose"]), i)
                self.assertEqual((row["intersecting"] == "1", int(row["pairs"])), (pose["intersecting"], pose["pairs"]))
                self.assertEqual(["none", "A_in_B", "B_in_A"][int(row["contained"])], pose["contained"])
                if "--cells" in options:
                    counts = [pose["cells"][key] for key in ("pairs", "a", "b", "triangles_a", "triangles_b")]
                    self.assertEqual([int(row[name]) for name in cells], counts)
                if "--distance" in options:
                    self.assertEqual(float(row["separation"]), pose["separation"])
                    for side in "ab":
                        self.assertEqual([float(row[side + x]) for x in "xyz"], pose["closest_" + side])
                        self.assertEqual(int(row["triangle_" + side]), pose["triangle_" + side])
        self.assertEqual([pose["contained"] for pose in report], ["A_in_B", "A_in_B", "none", "none"])

    def test_points_and_triangles_are_those_of_their_sides(self):
        """A corner of one tetrahedron in front of the slanted face of the other, then the other way round."""
        model, table = self.file("a.off", tetrahedron()), self.folder / "rows.csv"
        poses = self.file("poses.csv", text_of([shifted(2, 2, 2), shifted(-2, -2, -2)]))
        report = self.json_of("intersect", model, model, "--pose", poses, "--distance", "--out", table)["poses"]
        rows = list(csv.DictReader(io.StringIO(table.read_text())))
        third, slanted, at_corner = 1 / 3, {3}, {0, 1, 2}  # by mesh_files.TRIANGLES
        for row, pose, (a, b, of_a, of_b) in zip(rows, report, ((third, 2, slanted, at_corner), (0, third - 2, at_corner, slanted))):
            found = {"a": pose["closest_a"], "b": pose["closest_b"]}
            for side, expected in (("a", a), ("b", b)):
                for point in (found[side], [float(row[side + x]) for x in "xyz"]):
                    for x in point:
                        self.assertAlmostEqual(x, expected, delta=1e-14)
            for numbers in (row, pose):
                self.assertIn(int(numbers["triangle_a"]), of_a)
                self.assertIn(int(numbers["triangle_b"]), of_b)
                self.assertAlmostEqual(float(numbers["separation"]), 5 / math.sqrt(3), delta=1e-14)
        self.assertEqual([(pose["feature_a"], pose["feature_b"]) for pose in report], [("face", "vertex"), ("vertex", "face")])

    def test_one_line_or_several(self):
        contour = self.folder / "c.obj"
        self.assertIn("contour of 1 line,", self.succeed("intersect", "icosphere:3", "icosphere:3", "--pose", "1,0,0", "--contour", contour))
        self.assertIn("contour of 6 lines,", self.succeed("intersect", "cube", "icosphere:4", "--pose", "0,0,0", "--contour",
                                                          self.folder / "d.obj"))


class Refusing(ProgramTest):
    def test_poses_that_are_not_rigid_name_their_line(self):
        good = text_of([IDENTITY])
        for bad, says in (((2,) + IDENTITY[1:], "stretches"), ((-1,) + IDENTITY[1:], "mirrors"),
                          (IDENTITY[:1] + (1e-2,) + IDENTITY[2:], "shears"),
                          (tuple(0.01 * x for x in IDENTITY), "scales by 0.01")):
            path = self.file("poses.csv", good + text_of([bad]))
            self.refuse("intersect", "cube", "cube", "--pose", path, says=(says, "poses.csv:2"))
            headed = self.file("poses.csv", "r00,r01,r02,tx,r10,r11,r12,ty,r20,r21,r22,tz\n" + good + text_of([bad]))
            self.refuse("intersect", "cube", "cube", "--pose", headed, says="poses.csv:3")
            header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 12), }"
            npy = self.file("poses.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header) + 1) + header.encode()
                            + b"\n" + struct.pack("<24d", *IDENTITY, *bad))
            self.refuse("intersect", "cube", "cube", "--pose", npy, says=("poses.npy", "row 1"))

    def test_bad_files_and_options(self):
        for text, says in (("1,0\n", "poses.csv"), ("", "poses.csv"), (text_of([("nan",) + IDENTITY[1:]]), "poses.csv")):
            self.refuse("intersect", "cube", "cube", "--pose", self.file("poses.csv", text.replace("'", "")), says=says)
        self.refuse("intersect", "cube", "cube", "--contour", self.folder / "x.ply", says=".obj")
        self.refuse("intersect", "cube", "cube", "--picture", self.folder / "x.jpg", says=".png")
        self.refuse("intersect", "cube", "cube", "--pairs", self.folder / "x.txt", says="unknown extension")
        self.refuse("intersect", "cube", self.folder / "absent.off", says="absent.off")
        empty = self.file("empty.off", "OFF\n0 0 0\n")
        self.refuse("intersect", "cube", empty, says="empty.off")
        self.refuse("intersect", "cube", status=2, says="B")


if __name__ == "__main__":
    unittest.main()
