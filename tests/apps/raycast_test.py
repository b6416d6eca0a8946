"""proxima raycast as its users run it, against slabs and determinants that are written here in fractions."""
import csv
import io
import itertools
import math
import random
import struct
import unittest
import zlib
from fractions import Fraction

from bad_input_test import off
from mesh_oracle import cross, dot, sub
from npy_tables import read_npy
from proxima_program import ProgramTest

HIT_COLUMNS = ["index", "t", "triangle", "u", "v"]
CELL_COLUMNS = ["ray", "cell_depth", "cx", "cy", "cz", "enter", "exit", "chord", "penetration"]
KEYS = ["model", "triangles", "queries", "seconds", "ns_per_query", "build_seconds", "bytes", "method"]


def rays_text(rays, header=False):
    head = "ox,oy,oz,dx,dy,dz" + (",tmin,tmax" if len(rays[0]) == 8 else "") + "\n" if header else ""
    return head + "".join(",".join(map(repr, ray)) + "\n" for ray in rays)


def npy(rays):
    header = "{'descr': '<f8', 'fortran_order': False, 'shape': (%d, %d), }" % (len(rays), len(rays[0]))
    return (b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header) + 1) + header.encode() + b"\n"
            + b"".join(struct.pack("<%dd" % len(ray), *ray) for ray in rays))


def first_hit(points, triangles, ray):
    """(t, triangle, u, v) of the least t, in fractions; rays in a triangle's plane do not occur."""
    origin, direction = ([Fraction(x) for x in ray[i:i + 3]] for i in (0, 3))
    low, high = (Fraction(ray[6]), Fraction(ray[7])) if len(ray) == 8 else (Fraction(0), None)
    best = None
    for id, triangle in enumerate(triangles):
        a, b, c = ([Fraction(x) for x in points[v]] for v in triangle)
        normal = cross(sub(b, a), sub(c, a))
        slope = dot(normal, direction)
        if slope == 0:
            continue
        corners = [sub(p, origin) for p in (a, b, c)]
        weights = [dot(direction, cross(corners[(i + 1) % 3], corners[(i + 2) % 3])) / slope for i in range(3)]
        t = dot(normal, corners[0]) / slope
        if min(weights) < 0 or t < low or (high is not None and t > high):
            continue
        if best is None or t < best[0]:
            best = (t, id, weights[1], weights[2])
    return best


def some_mesh(rng, count):
    points = [tuple(rng.randint(-16, 16) / 8 for _ in range(3)) for _ in range(3 * count)]
    return points, [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(count)]


def some_rays(rng, count):
    return [tuple(rng.uniform(-3, 3) for _ in range(3)) + tuple(rng.uniform(-1, 1) for _ in range(3))
            for _ in range(count)]


def unfiltered(kind, row, last):
    """The bytes of a PNG's row of RGB: they were stored less a guess, from those to the left and in the row above."""
    if kind == 0:
        return row
    if kind == 2:
        return bytes((stored + up) & 255 for stored, up in zip(row, last))
    colors = []
    for color in range(3):
        left = corner = 0
        values = bytearray()
        for stored, up in zip(row[color::3], last[color::3]):
            if kind == 1:
                guess = left
            elif kind == 3:
                guess = (left + up) // 2
            elif up == corner:
                guess = left  # what follows, sooner
            else:
                of_left, of_up, of_corner = abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)
                guess = left if of_left <= of_up and of_left <= of_corner else up if of_up <= of_corner else corner
            left, corner = (stored + guess) & 255, up
            values.append(left)
        colors.append(values)
    return bytes(value for pixel in zip(*colors) for value in pixel)


def read_png(data):
    """Width, height and rows of RGB bytes of a PNG of 8-bit colours."""
    place, packed = 8, b""
    while place < len(data):
        length, kind = struct.unpack_from(">I4s", data, place)
        body = data[place + 8:place + 8 + length]
        if kind == b"IHDR":
            width, height, bits, color = struct.unpack_from(">IIBB", body)
            assert (bits, color) == (8, 2)
        if kind == b"IDAT":
            packed += body
        place += 12 + length
    raw, rows, last = zlib.decompress(packed), [], bytes(3 * width)
    for begin in range(0, height * (3 * width + 1), 3 * width + 1):
        last = unfiltered(raw[begin], raw[begin + 1:begin + 3 * width + 1], last)
        rows.append(last)
    return width, height, rows


