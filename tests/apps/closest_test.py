"""proxima closest as its users run it, against a search of all features that is written here."""
import csv
import io
import math
import os
import random
import struct
import subprocess
import threading
import unittest
from pathlib import Path

from bad_input_test import off
from mesh_oracle import Mesh, along, bumpy_ball, soup
from npy_tables import npy, read_npy
from proxima_program import PROXIMA, ProgramTest, environment_of_program, run

COLUMNS = ["index", "distance", "x", "y", "z", "triangle", "kind", "feature"]
SIGNS = ["signed_distance", "sign_method"]
KEYS = ["model", "triangles", "queries", "seconds", "ns_per_query", "build_seconds", "load_seconds", "bytes"]
KINDS = ["vertex", "edge", "face"]
METHODS = ["on_surface", "pseudonormal", "winding_number"]


def queries(rng, mesh, count):
    """Anywhere about the mesh, and near its corners."""
    points = [tuple(rng.uniform(-2, 2) for _ in range(3)) for _ in range(count)]
    for _ in range(count):
        points.append(along(rng.choice(mesh.points), tuple(rng.uniform(-1, 1) for _ in range(3)), 0.05))
    return points + [(1e3, -2e3, 5e2), (0.0, 0.0, 0.0)]


def csv_text(points):
    return "".join(",".join(map(repr, p)) + "\n" for p in points)


class Answering(ProgramTest):
    def check_against_all_features(self, seed, mesh, count):
        rng = random.Random(seed)
        points = queries(rng, mesh, count)
        model = self.file("model.off", mesh.text())
        text = self.succeed("closest", model, "--points", self.file("points.csv", csv_text(points)), "--out", "-")
        rows = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual(list(rows[0]), COLUMNS)
        self.assertEqual([int(row["index"]) for row in rows], list(range(len(points))))
        kinds = set()
        for p, row in zip(points, rows):
            with self.subTest(seed=seed, point=p):
                best = min(mesh.features(p))
                distance, kind, id = float(row["distance"]), KINDS.index(row["kind"]), int(row["feature"])
                self.assertAlmostEqual(distance, math.sqrt(best[0]), delta=1e-11 * max(1, distance))
                here = tuple(float(row[axis]) for axis in "xyz")
                self.assertAlmostEqual(distance, math.dist(p, here), delta=1e-11 * max(1, distance))
                kinds.add(kind)
                near = [f for f in mesh.features(p) if f[0] <= best[0] + 1e-9 * max(1, best[0])]
                self.assertIn((kind, id), [f[1:3] for f in near])
                self.assertEqual(int(row["triangle"]), mesh.triangle_of(kind, id))
        self.assertEqual(kinds, {0, 1, 2})

    def test_a_closed_mesh_that_is_not_convex(self):
        self.check_against_all_features(1, bumpy_ball(random.Random(1)), 150)

    def test_a_soup_of_triangles(self):
        self.check_against_all_features(2, soup(random.Random(2), 60), 150)

    def test_signs_of_a_closed_mesh(self):
        mesh = bumpy_ball(random.Random(3))
        points = queries(random.Random(4), mesh, 200)
        text = self.succeed("closest", self.file("model.off", mesh.text()), "--signed", "--out", "-", "--points",
                            self.file("points.csv", csv_text(points)))
        rows = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual(list(rows[0]), COLUMNS + SIGNS)
        inside = 0
        for p, row in zip(points, rows):
            self.assertEqual(abs(float(row["signed_distance"])), float(row["distance"]))
            self.assertIn(row["sign_method"], METHODS[1:])
            expected = mesh.solid_angle(p) > 2 * math.pi
            self.assertEqual(float(row["signed_distance"]) < 0, expected, p)
            inside += expected
        self.assertGreater(inside, 50)
        self.assertLess(inside, len(points) - 50)

    def test_points_on_the_surface(self):
        points = [(1.0, 0.5, 0.25), (1.0, 1.0, 0.5), (1.0, 1.0, 1.0)]
        text = self.succeed("closest", "cube", "--signed", "--out", "-", "--points",
                            self.file("points.csv", csv_text(points)))
        for row, kind in zip(csv.DictReader(io.StringIO(text)), ("face", "edge", "vertex")):
            self.assertEqual((float(row["distance"]), float(row["signed_distance"])), (0, 0))
            self.assertEqual((row["kind"], row["sign_method"]), (kind, "on_surface"))


