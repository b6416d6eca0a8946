"""Bad input and outputs that fail: a status, one line that says what, where and what to do, nothing left behind."""
import json
import random
import resource
import shutil
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import mesh_files
from proxima_program import PROXIMA, SANITIZED, ProgramTest, environment_of_program, run

TRIANGLE = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"


def off(points, triangles):
    lines = ["OFF", f"{len(points)} {len(triangles)} 0"] + [" ".join(map(repr, p)) for p in points]
    return "\n".join(lines + ["3 %d %d %d" % t for t in triangles]) + "\n"


CORNERS_OF_A_SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def tetrahedron(scale=1.0, offset=0.0):
    return off([tuple(scale * x + offset for x in point) for point in mesh_files.POSITIONS],
               mesh_files.TRIANGLES)


class Models(ProgramTest):
    def test_every_format_is_read_when_whole(self):
        for name, content in mesh_files.READ.items():
            with self.subTest(name):
                self.assertEqual(self.json_of("octree", self.file(name, content))["triangles"], 4)

    @unittest.skipIf(mesh_files.READS_SCENES, "built with assimp")
    def test_formats_that_this_build_does_not_read(self):
        for name, content in mesh_files.SCENES.items():
            with self.subTest(name):
                self.refuse("octree", self.file(name, content), says=(name, "PROXIMA_WITH_ASSIMP=ON"))

    @unittest.skipUnless(mesh_files.READS_SCENES, "built without assimp")
    def test_scenes_without_the_library_that_reads_them(self):
        with tempfile.TemporaryDirectory() as bare:
            program = shutil.copy(PROXIMA, bare)
            for name, content in mesh_files.READ.items():
                with self.subTest(name):
                    result = subprocess.run([program, "octree", self.file(name, content), "--json", "-"], env=environment_of_program(),
                                            capture_output=True, text=True)
                    if name in mesh_files.PLAIN:
                        self.assertEqual((result.returncode, json.loads(result.stdout)["triangles"]), (0, 4))
                        continue
                    self.assertEqual((result.returncode, result.stdout), (1, ""))
                    self.assertRegex(result.stderr, rf"^proxima: {self.folder}/{name}: the library that reads 3DS, glTF and GLB was not found: "
                                                    rf"tried {bare}/proxima/libproxima_scenes-\S+\.so .*; install it there, or convert the file to "
                                                    r"OBJ, PLY, STL or OFF\n$")

    def test_missing_file(self):
        path = self.folder / "missing.obj"
        self.refuse("octree", path, says=(str(path),))

    def test_a_folder_is_no_model(self):
        self.refuse("octree", self.folder, says=str(self.folder))

    def test_unknown_extension(self):
        self.refuse("octree", self.file("a.abc", TRIANGLE), says=("a.abc", ".obj"))
        self.assertEqual(self.refuse("index", self.folder / "a.abc", says=".obj").count("a.abc"), 1)
        self.refuse("octree", self.file("a", TRIANGLE), says=".obj")

    def test_unknown_built_in_size(self):
        self.refuse("octree", "sphere:1x1", says="sphere")
        self.refuse("octree", "sphere:axb", says="sphere")
        self.refuse("octree", "spaceship:33001", says="even")

    def test_truncated_files(self):
        for name, content in mesh_files.READ.items():
            for part in (0.35, 0.6, 0.97):
                with self.subTest(name, part=part):
                    cut = content[:int(part * len(content))]
                    if name == "a.obj":  # lines alone would be a smaller, valid file
                        cut = cut[:cut.rindex(b"\n", 0, -1) + 3]
                    self.refuse("octree", self.file(name, cut), says=name)

    def test_garbage(self):
        generator = random.Random(7)
        for name in mesh_files.READ:
            for size in (0, 1, 83, 5000):
                with self.subTest(name, size=size):
                    self.refuse("octree", self.file(name, generator.randbytes(size)), says=name)

    def test_one_format_under_the_name_of_another(self):
        for name in mesh_files.READ:
            for other, content in mesh_files.READ.items():
                if name.split(".")[1] != other.split(".")[1]:
                    with self.subTest(name, content=other):
                        self.refuse("octree", self.file(name, content), says=name)

    def test_empty_mesh(self):
        for name, content in {"a.off": "OFF\n0 0 0\n", "b.off": off([(0.0, 0.0, 0.0)], []),
                              "a.obj": "v 0 0 0\n", "a.stl": "solid s\nendsolid s\n"}.items():
            with self.subTest(name):
                self.refuse("octree", self.file(name, content), says=name)

    def test_nan_and_infinity(self):
        for word in ("nan", "inf", "-inf"):
            path = self.file("a.off", TRIANGLE.replace("0 1 0\n3", f"0 {word} 0\n3"))
            self.refuse("octree", path, says=(str(path), "vertex 2"))

    def test_index_out_of_range(self):
        self.refuse("octree", self.file("a.off", TRIANGLE.replace("3 0 1 2", "3 0 1 3")), says="a.off:6")
        self.refuse("octree", self.file("a.obj", "v 0 0 0\nf 1 1 2\n"), says="a.obj:2")
        self.refuse("octree", self.file("b.obj", "v 0 0 0\nf 0 0 0\n"), says="b.obj:2")


