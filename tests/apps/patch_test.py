"""proxima patch as its users run it, against rings and distances of all triangles that are found here."""
import csv
import math
import random
import unittest

from closest_test import KINDS
from mesh_oracle import Mesh, along, bumpy_ball, cross, dot, soup, sub
from npy_tables import read_npy
from proxima_program import ProgramTest

KEYS = ["model", "triangles", "point", "rings", "radius", "distance", "closest_point", "kind", "feature", "triangle",
        "patch_triangles", "ring_triangles", "area", "build_seconds", "seconds"]


def open_sheet(rng):
    """A bumpy 9 x 9 grid with a hole, and a fin on one of its edges: three triangles share that one."""
    points = [(x + rng.uniform(-0.2, 0.2), y + rng.uniform(-0.2, 0.2), rng.uniform(-0.5, 0.5))
              for x in range(9) for y in range(9)]
    triangles = []
    for x in range(8):
        for y in range(8):
            a = 9 * x + y
            if (x, y) not in ((3, 4), (4, 4)):
                triangles += [(a, a + 9, a + 1), (a + 1, a + 9, a + 10)]
    points.append((2.0, 2.5, 3.0))
    triangles.append((20, 21, 81))
    return Mesh(points, triangles)


def triangle_distance(mesh, id, p):
    """Of a point from the closed triangle."""
    a, b, c = (mesh.points[v] for v in mesh.triangles[id])
    best = min(math.dist(p, v) for v in (a, b, c))
    for u, v in ((a, b), (b, c), (c, a)):
        side = sub(v, u)
        t = min(1.0, max(0.0, dot(sub(p, u), side) / dot(side, side)))
        best = min(best, math.dist(p, along(u, side, t)))
    normal = cross(sub(b, a), sub(c, a))
    foot = along(p, normal, -dot(sub(p, a), normal) / dot(normal, normal))
    if all(dot(cross(sub(v, u), sub(foot, u)), normal) > 0 for u, v in ((a, b), (b, c), (c, a))):
        best = min(best, math.dist(p, foot))
    return best


def rings_of(mesh, kind, feature, count):
    """Triangles of rings 0 to `count`, a set for each."""
    edges = {number: edge for edge, number in mesh.edges.items()}
    if kind == "face":
        ring = {feature}
    else:
        wanted = {feature} if kind == "vertex" else edges[feature]
        ring = {i for i, triangle in enumerate(mesh.triangles) if wanted <= set(triangle)}
    rings, seen = [ring], set(ring)
    for _ in range(count):
        corners = {v for i in rings[-1] for v in mesh.triangles[i]}
        rings.append({i for i, t in enumerate(mesh.triangles) if corners & set(t)} - seen)
        seen |= rings[-1]
    while len(rings) > 1 and not rings[-1]:
        rings.pop()
    return rings


def area(mesh, ids):
    total = 0
    for id in ids:
        a, b, c = (mesh.points[v] for v in mesh.triangles[id])
        normal = cross(sub(b, a), sub(c, a))
        total += math.sqrt(dot(normal, normal)) / 2
    return total


def read_obj(path):
    points, triangles = [], []
    for line in path.read_text().splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            points.append(tuple(map(float, rest)))
        elif word == "f":
            triangles.append(tuple(int(corner) - 1 for corner in rest))
    return Mesh(points, triangles)


def text_of(p):
    return ",".join(map(repr, p))


