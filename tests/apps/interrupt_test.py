"""Signals during long work: the status that the documentation promises, soon, and nothing left behind."""
import os
import signal
import subprocess
import time
import unittest

from proxima_program import PROXIMA, ProgramTest, has_signal, run

# Seconds of the processor, so that a busy machine does not matter; watched by a sanitizer, programs are much slower.
SOON = 30.0 if os.environ.get("PROXIMA_SANITIZE") else 1.0
TICKS = os.sysconf("SC_CLK_TCK")


def processor_seconds(pid):
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def after(seconds):
    """A moment: so much of the processor's time after the start."""
    return lambda pid: processor_seconds(pid) >= seconds


class InterruptTest(ProgramTest):
    def interrupt(self, *arguments, when, sent=signal.SIGINT, keeps=()):
        """Runs, sends the signal at the moment that `when(pid)` tells, and sees what comes of it."""
        with subprocess.Popen([PROXIMA, *map(str, arguments), "--threads", "1"], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True) as process:
            # Watched by a sanitizer, it is long before the program handles signals.
            for comes in (lambda pid: has_signal(pid, "SigCgt", sent), when):
                while not comes(process.pid):
                    self.assertIsNone(process.poll(), "the work was over too soon for this test")
                    time.sleep(0.003)
            before = processor_seconds(process.pid)
            process.send_signal(sent)
            # Waits without reaping, so that the processor's time can still be asked.
            os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
            used = processor_seconds(process.pid) - before
            _, error = process.communicate(timeout=60)
        self.assertLess(used, SOON)
        self.assertEqual(process.returncode, 128 + sent, error)
        self.assertEqual(error.count("\n"), 1, error)
        self.assertTrue(error.startswith("proxima: "), error)
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), sorted(keeps),
                         "something was left behind, or taken away")

    def outputs(self):
        return ("--save", self.folder / "a.pxo", "--json", self.folder / "a.json",
                "--out", self.folder / "a.vtu")

    def is_writing(self, _pid):
        """Whether a file is half written."""
        try:
            return any(path.stat().st_size > 1 << 20 for path in self.folder.glob(".proxima-*.tmp"))
        except FileNotFoundError:  # whole in the meantime
            return False


class Building(InterruptTest):
    def test_slow_method(self):
        self.interrupt("octree", "spaceship:300000", "--depth", "10", "--method", "pairwise", *self.outputs(),
                       when=after(1))

    def test_fast_method(self):
        self.interrupt("octree", "spaceship:1000000", "--depth", "14", *self.outputs(), when=after(2))

    def test_termination(self):
        self.interrupt("octree", "spaceship:300000", "--depth", "10", "--method", "minkowski",
                       *self.outputs(), when=after(1), sent=signal.SIGTERM)

    def test_rays(self):
        self.interrupt("raycast", "cube", "--size", "16384x16384", "--picture", self.folder / "a.png", when=after(1))
        self.interrupt("raycast", "sphere:200x200", "--size", "512x512", "--method", "thesis", "--depth", "3",
                       "--picture", self.folder / "a.png", when=after(0.4))
        self.interrupt("raycast", "torus:200x100", "--size", "4000x4000", "--depth", "8", "--cells", "--out", self.folder / "a.csv", when=after(1))

    def test_pictures(self):
        # While the canvas is laid out, drawn on, and packed as PNG.
        for seconds in (0.3, 1, 2):
            with self.subTest(seconds):
                self.interrupt("octree", "icosphere:5", "--size", "8000x8000", "--picture", self.folder / "a.png",
                               when=after(seconds))
        self.interrupt("raycast", "cube", "--size", "16384x16384", "--picture", self.folder / "a.png", when=after(0.3))

    def test_closest_features(self):
        self.interrupt("proximity", "sphere:300x300", "--save", self.folder / "a.pxi", when=after(1))

    def test_pairs(self):
        self.interrupt("check", "spaceship:700000", when=after(1.5))

    def test_contours(self):
        # Each triangle meets all round it: 1.1 million pairs, then their contour.
        for seconds in (1, 3):
            with self.subTest(seconds):
                self.interrupt("intersect", "sphere:200x200", "sphere:200x200", "--pose", "0,0,0",
                               "--contour", self.folder / "a.obj", "--json", self.folder / "a.json", when=after(seconds))

    def test_pairs_of_cells(self):
        for options in (("--method", "thesis"), ("--cells",)):
            with self.subTest(options):
                self.interrupt("intersect", "sphere:200x200", "sphere:200x200", "--pose", "0,0,0", "--depth", "8",
                               *options, "--json", self.folder / "a.json", when=after(1.5))

    def test_a_closed_terminal(self):
        self.interrupt("octree", "spaceship:300000", "--depth", "10", "--method", "pairwise", *self.outputs(),
                       when=after(1), sent=signal.SIGHUP)

    def test_replays(self):
        recording = self.folder / "long.pxt"
        self.succeed("touch", "icosphere:4", "--device", "hand:stroke", "--seconds", 1800, "--free-running", "--record", recording)
        # While the file is read, its ticks are checked, and they are replayed.
        for seconds in (0.2, 0.5, 0.8, 2):
            with self.subTest(seconds):
                self.interrupt("touch", "icosphere:4", "--device", f"replay:{recording}", "--json", self.folder / "a.json",
                               when=after(seconds), keeps=["long.pxt"])

    def test_fields(self):
        # While there is nothing but zeros.
        self.interrupt("sdf", "cube", "--resolution", 450, "--out", self.folder / "a.npy", when=after(0.1))

    def test_compare(self):
        self.interrupt("compare", "spaceship:300000", "--json", self.folder / "a.json", when=after(1))

    def test_tables(self):
        # Among the queries, long after the structures were built.
        self.interrupt("tables", "--only", "5", "--json", self.folder / "a.json", when=after(1))

    def test_built_in_meshes(self):
        for name in ("spaceship:60000000", "icosphere:11", "sphere:8000x8000"):
            with self.subTest(name):
                self.interrupt("octree", name, *self.outputs(), when=after(0.5))