class Geometry(ProgramTest):
    """Meshes that are strange and still right."""

    def octree(self, content, **expected):
        for method in ("fast", "separating-axis", "index-tracking", "minkowski", "pairwise"):
            for extra in ((), ("--exact",)):
                with self.subTest(method=method, extra=extra):
                    result = self.json_of("octree", self.file("a.off", content), "--method", method,
                                          "--depth", 4, *extra)
                    self.assertGreaterEqual(result["references"], result["triangles"])
                    for key, value in expected.items():
                        self.assertEqual(result[key], value, key)

    def test_one_triangle(self):
        self.octree(TRIANGLE, triangles=1, total=1, references=1)

    def test_a_flat_mesh(self):
        self.octree(off([(0.0, 0.0, 5.0), (1.0, 0.0, 5.0), (1.0, 1.0, 5.0), (0.0, 1.0, 5.0)],
                        [(0, 1, 2), (0, 2, 3)]), triangles=2)

    def test_all_triangles_degenerate(self):
        self.octree(off([(1.0, 2.0, 3.0)], [(0, 0, 0), (0, 0, 0)]), triangles=2)
        self.octree(off([(0.0, 0.0, 0.0), (1.0, 1.0, 1.0)], [(0, 0, 1), (0, 1, 1)]), triangles=2)

    def test_far_from_the_origin(self):
        near = self.json_of("octree", self.file("near.off", tetrahedron(1024.0)), "--exact")
        far = self.json_of("octree", self.file("far.off", tetrahedron(1024.0, 2.0**30)), "--exact")
        for key in ("total", "leaves", "references", "inner", "outer"):
            self.assertEqual(near[key], far[key], key)
        self.octree(tetrahedron(1.0, 1e9), triangles=4)

    def test_tiny_and_huge(self):
        usual = self.json_of("octree", self.file("usual.off", tetrahedron()), "--exact")
        for power in (-100, 100):  # about 1e-30 and 1e30, exactly the same shape
            scaled = self.json_of("octree", self.file("scaled.off", tetrahedron(2.0**power)), "--exact")
            for key in ("total", "leaves", "references", "inner", "outer"):
                self.assertEqual(usual[key], scaled[key], key)
        self.octree(tetrahedron(1e-30), triangles=4)
        self.octree(tetrahedron(1e30), triangles=4)

    def test_pictures_of_them(self):
        for name, content in {"one": TRIANGLE, "point": off([(1.0, 2.0, 3.0)], [(0, 0, 0)]),
                              "tiny": tetrahedron(1e-30), "huge": tetrahedron(1e30),
                              "far": tetrahedron(1.0, 1e9)}.items():
            with self.subTest(name):
                self.succeed("octree", self.file(name + ".off", content), "--quiet", "--picture",
                             self.folder / (name + ".png"))

    def test_check_of_the_least_sizes(self):
        for size in (1e-150, 1e-300, 1e-307, 1e-310, 1e-320):
            with self.subTest(size):
                report = self.json_of("check", self.file("tiny.off", tetrahedron(size)))
                self.assertEqual(report["orientation"], "outward")
                self.assertGreaterEqual(report["signed_volume"], 0)
                kinds = [finding["kind"] for finding in report["findings"]]
                self.assertIn("extreme_scale", kinds)
                self.assertNotIn("inward_components", kinds)

    def test_check_says_what_they_mean(self):
        text = self.succeed("check", self.file("a.off", off([(1.0, 2.0, 3.0)], [(0, 0, 0), (0, 0, 0)])))
        self.assertIn("degenerate", text)