class Finding(ProgramTest):
    def ids_of(self, *arguments):
        """What a run wrote as CSV, and its JSON."""
        out = self.folder / "ids.csv"
        result = self.json_of("patch", *arguments, "--out", out)
        with open(out, newline="") as file:
            rows = list(csv.reader(file))
        self.assertEqual(rows[0], ["triangle"])
        return [int(row[0]) for row in rows[1:]], result

    def check_closest(self, mesh, p, result):
        best = min(mesh.features(p))
        self.assertAlmostEqual(result["distance"], math.sqrt(best[0]), delta=1e-11 * max(1, result["distance"]))
        self.assertAlmostEqual(result["distance"], math.dist(p, result["closest_point"]), delta=1e-11)
        kind = KINDS.index(result["kind"])
        near = [f[1:3] for f in mesh.features(p) if f[0] <= best[0] + 1e-9 * max(1, best[0])]
        self.assertIn((kind, result["feature"]), near)
        self.assertEqual(result["triangle"], mesh.triangle_of(kind, result["feature"]))
        self.assertEqual(result["point"], list(p))

    def check_patches(self, model, mesh, seed):
        rng = random.Random(seed)
        kinds = set()
        for turn in range(8):
            p = tuple(rng.uniform(-1, 1) + x for x in rng.choice(mesh.points))
            with self.subTest(seed=seed, point=p):
                count = turn % 4
                ids, result = self.ids_of(model, "--point=" + text_of(p), "--rings", count)
                self.check_closest(mesh, p, result)
                kinds.add(result["kind"])
                rings = rings_of(mesh, result["kind"], result["feature"], count)
                self.assertEqual(ids, sorted(set().union(*rings)))
                self.assertEqual(result["ring_triangles"], list(map(len, rings)))
                self.assertEqual((result["rings"], result["radius"]), (count, None))
                self.assertEqual(result["patch_triangles"], len(ids))
                self.assertAlmostEqual(result["area"], area(mesh, ids))

                radius = result["distance"] + (0 if turn == 0 else rng.uniform(0, 1.5))
                distances = [triangle_distance(mesh, i, p) for i in range(len(mesh.triangles))]
                expected = [i for i, d in enumerate(distances) if d <= radius * (1 - 1e-12)]
                doubtful = [i for i, d in enumerate(distances) if abs(d - radius) <= 1e-12 * radius]
                ids, result = self.ids_of(model, "--point=" + text_of(p), "--radius", repr(radius))
                self.assertEqual([i for i in ids if i not in doubtful], expected)
                self.assertEqual(ids, sorted(set(ids)))
                self.assertLessEqual(set(ids), {*expected, *doubtful})
                self.assertEqual((result["rings"], result["radius"], result["ring_triangles"]), (None, radius, None))
                self.assertAlmostEqual(result["area"], area(mesh, ids))
        self.assertGreater(len(kinds), 1)

    def check_mesh(self, mesh, seed):
        self.check_patches(self.file("model.off", mesh.text()), mesh, seed)

    def test_a_closed_mesh(self):
        self.check_mesh(bumpy_ball(random.Random(1)), 1)

    def test_an_open_mesh_that_is_not_manifold(self):
        self.check_mesh(open_sheet(random.Random(2)), 2)

    def test_a_soup_whose_triangles_share_nothing(self):
        self.check_mesh(soup(random.Random(3), 40), 3)

    def test_built_ins(self):
        for seed, model in enumerate(("torus:9x5", "cube", "sphere:6x7")):
            self.succeed("patch", model, "--point", "0,0,0", "--radius", 100, "--out", self.folder / "all.obj")
            mesh = read_obj(self.folder / "all.obj")
            self.assertEqual(len(mesh.triangles), self.json_of("check", model)["triangles"])
            self.check_patches(model, mesh, 10 + seed)

    def test_rings_beyond_the_mesh(self):
        ids, result = self.ids_of("cube", "--point", "0,0,3", "--rings", 2**31 - 1)
        self.assertEqual(ids, list(range(12)))
        self.assertEqual(sum(result["ring_triangles"]), 12)
        self.assertNotEqual(result["ring_triangles"][-1], 0)

    def test_one_ring_where_nothing_is_asked(self):
        arguments = ("torus:9x5", "--point", "3,1,0.5")
        ids, result = self.ids_of(*arguments)
        self.assertEqual(result["rings"], 1)
        self.assertEqual(ids, self.ids_of(*arguments, "--rings", 1)[0])

    def test_a_radius_that_reaches_nothing(self):
        ids, result = self.ids_of("cube", "--point", "0,0,3", "--radius", 1.5)
        self.assertEqual((ids, result["patch_triangles"], result["area"]), ([], 0, 0))
        for name in ("none.npy", "none.ply", "none.obj", "none.stl"):
            self.succeed("patch", "cube", "--point", "0,0,3", "--radius", 0, "--out", self.folder / name)


