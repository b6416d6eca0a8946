"""proxima-mpi closest, rays and sign on 1 to 4 ranks: the answers are those of one process, and bad input ends all with one message."""
import os
import random
import signal
import struct
import subprocess
import unittest

from generated_meshes import nasty_mesh, ply
from generated_meshes import npy as mesh_npy
from mpi_program import EVERY, PROXIMA, SEED, DistributedTest, command, faulty, messages, on_a_full_disk, ranks_of, run, run_each, some, some_ranks



def rows(table, columns):
    return (columns + "\n" + "".join(",".join(map(repr, row)) + "\n" for row in table)).encode()


def npy(table, order="C"):
    header = f"{{'descr': '<f8', 'fortran_order': {order == 'F'}, 'shape': ({len(table)}, {len(table[0])}), }}"
    header += " " * (-(11 + len(header)) % 64) + "\n"
    numbers = [x for row in (zip(*table) if order == "F" else table) for x in row]
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + struct.pack(f"<{len(numbers)}d", *numbers)


def middle(*corners):
    return [sum(axis) / len(corners) for axis in zip(*corners)]


def nasty_points(chance, positions, triangles, count):
    """Points on vertices, on middles of edges and faces, near them, far away, and between two vertices: many are as near to several features."""
    def of_triangle():
        return [positions[corner] for corner in chance.choice(triangles)]

    def between():
        return middle(chance.choice(positions), chance.choice(positions))

    kinds = [lambda: list(chance.choice(of_triangle())), lambda: middle(*of_triangle()[:2]), lambda: middle(*of_triangle()), between,
             lambda: [x + chance.gauss(0, 0.1) for x in middle(*of_triangle())], lambda: [x * 10.0 ** chance.randrange(1, 80) for x in between()],
             lambda: [float(chance.randrange(-2, 11)) for _ in range(3)]]
    return [[float(x) for x in chance.choice(kinds)()] for _ in range(count)]


def copies(positions, triangles, shift):
    """Two of a mesh: every feature of the first has one of the second at its place."""
    count = len(positions)
    second = [[x + shift for x in at] for at in positions]
    return positions + second, triangles + [[corner + count for corner in corners] for corners in triangles]


class QueryTest(DistributedTest):
    def sample(self, name):
        """A built-in mesh, as a file: with positions that are no floats."""
        path = self.folder / f"{name.replace(':', '_')}.ply"
        if not path.exists():
            subprocess.run([PROXIMA, "repair", name, "--out", path], check=True, capture_output=True)
        return path

    def verify(self, command, model, table, *options, ranks=None):
        """Runs with --verify on so many ranks: all write the same bytes."""
        ranks = list(dict.fromkeys(ranks or some_ranks()))
        outs = [self.folder / f"out_{count}.csv" for count in ranks]
        option = {"closest": "--points", "sign": "--points", "rays": "--rays"}[command]
        results = run_each((count, command, model, option, table, "--out", out, "--verify", *options) for count, out in zip(ranks, outs))
        for count, result in zip(ranks, results):
            self.assertEqual(result.returncode, 0, f"{model} on {count} ranks, seed {SEED}: {result.stderr}")
            self.assertIn("Answers are those of one process.", result.stdout)
        written = {out.read_bytes() for out in outs}
        self.assertEqual(len(written), 1)
        return written.pop().decode()