class Options(ProgramTest):
    def test_strict_checks_end_with_their_verdict(self):
        sound = self.file("sound.off", tetrahedron(1))
        self.succeed("check", sound, "--strict")
        holed = self.file("holed.off", off(CORNERS_OF_A_SQUARE, [(0, 1, 2), (0, 2, 3)]))
        self.succeed("check", holed)
        result = run("check", holed, "--strict", "--json", self.folder / "report.json")
        self.assertEqual(result.returncode, 1)
        self.assertIn("holed.off: has 1 flaw", result.stderr)
        self.assertIn("boundary", result.stdout)
        findings = json.loads((self.folder / "report.json").read_text())["findings"]
        self.assertEqual([f["kind"] for f in findings if f["severity"] != "note"], ["boundary_edges"])

    def test_strict_is_about_meshes(self):
        octree, index = self.folder / "a.pxo", self.folder / "a.pxi"
        self.succeed("octree", "cube", "--save", octree)
        self.succeed("index", "cube", "--save", index)
        for file in (octree, index):
            self.succeed("check", file)
            self.refuse("check", file, "--strict", status=2, says=("--strict", "meshes"))

    def test_a_setting_that_fits_no_model(self):
        picture = self.folder / "a.png"
        shown = ("--panel", "octree", "--size", "60x60", "--picture", picture)
        self.refuse("view", "cube", "octahedron", *shown, "--set", "model=5", says=('"5"', "model", "1 to 2"))
        self.refuse("view", "cube", *shown, "--set", "model=1", says=("model", "several models"))
        self.succeed("view", "cube", "octahedron", *shown, "--set", "model=2")

    def test_a_setting_that_is_set_twice(self):
        self.refuse("view", "cube", "--panel", "octree", "--set", "depth=3", "--set", "depth=4", "--picture", self.folder / "a.png",
                    status=2, says=("depth", "twice"))

    def test_counters_of_a_tool(self):
        self.refuse("touch", "cube", "--device", "hand:press", "--tool", "cube", "--verbose", status=2, says=("--verbose", "not for a tool"))

    def test_depth_over_the_limit(self):
        self.refuse("octree", "cube", "--depth", 20, status=2, says=("--depth", "19"))
        self.refuse("octree", "cube", "--depth", -1, status=2, says="--depth")
        self.refuse("compare", "cube", "--depths", "1-20", status=2, says=("--depths", "19"))

    def test_threshold_zero_or_negative(self):
        for value in ("0", "-1", "1.5", "many", "4294967296"):
            self.refuse("octree", "cube", "--threshold", value, status=2, says="--threshold")

    def test_budget_too_small(self):
        self.refuse("octree", "spaceship:100000", "--depth", 8, "--budget-mb", 1, says=("budget", "MB"))
        self.refuse("octree", "cube", "--depth", 10, "--uniform", "--budget-mb", 100,
                    says=("budget", "depth"))
        self.refuse("octree", "cube", "--depth", 19, "--uniform")

    def test_options_that_have_no_effect_together(self):
        self.refuse("octree", "cube", "--uniform", "--threshold", 3, status=2, says=("--uniform", "--threshold"))
        self.refuse("minkowski", "cube", "cube", "--hull", "--tolerance", 0.1, status=2, says=("--hull", "--tolerance"))

    def test_empty_values_are_not_left_out(self):
        """As a variable of a shell makes them that is not set."""
        for arguments, says in ((("index", "cube", "--save", ""), "after --save is empty"), (("check", ""), "after check is empty"),
                                (("contact-time", "cube", "cube", "--from", "5,0,0", "--to", ""), "after --to is empty"),
                                (("octree", "cube", "--json="), "--json= has an empty value")):
            with self.subTest(arguments):
                self.refuse(*arguments, status=2, says=says)

    def test_whole_numbers_are_decimal(self):
        for text, depth in (("3", 3), ("03", 3), ("010", 10), ("0", 0), ("00", 0)):
            self.assertEqual(self.json_of("octree", "cube", "--depth", text, "--threshold", 1000)["depth"], depth, text)
        self.refuse("octree", "cube", "--depth", "0x3", status=2, says="0x3 is no decimal number")
        self.refuse("deviation", "cube", "cube", "--tolerance", "-1", status=2, says="-1 is no number from 0 up")

    def test_a_camera_at_its_target_is_refused_before_anything_is_written(self):
        old = self.folder / "old.pxo"
        old.write_text("old")
        self.refuse("octree", "cube", "--depth", 1, "--save", old, "--picture", self.folder / "a.png", "--eye", "0,0,0",
                    "--target", "0,0,0", says="the eye is where it looks")
        self.assertEqual(old.read_text(), "old")