class Files(ProgramTest):
    ARGUMENTS = ("patch", "torus:9x5", "--point", "3,1,0.5", "--rings", 2)

    def test_json_and_text(self):
        result = self.json_of(*self.ARGUMENTS)
        self.assertEqual(list(result), KEYS)
        self.assertEqual((result["model"], result["triangles"]), ("torus:9x5", 90))
        out = self.folder / "patch.npy"
        text = self.succeed(*self.ARGUMENTS, "--out", out)
        sum = " + ".join(map(str, result["ring_triangles"]))
        for part in ("torus:9x5: 90 triangles", "closest to (3, 1, 0.5): %s %d" % (result["kind"], result["feature"]),
                     "rings 0 to 2: %s = %d triangles" % (sum, result["patch_triangles"]), f"wrote {out}"):
            self.assertIn(part, text)
        self.assertIn("within 2 of the point: ", self.succeed(*self.ARGUMENTS[:4], "--radius", 2, "--json", self.folder / "p.json"))
        self.assertEqual(self.succeed(*self.ARGUMENTS, "--quiet", "--out", out), "")

    def test_every_form_has_the_same_triangles(self):
        names = {kind: self.folder / ("patch." + kind) for kind in ("csv", "npy", "obj", "ply", "stl")}
        for name in names.values():
            self.succeed(*self.ARGUMENTS, "--out", name)
        ids = [int(line) for line in names["csv"].read_text().splitlines()[1:]]
        self.assertEqual([row[0] for row in read_npy(names["npy"].read_bytes())], ids)
        self.succeed("patch", "torus:9x5", "--point", "0,0,0", "--radius", 100, "--out", self.folder / "all.obj")
        whole = read_obj(self.folder / "all.obj")
        expected = [tuple(whole.points[v] for v in whole.triangles[id]) for id in ids]
        part = read_obj(names["obj"])
        self.assertEqual([tuple(part.points[v] for v in t) for t in part.triangles], expected)
        used = sorted({v for id in ids for v in whole.triangles[id]})
        self.assertEqual(part.points, [whole.points[v] for v in used])
        self.assertEqual(len(names["stl"].read_bytes()), 84 + 50 * len(ids))
        for kind in ("ply", "stl"):
            self.assertEqual(self.json_of("check", names[kind])["triangles"], len(ids))


