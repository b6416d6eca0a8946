"""What the command line does when all is well."""
import json
import math
import os
import pathlib
import pty
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib

import mesh_files
from bad_input_test import off
from proxima_program import PROXIMA, ProgramTest, environment_of_program, has_signal, run
from scene_test import cube

OCTREE_KEYS = ["model", "triangles", "depth", "threshold", "method", "total", "leaves",
               "occupied_percent", "min_triangles", "max_triangles", "references", "mean_triangles",
               "std_triangles", "mean_all_leaves", "std_all_leaves", "inner", "outer", "boundary",
               "bytes", "seconds"]
METHODS = ["fast", "separating-axis", "index-tracking", "minkowski", "pairwise"]


def without_seconds(result):
    return {key: value for key, value in result.items() if key != "seconds"}


class Octree(ProgramTest):
    def test_json_has_the_documented_keys_in_order(self):
        result = self.json_of("octree", "cube", "--depth", 3)
        self.assertEqual(list(result), OCTREE_KEYS)
        self.assertEqual((result["model"], result["triangles"], result["depth"], result["threshold"],
                          result["method"]), ("cube", 12, 3, 1, "fast"))
        self.assertEqual(result["boundary"] + result["inner"] + result["outer"], result["leaves"])

    def test_counts_of_the_thesis_sphere(self):
        expected = {1: (9, 8, 22392, 2799, 2799), 3: (521, 456, 28208, 9, 570),
                    5: (11977, 10480, 54344, 1, 198)}
        for depth, counts in expected.items():
            result = self.json_of("octree", "sphere:100x100", "--depth", depth, "--exact")
            self.assertEqual(tuple(result[key] for key in ("total", "leaves", "references",
                                                           "min_triangles", "max_triangles")), counts)

    def test_all_methods_give_one_octree_when_exact(self):
        results = [self.json_of("octree", "torus:24x12", "--depth", 4, "--exact", "--method", method)
                   for method in METHODS]
        for method, result in zip(METHODS, results):
            self.assertEqual(result.pop("method"), method)
            result.pop("seconds")
            self.assertEqual(result, results[0])

    def test_uniform_subdivision_splits_every_cell(self):
        result = self.json_of("octree", "cube", "--depth", 3, "--uniform")
        self.assertEqual((result["total"], result["leaves"]), (585, 512))

    def test_two_passes_end_with_the_longest_list_as_threshold(self):
        first = self.json_of("octree", "spaceship:4000", "--depth", 4)
        second = self.json_of("octree", "spaceship:4000", "--depth", 4, "--two-pass")
        self.assertEqual(second["threshold"], first["max_triangles"])
        self.assertLessEqual(second["max_triangles"], first["max_triangles"])
        self.assertLess(second["total"], first["total"])

    def test_box_roots_fit_tighter(self):
        cube = self.json_of("octree", "spaceship:4000", "--depth", 3, "--uniform")
        box = self.json_of("octree", "spaceship:4000", "--depth", 3, "--uniform", "--root", "box")
        self.assertGreater(box["occupied_percent"], cube["occupied_percent"])

    def test_threads_do_not_change_the_result(self):
        results = [without_seconds(self.json_of("octree", "spaceship:4000", "--depth", 6,
                                                "--threads", threads)) for threads in (1, 2, 3)]
        self.assertEqual(results[0], results[1])
        self.assertEqual(results[0], results[2])

    def test_json_to_a_file_beside_text_for_people(self):
        path = self.folder / "result.json"
        text = self.succeed("octree", "cube", "--json", path)
        self.assertIn("Pointers", text)
        self.assertEqual(list(json.loads(path.read_text())), OCTREE_KEYS)

    def test_typing_errors_get_a_suggestion(self):
        for arguments, meant in ((("octre", "cube"), "octree"), (("raycats", "cube"), "raycast"), (("min", "cube"), "minkowski"),
                                 (("octree", "cube", "--dept", 3), "--depth"), (("octree", "cube", "--detph=3"), "--depth"),
                                 (("octree", "cube", "--thresh", 3), "--threshold")):
            self.refuse(*arguments, status=2, says=f"did you mean {meant}?")
        for model, meant in (("spher:10x10", "sphere:10x10"), ("cub", "cube"), ("icospere:2", "icosphere:2")):
            self.refuse("octree", model, says=(model, f"did you mean the built-in {meant}?"))
        for arguments, status in ((("octree", "absent.obj"), 1), (("octree", "cube", "--wholly-other"), 2), (("zzz",), 2)):
            self.assertNotIn("did you mean", self.refuse(*arguments, status=status))

    def test_progress_in_a_pipe(self):
        result = run("index", "icosphere:5", "--lists", "--quiet", "--progress")
        self.assertEqual((result.returncode, result.stdout), (0, ""))
        lines = result.stderr.splitlines()
        self.assertTrue(lines)
        for line in lines:
            self.assertRegex(line, r"^proxima: [a-z -]+, \d+ %$")

    def test_the_page_of_options_is_that_of_the_program(self):
        root = pathlib.Path(__file__).resolve().parents[2]
        made = subprocess.run([sys.executable, root / "scripts/option_table.py", PROXIMA], check=True, capture_output=True,
                              text=True, env=environment_of_program()).stdout
        self.assertEqual((root / "docs/options.md").read_text(), made, "run scripts/option_table.py PROGRAM > docs/options.md")

    def test_the_manual_and_the_completion_have_all_commands_and_options(self):
        root = pathlib.Path(__file__).resolve().parents[2]
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-B", root / "scripts/manual.py", PROXIMA, folder], check=True, env=environment_of_program())
            pages = {path.stem: path.read_text() for path in pathlib.Path(folder).glob("*.1")}
            rows = [re.split(r"(?<!\\)\|", line) for line in (root / "docs/options.md").read_text().splitlines() if line.startswith("| `-")]
            commands = {name.removeprefix("proxima-") for name in pages} - {"proxima"}
            self.assertGreater(len(commands), 14)
            for _, name, _, users, *_ in rows:
                for command in commands if users.strip() == "all" else users.strip().split(", "):
                    self.assertIn("\\fB" + name.strip(" `").replace("-", "\\-") + "\\fR", pages[f"proxima-{command}"])
            for command in commands:
                self.assertIn("proxima-" + command + "(1)", pages["proxima"].replace("\\-", "-"))
            if shutil.which("groff"):
                said = subprocess.run(["groff", "-man", "-Tutf8", "-ww", *pathlib.Path(folder).glob("*.1")], check=True,
                                      capture_output=True, text=True).stderr
                self.assertEqual(said, "")

            def completed(*words):
                code = f'source {folder}/proxima.bash; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _proxima; echo "${{COMPREPLY[@]}}"'
                return subprocess.run(["bash", "-c", code, "bash", *words], check=True, capture_output=True, text=True).stdout.split()

            self.assertEqual(completed("proxima", "oc"), ["octree"])
            self.assertEqual(completed("proxima", "touch", "cube", "--gu"), ["--guard"])
            self.assertEqual(completed("proxima", "touch", "cube", "--guard", ""), ["off", "observe", "on"])
            self.assertEqual(completed("proxima", "cull", "--guard", ""), [])  # files
            for _, name, _, users, *_ in rows:
                for text in ((pathlib.Path(folder) / "_proxima").read_text(), (pathlib.Path(folder) / "proxima.fish").read_text()):
                    self.assertRegex(text, f"{name.strip(' `').removeprefix('--')}[^a-z-]")
            if shutil.which("zsh"):
                subprocess.run(["zsh", "-n", pathlib.Path(folder) / "_proxima"], check=True)
            if shutil.which("fish"):
                for line, word in (("proxima oc", "octree"), ("proxima touch cube --gu", "--guard"), ("proxima touch cube --guard ob", "observe")):
                    found = subprocess.run(["fish", "-c", f"source {folder}/proxima.fish; complete -C '{line}'"], check=True,
                                           capture_output=True, text=True).stdout
                    self.assertEqual([row.split("\t")[0] for row in found.splitlines()], [word])

    def test_a_threshold_that_makes_a_build_large_is_told(self):
        words = "--threshold 1 splits round edges"
        text = self.succeed("octree", "torus:40x20", "--depth", 11)
        self.assertIn(words, text)
        told = float(text.split(": some ")[1].split(" million")[0])
        leaves = self.json_of("octree", "torus:40x20", "--depth", 11)["leaves"]
        self.assertTrue(0.5 < told / (1e-6 * leaves) < 2, (told, leaves))
        for options in (("--depth", 11, "--threshold", 8), ("--depth", 7)):
            self.assertNotIn(words, self.succeed("octree", "torus:40x20", *options))

    def test_quiet_prints_nothing(self):
        self.assertEqual(self.succeed("octree", "cube", "--quiet"), "")

    def test_writes_its_own_format_and_every_export(self):
        names = ["a.pxo", "a.vtu", "a.htg", "a.glb", "a.ply"]
        arguments = ["--save", self.folder / "a.pxo"]
        for name in names[1:]:
            arguments += ["--out", self.folder / name]
        self.succeed("octree", "icosphere:2", "--depth", 4, *arguments)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), sorted(names))
        begins = {"a.vtu": b"<", "a.htg": b"<", "a.glb": b"glTF", "a.ply": b"ply"}
        for name, begin in begins.items():
            self.assertTrue((self.folder / name).read_bytes().startswith(begin), name)

    def test_picture_is_a_valid_png_with_something_in_it(self):
        path = self.folder / "a.png"
        self.succeed("octree", "icosphere:2", "--depth", 4, "--picture", path)
        data = path.read_bytes()
        self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">II", data[16:24]), (1280, 960))
        pixels, position = b"", 8
        while position < len(data):
            length, kind = struct.unpack(">I4s", data[position:position + 8])
            content = data[position + 8:position + 8 + length]
            self.assertEqual(zlib.crc32(kind + content),
                             struct.unpack(">I", data[position + 8 + length:position + 12 + length])[0])
            pixels += content if kind == b"IDAT" else b""
            position += 12 + length
        rows = zlib.decompress(pixels)
        self.assertEqual(len(rows), 960 * (1 + 3 * 1280))
        self.assertGreater(len(set(rows)), 100)

    def test_no_output_goes_where_the_report_on_stdout_goes(self):
        out = self.folder / "o.txt"
        for path in ("/dev/stdout", out):
            with open(out, "wb") as file:
                result = run("octree", "cube", "--json", path, stdout=file)
            self.assertEqual(result.returncode, 1)
            self.assertIn("stdout goes there", result.stderr)
        result = run("octree", "cube", "--json", "/dev/stdout", "--quiet")
        self.assertEqual(json.loads(result.stdout)["triangles"], 12)

    def test_no_output_goes_where_other_results_on_stdout_go(self):
        out, points = self.folder / "o.csv", ("closest", "cube", "--point", "2,2,2")
        for arguments in ((*points, "--out", out, "--json", "-"), (*points, "--json", out, "--out", "-"),
                          ("intersect", "cube", "cube", "--out", "-", "--pairs", out),
                          ("cull", "cube", "--plane", "1,0,0,0", "--out", "-", "--json", out),
                          ("closest", "octahedron", "--method", "thesis", "--point", "2,2,2", "--out", "-", "--json", out)):
            for quiet in ((), ("--quiet",)):
                with self.subTest(arguments + quiet):
                    with open(out, "wb") as file:
                        result = run(*arguments, *quiet, stdout=file)
                    self.assertEqual(result.returncode, 1)
                    self.assertIn("stdout goes there, and so does other output: name another file", result.stderr)
                    self.assertEqual(out.read_bytes(), b"")
        with open(out, "wb") as file:
            self.assertEqual(run(*points, "--out", out, "--quiet", stdout=file).returncode, 0)
        self.assertEqual(len(out.read_text().splitlines()), 2)

    def test_a_name_that_is_too_long_is_refused_before_the_work(self):
        self.succeed("octree", "cube", "--save", self.folder / ("a" * 251 + ".pxo"))
        long = self.folder / ("a" * 252 + ".pxo")
        self.refuse("octree", "spaceship:33000", "--depth", 12, "--save", long, says="shorter name")

    def test_an_output_replaces_the_old_file(self):
        path = self.file("a.pxo", "old")
        self.succeed("octree", "cube", "--save", path)
        self.assertNotEqual(path.read_bytes(), b"old")


