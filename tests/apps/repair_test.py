"""proxima repair as its users run it."""
import csv
import math
import random
import struct
import unittest

import mesh_files
from bad_input_test import off, tetrahedron
from proxima_program import ProgramTest

STEPS = ["drop_non_finite", "weld_vertices", "drop_degenerate", "drop_zero_area", "drop_duplicates",
         "drop_small_components", "orient_pieces", "turn_outward", "drop_unused_vertices"]
KEYS = ["model", "vertices_before", "triangles_before", "steps", "vertices", "triangles", "components", "pieces",
        "closed_pieces", "cavities", "unorientable_pieces", "unorientable_edges", "closed", "consistently_oriented",
        "orientation", "signed_volume", "boundary_loops", "non_manifold_edges", "non_manifold_vertices", "seconds"]


def counts(result):
    return {step["step"]: step["count"] for step in result["steps"] if step["count"]}


def read_off(path):
    words = path.read_text().split()
    vertices, triangles = int(words[1]), int(words[2])
    places, faces = words[4:4 + 3 * vertices], words[4 + 3 * vertices:]
    return ([tuple(map(float, places[3 * i:3 * i + 3])) for i in range(vertices)],
            [tuple(map(int, faces[4 * i + 1:4 * i + 4])) for i in range(triangles)])


def rows_of(path):
    """Of a table of whole numbers, without its names."""
    with open(path) as file:
        return [tuple(map(int, row)) for row in list(csv.reader(file))[1:]]


