"""proxima figures as its users run it."""
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

import mesh_files
from proxima_program import PROXIMA, ProgramTest, environment_of_program, run


class Making(ProgramTest):
    def test_chosen_figures_with_captions_and_commands(self):
        out = self.folder / "new" / "figures"
        result = self.json_of("figures", "--out", out, "--only", "3.14,5.6")
        self.assertEqual(list(result), ["figures", "missing"])
        self.assertEqual([figure["figure"] for figure in result["figures"]], ["3.14", "5.6"])
        self.assertEqual(list(result["figures"][0]), ["figure", "title", "caption", "files", "seconds"])
        self.assertEqual(result["figures"][0]["files"], ["figure_3_14.png", "figure_3_14.svg"])
        self.assertEqual(sorted(path.name for path in out.iterdir()),
                         ["figure_3_14.png", "figure_3_14.svg", "figure_5_6.png", "figures.html"])
        sheet = (out / "figures.html").read_text()
        for figure in result["figures"]:
            self.assertIn(f"proxima figures --out DIR --only {figure['figure']}<", sheet)
            self.assertRegex(figure["caption"], r"\d")
        for figure in result["missing"]:
            self.assertEqual(list(figure), ["figure", "title", "reason"])
            self.assertIn(f"<b>Figure {figure['figure']}.", sheet)

    def test_scans_of_a_folder_take_the_place_of_others(self):
        names = ("bun_zipper_res2.ply", "happy_vrip_res4.ply", "dragon_vrip_res3.ply")
        (self.folder / names[0]).write_bytes(mesh_files.PLAIN["ascii.ply"])
        figure, = self.json_of("figures", "--out", self.folder, "--only", "2.7", "--meshes", self.folder)["figures"]
        self.assertIn(names[0] + ", 4 triangles:", figure["caption"])
        for name, is_there in zip(names, (True, False, False)):
            self.assertEqual(f"there is no {self.folder / name}; it is in " in figure["caption"], not is_there)
        self.refuse("figures", "--out", self.folder, "--meshes", self.folder / "none", status=2, says="--meshes")
        (self.folder / names[1]).write_text("ply\nbroken")
        self.refuse("figures", "--out", self.folder, "--only", "2.7", "--meshes", self.folder, says=names[1])

    def test_pictures_do_not_depend_on_threads(self):
        pictures = []
        for threads in (1, 2):
            self.assertEqual(self.succeed("figures", "--out", self.folder, "--only", "4.2", "--threads", threads,
                                          "--quiet"), "")
            pictures.append((self.folder / "figure_4_2.png").read_bytes())
        self.assertEqual(*pictures)

    def test_opengl_draws_too_or_says_why_not(self):
        result = run("figures", "--out", self.folder, "--only", "3.7", "--opengl")
        if result.returncode == 0:
            self.assertGreater((self.folder / "figure_3_7.png").stat().st_size, 2000)
        else:
            self.assertEqual(result.returncode, 1)
            self.assertIn("OpenGL", result.stderr)
            self.assertEqual(list(self.folder.iterdir()), [])

    def test_the_whole_set(self):
        result = self.json_of("figures", "--out", self.folder)
        self.assertEqual(len(result["figures"]), 37)
        for figure in result["figures"]:
            for name in figure["files"]:
                self.assertGreater((self.folder / name).stat().st_size, 2000, name)
        sheet = (self.folder / "figures.html").read_text()
        shown = re.findall(r'<img src="([^"]+)"', sheet)
        self.assertEqual(shown, [figure["files"][0] for figure in result["figures"]])


class Refusing(ProgramTest):
    def test_wrong_names_and_places(self):
        self.refuse("figures", "--out", self.folder, "--only", "9.9", status=2, says=("9.9", "no figure here"))
        self.refuse("figures", status=2, says="--out")
        file = self.file("file", "")
        self.refuse("figures", "--out", file / "below", says=("below", "cannot be made"))


class WithoutTheLibrary(ProgramTest):
    """An installation that lacks the library that draws figures."""

    def test_pictures_are_refused_and_all_else_works(self):
        with tempfile.TemporaryDirectory() as bare:
            program = shutil.copy(PROXIMA, bare)
            deviation = ("deviation", "cube", "icosphere:3", "--histogram")
            for arguments, status in ((("octree", "cube"), 0), (("octree", "cube", "--picture", "a.png"), 1), ((*deviation, "a.csv"), 0),
                                      ((*deviation, "a.svg"), 1), (("figures", "--only", "4.2", "--out", "new"), 1)):
                with self.subTest(arguments):
                    result = subprocess.run([program, *arguments], env=environment_of_program(), cwd=self.folder, capture_output=True, text=True)
                    self.assertEqual(result.returncode, status, result.stderr)
                    written = [path.name for path in self.folder.iterdir()]
                    self.assertEqual(written, ["a.csv"] if "a.csv" in arguments else [])
                    for name in written:
                        (self.folder / name).unlink()
                    if status != 0:  # said before the work
                        self.assertEqual(result.stdout, "")
                        self.assertRegex(result.stderr, rf"^proxima: the library that draws figures was not found: tried {bare}/libproxima_figure-\S+\.so "
                                                        r".*; it is a part of the program: install it again\n$")

    def test_a_library_of_another_version_is_named(self):
        library, = pathlib.Path(PROXIMA).parent.glob("libproxima_figure-*.so")
        other = re.search(r"/\S+/libm\.so\S*", pathlib.Path("/proc/self/maps").read_text())[0]
        with tempfile.TemporaryDirectory() as bare:
            program = shutil.copy(PROXIMA, bare)
            shutil.copy(other, f"{bare}/{library.name}")
            result = subprocess.run([program, "octree", "cube", "--picture", "a.png"], env=environment_of_program(), cwd=self.folder,
                                    capture_output=True, text=True)
            self.assertEqual((result.returncode, result.stdout, list(self.folder.iterdir())), (1, "", []))
            self.assertRegex(result.stderr, rf"^proxima: {bare}/{library.name}: lacks \w+: it is of another version.*\n$")


if __name__ == "__main__":
    unittest.main()