class Compare(ProgramTest):
    def test_json_has_a_row_for_each_depth_and_method(self):
        result = self.json_of("compare", "torus:12x6", "--depths", "1-3", "--exact")
        self.assertEqual(list(result), ["model", "triangles", "rows"])
        self.assertEqual([(row["depth"], row["method"]) for row in result["rows"]],
                         [(depth, method) for depth in (1, 2, 3) for method in METHODS])
        for row in result["rows"]:
            self.assertEqual(list(row), ["depth", "method", "total", "references", "seconds",
                                         "ratio_to_separating_axis"])
            self.assertGreater(row["seconds"], 0)
            if row["method"] == "separating-axis":
                self.assertEqual(row["ratio_to_separating_axis"], 1)
        self.assertEqual(len({(row["depth"], row["total"], row["references"])
                              for row in result["rows"]}), 3)

    def test_ratio_is_null_without_separating_axes(self):
        result = self.json_of("compare", "cube", "--depths", "2", "--methods", "fast,pairwise")
        self.assertEqual([row["ratio_to_separating_axis"] for row in result["rows"]], [None, None])

    def test_says_how_it_measured(self):
        self.assertIn("1 thread, medians of up to 3 interleaved runs",
                      self.succeed("compare", "cube", "--depths", "1"))
        self.assertIn("2 threads, medians of up to 5 interleaved runs",
                      self.succeed("compare", "cube", "--depths", "1", "--threads", 2, "--repeats", 5))

    def test_says_that_all_methods_agree(self):
        self.assertIn("All methods gave the same octree",
                      self.succeed("compare", "cube", "--depths", "2,4", "--exact"))


