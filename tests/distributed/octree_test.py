"""proxima-mpi on 1 to 4 ranks: the octree is that of one process, and what cannot be done ends all ranks with one message."""
import os
import random
import signal
import struct
import subprocess
import unittest
from pathlib import Path

from generated_meshes import ball_in_a_box, nasty_mesh, npy, ply, shell, surfaces, wide_triangles
from mpi_program import PROXIMA, SEED, DistributedTest, faulty, messages, on_a_full_disk, run, run_apart, run_each, some, some_ranks

SURFACES = int(os.environ.get("SURFACES", "3"))


class Octree(DistributedTest):
    def expect_same(self, model, *options, ranks=None):
        ranks = ranks or some_ranks()
        results = run_each((count, "octree", model, *options, "--verify") for count in dict.fromkeys(ranks))
        for count, result in zip(dict.fromkeys(ranks), results):
            self.assertEqual(result.returncode, 0, f"{model} on {count} ranks: {result.stderr}")
            self.assertIn("Leaves, lists and classes are those of one process.", result.stdout)
        return results[-1].stdout

    def test_torus(self):
        self.expect_same("torus:200x100", "--depth", 7, "--threshold", 8)
        self.expect_same("torus:3x3", "--depth", 4)

    def test_few_cells_for_the_ranks(self):
        self.expect_same("torus:9x9", "--depth", 0)
        self.expect_same("torus:9x9", "--depth", 6, "--threshold", 2, "--routing-depth", 0, ranks=(1, 3))
        self.expect_same("torus:9x9", "--depth", 6, "--threshold", 1000, ranks=(4,))

    def test_ply_files(self):
        subprocess.run([PROXIMA, "repair", "spaceship:6000", "--out", self.folder / "ship.ply"], check=True, capture_output=True)
        self.expect_same(self.folder / "ship.ply", "--depth", 8, "--threshold", 4)

    def test_ply_files_with_long_headers(self):
        """Of more than 64 KiB, and of 64 KiB without the last line's end."""
        whole = ply(*nasty_mesh(1))
        header = whole.index(b"end_header") + len("end_header")
        for length in (100_000, (1 << 16) - header):
            comment = b"comment " + b"x" * (length - len("comment \n")) + b"\n"
            path = self.file(f"long_{length}.ply", whole.replace(b"element vertex", comment + b"element vertex", 1))
            self.expect_same(path, "--depth", 4, ranks=(2,))

    def test_nasty_meshes(self):
        for seed in some(range(6), 2):
            path = self.file(f"nasty_{seed}.ply", ply(*nasty_mesh(seed)))
            self.expect_same(path, "--depth", 4 + seed % 2, "--threshold", seed, "--routing-depth", 1 + seed, ranks=(1 + seed % 4,))

    def test_closed_and_open_surfaces(self):
        for seed in random.Random(SEED).sample(range(1000), SURFACES):
            path = self.file(f"surfaces_{seed}.ply", ply(*surfaces(seed)))
            self.expect_same(path, "--depth", max(5 + seed % 3, 1 + seed % 7), "--threshold", seed % 3, "--routing-depth", 1 + seed % 7,
                             ranks=(1 + seed % 4, 2 + (seed + 1) % 3))

    def test_ranks_that_see_no_way_out(self):
        for seed in some(range(4), 1):
            path = self.file(f"ball_{seed}.ply", ply(*ball_in_a_box(seed)))
            self.expect_same(path, "--depth", 7, "--threshold", 20, "--routing-depth", 6, ranks=(4, 7))

    def test_wide_triangles_are_sent_about_once(self):
        """400 triangles across the mesh, each of which touches thousands of cells at the routing depth 7."""
        path = self.file("wide.ply", ply(*wide_triangles(SEED, 400)))
        text = self.expect_same(path, "--depth", 7, "--routing-depth", 7, "--threshold", 8, ranks=(2,))
        self.assertLess(sum(row["Bytes sent"] for row in self.rank_rows(text, 2)), 1_000_000, f"seed {SEED}")

    def test_pairs_that_ranks_split(self):
        """Without a threshold every triangle of an occupied cell goes on to the next level: what is split is in the leaves of the levels above."""
        depths = (3, 4, 5)
        results = run_each((2, "octree", "torus:30x20", "--threshold", 0, "--routing-depth", 3, "--depth", depth) for depth in depths)
        rows = [self.rank_rows(result.stdout, 2) for result in results]
        pairs, pointers = ([sum(row[name] for row in ranks) for ranks in rows] for name in ("Pairs split", "Pointers"))
        self.assertEqual(pairs, [0, pointers[0], pointers[0] + pointers[1]])
        leaves = [int(line.split()[3]) for line in results[2].stdout.splitlines() if line.split()[:2] == ["5", "0"]]
        self.assertEqual([sum(row["Leaves"] for row in rows[2])], leaves)

    def test_what_ranks_have_and_send(self):
        """One has all triangles in its cell, and nobody to send them to. What others save, they send to the first: cells, nodes and pointers."""
        cells = (2, "octree", "torus:30x20", "--depth", 4, "--routing-depth", 2)
        results = run_each([(1, "octree", "torus:9x9", "--depth", 0), cells, (*cells, "--save", self.folder / "a.pxo")])
        alone, = self.rank_rows(results[0].stdout, 1)
        expected = {"Cells": 1, "Triangles": 162, "Leaves": 1, "Pairs split": 0, "Pointers": 162, "Messages": 0, "Bytes sent": 0}
        self.assertEqual({name: alone[name] for name in expected}, expected)
        self.assertTrue(4 < alone["Peak MB"] < 1000, alone)
        built, saved = (self.rank_rows(result.stdout, 2) for result in results[1:])
        self.assertEqual([row["Messages"] - before["Messages"] for before, row in zip(built, saved)], [0, 3])
        self.assertEqual(saved[0]["Bytes sent"], built[0]["Bytes sent"])
        self.assertGreater(saved[1]["Bytes sent"] - built[1]["Bytes sent"], 4 * built[1]["Pointers"])

    def test_statistics_are_those_of_the_program(self):
        options = ["--depth", 7, "--threshold", 8]
        one = subprocess.run([PROXIMA, "octree", "torus:200x100", *map(str, options)], capture_output=True, text=True, check=True).stdout
        figures = next(line for line in one.splitlines() if line.split()[:2] == ["7", "8"])
        self.assertIn(figures.split(), [line.split() for line in run(3, "octree", "torus:200x100", *options).stdout.splitlines()])