class Hits(ProgramTest):
    def check(self, rows, points, triangles, rays):
        hits = 0
        for i, (row, ray) in enumerate(zip(rows, rays)):
            truth = first_hit(points, triangles, ray)
            self.assertEqual(row[0], i)
            if truth is None:
                self.assertEqual(row[1:], (float("inf"), -1, 0, 0))
                continue
            hits += 1
            self.assertEqual(row[2], truth[1])
            for value, exact in zip((row[1], row[3], row[4]), (truth[0], truth[2], truth[3])):
                self.assertLess(abs(Fraction(value) - exact), Fraction(1, 10**9) * (1 + abs(exact)))
        self.assertEqual(len(rows), len(rays))
        return hits

    def test_are_those_of_fractions_in_csv_and_npy(self):
        rng = random.Random(5)
        points, triangles = some_mesh(rng, 40)
        model = self.file("m.off", off(points, triangles))
        for rays in (some_rays(rng, 150), [ray + (0.5, 3.0) for ray in some_rays(rng, 150)]):
            out = self.folder / "hits.csv"
            path = self.file("rays.csv", rays_text(rays, header=True))
            json = self.json_of("raycast", model, "--rays", path, "--out", out)
            lines = list(csv.reader(io.StringIO(out.read_text())))
            self.assertEqual(lines[0], HIT_COLUMNS)
            rows = [tuple(map(float, line)) for line in lines[1:]]
            hits = self.check(rows, points, triangles, rays)
            self.assertGreater(hits, 20)
            self.assertEqual(list(json), KEYS + ["hits"])
            self.assertEqual((json["triangles"], json["queries"], json["hits"]), (40, len(rays), hits))
            out = self.folder / "hits.npy"
            self.succeed("raycast", model, "--rays", self.file("rays.npy", npy(rays)), "--out", out)
            self.assertEqual(read_npy(out.read_bytes()), rows)

    def test_do_not_depend_on_threads(self):
        path = self.file("rays.csv", rays_text(some_rays(random.Random(6), 3000)))
        answers = {self.succeed("raycast", "torus:30x20", "--rays", path, "--out", "-", "--threads", n)
                   for n in (1, 3)}
        self.assertEqual(len(answers), 1)


def inside(ray):
    """From where to where a ray is in the cube of edge 3 about the origin."""
    sides = [sorted(((-1.5 - o) / d, (1.5 - o) / d)) for o, d in zip(ray, ray[3:])]
    return max(0, *(low for low, _ in sides)), min(high for _, high in sides)


class Cells(ProgramTest):
    def test_join_and_lie_on_the_ray(self):
        rays = some_rays(random.Random(7), 40)
        path = self.file("rays.csv", rays_text(rays))
        out = self.folder / "cells.csv"
        json = self.json_of("raycast", "torus:30x20", "--rays", path, "--cells", "--depth", 4, "--out", out)
        lines = list(csv.reader(io.StringIO(out.read_text())))
        self.assertEqual(lines[0], CELL_COLUMNS)
        self.assertEqual(list(json), KEYS + ["cells"])
        self.assertEqual(json["cells"], len(lines) - 1)
        self.assertGreater(len(lines), 40)
        by_ray = {}
        for line in lines[1:]:
            by_ray.setdefault(int(line[0]), []).append([float(x) for x in line[1:]])
        for i, cells in by_ray.items():
            length = dot(rays[i][3:], rays[i][3:]) ** 0.5
            for one, other in zip(cells, cells[1:]):
                self.assertEqual(one[5], other[4])
                self.assertNotEqual(one[:4], other[:4])
            for depth, *at, enter, leave, chord, penetration in cells:
                self.assertLessEqual(enter, leave)
                self.assertAlmostEqual(chord, (leave - enter) * length, 12)
                self.assertTrue(0 <= penetration <= 1)
                # The root is the cube of edge 3 about the torus.
                edge = 3 / 2 ** depth
                for t in (enter, leave):
                    for o, d, x in zip(rays[i], rays[i][3:], at):
                        self.assertAlmostEqual(min(max(o + t * d, edge * x - 1.5), edge * (x + 1) - 1.5), o + t * d, 12)
                self.assertTrue(all(0 <= x < 2 ** depth for x in at))
            # From one side of the cube, or the ray's origin, to the other.
            self.assertAlmostEqual(cells[0][4], inside(rays[i])[0], 12)
            self.assertAlmostEqual(cells[-1][5], inside(rays[i])[1], 12)
        self.assertEqual(set(by_ray), {i for i, ray in enumerate(rays) if inside(ray)[0] < inside(ray)[1]})