class Closest(QueryTest):
    def expect_same(self, name, positions, triangles, points, **options):
        model = self.file(f"{name}.ply", ply(positions, triangles))
        return self.verify("closest", model, self.file("points.csv", rows(points, "x,y,z")), **options)

    def test_torus(self):
        chance = random.Random(SEED)
        points = [[chance.uniform(-2, 2) for _ in range(3)] for _ in range(3000)]
        points += [[0.0, 0.0, float(z)] for z in range(3)]
        table = self.file("points.csv", rows(points, "x,y,z"))
        written = self.verify("closest", "torus:60x40", table)
        out = self.folder / "one.csv"
        subprocess.run([PROXIMA, "closest", "torus:60x40", "--points", table, "--out", out], check=True, capture_output=True)
        self.assertEqual(written, out.read_text())

    def test_nasty_meshes(self):
        for k in some(range(3), 2):
            chance = random.Random(SEED + k)
            positions, triangles = nasty_mesh(SEED + k)
            points = nasty_points(chance, positions, triangles, 400)
            self.expect_same(f"nasty_{k}", positions, triangles, points, ranks=(2 + k,))

    def test_ties_across_parts(self):
        """Duplicates of triangles with their own vertices and edges, in random order, and the middle of a ball."""
        chance = random.Random(SEED)
        grid = [[float(x), float(y), 0.0] for x in range(9) for y in range(9)]
        squares = [9 * x + y for x in range(8) for y in range(8)]
        triangles = [t for at in squares for t in ([at, at + 9, at + 10], [at, at + 10, at + 1])]
        chance.shuffle(triangles)
        positions, triangles = copies(grid, triangles, 0.0)
        points = [[float(chance.randrange(9)), chance.randrange(17) / 2, chance.choice([0.0, 1.0])] for _ in range(600)]
        self.expect_same("grid", positions, triangles, points)
        self.verify("closest", self.sample("icosphere:3"), self.file("middle.csv", rows([[0.0] * 3, [1e-17, 0.0, 0.0]], "x,y,z")))

    def test_few_triangles(self):
        positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        chance = random.Random(SEED)
        for triangles in ([[0, 1, 2]], [[0, 1, 2], [0, 2, 3]], [[0, 0, 0]], [[1, 1, 2], [3, 3, 3], [2, 1, 1]]):
            self.expect_same("few", positions, triangles, nasty_points(chance, positions, triangles, 60), ranks=(3,))

    def test_far_from_the_origin_and_sizes(self):
        for k, (scale, shift) in some(enumerate([(1.0, 1e9), (1e-150, 0.0), (1e-200, 0.0), (1e60, 0.0), (1e-9, 1.0)]), 3):
            chance = random.Random(SEED + k)
            positions, triangles = nasty_mesh(SEED + k)
            positions = [[x * scale + shift for x in at] for at in positions]
            points = [[x * scale + shift for x in at] for at in nasty_points(chance, positions, triangles, 200)]
            points = [[min(max(x, -1e300), 1e300) for x in at] for at in points]
            self.expect_same(f"sized_{k}", positions, triangles, points, ranks=(3,))

    def test_options(self):
        self.verify("closest", "torus:30x20", self.file("points.csv", b"0,0,0\n"), "--routing-depth", 0, ranks=(3,))
        result = run(2, "closest", "torus:30x20", "--point", "3,0,0", "--point", "0,0,0")
        one = subprocess.run([PROXIMA, "closest", "torus:30x20", "--point", "3,0,0", "--point", "0,0,0"], capture_output=True, text=True)
        self.assertEqual(result.stdout, one.stdout)


def nasty_rays(chance, positions, triangles, count):
    """Rays at and along vertices, edges and faces, from on them, along axes, and of any length and range."""
    def target():
        corners = [positions[corner] for corner in chance.choice(triangles)]
        return chance.choice([corners[0], middle(*corners[:2]), middle(*corners), [x + chance.gauss(0, 0.3) for x in corners[0]]])

    def ray():
        origin, at = target(), target()
        if chance.random() < 0.5:
            origin = [x + chance.randrange(-9, 10) for x in origin]
        direction = [b - a for a, b in zip(origin, at)]
        if chance.random() < 0.3:
            direction = [float(chance.randrange(-1, 2)) for _ in range(3)]
        if not any(direction):
            direction = [0.0, 0.0, -1.0]
        scale = chance.choice([1.0, 1.0, 1e-9, 1e90, 1e-250])
        limits = sorted(chance.choice([0.0, 0.25, 1.0, 2.0, -1.0]) for _ in range(2)) if chance.random() < 0.4 else [0.0, float("inf")]
        return [*map(float, origin), *(x * scale for x in direction), *limits]

    return [ray() for _ in range(count)]