class Errors(DistributedTest):
    def octree_of(self, name, content):
        return ["octree", self.file(name, content)]

    def test_a_cut_file(self):
        whole = ply(*nasty_mesh(1))
        jobs = [[self.octree_of(f"cut_{length}.ply", whole[:length]), f"cut_{length}.ply"] for length in (0, 3, 50, 200, len(whole) // 2, len(whole) - 1)]
        jobs[-1].append("cut off")
        self.refuse_each(*jobs, [self.octree_of("more.ply", whole + b"x"), "bytes"])

    def test_files_that_are_not_of_triangles(self):
        positions, triangles = nasty_mesh(3)
        whole = ply(positions, triangles)
        beyond, four = bytearray(whole), bytearray(whole)
        beyond[-4:] = struct.pack("<i", len(positions))
        four[-13] = 4
        jobs = [[self.octree_of("beyond.ply", beyond), f"uses vertex {len(positions)}"], [self.octree_of("four.ply", four), "4 corners"]]
        positions[triangles[-1][0]] = [float("nan"), 0, 0]
        self.refuse_each(*jobs, [self.octree_of("nan.ply", ply(positions, triangles)), "nan.ply", "NaN"])

    def test_vertices_whose_coordinates_are_not_three_real_numbers(self):
        """Files of the size that their headers promise."""
        jobs = []
        for name, properties, says in (("twice", ("float x", "float x", "float y"), "each once"),
                                       ("four", ("float x", "float y", "float z", "double y"), "each once"),
                                       ("whole", ("int x", "float y", "float z"), "must be float or double")):
            lines = "".join(f"property {kind}\n" for kind in properties)
            header = f"ply\nformat binary_little_endian 1.0\nelement vertex 3\n{lines}element face 1\nproperty list uchar int vertex_indices\nend_header\n"
            letters = "<" + "".join(kind[0] for kind in properties)
            corners = b"".join(struct.pack(letters, *([corner] * len(properties))) for corner in range(3))
            jobs.append([self.octree_of(f"{name}.ply", header.encode() + corners + struct.pack("<B3i", 3, 0, 1, 2)), f"{name}.ply", says])
        self.refuse_each(*jobs)

    def test_coordinates_that_overflow_exact_arithmetic(self):
        jobs = []
        for name, far in (("high", 1e150), ("low", -1e150)):
            positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, far]]
            jobs.append([self.octree_of(f"{name}.ply", ply(positions, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])), f"{name}.ply", "scale the mesh"])
        self.refuse_each(*jobs)

    def test_files_that_are_not_there_or_of_another_kind(self):
        jobs = [[["octree", self.folder / "none.ply"], "none.ply"], [self.octree_of("mesh.obj", b""), "torus:NxM"]]
        for name, options in (("dir.ply", []), ("dir.pxo", []), ("dir.npy", ["--triangles", self.folder / "dir.npy"])):
            (self.folder / name).mkdir()
            jobs.append([["octree", self.folder / name, *options], f"{name}: ", "folder"])
        self.refuse_each(*jobs, ranks=2)

    def test_files_that_one_rank_alone_lacks(self):
        vertices, triangles = npy(nasty_mesh(1)[0], "<f8", "d"), npy(nasty_mesh(1)[1], "<i4", "i")
        arrays = ["vertices.npy", "--triangles", "triangles.npy"]
        octree = self.folder / "octree.pxo"
        self.proxima("octree", "torus:40x20", "--depth", 5, "--save", octree)
        files = {"mesh.ply": ply(*nasty_mesh(1)), "vertices.npy": vertices, "triangles.npy": triangles, "octree.pxo": octree.read_bytes()}
        folders = [self.folder / "0", self.folder / "1"]
        for folder in folders:
            folder.mkdir()
            for name, content in files.items():
                (folder / name).write_bytes(content)
        for name, arguments in (("mesh.ply", ["mesh.ply"]), ("vertices.npy", arrays), ("triangles.npy", arrays), ("octree.pxo", ["octree.pxo"])):
            (folders[1] / name).unlink()
            result = run_apart(*((folder, ["octree", *arguments]) for folder in folders))
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertEqual(len(messages(result.stderr)), 1, result.stderr)
            self.assertIn(f"{name}: cannot be opened for reading on rank 1", messages(result.stderr)[0])
            (folders[1] / name).write_bytes(files[name])

    def test_triangles_beside_another_model(self):
        triangles = self.file("triangles.npy", npy([[0, 1, 2]], "<i4", "i"))
        models = self.file("mesh.ply", ply(*nasty_mesh(1))), "torus:9x9"
        self.refuse_each(*([["octree", model, "--triangles", triangles], f"{model}: --triangles goes with vertices in a .npy file"] for model in models), ranks=2)

    def expect_different(self, name, contents, *arguments):
        folders = [self.folder / str(rank) for rank in range(len(contents))]
        for folder, content in zip(folders, contents):
            folder.mkdir(exist_ok=True)
            (folder / name).write_bytes(content)
        result = run_apart(*((folder, arguments) for folder in folders))
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual(len(messages(result.stderr)), 1, result.stderr)
        self.assertIn(f"{name}: rank {len(contents) - 1} reads another content", messages(result.stderr)[0])

    def test_ranks_that_read_different_files(self):
        """Of one name, in a folder for each rank: of other sizes, and with one bit changed at any place of a small one."""
        positions, triangles = nasty_mesh(1)
        mesh = ply(positions, triangles)
        chance = random.Random(7)
        others = [ply(*nasty_mesh(2)), mesh[:-1]]
        for _ in range(2):
            bad = bytearray(mesh)
            bad[chance.randrange(200, len(mesh))] ^= 1
            others.append(bytes(bad))
        for other in others:
            self.expect_different("mesh.ply", [mesh, mesh, other], "octree", "mesh.ply")
        vertices, corners = npy(positions, "<f8", "d"), npy(triangles, "<i4", "i")
        for folder in ("0", "1"):
            (self.folder / folder / "corners.npy").write_bytes(corners)
        self.expect_different("vertices.npy", [vertices, npy([[x + 1 for x in at] for at in positions], "<f8", "d")],
                              "octree", "vertices.npy", "--triangles", "corners.npy")
        octrees = []
        for model in ("torus:40x20", "torus:20x40"):
            self.proxima("octree", model, "--depth", 5, "--save", self.folder / "octree.pxo")
            octrees.append((self.folder / "octree.pxo").read_bytes())
        self.expect_different("octree.pxo", octrees, "octree", "octree.pxo")
        for folder in ("0", "1"):
            (self.folder / folder / "mesh.ply").write_bytes(mesh)
        same = run_apart(*((self.folder / folder, ["octree", "mesh.ply"]) for folder in ("0", "1")))
        self.assertEqual(same.returncode, 0, same.stderr)

    def test_ranks_with_other_arguments(self):
        for name in ("a.ply", "b.ply"):
            self.file(name, ply(*nasty_mesh(1)))
        result = run_apart((self.folder, ["octree", "a.ply"]), (self.folder, ["octree", "b.ply"]))
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(len(messages(result.stderr)), 1, result.stderr)
        self.assertIn("rank 1 has other arguments than rank 0, octree b.ply", messages(result.stderr)[0])

    def test_wrong_usage(self):
        for result in run_each((2, "octree", "torus:9x9", *arguments) for arguments in (["--depth", "19"], ["--routing-depth", "8"], ["--threshold", "-1"])):
            self.assertEqual(result.returncode, 2, result.stderr)