class Pictures(ProgramTest):
    def test_show_the_model_in_the_middle(self):
        for flags, background in (([], None), (["--cells"], (0, 0, 0))):
            out = self.folder / "picture.png"
            self.succeed("raycast", "icosphere:2", "--size", "60x40", "--picture", out, *flags)
            width, height, rows = read_png(out.read_bytes())
            self.assertEqual((width, height), (60, 40))
            corner, middle = (tuple(rows[y][3 * x:3 * x + 3]) for x, y in ((0, 0), (30, 20)))
            self.assertNotEqual(corner, middle)
            if background is not None:
                self.assertEqual(corner, background)
                pixels = {tuple(row[3 * x:3 * x + 3]) for row in rows for x in range(width)}
                self.assertIn((252, 255, 164), pixels, "the largest weights are as light as can be")
                self.assertGreater(sum(pixel[0] > middle[0] for pixel in pixels), 10, "the rim is lighter")

    def test_frame_every_vertex_that_a_triangle_uses_and_no_other(self):
        # One large triangle, whose corners are three of 20,000 vertices, among triangles that are too small to be seen.
        for far_and_unused in (False, True):
            points = [(1e-5 * (i % 3 == 1), 1e-5 * (i % 3 == 2), 0.0) for i in range(20001)]
            points[5001:5004] = (0.0, 0.0, 0.0), (9.0, 0.0, 0.0), (0.0, 3.0, 0.0)
            faces = [(i, i + 1, i + 2) for i in range(0, 20001, 3) if i != 10002]
            if far_and_unused:
                points[10002:10005] = [(0.0, 400.0, 0.0)] * 3
            out = self.succeed("raycast", self.file("m.off", off(points, faces)), "--view", "front", "--size", "90x30", "--out", "-")
            columns = {int(row["index"]) % 90 for row in csv.DictReader(io.StringIO(out)) if row["triangle"] != "-1"}
            self.assertTrue(0 < min(columns) < 10 and 75 < max(columns) < 89, (far_and_unused, columns))

    def test_show_the_same_as_other_commands(self):
        """One camera for all pictures: where a ray misses, view and octree draw their background."""
        rng = random.Random(23)
        model, size = "torus:24x12", ("--size", "120x90")
        for camera in ((), ("--view", "iso"), ("--view", "left", "--up", "y"), ("--view", "-30,50", "--fov", "70"),
                       ("--eye", "3,-1,0.5", "--target", "0.3,0,0"), ("--eye", "0,0.3,0.1", "--target", "4,1,0", "--fov", "100"),
                       ("--eye", "%r,%r,4" % (rng.random(), rng.random()), "--up", "1,2,3")):
            with self.subTest(camera):
                hits = list(csv.DictReader(io.StringIO(self.succeed("raycast", model, *size, *camera, "--out", "-"))))
                missed = [row["triangle"] == "-1" for row in hits]
                self.assertIn(False, missed)
                for command in (("view", model), ("octree", model, "--depth", 0), ("cull", model, "--depth", 0, "--frustum", self.around())):
                    if command[0] == "cull" and any(name in camera for name in ("--eye", "--fov")):
                        continue  # its picture has a direction alone
                    if command[0] == "octree" and "--eye" not in camera:
                        continue  # its cells fill the picture, not the mesh
                    out = self.folder / "p.png"
                    options = ["--picture-view" if command[0] == "cull" and part == "--view" else part for part in camera]
                    self.succeed(*command, *size, *options, "--picture", out, "--quiet")
                    width, height, rows = read_png(out.read_bytes())
                    # The background is the same along a row, and bluish; clay is not.
                    drawn = [rows[y][3 * x] > rows[y][3 * x + 2] + 2 for y in range(height) for x in range(width)]
                    wrong = sum(a == b for a, b in zip(missed, drawn))
                    self.assertLess(wrong, 0.03 * width * height, command)

    def around(self):
        return self.file("around.csv", "1,0,0,99\n")

    def test_may_be_rows_instead(self):
        text = self.succeed("raycast", "cube", "--size", "5x4", "--out", "-")
        self.assertEqual(text.count("\n"), 21)