class SavedOctrees(ProgramTest):
    def saved(self, mesh):
        model, octree = self.file("model.off", mesh.text()), self.folder / "model.pxi"
        self.succeed("proximity", model, "--lists-mb", 1, "--save", octree)
        return model, octree

    def test_answers_are_those_of_the_mesh(self):
        for seed, mesh in enumerate((bumpy_ball(random.Random(5)), open_sheet(random.Random(6)))):
            model, octree = self.saved(mesh)
            rng = random.Random(seed)
            for options in (("--rings", 0), ("--rings", 3), ("--radius", 1.25)):
                point = "--point=" + text_of([rng.uniform(-1, 4) for _ in range(3)])
                results = [self.json_of("patch", one, point, *options, "--out", self.folder / (name + ".obj"))
                           for one, name in ((model, "mesh"), (octree, "octree"))]
                for result in results:
                    for key in ("model", "build_seconds", "seconds"):
                        result.pop(key)
                self.assertEqual(*results)
                self.assertEqual(*((self.folder / (name + ".obj")).read_bytes() for name in ("mesh", "octree")))

    def test_vertices_without_triangles(self):
        mesh = Mesh([(9.0, 9.0, 9.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (7.0, 7.0, 7.0)], [(1, 2, 3)])
        model, octree = self.saved(mesh)
        results = [self.json_of("patch", one, "--point", "8,8,8") for one in (model, octree)]
        self.assertEqual(results[0]["closest_point"], [0.5, 0.5, 0])
        for result in results:
            self.assertEqual((result["kind"], result["feature"], result["patch_triangles"]), ("edge", 1, 1))

    def test_damage_is_refused(self):
        octree = self.saved(bumpy_ball(random.Random(7)))[1]
        data = bytearray(octree.read_bytes())
        data[len(data) // 2] ^= 1
        self.refuse("patch", self.file("damaged.pxi", bytes(data)), "--point", "0,0,0", says="damaged.pxi")
        self.refuse("patch", self.file("cut.pxi", bytes(data[:1000])), "--point", "0,0,0", says="cut.pxi")
        self.refuse("patch", self.folder / "absent.pxi", "--point", "0,0,0", says="absent.pxi")


class Refusing(ProgramTest):
    def test_usage(self):
        def refuse(*options, says):
            self.refuse("patch", "cube", *options, status=2, says=says)
        refuse(says="--point")
        self.refuse("patch", "--point", "0,0,0", status=2, says="MODEL")
        for point in ("1,2", "1,2,3,4", "1,2,", "a,b,c", "nan,0,0", "0,-inf,0", "1e999,0,0", "1 2 3"):
            refuse("--point=" + point, says=("--point", "X,Y,Z"))
        good = ("--point", "0,0,3")
        refuse(*good, "--rings", 1, "--radius", 1, says=("--rings", "--radius"))
        for rings in ("-1", "1.5", "nan", "x", "2147483648"):
            refuse(*good, "--rings=" + rings, says="--rings")
        for radius in ("-1", "-0.001", "nan", "inf", "-inf", "x", "1,2"):
            refuse(*good, "--radius=" + radius, says="--radius")

    def test_negative_coordinates_are_no_options(self):
        self.assertEqual(self.json_of("patch", "cube", "--point", "-3,0.25,-0.5")["distance"], 2)

    def test_models(self):
        def refuse(name, content, says):
            self.refuse("patch", self.file(name, content), "--point", "0,0,0", says=(name, says))
        refuse("empty.off", "OFF\n0 0 0\n", "triangle")
        refuse("nan.off", "OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", "finite")
        refuse("model.txt", "", "extension")
        self.refuse("patch", self.folder / "absent.obj", "--point", "0,0,0", says="absent.obj")
        self.refuse("patch", "cube", "--point", "1e200,0,0", says=("--point", "too far"))

    def test_outputs(self):
        def refuse(*options, says):
            self.refuse("patch", "cube", "--point", "0,0,3", *options, says=says)
        refuse("--out", self.folder / "a.txt", says=("a.txt", ".npy"))
        refuse("--out", self.folder / "a.glb", says=("a.glb", ".obj"))
        refuse("--out", self.folder / "none" / "a.csv", says="a.csv")
        refuse("--out", "-", "--json", "-", says="stdout")
        path = self.folder / "ids.csv"
        self.succeed("patch", "cube", "--point", "0,0,3", "--out", path)
        for options in (("--out", "-"), (), ("--quiet",)):
            self.assertEqual(self.succeed("patch", "cube", "--point", "0,0,3", *options), path.read_text())
        path.unlink()
        refuse("--out", self.folder / "a.csv", "--json", self.folder / "a.csv", says="a.csv")
        big = self.file("big.off", "OFF\n3 1 0\n0 0 0\n1e60 0 0\n0 1e60 0\n3 0 1 2\n")
        self.refuse("patch", big, "--point", "0,0,0", "--out", self.folder / "a.stl", says="a.stl")


if __name__ == "__main__":
    unittest.main()
