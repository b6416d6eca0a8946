"""proxima proximity as its users run it."""
import csv
import re
import struct
import unittest
import xml.etree.ElementTree
import zlib

from bad_input_test import off, tetrahedron
from proxima_program import SANITIZED, ProgramTest

COMMON_KEYS = ["model", "triangles", "method", "threshold_vertex", "threshold_edge", "threshold_face", "margin"]
ROW_KEYS = ["depth", "nodes", "references", "bytes", "seconds", "max_depth", "max_list", "mean_list",
            "worst_case_steps", "worst_case_blocks", "inner", "outer", "boundary", "outer_cells",
            "outer_max_list", "outer_mean_list", "outer_percent_up_to_16"]
THESIS = ("proximity", "--method", "thesis")
GENERAL_KEYS = ["model", "triangles", "method", "margin", "budget_bytes"]
GENERAL_ROW_KEYS = ["depth", "nodes", "references", "bytes", "seconds", "max_depth", "max_list", "mean_list",
                    "worst_case_steps", "worst_case_blocks", "expected_list", "blocks", "leaves", "searched_leaves", "query_ns_median",
                    "query_ns_max", "peak_bytes"]
CURVE_KEYS = ["model", "triangles", "method", "margin", "queries_per_set", "left_out", "enough", "rows"]
CURVE_ROW_KEYS = ["budget_bytes_per_triangle", "bytes_per_triangle", "seconds", "ns_a", "ns_b", "ns_c", "worst_case_blocks"]


