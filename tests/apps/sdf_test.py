"""proxima sdf as its users run it, against distances of all triangles and answers of proxima closest."""
import ast
import csv
import math
import os
import random
import re
import struct
import subprocess
import unittest

from mesh_oracle import bumpy_ball
from proxima_program import ProgramTest

KEYS = ["model", "triangles", "size", "origin", "spacing", "band", "least", "most", "inside", "beyond", "build_seconds", "seconds",
        "ns_per_point"]


def read_grid(path):
    """Size and distances of a .npy file, x fastest."""
    data = path.read_bytes()
    length = struct.unpack("<H", data[8:10])[0]
    header = ast.literal_eval(data[10:10 + length].decode())
    assert header["descr"] == "<f8" and header["fortran_order"] is True, header
    numbers = data[10 + length:]
    return header["shape"], struct.unpack(f"<{len(numbers) // 8}d", numbers)


def read_vti(path):
    """Attributes of the image, and its arrays by name."""
    data = path.read_bytes()
    start = data.index(b"<AppendedData encoding=\"raw\">\n_") + len(b"<AppendedData encoding=\"raw\">\n_")
    text = data[:start].decode()
    image = dict(re.findall(r'(\w+)="([^"]*)"', re.search(r"<ImageData ([^>]*)>", text)[1]))
    arrays = {}
    for element in re.findall(r"<DataArray ([^>]*)/>", text):
        attributes = dict(re.findall(r'(\w+)="([^"]*)"', element))
        at = start + int(attributes["offset"])
        size = struct.unpack("<Q", data[at:at + 8])[0]
        kind, width = {"Float64": ("d", 8), "UInt8": ("B", 1)}[attributes["type"]]
        arrays[attributes["Name"]] = struct.unpack(f"<{size // width}{kind}", data[at + 8:at + 8 + size])
    return image, arrays


class Filling(ProgramTest):
    def points_of(self, result):
        x, y, z = result["size"]
        h = result["spacing"]
        return [tuple(o + h * i for o, i in zip(result["origin"], (i, j, k)))
                for k in range(z) for j in range(y) for i in range(x)]

    def closest_of(self, model, points):
        """Signed distances and methods, by proxima closest."""
        table = self.file("points.csv", "\n".join(",".join(map(repr, p)) for p in points))
        rows = list(csv.DictReader(self.succeed("closest", model, "--points", table, "--signed").splitlines()))
        return [float(row["signed_distance"]) for row in rows], [row["sign_method"] for row in rows]

    def test_distances_are_those_of_closest_bit_for_bit(self):
        model = self.file("ball.off", bumpy_ball(random.Random(5)).text())
        out = self.folder / "field.npy"
        for options in (["--resolution", "12"], ["--resolution", "12", "--threads", "1"], ["--spacing", "0.31", "--margin", "0.2"]):
            result = self.json_of("sdf", model, "--out", out, *options)
            self.assertEqual(list(result), KEYS)
            shape, distances = read_grid(out)
            self.assertEqual(list(shape), result["size"])
            if "12" in options:
                self.assertEqual(max(shape), 12)
            expected, _ = self.closest_of(model, self.points_of(result))
            self.assertEqual(list(distances), expected)
            self.assertEqual((result["least"], result["most"]), (min(expected), max(expected)))
            self.assertEqual(result["inside"], sum(d < 0 for d in expected))
            self.assertIsNone(result["band"])

    def test_beyond_the_band_only_the_sign_is_told(self):
        out = self.folder / "field.npy"
        result = self.json_of("sdf", "torus:30x15", "--resolution", "17", "--band", "0.25", "--out", out)
        _, distances = read_grid(out)
        expected, _ = self.closest_of("torus:30x15", self.points_of(result))
        self.assertEqual(list(distances), [d if abs(d) <= 0.25 else math.copysign(0.25, d) for d in expected])
        self.assertEqual(result["beyond"], sum(abs(d) >= 0.25 for d in expected))
        self.assertEqual(result["band"], 0.25)

    def test_an_image_has_gradients_and_methods(self):
        out = self.folder / "field.vti"
        self.json_of("sdf", "spaceship:1300", "--resolution", "14", "--gradients", "--methods", "--out", out)
        image, arrays = read_vti(out)
        result = self.json_of("sdf", "spaceship:1300", "--resolution", "14")
        self.assertEqual(image["WholeExtent"], " ".join(f"0 {n - 1}" for n in result["size"]))
        self.assertEqual(list(map(float, image["Origin"].split())), result["origin"])
        self.assertEqual(list(map(float, image["Spacing"].split())), [result["spacing"]] * 3)
        expected, methods = self.closest_of("spaceship:1300", self.points_of(result))
        self.assertEqual(list(arrays["distance"]), expected)
        names = ["on_surface", "pseudonormal", "winding_number"]
        self.assertEqual([names[m] for m in arrays["sign_method"]], methods)
        self.assertEqual(set(methods), {"pseudonormal", "winding_number"})
        gradients = arrays["gradient"]
        for i in range(len(expected)):
            self.assertAlmostEqual(math.hypot(*gradients[3 * i:3 * i + 3]), 1, places=12)

    def test_a_saved_index_serves_as_well(self):
        saved = self.folder / "torus.pxi"
        out = self.folder / "field.npy"
        self.succeed("index", "torus:30x15", "--save", saved)
        self.succeed("sdf", "torus:30x15", "--resolution", "9", "--out", out)
        first = out.read_bytes()
        self.succeed("sdf", saved, "--resolution", "9", "--out", out)
        self.assertEqual(out.read_bytes(), first)