def soup(seed, move=0.0):
    """The tetrahedron with vertices of each triangle alone, half of the triangles turned over, and rubbish: the text, and
    which triangle of the tetrahedron each one is."""
    chance = random.Random(seed)
    points, triangles, truth = [], [], []

    def add(positions, name):
        triangles.append(tuple(range(len(points), len(points) + 3)))
        points.extend(tuple(x + chance.uniform(-move, move) for x in p) for p in positions)
        truth.append(name)

    names = [0, 1, 2, 3, 2]
    chance.shuffle(names)
    for name in names:
        corners = [mesh_files.POSITIONS[i] for i in mesh_files.TRIANGLES[name]]
        chance.shuffle(corners)
        add(corners, name)
    add([mesh_files.POSITIONS[0]] * 2 + [mesh_files.POSITIONS[1]], None)
    add([(float("nan"), 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], None)
    points.append((9.0, 9.0, 9.0))
    return off(points, triangles), truth


class Repairing(ProgramTest):
    def check_tetrahedron(self, path, vertices=4):
        report = self.json_of("check", path)
        self.assertEqual((report["vertices"], report["triangles"], report["closed"], report["orientation"]),
                         (vertices, 4, True, "outward"))
        self.assertAlmostEqual(report["signed_volume"], 1 / 6, 3)

    def test_a_soup_becomes_the_solid_that_it_was(self):
        for seed in range(10):
            for move in (0.0, 1e-4):
                with self.subTest(seed=seed, move=move):
                    text, truth = soup(seed, move)
                    model, out, table = self.file("soup.off", text), self.folder / "out.ply", self.folder / "map.csv"
                    result = self.json_of("repair", model, "--out", out, "--map", table, "--weld", 5 * move)
                    self.assertEqual(list(result), KEYS)
                    self.assertEqual([step["step"] for step in result["steps"]], STEPS)
                    self.assertEqual((result["vertices_before"], result["triangles_before"]), (22, 7))
                    found = counts(result)
                    for kind, count in {"drop_non_finite": 1, "drop_degenerate": 1, "drop_duplicates": 1,
                                        "weld_vertices": 14, "drop_unused_vertices": 4}.items():
                        self.assertEqual(found.pop(kind), count, kind)
                    self.assertLessEqual(set(found), {"orient_pieces", "turn_outward"})
                    self.check_tetrahedron(out)
                    with open(table) as file:
                        rows = list(csv.DictReader(file))
                    self.assertEqual([int(row["triangle"]) for row in rows], [0, 1, 2, 3])
                    originals = [int(row["original"]) for row in rows]
                    self.assertEqual(originals, sorted(truth.index(name) for name in range(4)))

    def test_maps_say_where_corners_and_vertices_come_from(self):
        """By positions read back: a turned triangle has its last two corners swapped, and a vertex did not move."""
        model, out, table, vertices = (self.folder / name for name in ("soup.off", "out.off", "map.csv", "vertices.csv"))
        seen = set()
        for seed in range(10):
            for move in (0.0, 1e-4):
                with self.subTest(seed=seed, move=move):
                    self.file("soup.off", soup(seed, move)[0])
                    self.succeed("repair", model, "--out", out, "--map", table, "--vertex-map", vertices, "--weld", 5 * move)
                    (before, old), (after, new) = read_off(model), read_off(out)
                    rows = rows_of(table)
                    self.assertEqual([row[0] for row in rows], list(range(len(new))))
                    for triangle, original, turned in rows:
                        a, b, c = old[original]
                        for then, now in zip((a, c, b) if turned == 1 else (a, b, c), new[triangle]):
                            self.assertLessEqual(math.dist(before[then], after[now]), 5 * move)
                        seen.add(turned)
                    rows = rows_of(vertices)
                    self.assertEqual([row[0] for row in rows], list(range(len(after))))
                    for vertex, original in rows:
                        self.assertEqual(after[vertex], before[original])
        self.assertEqual(seen, {0, 1})

    def test_every_format(self):
        model = self.file("soup.off", soup(1)[0])
        for name in ("a.obj", "a.ply", "a.off", "a.stl", "A.OFF"):
            with self.subTest(name):
                out = self.folder / name
                self.succeed("repair", model, "--out", out)
                self.check_tetrahedron(out)

    def test_maps_of_numpy(self):
        model = self.file("soup.off", soup(2)[0])
        for option, columns, name in (("--map", 3, "t"), ("--vertex-map", 2, "v")):
            text, binary = self.folder / (name + ".csv"), self.folder / (name + ".npy")
            for table in (text, binary):
                self.succeed("repair", model, option, table)
            data = binary.read_bytes()
            numbers = struct.unpack("<%dd" % (4 * columns), data[-32 * columns:])
            rows = [[float(x) for x in line.split(",")] for line in text.read_text().splitlines()[1:]]
            self.assertEqual(sum(rows, []), list(numbers))

    def test_text_names_each_step(self):
        text = self.succeed("repair", self.file("soup.off", soup(3)[0]))
        for line in ("dropped 1 triangle with a NaN or infinite corner", "welded 14 vertices",
                     "dropped 1 degenerate triangle", "dropped 1 duplicate triangle", "dropped 4 unused vertices",
                     "4 triangles, closed, consistently oriented, outward"):
            self.assertIn(line, text)
        self.assertNotIn("left for other tools", text)

    def test_switches(self):
        model = self.file("soup.off", soup(4)[0])
        for options, step in ((("--keep-non-finite",), 0), (("--no-weld",), 1), (("--keep-degenerate",), 2),
                              (("--keep-duplicates",), 4), (("--no-orient",), 6), (("--no-outward",), 7),
                              (("--keep-unused",), 8)):
            with self.subTest(options):
                result = self.json_of("repair", model, *options)
                self.assertEqual((result["steps"][step]["enabled"], result["steps"][step]["count"]), (False, 0))
        by_default = [step["enabled"] for step in self.json_of("repair", model)["steps"]]
        self.assertEqual(by_default, [True, True, True, False, True, False, True, True, True])
        flat = self.file("flat.off", off([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]))
        self.assertEqual(counts(self.json_of("repair", flat, "--drop-zero-area"))["drop_zero_area"], 1)
        self.assertEqual(counts(self.json_of("repair", flat)), {})

    def test_small_components_and_cavities(self):
        points, triangles = [], []
        for scale, offset in ((20.0, -5.0), (1.0, 0.0), (0.01, 50.0)):
            triangles += [tuple(len(points) + i for i in t) for t in mesh_files.TRIANGLES]
            points += [tuple(scale * x + offset for x in p) for p in mesh_files.POSITIONS]
        model = self.file("three.off", off(points, triangles))
        result = self.json_of("repair", model, "--min-component-area", 0.001)
        self.assertEqual((counts(result), result["cavities"], result["orientation"]),
                         ({"drop_small_components": 1, "turn_outward": 1, "drop_unused_vertices": 4}, 1, "mixed"))
        self.assertEqual(counts(self.json_of("repair", model, "--no-cavities")), {})
        self.assertEqual(self.json_of("repair", model, "--min-component-triangles", 5)["triangles"], 0)

    def test_what_is_left_is_named_with_other_tools(self):
        model = self.file("open.off", off(mesh_files.POSITIONS, mesh_files.TRIANGLES[:-1]))
        text = self.succeed("repair", model)
        for part in ("open", "left for other tools", "1 hole", "MeshLab", "PyMeshFix", "CGAL"):
            self.assertIn(part, text)
        self.assertEqual(self.json_of("repair", model)["boundary_loops"], 1)

    def test_nothing_is_wrong_with_built_ins(self):
        for name in ("cube", "sphere:20x20", "torus:20x10", "spaceship:1300"):
            result = self.json_of("repair", name)
            self.assertEqual((counts(result), result["orientation"]), ({}, "outward"))

    def test_threads_change_nothing(self):
        model = self.file("soup.off", soup(5)[0])
        outs = [self.folder / (threads + ".ply") for threads in "13"]
        for threads, out in zip("13", outs):
            self.succeed("repair", model, "--out", out, "--threads", threads)
        self.assertEqual(outs[0].read_bytes(), outs[1].read_bytes())


class Refusing(ProgramTest):
    def test_outputs(self):
        model = self.file("a.off", tetrahedron())
        self.refuse("repair", model, "--out", self.folder / "a.glb", says=("a.glb", ".ply"))
        self.refuse("repair", model, "--out", self.folder / "none" / "a.ply", says="a.ply")
        self.refuse("repair", model, "--map", self.folder / "map.txt", says="map.txt")
        self.refuse("repair", model, "--out", model, says="read and written")
        self.assertEqual(model.read_text(), tetrahedron())
        same = self.folder / "b.csv"
        self.refuse("repair", model, "--map", same, "--vertex-map", same, says="two outputs")
        self.refuse("repair", model, "--out", "-", says="stdout")
        big = self.file("big.off", tetrahedron(1e60))
        self.refuse("repair", big, "--out", self.folder / "big.stl", "--map", self.folder / "map.csv", says="float32")

    def test_models(self):
        out = self.folder / "out.ply"
        self.refuse("repair", self.folder / "none.off", "--out", out, says="none.off")
        self.refuse("repair", self.file("cut.off", tetrahedron()[:-9]), "--out", out, says="cut.off")

    def test_empty_models_stay_empty(self):
        out = self.folder / "out.off"
        self.succeed("repair", self.file("empty.off", "OFF\n0 0 0\n"), "--out", out)
        self.assertEqual(self.json_of("repair", out)["triangles"], 0)

    def test_usage(self):
        for value in ("-1", "nan", "inf"):
            self.refuse("repair", "cube", "--weld=" + value, status=2, says="--weld")
            self.refuse("repair", "cube", "--min-component-area=" + value, status=2, says="--min-component-area")
        self.refuse("repair", "cube", "--min-component-area", 1.5, status=2, says="--min-component-area")
        self.refuse("repair", "cube", "--min-component-triangles", "-1", status=2, says="--min-component-triangles")
        self.refuse("repair", "cube", "--weld", 1, "--no-weld", status=2, says="--no-weld")
        self.refuse("repair", status=2, says="MODEL")


if __name__ == "__main__":
    unittest.main()