class Tables(ProgramTest):
    def test_table_2_1_has_the_structure_of_the_thesis(self):
        result = self.json_of("tables", "--only", "2.1")
        table, = result["tables"]
        self.assertEqual(list(table), ["table", "title", "rows", "notes"])
        for row in table["rows"]:
            for key in ("total", "leaves"):
                self.assertEqual(row[key]["proxima"], row[key]["thesis"])
        self.assertEqual([row["references"]["proxima"] for row in table["rows"]],
                         [22392, 24280, 28208, 36360, 54344])
        self.assertEqual([(row["min_triangles"]["proxima"], row["max_triangles"]["proxima"])
                          for row in table["rows"]],
                         [(2799, 2799), (78, 1101), (9, 570), (3, 315), (1, 198)])

    def test_table_2_2_has_the_totals_that_rounding_leaves_alone(self):
        table, = self.json_of("tables", "--only", "2.2")["tables"]
        totals = {row["threshold"]: row["total"]["proxima"] for row in table["rows"]}
        self.assertEqual([totals[threshold] for threshold in (1, 50, 150, 200)], [11977, 3017, 777, 713])

    def test_table_2_3_says_what_is_absent(self):
        table, = self.json_of("tables", "--only", "2.3", "--meshes", self.folder)["tables"]
        self.assertEqual(table["rows"], [])
        for model in ("Bunny", "Buddha", "Dragon"):
            self.assertTrue(any(model in note and "absent" in note for note in table["notes"]), model)

    def test_rows_of_table_2_3(self):
        # Any mesh under the model's name will do; that it is another one is said.
        (self.folder / "bun_zipper_res2.ply").write_bytes(mesh_files.PLAIN["ascii.ply"])
        table, = self.json_of("tables", "--only", "2.3", "--meshes", self.folder)["tables"]
        self.assertTrue(any("4 triangles here and 16301 in the thesis" in note for note in table["notes"]))
        self.assertEqual([(row["model"], row["passes"]) for row in table["rows"]], [("Bunny", 1), ("Bunny", 2)])
        both = ["threshold", "total", "leaves", "occupied_percent", "mean_all_leaves", "std_all_leaves"]
        for row in table["rows"]:
            self.assertEqual(list(row), ["model", "triangles", "passes", "thesis", "cube", "box"])
            self.assertEqual(row["triangles"], 4)
            self.assertEqual(list(row["thesis"]), both)
            for root in ("cube", "box"):
                self.assertEqual(list(row[root]), both + ["mean_triangles", "std_triangles"])
                self.assertGreaterEqual(row[root]["total"], row[root]["leaves"])
                self.assertGreaterEqual(row[root]["mean_triangles"], row[root]["mean_all_leaves"])
        first, second = table["rows"]
        self.assertEqual(first["cube"]["threshold"], 1)
        self.assertGreater(second["cube"]["threshold"], 1)
        self.assertLess(second["cube"]["total"], first["cube"]["total"])

    def test_table_2_3_says_that_no_folder_is_known(self):
        # A copy outside of any checkout, as if installed.
        copy = shutil.copy2(PROXIMA, self.folder / "proxima")
        result = subprocess.run([copy, "tables", "--only", "2.3", "--json", "-"], cwd=self.folder,
                                stdout=subprocess.PIPE, check=True)
        table, = json.loads(result.stdout)["tables"]
        self.assertEqual(table["rows"], [])
        note, = (note for note in table["notes"] if note.startswith("Bunny is absent: "))
        for words in ("no folder is known that may hold bun_zipper_res2.ply", "bunny.tar.gz",
                      "https://graphics.stanford.edu/data/3Dscanrep", "--meshes DIR"):
            self.assertIn(words, note)

    def test_rows_of_table_3_2(self):
        table, = self.json_of("tables", "--only", "3.2")["tables"]
        counts = ["dot_products", "cross_products", "flops", "additions", "subtractions",
                  "multiplications", "divisions", "negations", "comparisons"]
        self.assertGreaterEqual(len(table["rows"]), 5)
        for row in table["rows"]:
            self.assertEqual(list(row), ["method", *counts])
            number = {key: value["proxima"] if isinstance(value, dict) else value
                      for key, value in row.items() if key in counts}
            self.assertEqual(number["flops"], number["additions"] + number["subtractions"] +
                             number["multiplications"] + number["divisions"], row["method"])

    def test_rows_of_table_3_3(self):
        table, = self.json_of("tables", "--only", "3.3")["tables"]
        self.assertEqual([(row["depth"], row["method"]) for row in table["rows"]],
                         [(depth, method) for depth in range(1, 6) for method in METHODS])
        for row in table["rows"]:
            self.assertEqual(list(row), ["depth", "method", "seconds", "ratio_to_separating_axis"])
            ours = row["seconds"]["proxima"] if isinstance(row["seconds"], dict) else row["seconds"]
            self.assertGreater(ours, 0)

    def test_text_shows_both_values_and_a_reason(self):
        text = self.succeed("tables", "--only", "2.1")
        for part in ("22392", "22476", "thesis", "rounding"):
            self.assertIn(part, text)