def sides():
    """A triangle about each of the points -x, x, -y, y, -z, z."""
    points = []
    for axis in range(3):
        for sign in (-1, 1):
            for u, v in ((-0.5, -0.5), (1, 0), (0, 1)):
                point = [0, 0, 0]
                point[axis], point[(axis + 1) % 3], point[(axis + 2) % 3] = sign, u, v
                points.append(tuple(point))
    return off(points, [(i, i + 1, i + 2) for i in range(0, 18, 3)])


class Cameras(ProgramTest):
    """What they see is known without them."""

    def seen(self, model, *camera):
        """The triangle in the middle of the picture."""
        rows = self.succeed("raycast", model, *camera, "--target", "0,0,0", "--size", "1x1", "--out", "-")
        row, = csv.DictReader(io.StringIO(rows))
        return int(row["triangle"])

    def test_names_are_the_sides_that_they_see(self):
        model = self.file("sides.off", sides())
        for up, sides_of_names in (("z", {"left": "-x", "right": "x", "front": "-y", "back": "y", "bottom": "-z", "top": "z"}),
                                   ("y", {"left": "-x", "right": "x", "front": "z", "back": "-z", "bottom": "-y", "top": "y"})):
            for name, side in sides_of_names.items():
                with self.subTest(name, up=up):
                    self.assertEqual(self.seen(model, "--view", name, "--up", up), ["-x", "x", "-y", "y", "-z", "z"].index(side))

    def test_angles_are_degrees_to_the_right_and_upward(self):
        """Of an octahedron: from the left, the front and above the face with -x, -y and z is seen, where z is up."""
        points = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
        model = self.file("octahedron.off", off(points, list(itertools.product((0, 1), (2, 3), (4, 5)))))
        octants = list(itertools.product((1, -1), repeat=3))
        for right, front, above in octants:
            azimuth, elevation = right * (45 if front > 0 else 135), 35 * above
            with self.subTest(azimuth=azimuth, elevation=elevation):
                angles = f"{azimuth},{elevation}"
                self.assertEqual(self.seen(model, "--view", angles, "--up", "z"), octants.index((right, -front, above)))
                self.assertEqual(self.seen(model, "--view", angles, "--up", "y"), octants.index((right, above, front)))
        self.assertEqual(self.seen(model, "--view", "iso", "--up", "z"), octants.index((1, -1, 1)))

    def test_the_opening_angle_is_from_bottom_to_top(self):
        """Of a square straight ahead, half as wide as 0.28 of its distance, as many pixels as have their middles in it."""
        corners = [(-0.28, 0, -0.28), (0.28, 0, -0.28), (0.28, 0, 0.28), (-0.28, 0, 0.28)]
        model = self.file("square.off", off(corners, [(0, 1, 2), (0, 2, 3)]))
        for angle in (None, 20, 35, 60, 90, 120):
            slope = math.tan(math.radians((angle or 35) / 2))
            for width in (20, 40):
                with self.subTest(angle=angle, width=width):
                    columns, rows = (sum(abs(i + 0.5 - pixels / 2) / 10 * slope < 0.28 for i in range(pixels)) for pixels in (width, 20))
                    options = () if angle is None else ("--fov", angle)
                    found = self.json_of("raycast", model, "--eye", "0,-1,0", "--target", "0,0,0", "--up", "z", "--size", f"{width}x20", *options)
                    self.assertEqual(found["hits"], columns * rows)