class Rays(QueryTest):
    columns = "ox,oy,oz,dx,dy,dz,tmin,tmax"

    def expect_same(self, name, positions, triangles, rays, **options):
        model = self.file(f"{name}.ply", ply(positions, triangles))
        return self.verify("rays", model, self.file("rays.csv", rows(rays, self.columns)), **options)

    def test_torus(self):
        chance = random.Random(SEED)
        table = self.file("rays.csv", rows([[chance.uniform(-2, 2) for _ in range(6)] for _ in range(3000)], "ox,oy,oz,dx,dy,dz"))
        written = self.verify("rays", "torus:60x40", table)
        self.assertGreater(written.count(",inf,-1,"), 300)
        out = self.folder / "one.csv"
        subprocess.run([PROXIMA, "raycast", "torus:60x40", "--rays", table, "--out", out], check=True, capture_output=True)
        self.assertEqual(written, out.read_text())

    def test_nasty_meshes(self):
        for k in some(range(3), 2):
            chance = random.Random(SEED + k)
            positions, triangles = nasty_mesh(SEED + k)
            rays = nasty_rays(chance, positions, triangles, 600)
            self.expect_same(f"nasty_{k}", positions, triangles, rays, ranks=(2 + k,))

    def test_duplicates_and_sizes(self):
        for k, (scale, shift) in some(enumerate([(1.0, 1e7), (1e-100, 0.0), (1e60, 0.0)]), 2):
            chance = random.Random(SEED + k)
            positions, triangles = copies(*nasty_mesh(SEED + k), 0.0)
            rays = nasty_rays(chance, positions, triangles, 300)
            positions = [[x * scale + shift for x in at] for at in positions]
            rays = [[x * scale + shift for x in ray[:3]] + [x * scale for x in ray[3:6]] + ray[6:] for ray in rays]
            rays = [ray if any(ray[3:6]) else [*ray[:3], 1.0, 0.0, 0.0, *ray[6:]] for ray in rays]
            self.expect_same(f"sized_{k}", positions, triangles, rays, ranks=(3,))


def octahedron(center, radius, inside_out=False):
    positions = [[c + sign * radius * (axis == k) for k, c in enumerate(center)] for axis in range(3) for sign in (1, -1)]
    triangles = [[x, y, z] if (x + y + z) % 2 == inside_out else [y, x, z] for x in (0, 1) for y in (2, 3) for z in (4, 5)]
    return positions, triangles


def join(*meshes):
    positions, triangles = [], []
    for at, corners in meshes:
        triangles += [[corner + len(positions) for corner in triangle] for triangle in corners]
        positions += at
    return positions, triangles