class Check(ProgramTest):
    def test_a_closed_mesh_has_no_findings(self):
        result = self.json_of("check", "octahedron")
        self.assertEqual(list(result), [
            "model", "vertices", "triangles", "edges", "components", "boundary_loops", "bounds", "area",
            "min_edge_length", "max_edge_length", "closed", "consistently_oriented", "closed_if_welded",
            "orientation", "signed_volume", "euler_characteristic", "genus", "self_intersections", "findings",
            "outlook"])
        self.assertEqual((result["vertices"], result["edges"], result["triangles"]), (6, 12, 8))
        self.assertEqual((result["closed"], result["genus"], result["findings"]), (True, 0, []))
        self.assertEqual(result["self_intersections"], {"pairs": 0, "complete": True, "first_pairs": []})
        self.assertIn("nothing is wrong", self.succeed("check", "octahedron"))

    def test_a_box_has_the_measures_of_a_box(self):
        points, faces = cube()
        model = self.file("box.off", off([(x, 2 * y, 3 * z) for x, y, z in points], faces))
        result = self.json_of("check", model)
        self.assertEqual((result["vertices"], result["edges"], result["triangles"]), (8, 18, 12))
        self.assertEqual(result["bounds"], {"lower": [0, 0, 0], "upper": [1, 2, 3]})
        self.assertEqual((result["euler_characteristic"], result["genus"], result["orientation"]), (2, 0, "outward"))
        for name, expected in (("min_edge_length", 1), ("max_edge_length", math.sqrt(13)), ("area", 22), ("signed_volume", 6)):
            self.assertAlmostEqual(result[name], expected, 12, name)
        text = self.succeed("check", model)
        self.assertIn("from (0, 0, 0) to (1, 2, 3), area 22, edges 1 to 3.61 long\n", text)
        self.assertIn(", outward, volume 6, genus 0, Euler characteristic 2\n", text)

    def test_a_ring_has_a_hole(self):
        result = self.json_of("check", "torus:12x6")
        self.assertEqual((result["euler_characteristic"], result["genus"]), (0, 1))
        self.assertIn(", genus 1, Euler characteristic 0\n", self.succeed("check", "torus:12x6"))

    def test_triangles_that_intersect_are_counted_and_named(self):
        # Two crossing ones, one that shares an edge with the first, and one beside.
        path = self.file("cross.off", "OFF\n10 4 0\n0 0 0\n4 0 0\n0 4 0\n1 1 -1\n1 1 1\n3 3 1\n0 -4 0\n"
                                      "9 9 9\n8 9 9\n9 8 9\n3 0 1 2\n3 3 4 5\n3 1 0 6\n3 7 8 9\n")
        found = self.json_of("check", path)["self_intersections"]
        self.assertEqual(found, {"pairs": 1, "complete": True, "first_pairs": [[0, 1]]})
        self.assertIn("1 pair of triangles intersect", self.succeed("check", path))

    def test_signs_want_care_where_a_closed_surface_passes_through_itself(self):
        corners = ["0 0 0", "4 0 0", "0 4 0", "0 0 4"]
        faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]

        def tetrahedra(name, offset):
            moved = [" ".join(str(float(c) + offset) for c in corner.split()) for corner in corners]
            lines = ["3 %d %d %d" % face for face in faces] + ["3 %d %d %d" % tuple(i + 4 for i in face) for face in faces]
            path = self.file(name, "\n".join(["OFF", "8 8 0", *corners, *moved, *lines, ""]))
            result = self.json_of("check", path)
            self.assertTrue(result["closed"])
            sign, = [query for query in result["outlook"] if query["query"] == "sign"]
            return result["self_intersections"]["pairs"], sign["outlook"], sign["reason"]

        pairs, outlook, reason = tetrahedra("overlap.off", 0.5)
        self.assertGreater(pairs, 0)
        self.assertEqual(outlook, "with_care")
        self.assertIn("winding numbers decide", reason)
        self.assertEqual(tetrahedra("apart.off", 9)[:2], (0, "works"))

    def test_a_hole_is_found_and_said(self):
        path = self.file("open.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        result = self.json_of("check", path)
        finding, = [finding for finding in result["findings"] if finding["kind"] == "boundary_edges"]
        self.assertEqual(finding["count"], 3)
        self.assertEqual(list(finding), ["kind", "severity", "element", "count", "first_ids",
                                         "first_positions", "meaning"])
        self.assertIn("3 boundary edges", self.succeed("check", path))

    def test_people_read_words(self):
        one = "OFF\n%d 1 0\n0 0 0\n1 0 0\n0 1 0\n" + "5 5 5\n%s3 0 1 2\n"
        self.assertIn("1 unreferenced vertex\n",
                      self.succeed("check", self.file("one.off", one % (4, ""))))
        self.assertIn("2 unreferenced vertices\n",
                      self.succeed("check", self.file("two.off", one % (5, "6 6 6\n"))))
        path = self.file("none.off", "OFF\n1 0 0\n0 0 0\n")
        self.assertEqual({query["reason"] for query in self.json_of("check", path, "--quiet")["outlook"]},
                         {"no triangles"})

    def test_infinity_is_null(self):
        path = self.file("nan.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n")
        result = self.json_of("check", path)
        self.assertIsNone(result["findings"][0]["first_positions"][0][1])
        self.assertIsNone(result["self_intersections"])


class Parser(ProgramTest):
    def test_help_and_version(self):
        self.assertIn("octree", self.succeed("--help"))
        self.assertIn("--threshold", self.succeed("octree", "--help"))
        self.assertEqual(self.succeed("help", "octree"), self.succeed("octree", "--help"))
        self.assertEqual(self.succeed("help"), self.succeed("--help"))
        self.assertEqual(self.succeed("help", "help"), self.succeed("--help"))
        self.assertIn("proxima help SUBCOMMAND", self.succeed("--help"))
        self.refuse("help", "octre", status=2, says=("octre is no command", "did you mean octree?"))
        self.assertRegex(self.succeed("--version"), r"^\d+\.\d+\.\d+\ninstruction sets here, the best first:( \w+)+\n$")

    def test_every_instruction_set_gives_the_same_results(self):
        names = self.succeed("--version").split(":")[1].split()
        points = self.file("points.csv", "".join(f"{x},0.3,0.7\n" for x in range(-3, 4)))
        def answers(*options):
            return self.succeed("closest", "sphere:20x20", "--points", points, "--out", "-", *options)
        for name in names:
            self.assertEqual(answers("--simd", name), answers())
        self.assertEqual(answers("--simd", names[-1].lower()), answers())
        self.refuse("closest", "sphere:20x20", "--points", points, "--simd", "AVX9",
                    says="--simd (or PROXIMA_SIMD): no instruction set AVX9: this machine has " + ", ".join(names))

    def test_wrong_usage_has_status_2(self):
        self.refuse(status=2, says="subcommand")
        self.refuse("octre", status=2, says="octre")
        self.refuse("octree", status=2, says="MODEL")
        self.refuse("octree", "cube", "--dept", 3, status=2, says=("--dept", "--help"))
        self.refuse("octree", "cube", "--method", "quick", status=2, says=("quick", "index-tracking"))
        self.refuse("octree", "cube", "--root", "ball", status=2,
                    says=("--root", "ball", "cube, box"))
        self.refuse("compare", "cube", "--depths", "5-1", status=2, says=("5-1", "list of depths"))
        self.refuse("compare", "cube", "--methods", "fast,,pairwise", status=2, says="--methods")
        self.refuse("tables", "--only", "9.9", status=2, says=("9.9", "2.1"))
        self.refuse("octree", "cube", "--threads", -1, status=2, says=("--threads", "range"))
        for number in ("1.5", "1e2", "nan", "inf"):
            self.refuse("octree", "cube", "--threads", number, status=2, says=f"--threads: {number} is no whole number")
        for option, value in (("--size", "10x10"), ("--view", "top"), ("--eye", "9,9,9"), ("--target", "0,0,0"), ("--up", "x"), ("--fov", 20)):
            self.refuse("octree", "cube", option, value, status=2, says=f"{option} requires --picture")


class Controls(ProgramTest):
    def test_json_says_what_the_text_says(self):
        for panel, *settings in (("octree", "--set", "depth=7", "--set", "cut plane=on"), ("touch",)):
            asked = ("view", "--panel", panel, *settings, "--controls")
            result = self.json_of(*asked)
            self.assertEqual((list(result), result["panel"]), (["panel", "controls"], panel))
            self.assertGreater(len(result["controls"]), 5)
            lines = [control["name"] + ("" if control["value"] is None else f" = {control['value']}") + f" ({control['values']})" +
                     (f", needs {control['needs']}" if control["needs"] else "") for control in result["controls"]]
            self.assertEqual(self.succeed(*asked).splitlines(), lines)


class Views(ProgramTest):
    def test_points_and_lines_are_shown_where_asked_for(self):
        model = self.file("lines.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nl 1 4\np 2\n")
        self.assertEqual(self.json_of("view", model, "--out", self.folder / "a.glb")["facts"]["triangles"], "1")
        two = self.json_of("view", model, "cube", "--out", self.folder / "b.glb")
        self.assertEqual(two["facts"]["triangles"], ["1", "12"], "of each model")
        with_lines = self.json_of("view", model, "--points-and-lines", "--out", self.folder / "a.glb")
        self.assertEqual(with_lines["facts"]["triangles"], "3")
        alone = self.file("alone.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n")
        for command in (("octree",), ("check",), ("view", "--picture", self.folder / "a.png")):
            with self.subTest(command):
                done = run(*command, alone)
                self.assertRegex(done.stderr, "^proxima: .*no triangles.*--points-and-lines reads points and lines\n$")
        self.assertEqual(self.succeed("octree", alone, "--points-and-lines").count("1 triangles"), 1)
        self.refuse("view", "spher:10x10", "--picture", self.folder / "a.png", says="did you mean the built-in sphere:10x10?")
        nothing = self.file("nothing.off", "OFF\n0 0 0\n")
        for command in (("intersect",), ("deviation",), ("contacts",), ("view", "--picture", self.folder / "a.png")):
            with self.subTest(command):  # a file without anything is none of points
                done = run(*command, nothing, alone)
                self.assertRegex(done.stderr, "^proxima: .*nothing.off: ")
                self.assertNotIn("--points-and-lines", done.stderr)

    def test_progress_is_shown_where_asked_for(self):
        done = run("view", "icosphere:7", "--panel", "octree", "--size", "60x60", "--picture", self.folder / "a.png", "--progress")
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stderr, r"(?m)^proxima: .+, \d+ %$")