class Files(ProgramTest):
    POINTS = [(0.5, 0.25, 2.0), (-3.0, 0.125, 0.0), (0.0, 0.0, 0.5), (1.5, 2.5, -7.0)]

    def answers(self, name, content, *options):
        return self.succeed("closest", "torus:9x5", "--out", "-", "--points", self.file(name, content), *options)

    def check_rows(self, rows, expected):
        """One by one: unittest takes minutes to show how two long lists differ."""
        self.assertEqual(len(rows), len(expected))
        for row, other in zip(rows, expected):
            self.assertEqual(row, other)

    def test_every_form_of_points_is_the_same(self):
        expected = self.answers("plain.csv", csv_text(self.POINTS))
        self.assertEqual(expected.count("\n"), 5)
        forms = {
            "header.csv": "x,y,z\n" + csv_text(self.POINTS),
            "mark.csv": "\ufeff\"X\", \"Y\", \"Z\"\r\n" + csv_text(self.POINTS).replace("\n", "\r\n"),
            "numpy.txt": "# x,y,z\n" + csv_text(self.POINTS),
            "spaces.csv": csv_text(self.POINTS).replace(",", " ,\t") + "\n \n",
            "cut.csv": csv_text(self.POINTS).rstrip("\n"),
            "double.npy": npy(self.POINTS),
            "single.npy": npy(self.POINTS, "<f4"),
            "columns.npy": npy(self.POINTS, columns_first=True),
            "newer.NPY": npy(self.POINTS, version=2),
            "half.npy": npy(self.POINTS, "<f2"),
            "big.npy": npy(self.POINTS, ">f8"),
            "big_half.npy": npy(self.POINTS, ">f2"),
            "deep.npy": npy(self.POINTS, shape=(4, 3, 1)),
            "array_without_a_name_of_its_kind": npy(self.POINTS),
            "semicolons.csv": csv_text(self.POINTS).replace(",", ";"),
            "tabs.tsv": "X\tY\tZ\n" + csv_text(self.POINTS).replace(",", "\t"),
            "savetxt.txt": "".join(" ".join("%.18e" % x for x in p) + "\n" for p in self.POINTS),
            "columns.txt": "# made by hand\n\n" + "".join("  %8.4f   %8.4f %8.4f\n" % p for p in self.POINTS) + "# end\n",
            "remarks.csv": "\n# points\n\n" + csv_text(self.POINTS).replace("\n", "  # one\n\n"),
            "pandas.csv": ",0,1,2\n" + "".join("%d,%r,%r,%r\n" % (i, *p) for i, p in enumerate(self.POINTS)),
            "pandas.tsv": "\tx\ty\tz\n" + "".join("%d\t%r\t%r\t%r\n" % (i, *p) for i, p in enumerate(self.POINTS)),
            "named_pandas.csv": ",x,y,z\n" + "".join("%d,%r,%r,%r\n" % (i, *p) for i, p in enumerate(self.POINTS)),
            "more.csv": "id,z,name,X,y\n" + "".join("p%d,%r,\"a, b\",%r,%r\n" % (i, p[2], p[0], p[1])
                                                   for i, p in enumerate(self.POINTS)),
            "commented.txt": "# z y x\n" + "".join("%r %r %r\n" % p[::-1] for p in self.POINTS),
            "comment_of_other_words.txt": "# x y z in metres\n" + csv_text(self.POINTS).replace(",", " "),
            "z_first.csv": "z;x;y\r\n" + "".join("%r;%r;%r\r\n" % (p[2], p[0], p[1]) for p in self.POINTS),
        }
        for name, content in forms.items():
            with self.subTest(name):
                self.assertEqual(self.answers(name, content), expected)

    def noted(self, content, *options):
        """Answers, and the note on stderr, if any."""
        result = run("closest", "torus:9x5", "--points", self.file("points.csv", content), *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertLessEqual(result.stderr.count("\n"), 1)
        return result.stdout, result.stderr

    def test_numbered_columns_are_a_header_where_all_other_numbers_are_floats(self):
        expected = self.answers("plain.csv", csv_text(self.POINTS))
        for before, after in (("0,1,2\n", ""), ("# points\n\n0,1,2\n", ""), ("0, 1, 2\n\n", "\n"), ("\ufeff0,1,2\r\n", "")):
            answers, note = self.noted(before + csv_text(self.POINTS) + after)
            self.assertEqual(answers, expected)
            self.assertIn(f"points.csv:{before.rstrip().count(chr(10)) + 1}: 0,1,2 was taken for a header", note)
        self.assertEqual(self.noted("0;1;2\n" + csv_text(self.POINTS).replace(",", ";"))[0], expected)
        self.assertEqual(self.noted("0,1,2\n1e1,-2.5E0,3.\n")[0], self.noted("10,-2.5,3\n")[0])
        self.assertEqual(self.noted("0,1,2\n" + csv_text(self.POINTS), "--quiet"), (expected, ""))
        many = [tuple(random.Random(i).uniform(-2, 2) for _ in range(3)) for i in range(30_000)]  # several pieces
        self.assertTrue(self.noted("0,1,2\n" + csv_text(many))[0] == self.answers("plain.csv", csv_text(many)))

    def test_names_that_begin_as_nan_or_inf_are_a_header(self):
        expected = self.answers("plain.csv", csv_text(self.POINTS))
        for name in ("nanoseconds", "info", "Infinity_norm", "-inf_"):
            text = f"{name},x,y,z\n" + "".join("7," + line + "\n" for line in csv_text(self.POINTS).splitlines())
            self.assertEqual(self.answers("named.csv", text), expected, name)

    def test_numbered_columns_are_a_row_where_others_have_whole_numbers(self):
        for rest in ("", "5,7,1\n", "0.5,0.25,2\n", "0.5,0.25,2.0\n-3,0.125,0.0\n", "0.5,0.25,2.0\n" * 20_000 + "0.5,+3,1.0\n"):
            answers, note = self.noted("0,1,2\n" + rest)
            self.assertTrue(answers == self.noted("0.0,1,2\n" + rest)[0])
            self.assertEqual(answers.count("\n"), 2 + rest.count("\n"))
            self.assertIn("points.csv:1: 0,1,2 was taken for a row", note)

    def test_other_tables_leave_no_doubt(self):
        rest = csv_text(self.POINTS)
        for content in ("0.0,1,2\n" + rest, "00,1,2\n" + rest, "1,2,3\n" + rest, rest + "0,1,2\n", "x,y,z\n0,1,2\n", "z,y,x\n2,1,0\n",
                        "# x,y,z\n0,1,2\n", "0,2,1\n" + rest):
            self.assertEqual(self.noted(content)[1], "", content)
        self.assertEqual(self.answers("points.npy", npy([(0, 1, 2), (0.5, 0.25, 2)])).count("\n"), 3)
        self.assertEqual(self.succeed("closest", "torus:9x5", "--point", "0,1,2", "--point", "0.5,0.25,2.5").count("\n"), 3)

    def test_a_shape_in_a_pipe_that_no_file_has_is_refused(self):
        for rows in (768614336404564650, 768614336404564651, 3074457345618258603):  # bytes or numbers of about 2^64
            result = subprocess.run([PROXIMA, "closest", "cube", "--points", "-"], capture_output=True, check=False,
                                    input=npy([(1, 2, 3)] * 20, shape=f"({rows}, 3)"))
            self.assertEqual((result.returncode, result.stderr),
                             (1, b"proxima: standard input: its shape is larger than any file\n"))

    def test_lines_below_numbered_columns_keep_their_numbers(self):
        good, bad = "0.0,0.0,5.0,0.0,0.0,1.0\n", "0.0,0.0,5.0,0.0,0.0,0.0\n"
        for text, line in ((good + bad, 3), ("\n" + bad, 3), (bad, 2), (good + "\n\n" + good + bad, 6), ("# x\n" + good + bad, 4)):
            path = self.file("rays.csv", "0,1,2,3,4,5\n" + text)
            self.refuse("raycast", "cube", "--rays", path, says=f"rays.csv:{line}:")

    def test_whole_numbers(self):
        points = [(0, 3, 7), (120, 0, 1), (5, 5, 5)]
        expected = self.answers("plain.csv", csv_text(points))
        for kind in ("|u1", "|i1", "<i2", ">i2", "<u2", "<i4", ">i4", "<i8", ">i8"):
            with self.subTest(kind):
                self.assertEqual(self.answers("points.npy", npy(points, kind)), expected)
        below = [(-1, 2, -128), (-7, -8, 9)]
        for kind in ("|i1", "<i2", ">i4", "<i8"):
            self.assertEqual(self.answers("points.npy", npy(below, kind)), self.answers("plain.csv", csv_text(below)))

    def test_halves_are_those_of_the_standard(self):
        # All sixteen bits but infinities and NaN, three by three: struct reads them another way.
        bits = [b for b in range(1 << 16) if b >> 10 & 31 != 31][:3 * 21000]
        halves = struct.unpack("<%de" % len(bits), struct.pack("<%dH" % len(bits), *bits))
        points = [halves[i:i + 3] for i in range(0, len(halves), 3)]
        self.assertEqual(self.answers("half.npy", npy(points, "<f2")), self.answers("double.npy", npy(points)))

    def test_a_single_row(self):
        for shape in ("(3,)", "(1, 3)", "(3, 1)"):
            with self.subTest(shape):
                self.assertEqual(self.answers("one.npy", npy(self.POINTS[:1], shape=shape)),
                                 self.answers("one.csv", csv_text(self.POINTS[:1])))

    def test_standard_input_and_pipes(self):
        text, array = csv_text(self.POINTS), npy(self.POINTS)
        expected = self.answers("plain.csv", text)
        for content in (text.encode(), array):
            given = subprocess.run([PROXIMA, "closest", "torus:9x5", "--points", "-"], input=content, timeout=300,
                                   stdout=subprocess.PIPE, env=environment_of_program())
            self.assertEqual(given.stdout.decode(), expected)
            pipe = self.folder / "pipe"
            os.mkfifo(pipe)
            writer = threading.Thread(target=lambda: pipe.write_bytes(content))
            writer.start()
            self.assertEqual(self.succeed("closest", "torus:9x5", "--points", pipe), expected)
            writer.join()
            pipe.unlink()

    def test_a_pipe_in_pieces(self):
        points = queries(random.Random(15), Mesh([(0.0, 0.0, 1.0)], []), 2000)
        for content in (csv_text(points).encode(), npy(points)):
            program = subprocess.Popen([PROXIMA, "closest", "torus:9x5", "--points", "-"], stdin=subprocess.PIPE,
                                       stdout=subprocess.PIPE, env=environment_of_program())
            def feed():
                for i in range(0, len(content), 1777):
                    program.stdin.write(content[i:i + 1777])
                    program.stdin.flush()
                program.stdin.close()
            writer = threading.Thread(target=feed)
            writer.start()
            answered = program.stdout.read().decode()
            writer.join()
            self.assertEqual(program.wait(), 0)
            program.stdout.close()
            self.assertEqual(answered, self.answers("whole.csv", csv_text(points)))

    def test_points_of_the_command_line(self):
        expected = self.answers("plain.csv", csv_text(self.POINTS))
        options = [part for p in self.POINTS for part in ("--point", ",".join(map(repr, p)))]
        self.assertEqual(self.succeed("closest", "torus:9x5", *options), expected)
        self.assertEqual(self.succeed("closest", "torus:9x5", "--quiet", *options), expected)
        self.assertEqual(self.json_of("closest", "torus:9x5", *options)["queries"], 4)

    def test_numbers_read_back(self):
        points = queries(random.Random(5), Mesh([(0.0, 0.0, 1.0)], []), 3000)
        model, file = "torus:9x5", self.file("points.csv", csv_text(points))
        for options in ((), ("--signed",)):
            table, numbers = self.folder / "a.csv", self.folder / "a.npy"
            self.succeed("closest", model, "--points", file, "--out", table, *options)
            self.succeed("closest", model, "--points", file, "--out", numbers, "--threads", 1, *options)
            with open(table, newline="") as opened:
                rows = list(csv.DictReader(opened))
            self.assertEqual(list(rows[0]), COLUMNS + (SIGNS if options else []))
            for row in rows:
                row["kind"] = KINDS.index(row["kind"])
                if options:
                    row["sign_method"] = METHODS.index(row["sign_method"])
            self.check_rows([tuple(map(float, row.values())) for row in rows], read_npy(numbers.read_bytes()))

    def test_rounds_and_threads_do_not_change_answers(self):
        rng = random.Random(6)
        points = [tuple(rng.uniform(-2, 2) for _ in range(3)) for _ in range(140_000)]
        file = self.file("points.npy", npy(points))
        outputs = [self.folder / name for name in ("one.npy", "three.npy", "tail.npy")]
        self.succeed("closest", "cube", "--points", file, "--out", outputs[0], "--threads", 1)
        self.succeed("closest", "cube", "--points", file, "--out", outputs[1], "--threads", 3)
        self.assertTrue(outputs[0].read_bytes() == outputs[1].read_bytes())
        tail = self.file("tail_points.npy", npy(points[-50:]))
        self.succeed("closest", "cube", "--points", tail, "--out", outputs[2])
        whole, part = read_npy(outputs[0].read_bytes()), read_npy(outputs[2].read_bytes())
        self.assertTrue([row[0] for row in whole] == list(range(len(points))))
        self.assertEqual([row[1:] for row in whole[-50:]], [row[1:] for row in part])

    def test_lists_change_no_answer(self):
        model = "torus:24x36"
        file = self.file("points.csv", csv_text(self.POINTS))
        without = self.json_of("closest", model, "--points", file)["bytes"]
        usual = self.json_of("index", model, "--lists")["bytes"]
        self.assertEqual(self.json_of("closest", model, "--points", file, "--lists")["bytes"], usual)
        tight = self.json_of("closest", model, "--points", file, "--lists", "--lists-mb", 1)["bytes"]
        self.assertLess(without, tight)
        self.assertLessEqual(tight, without + 1_000_000)
        texts = [self.succeed("closest", model, "--points", file, "--out", "-", *options)
                 for options in ((), ("--lists",))]
        self.assertEqual(texts[0], texts[1])

    def test_json_and_text(self):
        file = self.file("points.csv", csv_text(self.POINTS))
        result = self.json_of("closest", "cube", "--points", file)
        self.assertEqual(list(result), KEYS)
        self.assertEqual((result["model"], result["triangles"], result["queries"]), ("cube", 12, 4))
        self.assertAlmostEqual(result["ns_per_query"], 1e9 * result["seconds"] / 4)
        self.assertIsNone(result["load_seconds"])
        out = self.folder / "a.csv"
        text = self.succeed("closest", "cube", "--points", file, "--out", out, "--signed")
        for part in ("4 points", "closest: vertices", "inside 1;", f"wrote {out}"):
            self.assertIn(part, text)
        self.assertEqual(self.succeed("closest", "cube", "--points", file, "--quiet", "--out", out), "")
        self.assertIn("4 points", self.succeed("closest", "cube", "--points", file, "--json", self.folder / "a.json"))


class SavedOctrees(ProgramTest):
    """A .pxi in the place of the mesh."""

    def saved(self, mesh):
        model, octree = self.file("model.off", mesh.text()), self.folder / "model.pxi"
        self.succeed("proximity", model, "--lists-mb", 1, "--save", octree)
        return model, octree

    def test_answers_are_those_of_the_mesh(self):
        for seed, mesh in enumerate((bumpy_ball(random.Random(7)), soup(random.Random(8), 60))):
            model, octree = self.saved(mesh)
            points = self.file("points.csv", csv_text(queries(random.Random(seed), mesh, 300)))
            for options in ((), ("--signed",)):
                texts = [self.succeed("closest", one, "--points", points, "--out", "-", *options)
                         for one in (model, octree)]
                self.assertTrue(texts[0] == texts[1])

    def test_seeds_of_the_fuzzer_are_sound(self):
        """What it starts from reaches the queries: a seed of another layout would be refused at once."""
        points = self.file("points.csv", "1,2,3\n")
        for name, triangles in (("cube", 12), ("leaf", 8), ("torus", 96)):
            seed = Path(__file__).resolve().parents[2] / "fuzz" / "corpus" / "index" / (name + ".pxi")
            self.assertEqual(self.json_of("closest", seed, "--points", points, "--signed")["triangles"], triangles)

    def test_the_mesh_is_not_needed(self):
        model, octree = self.saved(bumpy_ball(random.Random(9)))
        model.unlink()
        points = self.file("points.csv", "1,2,3\n")
        result = self.json_of("closest", octree, "--points", points)
        self.assertEqual(list(result), KEYS)
        self.assertEqual((result["triangles"], result["build_seconds"]), (128, 0))
        self.assertGreater(result["load_seconds"], 0)
        self.assertIn("loaded in", self.succeed("closest", octree, "--points", points, "--out", self.folder / "a.csv"))

    def test_saved_signs_are_used(self):
        for seed, mesh in enumerate((bumpy_ball(random.Random(13)), soup(random.Random(14), 60))):
            model, index = self.file("model.off", mesh.text()), self.folder / "signs.pxi"
            plain = self.json_of("index", model)
            self.assertEqual(plain["bytes_per_triangle"]["signs"], 0)
            saved = self.json_of("index", model, "--signs", "--save", index)
            self.assertAlmostEqual(saved["bytes_per_triangle"]["signs"] * saved["triangles"],
                                   saved["bytes"] - plain["bytes"])
            points = self.file("points.csv", csv_text(queries(random.Random(seed), mesh, 300)))
            texts = [self.succeed("closest", one, "--points", points, "--out", "-", "--signed")
                     for one in (model, index)]
            self.assertTrue(texts[0] == texts[1])
            self.assertEqual(self.json_of("closest", index, "--points", points, "--signed")["build_seconds"], 0)
            self.assertGreater(self.json_of("closest", model, "--points", points, "--signed")["build_seconds"], 0)

    def test_checked(self):
        """By `proxima check`: alone, with its mesh, with another one, damaged."""
        model, octree = self.saved(bumpy_ball(random.Random(11)))
        alone = self.json_of("check", octree)
        self.assertEqual((alone["mesh"], alone["triangles"], alone["points"]), (None, 128, 3000))
        self.assertEqual(self.json_of("check", octree, "--mesh", model), {**alone, "mesh": str(model)})
        text = self.succeed("check", octree)
        self.assertIn("answers at 3000 points are those of all triangles", text)
        self.assertIn(f"128 triangles, {alone['bytes']} bytes\nlists: ", text)
        self.assertIn(f" bytes for {alone['leaves']} leaves", text)
        self.assertIn("slabs: none\nsigns: none\n", text)
        plain = self.folder / "plain.pxi"
        self.succeed("index", model, "--save", plain)
        self.assertIn("lists: none\n", self.succeed("check", plain))
        other = self.file("other.off", bumpy_ball(random.Random(12)).text())
        self.refuse("check", octree, "--mesh", other, says=("other.off", "another mesh"))
        data = octree.read_bytes()
        damaged = self.file("damaged.pxi", data[:5000] + bytes([data[5000] ^ 4]) + data[5001:])
        self.refuse("check", damaged, says="damaged.pxi")
        for size in ("1e160", "1e-160"):  # whose squares no double holds
            corners = f"0 0 0\n{size} 0 0\n0 {size} 0\n0 0 {size}"
            model = self.file("sized.off", f"OFF\n4 4 0\n{corners}\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
            self.succeed("index", model, "--save", plain)
            self.assertIn("answers at 3000 points are those of all", self.succeed("check", plain))

    def test_what_cannot_be(self):
        octree = self.saved(bumpy_ball(random.Random(10)))[1]
        points = self.file("points.csv", "1,2,3\n")
        for lists in (("--lists-mb", 1), ("--lists",)):
            self.refuse("closest", octree, "--points", points, *lists, status=2, says=lists[0])
            self.refuse("closest", "cube", "--points", points, "--method", "thesis", *lists, status=2, says=lists[0])
        data = octree.read_bytes()
        for name, content in (("cut.pxi", data[:-8]), ("text.pxi", b"v 1 2 3\n"), ("empty.pxi", b""),
                              ("flipped.pxi", data[:5000] + bytes([data[5000] ^ 4]) + data[5001:])):
            self.refuse("closest", self.file(name, content), "--points", points, says=name)
        self.refuse("closest", self.folder / "absent.pxi", "--points", points, says="absent.pxi")


class Refusing(ProgramTest):
    GOOD = "1,2,3\n"

    def refuse_points(self, name, content, says):
        out = self.folder / "answers.csv"
        self.refuse("closest", "cube", "--out", out, "--points", self.file(name, content), says=says)

    def test_lines(self):
        for content, line, says in (
                ("1,2\n", 1, ("2 numbers", "x,y,z")), ("1,2,3\n1,2,3,4\n", 2, "4 numbers"),
                ("x,y,z\n1,2,nan\n", 2, ("column 3", "finite")), ("nan,1,2\n", 1, "finite"), ("1,-inf,2", 1, "finite"),
                ("1,2,1e999\n", 1, "finite"), ("1,2,3\n1,,3\n", 2, "missing"), ("1,2,3,\n", 1, "4 numbers"),
                ("1,5;2,5;3,5\n", 1, ("1,5 is no number", "point")), ("1,2,3\n1,b,3\n", 2, "b is no number"),
                ("1 2 3\n1,2,3\n", 2, "1,2,3 is no number"), ("1,2,3\n4 5 6\n", 2, "4 5 6 is no number"),
                ("1,2,0x10\n", 1, "no number"), ("a,b,c\n1,2,3\n", 1, ("named x", "a,b,c", "x,y,z")),
                ("1,2,3\nx,y,z\n", 2, "no number"), ("x,y,z,x\n1,2,3,4\n", 1, "2 columns are named x"),
                ("id,x,y,z\n1,2,3,4\n1,2,3\n", 3, ("3 numbers", "header names 4")),
                (",0,1\n0,1,2\n", 1, "2 numbers"), ("\n\n# x\n1,2,3\n\n1,2\n", 6, "2 numbers")):
            with self.subTest(content):
                says = (says,) if isinstance(says, str) else says
                self.refuse_points("points.csv", content, (f"points.csv:{line}:", *says))

    def test_files_without_points(self):
        self.refuse_points("empty.csv", "", ("empty.csv", "empty"))
        self.refuse_points("header.csv", "x,y,z\n", ("header.csv", "no row"))
        self.refuse_points("none.npy", npy([]), ("none.npy", "no row"))
        self.refuse("closest", "cube", "--points", self.folder / "absent.csv", says=("absent.csv", "No such file"))
        self.refuse("closest", "cube", "--points", self.folder, says="folder")
        self.refuse("closest", "cube", "--points", "/dev/null", says=("/dev/null", "empty"))
        self.refuse("closest", "cube", "--points", "/dev/zero", says=("/dev/zero:1:", "longer"))
        self.refuse_points("remarks.csv", "# only\n\n# remarks\n", ("remarks.csv", "no row"))
        self.refuse("closest", "cube", "--points", "-", input="1,2\n", says="standard input:1:")
        for text, says in (("1,2", "2 numbers"), ("a,b,c", "a is no number"), (" ", "no row"), ("1,2,inf", "finite")):
            self.refuse("closest", "cube", "--point", text, says=("--point", says))
        self.refuse_points("long.csv", "1" * 3_000_000, ("long.csv:1:", "longer"))

    def test_arrays(self):
        points = [(1.0, 2.0, 3.0), (4.0, 5.0, 6.0)]
        good = npy(points)
        for name, content, says in (
                ("cut.npy", good[:-1], "47 bytes follow"), ("more.npy", good + b"0", "49 bytes follow"),
                ("huge.npy", npy(points, shape=(1 << 62, 3)), "larger than any file"),
                ("four.npy", npy(points, shape=(2, 4)), "4 columns"), ("flat.npy", npy(points, shape="(6,)"), "6 columns"),
                ("deep.npy", npy(points, shape=(1, 1, 1, 2, 3)), "5 dimensions"), ("none.npy", npy(points, shape="()"), "0 dim"),
                ("long.npy", npy(points).replace(b"<f8", b"<f9"), "<f9"), ("complex.npy", npy(points).replace(b"<f8", b"<c8"), "<c8"),
                ("vast.npy", npy(points, shape=(1 << 40, 1 << 30)), "shape"), ("nan.npy", npy([points[0], (1, math.nan, 2)]), "row 1 "),
                ("turned.npy", npy([points[0], (1, 2, math.inf)], columns_first=True), "row 1 "),
                ("text.npy", self.GOOD, "numpy.save"), ("header.npy", good[:40], "numpy.save"),
                ("records.npy", good.replace(b"'<f8'", b"[3,4]"), "records"),
                ("noise.npy", good[:12] + b"?" * 40, "numpy.save"), ("short.npy", good[:7], "numpy.save")):
            with self.subTest(name):
                self.refuse_points(name, content, (name, says))

    def test_models(self):
        points = self.file("points.csv", self.GOOD)
        def refuse(name, content, says):
            self.refuse("closest", self.file(name, content), "--points", points, says=(name, says))
        refuse("empty.off", "OFF\n0 0 0\n", "triangle")
        refuse("nan.off", "OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", "finite")
        self.refuse("closest", self.folder / "absent.obj", "--points", points, says="absent.obj")

    def test_models_of_points_and_segments_have_answers(self):
        # A triangle that is a segment, and ten that are one point.
        corners = [(0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (2.0, 2.0, 2.0), (5.0, 5.0, 5.0)]
        model = self.file("flat.off", off(corners, [(0, 1, 2)] + 10 * [(3, 3, 3)]))
        points = self.file("points.csv", "3,0,0\n-1,0,0\n9,5,5\n")
        rows = list(csv.DictReader(io.StringIO(self.succeed("closest", model, "--points", points, "--out", "-"))))
        for row, expected in zip(rows, (math.sqrt(6), 1.0, 4.0)):
            self.assertAlmostEqual(float(row["distance"]), expected)

    def test_outputs(self):
        points = self.file("points.csv", self.GOOD)
        def refuse(*options, says):
            self.refuse("closest", "cube", "--points", points, *options, says=says)
        refuse("--out", self.folder / "a.txt", says=("a.txt", ".npy"))
        refuse("--out", self.folder / "none" / "a.csv", says="a.csv")
        refuse("--out", "-", "--json", "-", says="stdout")
        refuse("--out", self.folder / "a.csv", "--json", self.folder / "a.csv", says="a.csv")
        with open("/dev/full", "w") as full:
            result = run("closest", "cube", "--points", points, "--out", "-", stdout=full)
        self.assertEqual(result.returncode, 1)
        self.assertIn("standard output", result.stderr)

    def test_usage(self):
        self.refuse("closest", "cube", status=2, says="--points")
        self.refuse("closest", "--points", self.file("points.csv", self.GOOD), status=2, says="MODEL")


if __name__ == "__main__":
    unittest.main()