class Sign(QueryTest):
    def expect_same(self, name, mesh, points, **options):
        model = self.file(f"{name}.ply", ply(*mesh))
        written = self.verify("sign", model, self.file("points.csv", rows(points, "x,y,z")), **options)
        return [line.split(",") for line in written.splitlines()[1:]]

    def test_torus(self):
        chance = random.Random(SEED)
        points = [[chance.uniform(-1.6, 1.6), chance.uniform(-1.6, 1.6), chance.uniform(-0.6, 0.6)] for _ in range(3000)]
        written = self.verify("sign", "torus:60x40", self.file("points.csv", rows(points, "x,y,z")))
        inside = written.count(",-")
        self.assertGreater(written.count("winding_number"), 2990)
        self.assertGreater(inside, 300)

    def test_solids(self):
        """In each other, overlapping, inside out, twice at the same place, in pieces and with faces that have no area."""
        chance = random.Random(SEED)
        ball, inner, beside = octahedron([0, 0, 0], 4.0), octahedron([0, 0, 0], 2.0), octahedron([3, 0, 0], 4.0)
        solids = {"nested": join(ball, inner), "hollow": join(ball, octahedron([0, 0, 0], 2.0, True)), "overlapping": join(ball, beside),
                  "inside_out": octahedron([0, 0, 0], 4.0, True), "twice": join(ball, ball), "three": join(beside, inner, octahedron([1, 20, 0], 0.5))}
        positions, triangles = ball
        solids["no_area"] = positions, triangles + [[0, 0, 2], [3, 3, 3], [1, 4, 4]]
        for name, mesh in some(solids.items(), 4):
            points = nasty_points(chance, *mesh, 500)
            found = self.expect_same(name, mesh, points, ranks=(chance.randrange(1, 5),))
            self.assertGreater(sum(row[-1] == "on_surface" for row in found), 50)

    def test_samples(self):
        chance = random.Random(SEED)
        for name in some(("icosphere:3", "sphere:20x30", "spaceship:2000"), 2):
            points = [[chance.choice([chance.uniform(-1, 1), chance.randrange(-4, 5) / 4]) for _ in range(3)] for _ in range(1500)]
            self.verify("sign", self.sample(name), self.file("points.csv", rows(points, "x,y,z")), ranks=(1, 4))

    def test_far_from_the_origin(self):
        chance = random.Random(SEED)
        positions, triangles = octahedron([1e8, -3e7, 1e5], 1 / 3)
        found = self.expect_same("far", (positions, triangles), nasty_points(chance, positions, triangles, 500))
        self.assertIn("winding_number", {row[-1] for row in found})

    def test_open_meshes(self):
        """With holes, with faces turned over, sheets, and whatever triangles; points of edges and faces, far away and in the planes of holes."""
        chance = random.Random(SEED)
        positions, triangles = octahedron([0, 0, 0], 4.0)
        meshes = [(positions, triangles[1:]), (positions, [triangles[0][::-1], *triangles[1:]]), (positions, triangles[:4]),
                  join((positions, triangles[1:]), octahedron([1, 0, 0], 1.0)), *(nasty_mesh(SEED + k) for k in range(4))]
        inside = 0
        for k, mesh in [*some(enumerate(meshes[:4]), 2), *some(enumerate(meshes[4:], 4), 2)]:
            points = nasty_points(chance, *mesh, 300)
            inside += sum(float(row[-2]) < 0 for row in self.expect_same(f"open_{k}", mesh, points, ranks=(chance.randrange(1, 5),)))
        self.assertGreater(inside, 100 if EVERY else 20)

    def test_open_meshes_from_far_away(self):
        """Where powers of the distance overflow; and inside of many sheets, though outside of their box."""
        sheet = [[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]]
        far = [[sign * 10.0 ** k, 0.5, -1.0] for k in (1, 3, 8, 20, 52, 80, 103, 110, 155, 250, 307) for sign in (1, -1)]
        near = [[0.1, 0.2, sign * 2.0 ** k] for k in range(-8, 12) for sign in (1, -1)]
        for size in some((1.0, 1e-100, 1e90), 2):
            mesh = join(*([([[x * size for x in at] for at in sheet], [[0, 1, 2]])] * 40))
            points = far + [[x * size for x in at] for at in near]
            inside = [float(row[-2]) < 0 for row in self.expect_same("sheets", mesh, points, ranks=(3,))]
            self.assertGreater(sum(inside[len(far):]), 5)
            if size < 1e90:
                self.assertFalse(any(inside[:len(far)]))

    def test_what_rounding_would_decide(self):
        """A point whose winding number differs from the limit, 1/2 - 2^-40, by less than 2^-42: between one inside and one outside, ever closer."""
        positions, triangles = octahedron([0, 0, 0], 1.0)
        model = self.file("open.ply", ply(positions, [t for t in triangles if 4 not in t]))
        low, high = -0.5, 0.5  # z: inside of the lower half, above it
        for _ in range(8):
            heights = [low + (high - low) * k / 512 for k in range(513)]
            result = run(1, "sign", model, "--points", self.file("z.csv", rows([[0.1, 0.05, z] for z in heights], "x,y,z")))
            if result.returncode != 0:
                break
            outside = next(k for k, line in enumerate(result.stdout.splitlines()[1:]) if not line.split(",")[-2].startswith("-"))
            low, high = heights[outside - 1:outside + 1]
        for ranks in (1, 3):
            result = run(ranks, "sign", model, "--points", self.folder / "z.csv")
            self.assertEqual(result.returncode, 1)
            self.assertRegex(result.stderr, r"proxima-mpi: the mesh is open, and whether point \d+ is inside hangs on rounding")


