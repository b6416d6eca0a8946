"""proxima minkowski as its users run it."""
import json
import struct
import unittest

import mesh_files
from bad_input_test import off, tetrahedron
from proxima_program import ProgramTest

SQUARE = off([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)])


class Summing(ProgramTest):
    def test_cube_and_octahedron_by_every_method(self):
        for method in ("arcs", "geometric", "hull"):
            with self.subTest(method):
                result = self.json_of("minkowski", "cube", "octahedron", "--method", method)
                self.assertEqual([result[key] for key in ("vertices", "edges", "facets")], [24, 48, 26])
                self.assertEqual([result["facets_" + key] for key in ("of_a", "of_b", "of_both", "swept")],
                                 [6, 8, 0, 12])
                self.assertEqual((result["lower"], result["upper"]), ([-2] * 3, [2] * 3))

    def test_scale_keeps_the_facets(self):
        result = self.json_of("minkowski", "cube", "octahedron", "--scale", 3)
        self.assertEqual((result["facets"], result["scale"], result["upper"]), (26, 3, [4] * 3))

    def test_a_negative_scale_mirrors(self):
        corners = [(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3)]
        shape = self.file("corner.off", off(corners, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]))
        other = self.file("other.off", off([tuple(-2 * x for x in p) for p in corners],
                                           [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]))
        mirrored, plain = (self.json_of("minkowski", shape, *b) for b in ((shape, "--scale", "-2"), (other,)))
        self.assertEqual((mirrored["scale"], mirrored["lower"], mirrored["upper"]), (-2, [-2, -4, -6], [1, 2, 3]))
        for key in ("vertices", "edges", "facets", "facets_swept", "lower", "upper"):
            self.assertEqual(mirrored[key], plain[key])

    def test_cubes_share_their_normals(self):
        result = self.json_of("minkowski", "cube", "cube")
        self.assertEqual((result["facets"], result["facets_of_both"], result["vertices"]), (6, 6, 8))

    def test_operations_are_counted(self):
        counts = self.json_of("minkowski", "cube", "octahedron", "--count-operations")["operations"]
        self.assertEqual(list(counts), ["arcs", "geometric", "hull"])
        # 48 pairs along N_A, N_B and the cross products of 12 x 12 edges, none parallel.
        self.assertGreaterEqual(counts["geometric"]["dot_products"], 48 * (6 + 8 + 144))
        self.assertLess(counts["arcs"]["flops"], counts["hull"]["flops"])
        self.assertEqual(counts["arcs"]["cross_products"], 0)
        too_large = self.json_of("minkowski", "icosphere:3", "icosphere:3", "--count-operations")["operations"]
        self.assertIn("4,096", too_large["hull"]["error"])

    def test_sums_are_written(self):
        for name in ("s.obj", "s.ply", "s.glb", "S.PLY"):
            self.succeed("minkowski", "cube", "octahedron", "--out", self.folder / name)
        for name in ("s.obj", "s.ply"):
            report = self.json_of("check", self.folder / name)
            self.assertEqual((report["vertices"], report["closed"], report["orientation"]), (24, True, "outward"))
            self.assertAlmostEqual(report["signed_volume"], 8 + 4 / 3 + 24 + 12)
        text = (self.folder / "s.obj").read_text()
        self.assertEqual([text.count("\ng " + group) for group in ("a\n", "b\n", "both\n", "swept\n")], [1, 1, 0, 1])
        faces = [line.split() for line in (self.folder / "s.ply").read_text().splitlines()[-26:]]
        # Squares of the cube are red, triangles of the octahedron blue, rectangles of their edges green.
        self.assertEqual(sorted((int(face[0]), " ".join(face[-3:])) for face in faces),
                         [(3, "60 90 200")] * 8 + [(4, "200 60 50")] * 6 + [(4, "70 170 80")] * 12)
        self.succeed("minkowski", "cube", "cube", "--out", self.folder / "both.ply")
        self.assertEqual((self.folder / "both.ply").read_text().count(" 150 70 170\n"), 6)
        glb = (self.folder / "s.glb").read_bytes()
        length, = struct.unpack_from("<I", glb, 12)
        document = json.loads(glb[20:20 + length])
        self.assertEqual([mesh["name"] for mesh in document["meshes"]], ["a", "b", "swept"])
        self.assertEqual(struct.unpack_from("<I", glb, 8)[0], len(glb))
        if mesh_files.READS_SCENES:
            self.assertEqual(self.json_of("check", self.folder / "s.glb")["triangles"], 12 + 8 + 24)

    def test_hulls_of_whatever_there_is(self):
        result = self.json_of("minkowski", "torus:12x8", self.file("flat.off", SQUARE), "--hull")
        self.assertEqual(result["b"]["facets"], 2)