class Saving(DistributedTest):
    """Files by proxima-mpi are those of proxima: checked by it against the mesh, and read back on other numbers of ranks."""

    def expect_round_trip(self, model, *options):
        one = self.folder / "one.pxo"
        expected = self.figures(self.proxima("octree", model, *options, "--save", one))
        files = {ranks: self.folder / f"by_{ranks}.pxo" for ranks in (1, 3)}
        for file, result in zip(files.values(), run_each((ranks, "octree", model, *options, "--save", file) for ranks, file in files.items())):
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(self.figures(result.stdout), expected)
            self.assertIn("every invariant holds against", self.proxima("check", file, "--mesh", model))
            self.assertEqual(self.figures(self.proxima("octree", file)), expected)
            self.assertEqual(file.stat().st_size, one.stat().st_size)
        again = {ranks: self.folder / f"again_{ranks}.pxo" for ranks in (2, 4, 3)}
        jobs = [(ranks, "octree", file, "--save", again[ranks], "--routing-depth", ranks) for ranks, file in zip(again, (files[3], files[1], one))]
        for (ranks, file), result in zip(again.items(), run_each(jobs)):
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertGreater(max(row["Work us"] for row in self.rank_rows(result.stdout, ranks)), 0)
            self.assertEqual(self.figures(result.stdout), expected)
            self.assertIn("every invariant holds against", self.proxima("check", file, "--mesh", model))

    def test_files_of_other_numbers_of_ranks(self):
        self.expect_round_trip("torus:100x60", "--depth", 6, "--threshold", 4)
        self.expect_round_trip("torus:9x9", "--depth", 0)
        self.expect_round_trip(self.file("surfaces.ply", ply(*surfaces(1))), "--depth", 6, "--threshold", 1)

    def test_damaged_files(self):
        good = self.folder / "good.pxo"
        self.proxima("octree", "torus:40x20", "--depth", 5, "--save", good)
        content = good.read_bytes()
        files = [self.file(f"cut_{length}.pxo", content[:length]) for length in (0, 7, 39, 200, len(content) // 2, len(content) - 1)]
        chance = random.Random(5)
        for number in range(4):
            bad = bytearray(content)
            bad[chance.randrange(len(bad))] ^= 1 << chance.randrange(8)
            files.append(self.file(f"flipped_{number}.pxo", bad))
        self.proxima("octree", "torus:40x20", "--depth", 3, "--uniform", "--save", good)
        self.refuse_each(*([["octree", file], file.name] for file in files), [["octree", good], "good.pxo", "uniform"])

    def test_a_full_disk_keeps_the_old_file(self):
        file = self.file("old.pxo", b"old")
        result = on_a_full_disk("octree", "torus:100x60", "--depth", 7, "--save", file)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual(len(messages(result.stderr)), 1, result.stderr)
        self.assertIn("cannot write this file", messages(result.stderr)[0])
        self.assertEqual(file.read_bytes(), b"old")
        self.assertEqual([path.name for path in self.folder.iterdir()], ["old.pxo"])

    def test_a_rank_that_is_killed_amid_a_save_keeps_the_old_file(self):
        """The writer, when all is written and when the file is to get its name."""
        file = self.folder / "old.pxo"
        for call in ("fsync", "rename"):
            file.write_bytes(b"old")
            result = faulty(call, "kill", "octree", "torus:60x40", "--depth", 6, "--save", file)
            self.assertEqual(result.returncode, 128 + signal.SIGKILL, f"{call}: {result.stderr}")
            self.assertIn("signal 9", result.stderr)
            self.assertEqual(result.stdout.count("triangles,"), 0)
            self.assertEqual(file.read_bytes(), b"old", call)

    def test_the_next_run_removes_what_a_killed_one_left(self):
        for name, option in (("a.pxo", "--save"), ("a.pvtu", "--out")):
            left = self.file(".proxima-1-0.tmp", b"left")
            self.assertEqual(run(2, "octree", "torus:9x9", option, self.folder / name).returncode, 0)
            self.assertFalse(left.exists())

    def test_what_cannot_be_written(self):
        result = run(2, "octree", "torus:9x9", "--save", self.folder / "none" / "a.pxo")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("does not exist", messages(result.stderr)[0])
        self.assertEqual(run(2, "octree", "torus:9x9", "--save", self.folder / "a.ply").returncode, 2)
        self.proxima("octree", "torus:9x9", "--save", self.folder / "a.pxo")
        self.assertEqual(run(2, "octree", self.folder / "a.pxo", "--depth", 3).returncode, 1)


class Arrays(DistributedTest):
    def test_arrays_are_read_as_the_mesh_that_they_are(self):
        positions, triangles = ball_in_a_box(2)
        positions = [[struct.unpack("<f", struct.pack("<f", number))[0] for number in at] for at in positions]
        mesh = self.file("mesh.ply", ply(positions, triangles))
        options = ["--depth", 6, "--threshold", 2]
        expected = self.figures(self.proxima("octree", mesh, *options))
        for ranks, vertex_kind, corner_kind in ((1, ("<f4", "f"), ("<i8", "q")), (3, ("<f8", "d", 2), ("<u4", "I")), (4, ("<f8", "d"), ("<i2", "h", 2))):
            vertices = self.file("vertices.npy", npy(positions, *vertex_kind))
            corners = self.file("triangles.npy", npy(triangles, *corner_kind))
            saved = self.folder / "octree.pxo"
            result = run(ranks, "octree", vertices, "--triangles", corners, *options, "--save", saved)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(self.figures(result.stdout), expected)
            self.assertIn("every invariant holds against", self.proxima("check", saved, "--mesh", mesh))

    def test_arrays_that_are_no_mesh(self):
        positions, triangles = shell(random.Random(1), [0, 0, 0], 1, 5)
        vertices, corners = npy(positions, "<f8", "d"), npy(triangles, "<i4", "i")
        jobs = []
        for number, (of_vertices, of_triangles, *says) in enumerate((
                (vertices[:-1], corners, "vertices.npy", "cut off"),
                (vertices, corners[:-1], "triangles.npy", "cut off"),
                (vertices[:60], corners, "vertices.npy"),
                (b"", corners),
                (corners, corners, "vertices.npy", "real numbers"),
                (vertices, vertices, "triangles.npy", "whole numbers"),
                (vertices, npy([], "<i4", "i"), "no triangles"),
                (vertices, npy([[0, 1, -1]], "<i8", "q"), "uses vertex -1"),
                (vertices, npy([[0, 1, len(positions)]], "<u8", "Q"), f"uses vertex {len(positions)}"),
                (vertices.replace(b"False", b"True "), corners, "C order"),
                (npy(positions, ">f8", "d"), corners, "little-endian"))):
            files = [self.file(f"{number}_{name}.npy", content) for name, content in (("vertices", of_vertices), ("triangles", of_triangles))]
            jobs.append([["octree", files[0], "--triangles", files[1]], *says])
        self.refuse_each(*jobs)


class Exporting(DistributedTest):
    READER = Path(__file__).parent.parent / "octree" / "read_exported_leaves.py"

    def leaves(self, path):
        result = subprocess.run(["/usr/bin/python3", self.READER, path], capture_output=True, text=True)
        if result.returncode == 77:
            self.skipTest(result.stdout)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def test_paraview_has_the_leaves_of_one_process(self):
        options = ["--depth", 6, "--threshold", 2]
        for model in ("torus:30x20", self.file("ball & box.ply", ply(*ball_in_a_box(1)))):
            one = self.folder / "one.vtu"
            self.proxima("octree", model, *options, "--out", one)
            expected = self.leaves(one)
            for ranks in (1, 3):
                path = self.folder / f"a & <b> {ranks}.pvtu"
                result = run(ranks, "octree", model, *options, "--out", path)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertEqual(path.read_text().count("<Piece"), ranks)
                self.assertEqual(self.leaves(path), expected)

    def test_ranks_without_leaves_have_no_piece(self):
        path = self.folder / "leaves.pvtu"
        self.assertEqual(run(4, "octree", "torus:9x9", "--depth", 0, "--out", path).returncode, 0)
        self.assertEqual(path.read_text().count("<Piece"), 1)
        self.assertEqual(self.leaves(path).count("\n"), 2)

    def test_an_export_that_fails_leaves_none(self):
        path = self.folder / "leaves.pvtu"
        self.assertEqual(run(3, "octree", "torus:30x20", "--out", path).returncode, 0)
        (self.folder / "leaves_1.vtu").unlink()
        (self.folder / "leaves_1.vtu").mkdir()
        result = run(3, "octree", "torus:40x20", "--out", path)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual(len(messages(result.stderr)), 1, result.stderr)
        self.assertIn("leaves_1.vtu: cannot write this file", result.stderr)
        self.assertEqual([left.name for left in self.folder.iterdir()], ["leaves_1.vtu"])


if __name__ == "__main__":
    unittest.main()