class Tables(QueryTest):
    def test_arrays_and_texts(self):
        """More rows than go round at once, read in blocks; the same answers from both orders of an array and from text."""
        chance = random.Random(SEED)
        points = [[chance.uniform(-2, 2) for _ in range(3)] for _ in range(300000)]
        written = [self.folder / f"{k}.npy" for k in range(4)]
        tables = [self.file("c.npy", npy(points)), self.folder / "c.npy", self.file("f.npy", npy(points, "F")), self.file("t.txt", rows(points, "x,y,z"))]
        for result in run_each((ranks, "closest", "torus:9x9", "--points", table, "--out", out) for ranks, table, out in zip((1, 2, 2, 1), tables, written)):
            self.assertEqual(result.returncode, 0, result.stderr)
        one = self.folder / "one.npy"
        subprocess.run([PROXIMA, "closest", "torus:9x9", "--points", self.folder / "c.npy", "--out", one], check=True, capture_output=True)
        for out in written:
            self.assertTrue(out.read_bytes() == one.read_bytes(), out)

    def test_many_ranks_hold_no_more_rows_at_once(self):
        """The first rank reads all rows of a block, and one rank is asked them all."""
        one = npy([[0.5, 0.25, 2.0]])
        header = one[:-24].replace(b"(1, 3), }" + b" " * 6, b"(2200000, 3), }")
        points = self.file("points.npy", header + one[-24:] * 2200000)
        out = self.folder / "out.npy"
        result = run(16, "closest", "torus:9x9", "--points", points, "--out", out)
        self.assertEqual(result.returncode, 0, result.stderr)
        ranks = [line.split() for line in result.stdout.splitlines() if len(line.split()) == 6 and line.split()[0].isdigit()]
        self.assertEqual(len(ranks), 16)
        self.assertLess(max(int(rank[-1]) for rank in ranks), 280)  # MB

    def test_meshes_as_arrays(self):
        chance = random.Random(SEED)
        positions, triangles = nasty_mesh(SEED)
        points = self.file("points.csv", rows(nasty_points(chance, positions, triangles, 300), "x,y,z"))
        whole = self.file("mesh.ply", ply(positions, triangles))
        arrays = [self.file("vertices.npy", mesh_npy(positions, "<f8", "d")), "--triangles", self.file("triangles.npy", mesh_npy(triangles, "<i4", "i"))]
        answers = [run(ranks, "closest", *mesh, "--points", points) for ranks, mesh in ((1, [whole]), (3, arrays))]
        self.assertEqual(answers[0].returncode, 0, answers[0].stderr)
        self.assertEqual(answers[0].stdout, answers[1].stdout, f"seed {SEED}: {answers[1].stderr}")
        result = run(2, "closest", *arrays, "--points", points, "--verify")
        self.assertIn("--verify is for meshes that one process reads", result.stderr)

    def test_bad_rows_of_later_blocks(self):
        table = [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0] for _ in range(300000)]
        jobs = []
        for name, number, length, says in (("zero", 0.0, None, "zero.npy, row 290000: this is no ray"), ("cut", 0.0, -8, "cut.npy: the header says 300000 rows"),
                                           ("nan", float("nan"), None, "row 290000 from 0: nan is no finite number")):
            table[290000][3] = number
            rays = self.file(f"{name}.npy", npy(table)[:length])
            jobs.append([["rays", "torus:9x9", "--rays", rays, "--out", self.folder / f"{name}.csv"], says])
        self.refuse_each(*jobs, ranks=2)
        self.assertEqual(list(self.folder.glob("*.csv")), [])