class Outputs(ProgramTest):
    """Every kind of output where it cannot be written."""
    OPTIONS = {"--json": "a.json", "--save": "a.pxo", "--out": ("a.vtu", "a.htg", "a.glb", "a.ply"), "--picture": "a.png"}

    def each(self):
        for option, names in self.OPTIONS.items():
            for name in [names] if isinstance(names, str) else names:
                yield option, name

    def test_folder_missing(self):
        for option, name in self.each():
            with self.subTest(option, name=name):
                self.refuse("octree", "cube", option, self.folder / "missing" / name, says=name)

    def test_folder_that_takes_no_files(self):
        # Root may write into read-only folders, but not below a file or into /proc.
        below = self.file("file", "")
        for option, name in self.each():
            with self.subTest(option, name=name):
                self.refuse("octree", "cube", option, below / name, says=name)
                self.refuse("octree", "cube", option, "/proc/" + name, says=name)

    def test_a_folder_is_no_output(self):
        for option, name in self.each():
            (self.folder / name).mkdir()
            with self.subTest(option, name=name):
                self.refuse("octree", "cube", option, self.folder / name, says=name)

    def test_only_json_goes_to_stdout(self):
        for option in ("--save", "--out", "--picture"):
            with self.subTest(option):
                self.refuse("octree", "cube", option, "-", says=("-", "--json", "stdout"))

    def test_two_outputs_in_one_file(self):
        (self.folder / "folder").mkdir()
        path, same = self.folder / "a.ply", self.folder / "folder" / ".." / "a.ply"
        for first, second in (("--save", "--json"), ("--save", "--out"), ("--out", "--json"),
                              ("--out", "--out"), ("--out", "--picture")):
            with self.subTest(first, second=second):
                self.refuse("octree", "cube", first, path, second, same, says=("a.ply", "two outputs"))

    def test_outputs_that_are_one_file_through_a_link_without_a_target(self):
        (self.folder / "y.csv").symlink_to("x.csv")
        self.refuse("closest", "cube", "--point", "1,2,3", "--out", self.folder / "x.csv", "--json", self.folder / "y.csv",
                    says=("y.csv", "two outputs"))
        self.assertFalse((self.folder / "x.csv").exists())
        there = self.file("there.csv", "1\n")
        self.refuse("closest", "cube", "--point", "1,2,3", "--out", there, "--json", there, says=("there.csv", "two outputs"))
        self.assertEqual(there.read_text(), "1\n")
        touch = ("touch", "cube", "--device", "hand:press", "--seconds", 0.1, "--free-running")
        for first, second in (("--picture", "--json"), ("--record", "--json"), ("--record", "--picture")):
            with self.subTest(first, second=second):
                self.refuse(*touch, first, self.folder / "a.pxt", second, self.folder / "a.pxt", says=("a.pxt", "two outputs"))

    def test_options_without_effect(self):
        for command in (("deviation", "cube", "icosphere:1", "--signed"),
                        ("deviation", "cube", "icosphere:1", "--place-spacing", "0.1"),
                        ("deviation", "cube", "icosphere:1", "--no-mean", "--mean-tolerance", "0.1"),
                        ("deviation", "cube", "icosphere:1", "--no-mean", "--histogram", self.folder / "h.csv"),
                        ("cull", "cube", "--plane", "1,0,0,0", "--picture-view", "top"),
                        ("cull", "cube", "--plane", "1,0,0,0", "--up", "x"),
                        ("cull", "cube", "--plane", "1,0,0,0", "--size", "30x30"),
                        ("repair", "cube", "--no-outward", "--no-cavities"),
                        ("view", "cube", "--controls", "--picture", self.folder / "a.png"),
                        ("view", "cube", "--controls"),
                        ("view", "cube", "--picture", self.folder / "a.png", "--state", self.folder / "lost.json"),
                        ("view", "cube", "--picture", self.folder / "a.png", "--gl-debug"),
                        ("view", "cube", "--out", self.folder / "a.glb", "--opengl"),
                        ("deviation", "cube", "icosphere:1", "--no-mean", "--bins", 4),
                        ("touch", "cube", "--device", "hand:press", "--list-devices"),
                        ("touch", "--list-devices", "--record", self.folder / "lost.pxt"),
                        ("touch", "--list-devices", "--self-test")):
            with self.subTest(command):
                result = run(*command)
                self.assertEqual(result.returncode, 2)
                self.assertTrue(any(word in result.stderr for word in command if str(word).startswith("--")), result.stderr)

    def test_meshes_that_are_too_large_to_touch(self):
        huge = self.file("huge.obj", "".join(f"v {x}e150 {y}e150 {z}e150\n" for x in (0, 1) for y in (0, 1) for z in (0, 1)) +
                         "f 1 2 4\nf 1 4 3\nf 5 8 6\nf 5 7 8\nf 1 5 6\nf 1 6 2\nf 3 4 8\nf 3 8 7\nf 1 3 7\nf 1 7 5\nf 2 6 8\nf 2 8 4\n")
        self.refuse("touch", huge, "--device", "hand:press", "--free-running", "--seconds", 0.1, says=("huge.obj", "too large"))
        large = self.file("large.obj", Path(huge).read_text().replace("e150", "e100"))
        session = self.folder / "large.pxt"
        touch = ("touch", large, "--device", "hand:press", "--free-running", "--seconds", 0.1)
        self.succeed(*touch)
        for more in ((), ("--tool", "icosphere:1", "--tool-scale", 0.05)):
            self.refuse(*touch, *more, "--record", session, says=("--record", "could not be replayed", "units_per_metre"))
            self.assertFalse(session.exists())

    def test_lists_of_a_single_place(self):
        for text in ("1 2 3\n", "0 0 0\n", "1 2 3\n1 2 3\n"):
            points, index = self.file("point.xyz", text), self.folder / "point.pxi"
            self.succeed("index", points, "--lists", "--save", index)
            self.succeed("closest", index, "--point", "5,2,3")

    def test_what_is_read_is_not_written(self):
        mesh = self.file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        points = self.file("points.csv", "x,y,z\n1,2,3\n")
        session = self.folder / "session.pxt"
        self.succeed("touch", "cube", "--device", "hand:press", "--seconds", 0.1, "--free-running", "--record", session)
        (self.folder / "folder").mkdir()
        again = self.folder / "folder" / ".." / "a.obj"
        kept = {path: path.read_bytes() for path in (mesh, points, session)}
        for arguments in (("patch", mesh, "--point", "0,0,0", "--rings", 1, "--out", again),
                          ("closest", mesh, "--points", points, "--out", points),
                          ("octree", mesh, "--json", mesh), ("check", mesh, "--json", mesh), ("view", mesh, "--state", mesh),
                          ("touch", "cube", "--device", f"replay:{session}", "--json", session),
                          ("minkowski", mesh, "cube", "--out", mesh)):
            with self.subTest(arguments):
                self.refuse(*arguments, says="read and written")
        for arguments in (("closest", "cube", "--points", "-", "--out", points), ("closest", "cube", "--points", "-", "--json", points)):
            with self.subTest(arguments), open(points) as redirected:
                self.refuse(*arguments, stdin=redirected, says="read and written")
        for path, content in kept.items():
            self.assertEqual(path.read_bytes(), content)

    def test_own_files_have_their_extensions(self):
        self.refuse("octree", "cube", "--save", self.folder / "a.obj", says=("a.obj", ".pxo"))
        self.refuse("touch", "cube", "--device", "hand:press", "--record", self.folder / "a.obj", says=("a.obj", ".pxt"))
        self.refuse("proximity", "cube", "--save", self.folder / "a.obj", says=("a.obj", ".pxi"))

    @unittest.skipIf(SANITIZED, "sanitizers take address space of their own")
    def test_advice_can_be_followed(self):
        def little_memory():
            resource.setrlimit(resource.RLIMIT_AS, (400_000_000, 400_000_000))
        for arguments in (("raycast", "spaceship:1000000", "--size", "10x10", "--picture", self.folder / "a.png"),
                          ("check", "spaceship:1000000"), ("index", "spaceship:1000000", "--lists")):
            with self.subTest(arguments):
                said = self.refuse(*arguments, says="memory", preexec_fn=little_memory)
                self.assertNotIn("raise", said)

    def test_unknown_extension_is_said_before_the_work(self):
        start = time.monotonic()
        self.refuse("octree", "spaceship:2000000", "--depth", 12, "--out", self.folder / "a.bmp",
                    says=(".vtu", "a.bmp"))
        self.assertLess(time.monotonic() - start, 5)

    def test_disk_full(self):
        for option, name in self.each():
            (self.folder / name).symlink_to("/dev/full")
            with self.subTest(option, name=name):
                self.refuse("octree", "cube", "--depth", 4, option, self.folder / name, says=name)

    def test_stdout_full(self):
        for extra in ((), ("--json", "-")):
            with open("/dev/full", "w") as full, self.subTest(extra=extra):
                self.refuse("octree", "cube", *extra, stdout=full, says="standard output")
        for arguments in (("--help",), ("--version",), ("octree", "--help")):
            with open("/dev/full", "w") as full, self.subTest(arguments):
                self.refuse(*arguments, stdout=full, says="standard output: cannot write: No space left")

    def test_file_size_limit_keeps_the_old_file(self):
        for option, name in self.each():
            if option == "--json":
                continue  # smaller than any limit that the program could start with
            path = self.file(name, "old")
            with self.subTest(option, name=name):
                self.refuse("octree", "icosphere:3", "--depth", 6, option, path, says=name,
                            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096)))
                self.assertEqual(path.read_text(), "old")


if __name__ == "__main__":
    unittest.main()