class LevelSets(ProgramTest):
    """.vdb files, where the program was built with OpenVDB, which reads them back."""

    def setUp(self):
        super().setUp()
        self.reader = os.environ.get("READ_VDB")
        if not self.reader:
            self.skipTest("built without OpenVDB")

    def read_vdb(self, path, size):
        lines = subprocess.run([self.reader, path, *map(str, size)], capture_output=True, text=True, check=True).stdout.splitlines()
        numbers = [line.split() for line in lines[3:-1]]
        return {"head": lines[0].rsplit(" ", 1), "origin": list(map(float, lines[1].split())), "step": list(map(float, lines[2].split())),
                "values": [float(v) for v, _ in numbers], "active": [a == "1" for _, a in numbers], "count": int(lines[-1])}

    def test_a_band_is_a_level_set(self):
        # More than a leaf of 8^3 on each side, with whole leaves inside and outside the band.
        options = ["sdf", "icosphere:3", "--resolution", "41", "--band", "0.15"]
        self.json_of(*options, "--out", self.folder / "field.npy")
        result = self.json_of(*options, "--out", self.folder / "field.vdb")
        shape, distances = read_grid(self.folder / "field.npy")
        field = self.read_vdb(self.folder / "field.vdb", shape)
        kind, background = field["head"]
        to_float = lambda d: struct.unpack("f", struct.pack("f", d))[0]
        self.assertEqual((kind, to_float(float(background))), ("level set", to_float(0.15)))
        self.assertEqual([to_float(v) for v in field["values"]], [to_float(d) for d in distances])
        self.assertEqual(field["active"], [abs(d) != 0.15 for d in distances])
        self.assertEqual(field["count"], len(distances) - result["beyond"])
        self.assertTrue(any(d == -0.15 for d in distances))
        for found, told in zip(field["origin"] + field["step"], result["origin"] + 3 * [result["spacing"]]):
            self.assertAlmostEqual(found, told, delta=1e-15)
        dense = len(distances) * 4
        self.assertLess((self.folder / "field.vdb").stat().st_size, dense)

    def test_without_a_band_every_point_is_there(self):
        for model, size in (("torus:30x15", "20"), ("cube", "8")):
            self.json_of("sdf", model, "--resolution", size, "--out", self.folder / "field.npy")
            self.json_of("sdf", model, "--resolution", size, "--out", self.folder / "field.vdb")
            shape, distances = read_grid(self.folder / "field.npy")
            field = self.read_vdb(self.folder / "field.vdb", shape)
            self.assertEqual(field["head"][0], "unknown")
            self.assertTrue(all(field["active"]))
            self.assertEqual(field["count"], len(distances))
            for found, told in zip(field["values"], distances):
                self.assertAlmostEqual(found, told, delta=1e-7 * abs(told))

    def test_what_floats_do_not_hold(self):
        model = self.file("huge.off", "OFF\n3 1 0\n0 0 0\n1e60 0 0\n0 1e60 0\n3 0 1 2\n")
        out = self.folder / "field.vdb"
        self.refuse("sdf", model, "--resolution", "5", "--out", out, says=["floats", ".npy"])
        self.assertFalse(out.exists())

    def test_memory_of_the_tree_is_part_of_the_budget(self):
        options = ["sdf", "cube", "--resolution", "100", "--budget-mb", "10", "--out"]
        self.succeed(*options, self.folder / "field.npy")
        self.refuse(*options, self.folder / "field.vdb", says="--budget-mb")


class WithoutOpenVdb(ProgramTest):
    def test_says_what_to_do(self):
        if os.environ.get("READ_VDB"):
            self.skipTest("built with OpenVDB")
        self.refuse("sdf", "cube", "--out", self.folder / "field.vdb", says=["OpenVDB", ".npy"])


class Refusing(ProgramTest):
    def test_bad_options(self):
        for options, says in (
                (["--resolution", "1"], "--resolution"), (["--spacing", "0"], "--spacing"), (["--spacing", "nan"], "--spacing"),
                (["--spacing", "1", "--resolution", "9"], "--resolution"), (["--margin", "-1"], "--margin"),
                (["--band", "inf"], "--band"), (["--gradients"], ".vti"),
                (["--methods", "--out", self.folder / "f.npy"], ".vti")):
            with self.subTest(options=options):
                self.refuse("sdf", "cube", *options, status=2, says=says)

    def test_outputs_that_cannot_be(self):
        self.refuse("sdf", "cube", "--out", self.folder / "field.txt", says=[".npy", ".vti", ".vdb"])
        self.refuse("sdf", "cube", "--out", self.folder / "none" / "field.npy", says="none")

    def test_grids_too_large(self):
        self.refuse("sdf", "cube", "--resolution", "2000", "--budget-mb", "100", says=["2000 x 2000 x 2000", "--budget-mb"])
        self.refuse("sdf", "cube", "--spacing", "1e-9", says="spacing")


if __name__ == "__main__":
    unittest.main()