class Refusing(ProgramTest):
    def test_operands(self):
        self.refuse("minkowski", "torus:12x8", "cube", says=("torus:12x8", "not convex", "--hull"))
        self.refuse("minkowski", "cube", self.file("flat.off", SQUARE), says=("flat.off", "no volume"))
        open_mesh = off(mesh_files.POSITIONS, mesh_files.TRIANGLES[:-1])
        self.refuse("minkowski", self.file("open.off", open_mesh), "cube", says=("open.off", "open", "vertex"))
        broken = tetrahedron().replace("0.0", "nan", 1)
        self.refuse("minkowski", self.file("nan.off", broken), "cube", says="nan.off")
        self.refuse("minkowski", self.file("huge.off", tetrahedron(1e100)), "cube", says=("huge.off", "2e90"))
        for scale in (1e-30, 1e30):
            name = self.file("scaled.off", tetrahedron(scale))
            self.assertEqual(self.json_of("minkowski", name, "cube")["a"]["facets"], 4)
        two_points = self.file("two.off", "OFF\n2 1 0\n0 0 0\n1 0 0\n3 0 1 1\n")
        self.refuse("minkowski", two_points, "cube", says="two.off")
        self.refuse("minkowski", self.file("empty.off", "OFF\n0 0 0\n"), "cube", says="empty.off")
        self.refuse("minkowski", self.folder / "none.off", "cube", says="none.off")

    def test_methods_with_limits(self):
        for method in ("geometric", "hull"):
            self.refuse("minkowski", "icosphere:3", "icosphere:3", "--method", method, says="arcs")

    def test_outputs(self):
        self.refuse("minkowski", "cube", "cube", "--out", self.folder / "a.stl", says=("a.stl", ".glb"))
        self.refuse("minkowski", "cube", "cube", "--out", self.folder / "none" / "a.obj", says="a.obj")
        below = self.file("file", "") / "a.obj"
        self.refuse("minkowski", "cube", "cube", "--out", below, says="a.obj")
        (self.folder / "b.ply").mkdir()
        self.refuse("minkowski", "cube", "cube", "--out", self.folder / "b.ply", says="b.ply")

    def test_usage(self):
        self.refuse("minkowski", "cube", status=2, says="B")
        self.refuse("minkowski", "cube", "cube", "--method", "fast", status=2, says="geometric")
        for scale in ("0", "-inf", "nan"):
            self.refuse("minkowski", "cube", "cube", "--scale", scale, status=2, says="--scale")
        for tolerance in ("-1", "inf", "nan"):
            self.refuse("minkowski", "cube", "cube", "--tolerance", tolerance, status=2, says="--tolerance")

    def test_scales_that_make_coordinates_infinite(self):
        ten = self.file("ten.off", tetrahedron(10))
        for scale in ("1e308", "-1e308"):
            for name in ("o.obj", "o.ply", "o.glb", None):
                out = ("--out", self.folder / name) if name else ()
                self.refuse("minkowski", ten, ten, "--scale", scale, *out, says=("--scale", "1.8e308"))
        self.succeed("minkowski", ten, ten, "--scale", "1e306", "--out", self.folder / "o.obj")


if __name__ == "__main__":
    unittest.main()
