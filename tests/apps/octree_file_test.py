"""Saved octrees (.pxo) in the place of MODEL."""
import unittest

from proxima_program import ProgramTest

CHECK_KEYS = ["model", "mesh", "triangles", "depth", "threshold", "method", "uniform", "exact", "classified",
              "components", "leaked_components", "leaked_leaves", "total", "leaves", "references", "bytes"]
MESH = "spaceship:4000"


class OctreeFileTest(ProgramTest):
    def saved(self, *options, name="a.pxo", mesh=MESH, threshold=3):
        """A file of its own, and what was said when it was made."""
        path = self.folder / name
        sizes = ("--depth", 5) if "--uniform" in options else ("--depth", 5, "--threshold", threshold)
        return path, self.json_of("octree", mesh, *sizes, *options, "--save", path)


class Opening(OctreeFileTest):
    def test_statistics_are_those_of_the_octree_that_was_saved(self):
        for options in ((), ("--method", "separating-axis", "--exact"), ("--uniform",)):
            with self.subTest(options):
                path, built = self.saved(*options)
                opened = self.json_of("octree", path)
                self.assertEqual(list(opened), list(built))
                self.assertEqual(opened.pop("model"), str(path))
                for changed in ("model", "seconds"):
                    built.pop(changed)
                opened.pop("seconds")
                self.assertEqual(opened, built)

    def test_text_says_what_it_is(self):
        path, _ = self.saved("--method", "pairwise", "--exact")
        text = self.succeed("octree", path)
        self.assertIn("octree of 4000 triangles, method pairwise, exact, loaded in", text)
        self.assertIn("Pointers", text)

    def test_saved_again_it_has_the_same_bytes(self):
        path, _ = self.saved()
        again = self.folder / "again.pxo"
        self.succeed("octree", path, "--save", again)
        self.assertEqual(path.read_bytes(), again.read_bytes())
        before = path.read_bytes()
        self.refuse("octree", path, "--save", path, says=("a.pxo", "read and written"))
        self.assertEqual(path.read_bytes(), before)

    def test_exports_are_those_of_the_mesh(self):
        path, _ = self.saved()
        for name in ("a.vtu", "a.htg", "a.ply", "a.glb", "a.png"):
            option = "--picture" if name == "a.png" else "--out"
            with self.subTest(name):
                built, opened, alone = (self.folder / (kind + name) for kind in ("built", "opened", "alone"))
                self.succeed("octree", MESH, "--depth", 5, "--threshold", 3, option, built)
                self.succeed("octree", path, "--mesh", MESH, option, opened)
                self.assertEqual(built.read_bytes(), opened.read_bytes())
                self.succeed("octree", path, option, alone)
                if name in ("a.glb", "a.png"):  # the mesh is a part of these
                    self.assertLess(len(alone.read_bytes()), len(built.read_bytes()))
                else:
                    self.assertEqual(built.read_bytes(), alone.read_bytes())

    def test_it_is_built_already(self):
        path, _ = self.saved()
        for option in (("--depth", 5), ("--threshold", 3), ("--method", "fast"), ("--exact",), ("--uniform",),
                       ("--two-pass",), ("--root", "box"), ("--budget-mb", 100)):
            self.refuse("octree", path, *option, status=2, says=(option[0], "built already", "a.pxo"))

    def test_mesh_goes_with_octree_files_alone(self):
        self.refuse("octree", "cube", "--mesh", "cube", status=2, says=("--mesh", ".pxo"))
        self.refuse("check", "cube", "--mesh", "cube", status=2, says=("--mesh", "octree or index file (.pxo, .pxi)"))

    def test_the_mesh_of_another_octree_is_refused(self):
        path, _ = self.saved()
        for command in ("octree", "check"):
            self.refuse(command, path, "--mesh", "cube", says=("cube", "not the octree's mesh", "4000"))
        larger = self.file("a.off", "OFF\n3 1 0\n0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n")
        smaller = self.file("b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        small, _ = self.saved(name="b.pxo", mesh=smaller)
        self.refuse("octree", small, "--mesh", larger, says=("a.off", "root cell"))

    def test_missing(self):
        self.refuse("octree", self.folder / "missing.pxo", says="missing.pxo")
        self.refuse("check", self.folder / "missing.pxo", says="missing.pxo")


class Checking(OctreeFileTest):
    def test_structure_alone(self):
        path, built = self.saved()
        result = self.json_of("check", path)
        self.assertEqual(list(result), CHECK_KEYS)
        self.assertIsNone(result["mesh"])
        for key in ("triangles", "depth", "threshold", "method", "total", "leaves", "references", "bytes"):
            self.assertEqual(result[key], built[key], key)
        self.assertIn("structure are sound", self.succeed("check", path))

    def test_invariants_with_the_mesh(self):
        path, _ = self.saved()
        self.assertEqual(self.json_of("check", path, "--mesh", MESH)["mesh"], MESH)
        self.assertIn("every invariant holds against " + MESH, self.succeed("check", path, "--mesh", MESH))

    def test_a_broken_invariant_is_found(self):
        # As many triangles, in the same box, elsewhere.
        points = "0 0 0\n1 0 0\n0 1 0\n1 1 1\n"
        path, _ = self.saved(mesh=self.file("a.off", "OFF\n4 2 0\n" + points + "3 0 1 2\n3 0 1 3\n"),
                             threshold=1)
        other = self.file("b.off", "OFF\n4 2 0\n" + points + "3 0 1 2\n3 2 1 3\n")
        self.refuse("check", path, "--mesh", other, says=("a.pxo", "octree cell", "triangle 1"))

    def test_damage_is_found(self):
        path, _ = self.saved()
        data = path.read_bytes()
        for place in (0, 9, 13, 30, 50, 200, len(data) // 2, len(data) - 1):
            with self.subTest(place):
                damaged = self.file("damaged.pxo", data[:place] + bytes([data[place] ^ 0x10]) + data[place + 1:])
                for command in ("octree", "check"):
                    self.refuse(command, damaged, says="damaged.pxo")
        for length in (0, 5, 39, 100, len(data) - 1):
            with self.subTest(length=length):
                self.refuse("check", self.file("damaged.pxo", data[:length]), says="damaged.pxo")
        self.refuse("check", self.file("damaged.pxo", data + b"x"), says=("damaged.pxo", "damaged or cut off"))
        self.refuse("octree", self.file("mesh.pxo", "v 0 0 0\n"), says="no octree file")


if __name__ == "__main__":
    unittest.main()