class Loading(InterruptTest):
    """Files so large that reading them takes a second or more."""
    VERTICES = b"0.123456 0.234567 0.345678\n" * (1 << 16)
    BLOCKS = 200

    def ply(self):
        path = self.folder / "large.ply"
        with open(path, "wb") as file:
            file.write(b"ply\nformat ascii 1.0\nelement vertex %d\nproperty double x\nproperty double y\n"
                       b"property double z\nelement face 1\nproperty list uchar int vertex_indices\n"
                       b"end_header\n" % (self.BLOCKS << 16))
            for _ in range(self.BLOCKS):
                file.write(self.VERTICES)
            file.write(b"3 0 1 2\n")
        return path

    def obj(self):
        path = self.folder / "large.obj"
        with open(path, "wb") as file:
            block = self.VERTICES.replace(b"0.123", b"v 0.123")
            for _ in range(self.BLOCKS):
                file.write(block)
            file.write(b"f 1 2 3\n")
        return path

    def stl(self):
        path = self.folder / "large.stl"
        facet = (b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
                 b"endfacet\n")
        with open(path, "wb") as file:
            file.write(b"solid large\n")
            for _ in range(self.BLOCKS):
                file.write(facet * (1 << 14))
            file.write(b"endsolid large\n")
        return path

    def test_each_format(self):
        for make in (self.ply, self.obj, self.stl):
            path = make()
            with self.subTest(path.name):
                for command in ("octree", "check"):
                    self.interrupt(command, path, "--json", self.folder / "a.json", when=after(0.3),
                                   keeps=[path.name])
            path.unlink()


class Writing(InterruptTest):
    """Outputs of some hundred megabytes, interrupted when a part of them is in the file."""
    MODEL = ("octree", "icosphere:3", "--uniform", "--depth", 7)

    def test_each_export(self):
        for name in ("a.vtu", "a.ply"):
            with self.subTest(name):
                path = self.file(name, "old")
                self.interrupt(*self.MODEL, "--out", path, when=self.is_writing, keeps=[name])
                self.assertEqual(path.read_text(), "old")
                path.unlink()

    def test_saving(self):
        path = self.file("a.pxo", "old")
        self.interrupt("octree", "icosphere:3", "--uniform", "--depth", 8, "--save", path,
                       when=self.is_writing, keeps=["a.pxo"])
        self.assertEqual(path.read_text(), "old")

    def test_loading_an_octree(self):
        path = self.folder / "a.pxo"
        self.assertEqual(run("octree", "icosphere:3", "--uniform", "--depth", 8, "--save", path).returncode, 0)
        self.interrupt("check", path, "--mesh", "icosphere:3", "--json", self.folder / "a.json",
                       when=after(0.2), keeps=["a.pxo"])


if __name__ == "__main__":
    unittest.main()