class QueryErrors(QueryTest):
    def test_bad_points(self):
        cases = ((b"x,y,z\n1,2\n", "points_0.csv:2"), (b"1,2,nan\n", "points_1.csv:1"), (b"", "empty"), (b"1,2\n", "x,y,z"))
        jobs = [[["closest", "torus:9x9", "--points", self.file(f"points_{number}.csv", content)], says] for number, (content, says) in enumerate(cases)]
        self.refuse_each(*jobs, [["closest", "torus:9x9", "--points", self.folder / "none.csv"], "none.csv"])

    def test_bad_rays(self):
        cases = ((b"0,0,0,0,0,0\n", "rays_0.csv:1: this is no ray"), (b"0,0,0,1,0,0,3,2\n", "tmin"), (b"1,2,3\n", "ox,oy,oz"))
        self.refuse_each(*([["rays", "torus:9x9", "--rays", self.file(f"rays_{number}.csv", content)], says] for number, (content, says) in enumerate(cases)))

    def test_outputs(self):
        points = self.file("points.csv", b"1,2,3\n")
        self.refuse_each([["closest", "torus:9x9", "--points", points, "--out", "answers.txt"], "answers.txt"],
                         [["closest", "torus:9x9", "--points", points, "--out", self.folder / "none" / "a.csv"], "none"],
                         [["closest", self.folder / "none.ply", "--points", points, "--out", self.folder / "a.csv"], "none.ply"])
        self.assertFalse((self.folder / "a.csv").exists())

    def test_usage(self):
        jobs = [(3, "closest", "torus:9x9"), (3, "closest", "torus:9x9", "--point", "1,2,3", "--points", "x.csv")]
        for result in run_each(jobs):
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn("--point", result.stderr)


class QueryFaults(QueryTest):
    """A disk that is full, and ranks that are killed: one error, and the old table stays."""

    def jobs(self):
        points, rays = self.file("points.csv", b"1,2,3\n0,0,0\n"), self.file("rays.csv", b"0,0,5,0,0,-1\n")
        for name, table, ending in (("closest", ["--points", points], ".csv"), ("sign", ["--points", points], ".npy"), ("rays", ["--rays", rays], ".csv")):
            out = self.file(f"old{ending}", b"old")
            yield out, [name, "torus:9x9", *table, "--out", out]

    def expect_old(self, result, out):
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertEqual(len(messages(result.stderr)), 1, result.stderr)
        self.assertIn(out.name, messages(result.stderr)[0])
        self.assertEqual(out.read_bytes(), b"old")
        self.assertEqual(list(self.folder.glob(".proxima-*")), [])

    def test_a_disk_that_is_full_at_the_end_keeps_the_old_table(self):
        for out, arguments in self.jobs():
            self.expect_old(faulty("fsync", "fail", *arguments), out)

    def test_a_disk_that_is_full_amid_rows_keeps_the_old_table(self):
        table = self.file("points.npy", npy([[1.0, 2.0, 3.0]] * 9000))
        for name in ("closest", "sign"):
            out = self.file("old.csv", b"old")
            self.expect_old(on_a_full_disk(name, "torus:9x9", "--points", table, "--out", out), out)

    def test_a_writer_that_is_killed_keeps_the_old_table(self):
        for out, arguments in self.jobs():
            result = faulty("rename", "kill", *arguments)
            self.assertEqual(result.returncode, 128 + signal.SIGKILL, result.stderr)
            self.assertIn("signal 9", result.stderr)
            self.assertEqual(out.read_bytes(), b"old")

    def test_a_rank_that_is_killed_amid_answers(self):
        chance = random.Random(SEED)
        points = self.file("points.npy", npy([[chance.uniform(-2, 2) for _ in range(3)] for _ in range(40000)] * 30))
        rays = self.file("rays.npy", npy([[chance.uniform(-2, 2) for _ in range(6)] for _ in range(20000)] * 30))
        for name, option, table in (("closest", "--points", points), ("sign", "--points", points), ("rays", "--rays", rays)):
            out = self.file("old.csv", b"old")
            process = subprocess.Popen(command(3, "--progress", name, "torus:300x200", option, table, "--out", out), text=True,
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.addCleanup(process.kill)
            while "answering" not in (line := process.stderr.readline()):
                self.assertNotEqual(line, "", "the run ended before it answered")
            os.kill(ranks_of(process)[1], signal.SIGKILL)
            _, errors = process.communicate(timeout=200)
            self.assertEqual(process.returncode, 128 + signal.SIGKILL, errors)
            self.assertIn("signal 9", errors)
            self.assertEqual(out.read_bytes(), b"old")


if __name__ == "__main__":
    unittest.main()