class Reports(ProgramTest):
    HOSTILE = os.fsdecode(b"ok\n\x1b[31m\xff\xe2\x80\xae")
    SHOWN = r"ok\x0A\x1B[31m\xFF\xE2\x80\xAE"

    def test_names_are_shown_so_that_they_change_nothing_else(self):
        model = self.file(self.HOSTILE + ".ply", mesh_files.PLAIN["ascii.ply"])
        out = self.folder / f"out {self.HOSTILE}"
        saved = f"{out}.pxi"
        session = f"{out}.pxt"
        touch = ("--free-running", "--seconds", 0.01)
        for arguments, shown in ((("check", model), (".ply",)), (("repair", model, "--out", f"{out}.off"), (".ply",)),
                                 (("closest", model, "--point", "0,0,2", "--out", f"{out}.csv"), (".ply", ".csv")),
                                 (("cull", model, "--view", "front", "--out", f"{out}.npy", "--picture", f"{out}.png"), (".npy", ".png")),
                                 (("index", model, "--save", saved), (".ply", ".pxi")), (("check", saved), (".pxi",)),
                                 (("octree", model, "--save", f"{out}.pxo", "--out", f"{out}.ply"), (".ply", ".pxo")),
                                 (("check", f"{out}.pxo"), (".pxo",)), (("sdf", model, "--out", f"{out}.vti"), (".ply", ".vti")),
                                 (("view", model, "--out", f"{out}.glb"), (".glb",)),
                                 (("touch", model, "--device", "hand:press", "--record", session, *touch), (".ply", ".pxt")),
                                 (("touch", model, "--device", f"replay:{session}"), (".ply", ".pxt"))):
            with self.subTest(arguments):
                text = self.succeed(*arguments)
                for extension in shown:
                    self.assertIn(self.SHOWN + extension, text)
                self.assertEqual([c for c in text if c != "\n" and not c.isprintable()], [])
                self.assertNotIn("ok\n", text)


