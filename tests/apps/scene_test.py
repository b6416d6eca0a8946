"""proxima scene as its users run it, against the models moved by hand and put into one mesh."""
import csv
import itertools
import math
import random
import unittest

from intersect_test import turned
from npy_tables import npy, read_npy
from proxima_program import ProgramTest, run

KEYS = ["models", "triangles", "instances", "query", "queries", "found", "seconds", "ns_per_query", "index_seconds", "build_seconds",
        "rotation_error", "bytes"]


def cube():
    points = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
    return points, faces


def corner():
    return [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def text_of(points, faces):
    return f"OFF\n{len(points)} {len(faces)} 0\n" + "".join(" ".join(map(repr, p)) + "\n" for p in points) + "".join(
        "3 " + " ".join(map(str, f)) + "\n" for f in faces)


def apply(pose, p):
    return tuple(sum(pose[4 * r + k] * p[k] for k in range(3)) + pose[4 * r + 3] for r in range(3))


class SceneTest(ProgramTest):
    """Has two models, their poses, and all of them in one mesh."""

    def setUp(self):
        super().setUp()
        self.random = random.Random(11)
        self.shapes = [cube(), corner()]
        self.models = [self.file(f"model{i}.off", text_of(*shape)) for i, shape in enumerate(self.shapes)]
        self.poses = []
        for _ in range(40):
            pose = list(turned([self.random.uniform(-1, 1) for _ in range(3)], self.random.uniform(0, 6)))
            for row in range(3):
                pose[4 * row + 3] = self.random.uniform(-4, 4)
            self.poses.append(pose)
        self.table = self.file("poses.csv", self.csv_of(self.poses))
        points, faces, self.first = [], [], []
        for i, pose in enumerate(self.poses):
            shape = self.shapes[i % 2]
            self.first.append(len(faces))
            faces += [tuple(c + len(points) for c in face) for face in shape[1]]
            points += [apply(pose, p) for p in shape[0]]
        self.all = self.file("all.off", text_of(points, faces))

    def csv_of(self, rows):
        return "".join(",".join(map(repr, row)) + "\n" for row in rows)

    def rows_of(self, *arguments):
        return list(csv.DictReader(self.succeed("scene", *self.models, "--poses", self.table, *arguments).splitlines()))


class Asking(SceneTest):
    def test_rays_hit_what_they_hit_in_one_mesh(self):
        rays = []
        for _ in range(300):  # towards some instance
            origin = [self.random.uniform(-5, 5) for _ in range(3)]
            target = apply(self.random.choice(self.poses), (0.3, 0.3, 0.3))
            rays.append(origin + [t - o for t, o in zip(target, origin)])
        table = self.file("rays.csv", self.csv_of(rays))
        own = self.rows_of("--rays", table)
        expected = list(csv.DictReader(self.succeed("raycast", self.all, "--rays", table).splitlines()))
        hits = 0
        for a, b in zip(own, expected, strict=True):
            if float(b["triangle"]) < 0:
                self.assertEqual((a["instance"], a["triangle"]), ("-1", "-1"))
                self.assertEqual(float(a["t"]), math.inf)
                continue
            hits += 1
            self.assertEqual(self.first[int(a["instance"])] + int(a["triangle"]), int(b["triangle"]))
            self.assertAlmostEqual(float(a["t"]), float(b["t"]), delta=1e-12 * (1 + abs(float(b["t"]))))
        self.assertGreater(hits, 250)
        one = self.rows_of("--ray", ",".join(map(repr, rays[0])))
        self.assertEqual(one[0], own[0])

    def test_points_are_as_far_as_from_one_mesh(self):
        points = [[self.random.uniform(-6, 6) for _ in range(3)] for _ in range(300)]
        table = self.file("points.csv", self.csv_of(points))
        own = self.rows_of("--points", table)
        expected = list(csv.DictReader(self.succeed("closest", self.all, "--points", table).splitlines()))
        for a, b in zip(own, expected, strict=True):
            self.assertAlmostEqual(float(a["distance"]), float(b["distance"]), delta=1e-12)
            for axis in "xyz":
                self.assertAlmostEqual(float(a[axis]), float(b[axis]), delta=1e-6)
            self.assertEqual(a["kind"], b["kind"])
        out = self.folder / "near.npy"
        self.succeed("scene", *self.models, "--poses", self.table, "--points", table, "--out", out, "--quiet")
        numbers = read_npy(out.read_bytes())
        self.assertEqual([row[1] for row in numbers], [float(row["distance"]) for row in own])
        self.assertEqual([["vertex", "edge", "face"][int(row[7])] for row in numbers], [row["kind"] for row in own])

    def test_pairs_are_those_that_intersect_finds(self):
        own = {(int(row["a"]), int(row["b"])) for row in self.rows_of("--pairs")}
        within = {(int(row["a"]), int(row["b"])): row for row in self.rows_of("--pairs", "--within", "0.5")}
        self.assertTrue(own)
        self.assertGreater(len(within), len(own))
        for a, b in itertools.combinations(range(12), 2):
            meshes = [self.file(f"{name}.off", text_of([apply(self.poses[i], p) for p in self.shapes[i % 2][0]], self.shapes[i % 2][1]))
                      for name, i in (("a", a), ("b", b))]
            answer = self.json_of("intersect", *meshes, "--pose", "0,0,0", "--distance")["poses"][0]
            self.assertEqual((a, b) in own, answer["intersecting"])
            self.assertEqual((a, b) in within, answer["separation"] <= 0.5)
            if (a, b) in within:
                row = within[a, b]
                self.assertAlmostEqual(float(row["distance"]), answer["separation"], delta=1e-12)
                apart = math.dist([float(row["a" + c]) for c in "xyz"], [float(row["b" + c]) for c in "xyz"])
                self.assertAlmostEqual(apart, float(row["distance"]), delta=1e-9)

    def test_shapes_say_which_model_an_instance_is_of(self):
        which = [self.random.randrange(2) for _ in self.poses]
        shapes = self.file("shapes.txt", "model\n" + "".join(f"{i}\n" for i in which))
        ray = "0,0,9,0,0,-1"
        answers = self.succeed("scene", *self.models, "--poses", self.table, "--shapes", shapes, "--ray", ray)
        for shape in ("(40,)", "(40, 1)"):
            array = self.file("shapes.npy", npy([(i,) for i in which], "<i8", shape=shape))
            self.assertEqual(self.succeed("scene", *self.models, "--poses", self.table, "--shapes", array, "--ray", ray), answers)
        array = self.file("shapes.npy", npy([(i,) for i in which], "<i8", shape="(1, 40)"))
        self.refuse("scene", *self.models, "--poses", self.table, "--shapes", array, "--ray", ray, says="40 columns")
        first = self.json_of("scene", *self.models, "--poses", "0,0,0", "--shapes", self.file("one.txt", "1\n"), "--point", "1,1,1")
        self.assertEqual(first["found"], 1)
        far = list(csv.DictReader(self.succeed("scene", *self.models, "--poses", "0,0,0", "--shapes", self.folder / "one.txt", "--point",
                                               "1,1,1").splitlines()))
        self.assertAlmostEqual(float(far[0]["distance"]), 2 / math.sqrt(3))

    def test_two_tables_cannot_both_come_from_standard_input(self):
        done = run("scene", "cube", "--poses", "-", "--points", "-", input="0,0,0\n")
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("name it for one option only", done.stderr)

    def test_a_model_that_no_pose_places_is_named(self):
        done = run("scene", "cube", "icosphere:1", "--poses", "0,0,0", "--point", "1,1,1")
        self.assertEqual((done.returncode, done.stderr), (0, "proxima: no pose places icosphere:1\n"))

    def test_report_and_json(self):
        result = self.json_of("scene", *self.models, "--poses", self.table, "--pairs")
        self.assertEqual(list(result), KEYS)
        self.assertEqual((result["instances"], result["query"], result["triangles"]), (40, "contact", 16))
        self.assertEqual(result["found"], len(self.rows_of("--pairs")))
        out = self.folder / "pairs.csv"
        text = self.succeed("scene", *self.models, "--poses", self.table, "--pairs", "--out", out)
        self.assertIn("40 instances of 2 models with 16 triangles", text)
        self.assertIn(f"{result['found']} pairs in contact", text)
        self.assertIn(f"wrote {out}", text)
        saved = self.folder / "model.pxi"
        self.succeed("index", self.models[0], "--save", saved)
        self.assertEqual(self.succeed("scene", saved, self.models[1], "--poses", self.table, "--pairs"),
                         self.succeed("scene", *self.models, "--poses", self.table, "--pairs"))


class Refusing(SceneTest):
    def test_bad_options_and_tables(self):
        model = self.models[0]
        self.refuse("scene", model, "--poses", self.table, status=2, says="--pairs")
        self.refuse("scene", model, "--poses", self.table, "--pairs", "--point", "0,0,0", status=2, says="one of")
        self.refuse("scene", model, "--poses", self.table, "--point", "0,0,0", "--within", "1", status=2, says="--within")
        self.refuse("scene", model, "--poses", self.table, "--pairs", "--within", "-1", status=2, says="--within")
        self.refuse("scene", model, "--pairs", status=2, says="--poses")
        self.refuse("scene", "--poses", self.table, "--pairs", status=2, says="MODEL")
        self.refuse("scene", model, "--poses", self.file("bad.csv", "2,0,0,0,0,2,0,0,0,0,2,0\n"), "--pairs", says=["bad.csv:1", "scales"])
        self.refuse("scene", model, "--poses", "1e300,0,0", "--pairs", says=["instance 0", "2^500"])
        self.refuse("scene", model, "--poses", self.table, "--shapes", self.file("few.txt", "0\n"), "--pairs", says=["few.txt", "40 poses"])
        many = self.file("many.txt", "0\n" * 39 + "1\n")
        self.refuse("scene", model, "--poses", self.table, "--shapes", many, "--pairs", says=["many.txt:40", "no model 1"])
        self.refuse("scene", self.folder / "none.off", "--poses", self.table, "--pairs", says="none.off")
        self.refuse("scene", model, "--poses", self.table, "--ray", "0,0,0,0,0,0", says="no ray")


if __name__ == "__main__":
    unittest.main()