def png_pixels(data):
    """Width, height and the unfiltered rows of an 8-bit RGB picture."""
    width, height = struct.unpack_from(">II", data, 16)
    packed, place = b"", 8
    while place < len(data):
        length, kind = struct.unpack_from(">I4s", data, place)
        if kind == b"IDAT":
            packed += data[place + 8:place + 8 + length]
        place += length + 12
    raw, rows, above = zlib.decompress(packed), [], bytes(3 * width)
    for y in range(height):
        start = y * (3 * width + 1)
        kind, row = raw[start], bytearray(raw[start + 1:start + 1 + 3 * width])
        for x in range(len(row)):
            left = row[x - 3] if x >= 3 else 0
            corner = above[x - 3] if x >= 3 else 0
            if kind == 1:
                row[x] = (row[x] + left) & 255
            elif kind == 2:
                row[x] = (row[x] + above[x]) & 255
            elif kind == 3:
                row[x] = (row[x] + (left + above[x]) // 2) & 255
            elif kind == 4:
                guess = left + above[x] - corner
                nearest = min((left, above[x], corner), key=lambda one: abs(guess - one))
                row[x] = (row[x] + nearest) & 255
        rows.append(bytes(row))
        above = row
    return width, height, rows


class DrawingTest(ProgramTest):
    def check_drawings(self, names, notes):
        """The same drawing as SVG, PDF and PNG, with so many lines of notes; returns png_pixels of the last."""
        width, height, rows = png_pixels(names[2].read_bytes())
        self.assertEqual(width, 1200)
        self.assertIn(height - 764 - 24 * notes, (0, 30, 60), "rows of the legend")
        svg = xml.etree.ElementTree.parse(names[0]).getroot()
        self.assertEqual([svg.get("width"), svg.get("height")], ["1200px", f"{height}px"])
        letters = svg.findall(".//{http://www.w3.org/2000/svg}use")
        self.assertGreater(len(letters), 60, "letters of the words")
        pdf = names[1].read_bytes()
        self.assertEqual(pdf[:5], b"%PDF-")
        self.assertIn(b"%%EOF", pdf[-8:])
        box = [float(part) for part in re.search(rb"/MediaBox \[ ?([\d. ]+)\]", pdf)[1].split()]
        self.assertEqual(box, [0, 0, 900, 0.75 * height])
        self.assertIn(b"DejaVu", pdf)
        return width, height, rows


class General(DrawingTest):
    def test_json_has_the_documented_keys_in_order(self):
        result = self.json_of("proximity", "torus:40x20")
        self.assertEqual(list(result), GENERAL_KEYS + GENERAL_ROW_KEYS)
        self.assertEqual([result[key] for key in GENERAL_KEYS], ["torus:40x20", 1600, "general", 0.5, 832000])
        self.assertLessEqual(result["bytes"], 960000)
        self.assertEqual(result["leaves"], (7 * result["nodes"] + 1) // 8)
        self.assertAlmostEqual(result["mean_list"], result["references"] / (result["leaves"] - result["searched_leaves"]))
        self.assertLessEqual(result["mean_list"], result["max_list"])
        self.assertLessEqual(result["query_ns_median"], result["query_ns_max"])
        self.assertGreater(result["query_ns_median"], 0)

    def test_the_worst_case_is_printed(self):
        text = self.succeed("proximity", "torus:40x20", "--method", "general")
        result = self.json_of("proximity", "torus:40x20")
        self.assertIn("at most %d steps down" % result["worst_case_steps"], text)
        self.assertIn("and %d blocks of triangles" % result["worst_case_blocks"], text)
        self.assertRegex(text, r"About \d+ ns, \d+ ns at most")

    def test_leaves_without_a_list_are_told(self):
        tight = ("proximity", "torus:100x50", "--lists-mb", 2)
        result = self.json_of(*tight)
        self.assertGreater(result["searched_leaves"], 0)
        self.assertIn("In %d of %d leaves" % (result["searched_leaves"], result["leaves"]), self.succeed(*tight))
        self.assertLessEqual(result["bytes"], 2_000_000)

    def test_peak_memory(self):
        result = self.json_of("proximity", "torus:100x50", "--lists-mb", 6)
        if result["peak_bytes"] is None:
            self.skipTest("this system does not tell the memory of a process")
        # The octree itself, and not what stood there before or comes after.
        self.assertGreater(result["peak_bytes"], result["bytes"])
        if not SANITIZED:
            self.assertLess(result["peak_bytes"], 200e6)
        small = self.json_of("proximity", "cube", "--lists-mb", 1)
        self.assertLess(small["peak_bytes"], result["peak_bytes"])
        text = self.succeed("proximity", "torus:40x20")
        self.assertRegex(text, r"raised the memory of the process by [\d.]+ MB at most, [\d.]+ times the budget")

    def test_depths_and_budget(self):
        result = self.json_of("proximity", "torus:40x20", "--depth", "0-4", "--lists-mb", 4)
        self.assertEqual(list(result), GENERAL_KEYS + ["rows"])
        self.assertEqual(result["budget_bytes"], 4_000_000)
        rows = result["rows"]
        self.assertTrue(all(list(row) == GENERAL_ROW_KEYS for row in rows))
        self.assertEqual([row["max_depth"] for row in rows], [0, 1, 2, 3, 4])
        self.assertEqual((rows[0]["leaves"], rows[0]["max_list"]), (1, 1600))
        means = [row["mean_list"] for row in rows]
        self.assertEqual(means, sorted(means, reverse=True))
        small, large = (self.json_of("proximity", "torus:100x50", "--lists-mb", mb) for mb in (3, 6))
        self.assertLess(small["nodes"], large["nodes"])
        self.assertLess(large["expected_list"], small["expected_list"])
        self.assertLessEqual(small["bytes"], 3_000_000)

    def test_threads_do_not_change_the_result(self):
        results = [self.json_of("proximity", "torus:40x20", "--threads", threads) for threads in (1, 3)]
        for result in results:
            for key in ("seconds", "query_ns_median", "query_ns_max", "peak_bytes"):
                result.pop(key)
        self.assertEqual(results[0], results[1])

    def test_histograms(self):
        names = [self.folder / ("h." + kind) for kind in ("csv", "svg", "pdf", "png")]
        options = [option for name in names for option in ("--histogram", name)]
        text = self.succeed("proximity", "torus:40x20", "--depth", "0,4", *options)
        for name in names:
            self.assertIn(f"wrote {name}", text)
        with open(names[0], newline="") as file:
            table = list(csv.DictReader(file))
        self.assertEqual(list(table[0]), ["depth", "triangles", "volume_percent"])
        self.assertEqual(table[0], {"depth": "0", "triangles": "1600", "volume_percent": "100"})
        longest = self.json_of("proximity", "torus:40x20", "--depth", 4)["max_list"]
        self.assertEqual(max(int(line["triangles"]) for line in table[1:]), longest)
        self.assertAlmostEqual(sum(float(line["volume_percent"]) for line in table[1:]), 100, places=2)
        self.check_drawings(names[1:], notes=1)

    def test_the_usual_budget_does_for_any_model(self):
        corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        for faces in ([(0, 2, 1)], [(0, 2, 1), (0, 1, 3)], [(0, 2, 1), (0, 1, 3), (0, 3, 2)]):
            result = self.json_of("proximity", self.file("few.off", off(corners, faces)))
            self.assertEqual(result["triangles"], len(faces))
            self.assertLessEqual(result["bytes"], result["budget_bytes"])
        self.assertEqual(self.json_of("proximity", "torus:40x20")["budget_bytes"], 520 * 1600)

    def test_models_too_small_for_squares(self):
        for size in (1e-150, 1e-310):
            self.refuse("proximity", self.file("tiny.off", tetrahedron(size)), says=("tiny.off", "scale it towards size 1"))

    def test_models_that_are_not_closed(self):
        corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        self.succeed("proximity", self.file("open.off", off(corners, [(0, 2, 1), (0, 1, 3)])), "--lists-mb", 1)
        self.refuse("proximity", self.file("empty.off", "OFF\n0 0 0\n"), says="empty.off")
        self.refuse("proximity", self.file("nan.off", tetrahedron().replace("0.0", "nan", 1)), says="nan.off")

    def test_usage(self):
        for option in ("--threshold", "--threshold-vertex", "--threshold-edge", "--threshold-face"):
            self.refuse("proximity", "cube", option, 3, status=2, says=(option, "--method thesis"))
        for option, name in (("--save", "a.pxi"), ("--out", "a.vtu")):
            self.refuse(*THESIS, "cube", option, self.folder / name, status=2, says=(option, "--method general"))
            self.refuse("proximity", "cube", "--depth", "1-3", option, self.folder / name, status=2, says=(option, "one depth"))
        self.refuse("proximity", "cube", "--depth", "3,15", status=2, says=("--depth", "14"))
        for margin in ("1001", "nan", "-1", "inf"):
            self.refuse("proximity", "cube", "--margin", margin, status=2, says=("--margin", "0 to 1000"))
        thesis = ("proximity", "octahedron", "--method", "thesis", "--depth", 1)
        self.succeed(*thesis, "--margin", "2000")
        for margin in ("1.1e6", "nan"):
            self.refuse(*thesis, "--margin", margin, status=2, says=("--margin", "0 to 1e+06"))


class BudgetCurve(DrawingTest):
    def test_budgets_too_small_are_left_out(self):
        curve = self.folder / "curve.svg"
        result = self.json_of("proximity", "octahedron", "--budget-curve", curve)
        # Lists take at least 1,024 bytes, of eight triangles 128 each.
        self.assertEqual(result["left_out"], [100])
        self.assertIn("left out, for they are too small", self.succeed("proximity", "octahedron", "--budget-curve", curve))

    def test_files_and_json(self):
        names = [self.folder / ("curve." + kind) for kind in ("csv", "svg", "pdf", "png")]
        options = [option for name in names for option in ("--budget-curve", name)]
        result = self.json_of("proximity", "torus:12x8", *options)
        self.assertEqual(list(result), CURVE_KEYS)
        self.assertEqual([result[key] for key in CURVE_KEYS[:5]], ["torus:12x8", 192, "general", 0.5, 100000])
        rows = result["rows"]
        self.assertTrue(all(list(row) == CURVE_ROW_KEYS for row in rows))
        budgets = [row["budget_bytes_per_triangle"] for row in rows]
        every = [100, 150, 200, 300, 400, 600, 900, 1500, 2500, 4000, 7000, 12000]
        self.assertEqual(result["left_out"] + budgets, every[:len(result["left_out"] + budgets)])
        # A small octree of short lists wants no more.
        self.assertEqual(result["enough"], budgets[-1])
        self.assertLess(result["enough"], 12000)
        self.assertEqual(result["left_out"], [])
        for row in rows:
            self.assertLessEqual(row["bytes_per_triangle"], row["budget_bytes_per_triangle"])
            for key in ("ns_a", "ns_b", "ns_c", "worst_case_blocks"):
                self.assertGreater(row[key], 0)
        sizes = [row["bytes_per_triangle"] for row in rows]
        # What lists take is known by the bytes of a sample, so a larger budget may use a little less.
        for less, more in zip(sizes, sizes[1:]):
            self.assertGreater(more, 0.98 * less)
        with open(names[0], newline="") as file:
            table = list(csv.DictReader(file))
        self.assertEqual(list(table[0]), CURVE_ROW_KEYS[:-1])
        for line, row in zip(table, rows):
            for key, value in line.items():
                self.assertAlmostEqual(float(value), row[key], delta=1e-5 * row[key])
        _, _, pixels = self.check_drawings(names[1:], notes=2)
        colors = {row[x:x + 3] for row in pixels for x in range(0, len(row), 3)}
        for color in (b"\x44\x77\xaa", b"\xee\x66\x77", b"\x22\x88\x33"):
            self.assertIn(color, colors)

    def test_usage(self):
        curve = ("--budget-curve", self.folder / "c.csv")
        for other in (("--lists-mb", 3), ("--save", self.folder / "a.pxi"), ("--histogram", self.folder / "h.csv"),
                      ("--out", self.folder / "e.vtu")):
            self.refuse("proximity", "cube", *curve, *other, status=2, says=("--budget-curve", other[0]))
        self.refuse("proximity", "cube", *curve, "--depth", "1-3", status=2, says="--budget-curve")
        self.refuse(*THESIS, "cube", *curve, status=2, says="--budget-curve")
        self.refuse("proximity", "cube", "--budget-curve", self.folder / "c.gif", says=("c.gif", ".svg"))
        self.refuse("proximity", "cube", "--budget-curve", "-", says="-")
        self.refuse("proximity", self.file("nan.off", tetrahedron().replace("0.0", "nan", 1)), *curve, says="nan.off")
        self.refuse("proximity", self.file("empty.off", "OFF\n0 0 0\n"), *curve, says="empty.off")


class Thesis(DrawingTest):
    def test_json_has_the_documented_keys_in_order(self):
        result = self.json_of(*THESIS, "octahedron", "--depth", 4)
        self.assertEqual(list(result), COMMON_KEYS + ROW_KEYS + ["ridge_edges"])
        self.assertEqual([result[key] for key in COMMON_KEYS], ["octahedron", 8, "thesis", 1, 1, 1, 0.5])
        self.assertEqual((result["max_depth"], result["worst_case_steps"], result["worst_case_blocks"]), (4, 4, None))
        self.assertEqual(result["inner"] + result["outer"] + result["boundary"], (7 * result["nodes"] + 1) // 8)

    def test_lists_of_figure_5_3(self):
        result = self.json_of(*THESIS, "sphere:50x50", "--depth", "1-6", "--threshold", 0)
        self.assertEqual(list(result), COMMON_KEYS + ["rows", "ridge_edges"])
        rows = {row["depth"]: row for row in result["rows"]}
        self.assertTrue(all(list(row) == ROW_KEYS for row in rows.values()))
        means = {3: 97.72, 4: 32.66, 5: 12.15, 6: 5.33}
        shares = {3: 0, 4: 1.6, 5: 84.1, 6: 99.4}
        for depth, mean in means.items():
            self.assertAlmostEqual(rows[depth]["outer_mean_list"], mean, delta=0.006)
            self.assertAlmostEqual(rows[depth]["outer_percent_up_to_16"], shares[depth], delta=0.06)
        self.assertEqual((rows[1]["outer_cells"], rows[4]["outer_cells"]), (0, 3176))

    def test_thresholds_and_margin(self):
        def nodes(*options):
            return self.json_of(*THESIS, "icosphere:2", "--depth", 5, *options)["nodes"]
        every = nodes("--threshold", 12)
        self.assertEqual(every, nodes("--threshold-vertex", 12, "--threshold-edge", 12, "--threshold-face", 12))
        self.assertLess(every, nodes("--threshold-vertex", 12, "--threshold-edge", 2, "--threshold-face", 12))
        self.assertLess(every, nodes("--threshold", 3))
        wide = self.json_of(*THESIS, "icosphere:2", "--depth", 3, "--margin", 2)
        self.assertEqual(wide["margin"], 2)
        self.assertGreater(wide["outer_cells"], self.json_of(*THESIS, "icosphere:2", "--depth", 3)["outer_cells"])

    def test_threads_do_not_change_the_result(self):
        results = [self.json_of(*THESIS, "sphere:20x20", "--depth", 4, "--threads", threads) for threads in (1, 3)]
        for result in results:
            result.pop("seconds")
        self.assertEqual(results[0], results[1])

    def test_histograms(self):
        names = [self.folder / ("h." + kind) for kind in ("csv", "svg", "pdf", "png")]
        options = [option for name in names for option in ("--histogram", name)]
        text = self.succeed(*THESIS, "sphere:20x20", "--depth", "1,3-4", *options)
        for name in names:
            self.assertIn(f"wrote {name}", text)
        result = self.json_of(*THESIS, "sphere:20x20", "--depth", "1,3-4")
        with open(names[0], newline="") as file:
            table = list(csv.DictReader(file))
        self.assertEqual(list(table[0]), ["depth", "features", "cells", "percent"])
        for row in result["rows"]:
            lines = [line for line in table if int(line["depth"]) == row["depth"]]
            cells = [int(line["cells"]) for line in lines]
            self.assertEqual(sum(cells), row["outer_cells"])
            if not cells:
                continue
            self.assertAlmostEqual(sum(float(line["percent"]) for line in lines), 100, places=3)
            mean = sum(int(line["features"]) * int(line["cells"]) for line in lines) / sum(cells)
            self.assertAlmostEqual(mean, row["outer_mean_list"])
            self.assertEqual(max(int(line["features"]) for line in lines), row["outer_max_list"])
        _, _, rows = self.check_drawings(names[1:], notes=1)
        colors = {row[x:x + 3] for row in rows for x in range(0, len(row), 3)}
        # White, ink, and the lines of the second and third series.
        for color in (b"\xff\xff\xff", b"\x22\x22\x22", b"\xee\x66\x77", b"\x22\x88\x33"):
            self.assertIn(color, colors)

    def test_a_histogram_without_outer_cells(self):
        self.succeed(*THESIS, "cube", "--depth", 0, "--histogram", self.folder / "a.svg", "--histogram",
                     self.folder / "a.csv", "--histogram", self.folder / "a.png")
        self.assertEqual((self.folder / "a.csv").read_text(), "depth,features,cells,percent\n")


class Refusing(ProgramTest):
    def test_models_that_are_not_convex_and_closed(self):
        self.refuse(*THESIS, "torus:12x8", says=("torus:12x8", "not convex"))
        self.refuse(*THESIS, "spaceship:2000", says="spaceship:2000")
        self.refuse(*THESIS, self.file("empty.off", "OFF\n0 0 0\n"), says="empty.off")
        self.refuse(*THESIS, self.file("nan.off", tetrahedron().replace("0.0", "nan", 1)), says="nan.off")
        corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
        self.succeed(*THESIS, self.file("good.off", off(corners, faces)))
        self.refuse(*THESIS, self.file("open.off", off(corners, faces[:3])), says=("open.off", "open"))
        inside_out = [(a, c, b) for a, b, c in faces]
        self.refuse(*THESIS, self.file("turned.off", off(corners, inside_out)), says=("turned.off", "inside out"))
        flat = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
        self.refuse(*THESIS, self.file("flat.off", off(flat, faces)), says=("flat.off", "no volume"))

    def test_usage(self):
        self.refuse("proximity", status=2, says="MODEL")
        self.refuse("proximity", "cube", "--method", "magic", status=2, says=("magic", "thesis"))
        for depth in ("20", "-1", "x", "3-1"):
            self.refuse(*THESIS, "cube", f"--depth={depth}", status=2, says="--depth")
        for name, value in (("--margin", "-1"), ("--flat", "1.5"), ("--flat", "nan")):
            self.refuse(*THESIS, "cube", name, value, status=2, says=name)
        self.refuse(*THESIS, "cube", "--threshold", 3, "--threshold-edge", 2, status=2, says="--threshold")

    def test_outputs(self):
        self.refuse(*THESIS, "cube", "--histogram", self.folder / "h.gif", says=("h.gif", ".svg"))
        self.refuse(*THESIS, "cube", "--histogram", self.folder / "none" / "h.svg", says="h.svg")
        self.refuse(*THESIS, "cube", "--histogram", "-", says="-")
        twice = self.folder / "h.csv"
        self.refuse(*THESIS, "cube", "--histogram", twice, "--histogram", twice, says="h.csv")

    def test_a_model_may_stand_behind_them(self):
        for option in ("--histogram", "--budget-curve", "--out"):
            out = self.folder / ("a.vtu" if option == "--out" else "a.csv")
            self.assertEqual(self.json_of("proximity", option, out, "octahedron")["model"], "octahedron")

    def test_a_budget_too_small(self):
        self.refuse(*THESIS, "sphere:50x50", "--depth", 8, "--budget-mb", 30, says=("sphere:50x50", "budget"))


if __name__ == "__main__":
    unittest.main()