class Pipes(ProgramTest):
    """Outputs that are named pipes."""

    def pipe(self, name):
        path = self.folder / name
        os.mkfifo(path)
        return path

    def test_a_reader_gets_everything(self):
        for arguments, option, name in ((("repair", "icosphere:5"), "--out", "a.off"),
                                        (("octree", "cube"), "--json", "a.json"),
                                        (("closest", "cube", "--point", "0,0,2"), "--out", "a.csv"),
                                        (("octree", "icosphere:3"), "--save", "a.pxo")):
            with self.subTest(name):
                pipe = self.pipe(f"pipe-{name}")
                with subprocess.Popen(["cat", pipe], stdout=subprocess.PIPE) as reader:
                    writer = subprocess.Popen([PROXIMA, *arguments, option, pipe, "--quiet"], env=environment_of_program())
                    self.addCleanup(writer.kill)
                    got = reader.communicate(timeout=60)[0]
                    self.assertEqual(writer.wait(timeout=60), 0)
                if option == "--json":
                    self.assertEqual(list(json.loads(got)), OCTREE_KEYS)
                    continue
                self.succeed(*arguments, option, self.folder / name, "--quiet")
                self.assertTrue(got == (self.folder / name).read_bytes())

    def test_a_pipe_that_nobody_reads(self):
        for option, name in (("--out", "a.off"), ("--json", "a.json")):
            pipe = self.pipe(name)
            self.refuse("repair", "icosphere:1", option, pipe, timeout=60, says=(name, "start its reader first"))

    def test_a_signal_ends_the_wait_for_a_reader(self):
        process = subprocess.Popen([PROXIMA, "repair", "icosphere:1", "--out", self.pipe("a.off")], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=environment_of_program())
        self.addCleanup(process.kill)
        while not has_signal(process.pid, "SigCgt", signal.SIGTERM):
            self.assertIsNone(process.poll())
            time.sleep(0.001)
        process.send_signal(signal.SIGTERM)
        error = process.communicate(timeout=60)[1]
        self.assertEqual((process.returncode, error.count("\n")), (143, 1), error)


class Terminal(ProgramTest):
    """A long build shows a progress bar on a terminal, and nothing anywhere else."""
    ARGUMENTS = [PROXIMA, "octree", "spaceship:200000", "--depth", "9", "--method", "minkowski",
                 "--threads", "1"]

    def test_a_bar_on_a_terminal(self):
        master, slave = pty.openpty()
        with subprocess.Popen(self.ARGUMENTS, stdout=subprocess.DEVNULL, stderr=slave) as process:
            os.close(slave)
            seen = b""
            while b"%" not in seen and process.poll() is None:
                try:
                    seen += os.read(master, 4096)
                except OSError:
                    break
            process.terminate()
        os.close(master)
        self.assertRegex(seen.decode(), r"\r\x1b\[K\[[#.]{40}\] +\d+ %")

    def test_no_bar_in_a_pipe(self):
        with subprocess.Popen(self.ARGUMENTS, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
            try:
                process.wait(timeout=1.5)
            except subprocess.TimeoutExpired:
                pass
            process.terminate()
            self.assertNotIn("%", process.stderr.read().decode())


if __name__ == "__main__":
    unittest.main()