class Refusing(ProgramTest):
    def test_wrong_options(self):
        rays = self.file("rays.csv", "0,0,5,0,0,-1\n")
        out = self.folder / "x.png"
        for arguments, says in (
                ([], "--rays, --ray and a camera"),
                (["--rays", rays, "--size", "4x4"], "--rays, --ray and a camera"),
                (["--rays", rays, "--picture", out], "a camera")):
            self.refuse("raycast", "cube", *arguments, status=2, says=says)
        for arguments, says in (
                (["--picture", self.folder / "x.jpg"], ".png"),
                (["--picture", out, "--eye", "1,2,3", "--target", "1,2,3"], "--eye"),
                (["--rays", rays, "--out", self.folder / "x.txt"], "unknown extension"),
                (["--rays", rays, "--out", "-", "--json", "-"], "stdout")):
            self.refuse("raycast", "cube", *arguments, says=says)
        for option, value in (("--size", "4"), ("--size", "0x4"), ("--size", "99999x4"), ("--view", "fornt"), ("--view", "0,91"),
                              ("--eye", "1,2"), ("--target", "a,b,c"), ("--up", "w"), ("--up", "0,0,0"), ("--fov", "180"), ("--fov", "nan"),
                              ("--depth", "99")):
            self.refuse("raycast", "cube", "--picture", out, option, value, status=2, says=option)
        for option in ("--depth", "--threshold"):
            self.refuse("raycast", "cube", "--rays", rays, option, 3, status=2, says=(option, "--cells"))
        self.refuse("raycast", "cube", "--picture", out, "--view", "top", "--eye", "1,2,3", status=2, says=("--view", "--eye"))

    def test_rays_of_the_command_line(self):
        rays = [(0.25, 0.5, 5.0, 0.0, 0.0, -1.0), (0.0, 0.25, -5.0, 0.0, 0.0, 1.0)]
        expected = self.succeed("raycast", "cube", "--rays", self.file("rays.csv", rays_text(rays)), "--out", "-")
        options = [part for ray in rays for part in ("--ray", ",".join(map(repr, ray)))]
        self.assertEqual(self.succeed("raycast", "cube", *options), expected)
        self.assertEqual([row["t"] for row in csv.DictReader(io.StringIO(expected))], ["4", "4"])
        open_end = self.file("open.csv", rays_text([ray + (0.0, float("inf")) for ray in rays], header=True))
        self.assertEqual(self.succeed("raycast", "cube", "--rays", open_end), expected)
        named = self.file("named.csv", "tmax dx dy dz ox oy oz tmin\n"
                          + "".join("inf %r %r %r %r %r %r 0\n" % (ray[3:] + ray[:3]) for ray in rays))
        self.assertEqual(self.succeed("raycast", "cube", "--rays", named), expected)

    def test_bad_rays(self):
        for text, says in (("0,0,5,0,0,0\n", "rays.csv:1:"), ("# rays\n0,0,5,0,0,1,2,1\n", "rays.csv:2:"),
                           ("0,0,5,0,0,inf\n", "finite"), ("0,0,5,0,0,1,0,nan\n", "finite"),
                           ("0,0,5,0,0\n", "rays.csv"), ("0,0,nan,0,0,1\n", "rays.csv"), ("", "rays.csv")):
            self.refuse("raycast", "cube", "--rays", self.file("rays.csv", text), says=says)
        self.refuse("raycast", "cube", "--rays", self.folder / "absent.csv", says="absent.csv")


if __name__ == "__main__":
    unittest.main()
