#!/usr/bin/env python3
"""What a newcomer's day holds: tasks in plain words, each with its command and its check.

    tests/tasks/newcomer.py PROGRAM [MODEL]...

Every command runs in a shell, in a folder of its own with the files that `prepare` lists; there the program is called
proxima, and m.off is the model. Checks compute anew what can be computed: brute force over all triangles, whole files,
shapes with formulas. Prints what failed; exits with 1 if anything did."""
import csv
import io
import json
import math
import os
import struct
import subprocess
import sys
import tempfile
from pathlib import Path


# -- Oracles -----------------------------------------------------------------------------------------------------------

def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def to_segment(p, a, b):
    ab = sub(b, a)
    t = min(1.0, max(0.0, dot(sub(p, a), ab) / (dot(ab, ab) or 1.0)))
    return math.dist(p, [x + t * y for x, y in zip(a, ab)])


def to_triangle(p, a, b, c):
    n = cross(sub(b, a), sub(c, a))
    if dot(n, n) > 0 and all(dot(cross(sub(v, u), sub(p, u)), n) >= 0 for u, v in ((a, b), (b, c), (c, a))):
        return abs(dot(sub(p, a), n)) / math.sqrt(dot(n, n))
    return min(to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a))


def ray_hit(o, d, a, b, c):
    """The t of a ray, by the volumes of tetrahedra; None for a miss."""
    u, v, w = (dot(d, cross(sub(y, o), sub(x, o))) for x, y in ((b, c), (c, a), (a, b)))
    n = cross(sub(b, a), sub(c, a))
    if dot(d, n) == 0 or not (min(u, v, w) >= 0 or max(u, v, w) <= 0):
        return None
    t = dot(sub(a, o), n) / dot(d, n)
    return t if t >= 0 else None


class Mesh:
    def __init__(self, path):
        numbers = path.read_text().split("#")[0].split()
        count, faces = int(numbers[1]), int(numbers[2])
        values = list(map(float, numbers[4:4 + 3 * count]))
        self.points = [tuple(values[i:i + 3]) for i in range(0, 3 * count, 3)]
        rest = list(map(int, numbers[4 + 3 * count:]))
        self.faces = [tuple(rest[i + 1:i + 4]) for i in range(0, 4 * faces, 4)]
        self.lower = [min(p[k] for p in self.points) for k in range(3)]
        self.upper = [max(p[k] for p in self.points) for k in range(3)]
        self.size = math.dist(self.lower, self.upper)
        self.middle = [(a + b) / 2 for a, b in zip(self.lower, self.upper)]
        uses = {}
        for face in self.faces:
            for k in range(3):
                edge = tuple(sorted((face[k], face[(k + 1) % 3])))
                uses[edge] = uses.get(edge, 0) + 1
        self.edges = len(uses)
        self.closed = all(n == 2 for n in uses.values())

    def triangles(self):
        return [tuple(self.points[v] for v in face) for face in self.faces]

    def area(self):
        return sum(math.sqrt(dot(n, n)) / 2 for n in (cross(sub(b, a), sub(c, a)) for a, b, c in self.triangles()))

    def volume(self):
        return sum(dot(sub(a, self.middle), cross(sub(b, self.middle), sub(c, self.middle))) for a, b, c in self.triangles()) / 6

    def distance(self, p):
        return min(to_triangle(p, *t) for t in self.triangles())

    def first_hit(self, o, d):
        return min((t for t in (ray_hit(o, d, *x) for x in self.triangles()) if t is not None), default=math.inf)


def png_size(path):
    data = path.read_bytes()
    return struct.unpack(">II", data[16:24]) if data[:8] == b"\x89PNG\r\n\x1a\n" else None


def npy_array(path):
    """Shape and numbers of an array of doubles."""
    data = path.read_bytes()
    end = 10 + struct.unpack("<H", data[8:10])[0]
    shape = eval(data[10:end])["shape"]
    return shape, struct.unpack("<%dd" % math.prod(shape), data[end:])


def write_npy(path, rows, kind="<f8", code="d"):
    header = "{'descr': '%s', 'fortran_order': False, 'shape': (%d, %d), }" % (kind, len(rows), len(rows[0]))
    header += " " * (-(len(header) + 11) % 64) + "\n"
    numbers = [x for row in rows for x in row]
    path.write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode()
                     + struct.pack("<%d%s" % (len(numbers), code), *numbers))


def near(a, b, tolerance=1e-9):
    return a == b or abs(a - b) <= tolerance * max(1e-300, abs(a), abs(b))


# -- The files of the folder, and what a command left -------------------------------------------------------------------

class Task:
    """What a check may look at: status, out, err, files of the folder, and what the tasks before it kept."""

    def __init__(self, folder, mesh, kept):
        self.folder, self.mesh, self.kept = folder, mesh, kept

    def run(self, command, program):
        environment = {**os.environ, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}"}
        result = subprocess.run(["bash", "-c", command], cwd=self.folder, env=environment, capture_output=True, text=True, timeout=300)
        self.status, self.out, self.err = result.returncode, result.stdout, result.stderr

    @property
    def json(self):
        return json.loads(self.out)

    def rows(self, text=None):
        return list(csv.DictReader(io.StringIO(self.out if text is None else text)))

    def path(self, name):
        return self.folder / name

    def text(self, name):
        return self.path(name).read_text()

    def ids(self, text):
        return {int(row["triangle"]) for row in self.rows(text)}

    def keep(self, name, value):
        self.kept[name] = value
        return True


def prepare(folder, mesh):
    """Points round the model, cameras and poses, as other programs write them; and meshes with one flaw each."""
    size, middle = mesh.size, mesh.middle
    points = [tuple(m + size * s for m, s in zip(middle, shift)) for shift in ((1, 0.3, 0.2), (-0.1, 0.9, -0.4), (0.05, 0.02, 0.03))]
    (folder / "points.csv").write_text("x,y,z\n" + "".join("%r,%r,%r\n" % p for p in points))
    (folder / "savetxt.txt").write_text("# x y z\n" + "".join("%.18e %.18e %.18e\n" % p for p in points))
    (folder / "pandas.csv").write_text(",name,z,y,x\n" + "".join("%d,p%d,%r,%r,%r\n" % (i, i, p[2], p[1], p[0]) for i, p in enumerate(points)))
    write_npy(folder / "points.npy", points)
    (folder / "point").write_text("%r,%r,%r" % points[0])
    rays = [(*p, *sub(middle, p)) for p in points[:2]] + [(*points[0], 1.0, 0.0, 0.0)]
    (folder / "rays.csv").write_text("".join(",".join(map(repr, ray)) + "\n" for ray in rays))
    (folder / "plane.csv").write_text("1,0,0,%r\n" % -middle[0])
    turn = math.cos(math.radians(30)), math.sin(math.radians(30))
    back = middle[0] - turn[0] * middle[0] + turn[1] * middle[1], middle[1] - turn[1] * middle[0] - turn[0] * middle[1]
    poses = [(turn[0], -turn[1], 0, back[0] + x, turn[1], turn[0], 0, back[1], 0, 0, 1, 0) for x in (0.0, 0.1 * size, 3 * size)]
    write_npy(folder / "poses32.npy", poses, "<f4", "f")
    cube = "8 %d 0\n" + "".join("%d %d %d\n" % (x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1))
    faces = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]

    def off(name, triangles):
        (folder / name).write_text("OFF\n" + cube % len(triangles) + "".join("3 %d %d %d\n" % f for f in triangles))
    off("cube.off", faces)
    off("doubled.off", faces + [faces[0], (3, 3, 1)])
    off("inside_out.off", [f[::-1] for f in faces])
    off("half_turned.off", [f[::-1] if i % 3 == 0 else f for i, f in enumerate(faces)])
    off("open.off", faces[2:])
    (folder / "small.off").write_text("OFF\n" + "4 4 0\n0.4 0.4 0.4\n0.6 0.4 0.4\n0.4 0.6 0.4\n0.4 0.4 0.6\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
    return points, rays


# -- The tasks ---------------------------------------------------------------------------------------------------------

P, R = 0, 1  # of what prepare returns: points, rays

TASKS = [
    # Looking at a mesh
    ("Tell me whether anything is wrong with my mesh.", "proxima check m.off",
     lambda t: "Outlook" in t.out and f"{len(t.mesh.faces)} triangles" in t.out),
    ("How many vertices, edges and triangles has it?", "proxima check m.off --json -",
     lambda t: (t.json["vertices"], t.json["edges"], t.json["triangles"]) == (len(t.mesh.points), t.mesh.edges, len(t.mesh.faces))),
    ("How large is it?", "proxima check m.off --json -",
     lambda t: t.json["bounds"] == {"lower": t.mesh.lower, "upper": t.mesh.upper}),
    ("What is its area?", "proxima check m.off --json -", lambda t: near(t.json["area"], t.mesh.area(), 1e-6)),
    ("Is it closed, and if so what is its volume?", "proxima check m.off --json -",
     lambda t: t.json["closed"] == t.mesh.closed and (not t.mesh.closed or near(t.json["signed_volume"], t.mesh.volume(), 1e-4))),
    ("Stop my script where a mesh is flawed.", "proxima check doubled.off --strict --quiet && echo goes on",
     lambda t: t.status == 1 and t.out == ""),
    ("... and let it go on where it is not.", "proxima check cube.off --strict --quiet && echo goes on", lambda t: t.out == "goes on\n"),
    ("Where is the hole?", "proxima check open.off --json -",
     lambda t: t.json["boundary_loops"] == 1 and not t.json["closed"]),
    ("Which version is this, and what can my processor do?", "proxima --version", lambda t: t.out[0].isdigit() and "instruction sets" in t.out),
    # Mending and converting
    ("Make an STL of it.", "proxima repair m.off --out m.stl",
     lambda t: t.path("m.stl").stat().st_size == 84 + 50 * len(t.mesh.faces)),
    ("Make an OBJ of it.", "proxima repair m.off --out m.obj", lambda t: t.text("m.obj").count("\nf ") == len(t.mesh.faces)),
    ("Make a PLY of it, and read that again.", "proxima repair m.off --out m.ply --quiet && proxima check m.ply --json -",
     lambda t: t.json["triangles"] == len(t.mesh.faces) and t.json["bounds"]["upper"] == t.mesh.upper),
    ("Join the triangles of an STL.", "proxima repair cube.off --out soup.stl --quiet && proxima repair soup.stl --out whole.off --json -",
     lambda t: Mesh(t.path("whole.off")).closed and len(Mesh(t.path("whole.off")).points) == 8),
    ("Throw away doubled and collapsed triangles.", "proxima repair doubled.off --out single.off", lambda t: len(Mesh(t.path("single.off")).faces) == 12),
    ("Turn a mesh that is inside out.", "proxima repair inside_out.off --out outward.off", lambda t: near(Mesh(t.path("outward.off")).volume(), 1)),
    ("Make the triangles face one way.", "proxima repair half_turned.off --out one_way.off", lambda t: near(Mesh(t.path("one_way.off")).volume(), 1)),
    ("Which triangle was which before?", "proxima repair doubled.off --out single.off --map map.csv",
     lambda t: [int(row["original"]) for row in t.rows(t.text("map.csv"))] == list(range(12))),
    # Closest points
    ("How far is this point from the surface?", "proxima closest m.off --point $(cat point)",
     lambda t: near(float(t.rows()[0]["distance"]), t.mesh.distance(t.kept["prepared"][P][0])) and t.keep("closest", t.out)),
    ("How far are all of these?", "proxima closest m.off --points points.csv",
     lambda t: all(near(float(row["distance"]), t.mesh.distance(p)) for row, p in zip(t.rows(), t.kept["prepared"][P], strict=True)) and t.keep("all", t.out)),
    ("My points are from numpy.savetxt.", "proxima closest m.off --points savetxt.txt", lambda t: t.out == t.kept["all"]),
    ("My points are from pandas, with a name column, z first.", "proxima closest m.off --points pandas.csv", lambda t: t.out == t.kept["all"]),
    ("My points are an array, and I want one back.", "proxima closest m.off --points points.npy --out a.npy",
     lambda t: npy_array(t.path("a.npy"))[0][0] == 3 and all(near(x, float(row["distance"])) for x, row in
               zip(npy_array(t.path("a.npy"))[1][1::npy_array(t.path("a.npy"))[0][1]], t.rows(t.kept["all"])))),
    ("My points come through a pipe.", "tail -n +2 points.csv | proxima closest m.off --points -", lambda t: t.out == t.kept["all"]),
    ("Only those that are nearer than a length.", "proxima closest cube.off --point 0.5,0.5,2 --point 0.5,0.5,9 | awk -F, 'NR > 1 && $2 < 2'",
     lambda t: t.out.startswith("0,1,") and t.out.count("\n") == 1),
    ("Is a point inside?", "proxima closest cube.off --point 0.5,0.5,0.4 --point 0.5,0.5,2 --signed",
     lambda t: [float(row["signed_distance"]) for row in t.rows()] == [-0.4, 1]),
    ("Inside an open mesh?", "proxima closest open.off --point 0.5,0.5,0.9 --signed", lambda t: t.rows()[0]["sign_method"] == "winding_number"),
    ("Do I hit a vertex, an edge or a face?", "proxima closest cube.off --point 2,2,2 --point 2,2,0.5 --point 2,0.5,0.4",
     lambda t: [row["kind"] for row in t.rows()] == ["vertex", "edge", "face"]),
    ("Bound the slowest query.", "proxima closest m.off --points points.csv --lists", lambda t: t.out == t.kept["all"]),
    ("Build once, ask later.", "proxima index m.off --signs --save m.pxi --quiet && proxima closest m.pxi --points points.csv", lambda t: t.out == t.kept["all"]),
    ("What does the index cost?", "proxima index m.off --json -",
     lambda t: near(t.json["bytes"], t.json["triangles"] * sum(t.json["bytes_per_triangle"].values()), 1e-6)),
    ("Is the saved file still sound?", "proxima check m.pxi --mesh m.off", lambda t: t.status == 0),
    ("The answers shall not depend on threads.", "proxima closest m.off --points points.csv --threads 1", lambda t: t.out == t.kept["all"]),
    ("Which triangles are round this place?", "proxima patch m.off --point $(cat point) --rings 2",
     lambda t: int(t.rows(t.kept["closest"])[0]["triangle"]) in t.ids(t.out)),
    ("All triangles within a radius of a point.", "proxima patch cube.off --point 0.5,0.5,2 --radius 1.1", lambda t: t.ids(t.out) == {2, 3}),
    # Rays
    ("What does this ray hit?", "proxima raycast cube.off --ray 0.5,0.25,3,0,0,-1", lambda t: t.rows()[0]["t"] == "2" and t.rows()[0]["triangle"] in "23"),
    ("What do all of these hit?", "proxima raycast m.off --rays rays.csv",
     lambda t: all(near(float(row["t"]), t.mesh.first_hit(ray[:3], ray[3:]), 1e-7) for row, ray in zip(t.rows(), t.kept["prepared"][R], strict=True))),
    ("Only hits within a range.", "proxima raycast cube.off --ray 0.5,0.25,3,0,0,-1,0,1.5 --ray 0.5,0.25,3,0,0,-1,2.5,9",
     lambda t: [row["t"] for row in t.rows()] == ["inf", "3"]),
    ("Which cells of the octree does a ray go through?", "proxima raycast cube.off --ray 0.5,0.25,3,0,0,-1 --cells --depth 3",
     lambda t: near(sum(float(row["chord"]) for row in t.rows()), 1)),
    # Pictures
    ("Show me the mesh.", "proxima view m.off --picture front.png", lambda t: png_size(t.path("front.png")) == (1280, 820)),
    ("... from the left, smaller.", "proxima view m.off --view left --size 640x480 --picture left.png",
     lambda t: png_size(t.path("left.png")) == (640, 480) and t.path("left.png").read_bytes() != t.path("front.png").read_bytes()),
    ("... z is up in my files.", "proxima view m.off --up z --size 1280x820 --picture z.png",
     lambda t: t.path("z.png").read_bytes() != t.path("front.png").read_bytes()),
    ("... from this eye, as rays see it.", "proxima raycast m.off --eye $(cat point) --picture rays.png", lambda t: png_size(t.path("rays.png")) == (1280, 960)),
    ("Show me its flaws in colours.", "proxima view open.off --panel model --picture flaws.png", lambda t: png_size(t.path("flaws.png")) is not None),
    ("Put it on a web page.", "proxima view m.off --panel octree --out scene.glb", lambda t: t.path("scene.glb").read_bytes()[:4] == b"glTF"),
    # Culling
    ("What does a camera see?", "proxima cull m.off --view front", lambda t: t.ids(t.out) == set(range(len(t.mesh.faces)))),
    ("What is on this side of a plane?", "proxima cull m.off --frustum plane.csv --exact",
     lambda t: t.ids(t.out) == {i for i, f in enumerate(t.mesh.triangles()) if max(p[0] for p in f) >= t.mesh.middle[0]}),
    ("... and between two planes?", "proxima cull cube.off --plane 0,0,1,-0.5 --plane 0,0,-1,2 --exact", lambda t: {2, 3} < t.ids(t.out) < set(range(12))),
    ("Keep only that part.", "proxima cull m.off --frustum plane.csv --out part.off --picture part.png",
     lambda t: Mesh(t.path("part.off")).upper[0] == t.mesh.upper[0] and png_size(t.path("part.png")) == (1280, 960)),
    # Two meshes
    ("Do these two touch?", "proxima intersect cube.off small.off --json -", lambda t: t.json["poses"][0]["intersecting"] is False),
    ("Is one inside the other?", "proxima intersect cube.off small.off", lambda t: t.rows()[0]["contained"] == "2"),
    ("How far apart are they when B moves?", "proxima intersect cube.off cube.off --pose 3,0,0 --distance",
     lambda t: float(t.rows()[0]["separation"]) == 2),
    ("... and turns?", "proxima intersect cube.off cube.off --pose 3,0,0@0,0,1,90 --distance", lambda t: near(float(t.rows()[0]["separation"]), 1)),
    ("My poses are a float32 array.", "proxima intersect m.off m.off --pose poses32.npy",
     lambda t: [row["intersecting"] for row in t.rows()][::2] == ["1", "0"]),
    ("Where do they meet? As curves.", "proxima intersect sphere:40x40 sphere:40x40 --pose 1,0,0 --contour c.obj",
     lambda t: all(near(float(line.split()[1]), 0.5, 0.05) for line in t.text("c.obj").splitlines() if line.startswith("v ")) and "\nl " in t.text("c.obj")),
    ("Which triangles meet?", "proxima intersect cube.off cube.off --pose 1,0,0 --pairs pairs.csv", lambda t: len(t.text("pairs.csv").splitlines()) > 4),
    ("Where may B's origin not go?", "proxima minkowski cube.off small.off --scale -1 --out obstacle.off --json - || proxima minkowski cube.off small.off --scale -1 --json -",
     lambda t: near(t.json["lower"][0], -0.6) and near(t.json["upper"][0], 0.6)),
    ("Grow the hull of my mesh.", "proxima minkowski m.off octahedron --hull --out grown.obj --json -",
     lambda t: all(near(a, b - 1, 1e-6) for a, b in zip(t.json["lower"], t.mesh.lower)) and t.path("grown.obj").exists()),
    # Octrees
    ("How many cells has its octree?", "proxima octree m.off --depth 6 --threshold 8 --save o.pxo --json -",
     lambda t: t.json["leaves"] == t.json["inner"] + t.json["outer"] + t.json["boundary"] and t.keep("octree", t.json)),
    ("Open the saved one.", "proxima octree o.pxo --json -", lambda t: (t.json["total"], t.json["references"]) == (t.kept["octree"]["total"], t.kept["octree"]["references"])),
    ("Is it that mesh's?", "proxima check o.pxo --mesh m.off", lambda t: t.status == 0),
    ("... and not another one's.", "proxima check o.pxo --mesh cube.off", lambda t: t.status == 1 and t.err.count("\n") == 1),
    ("Look at it in ParaView.", "proxima octree o.pxo --out o.vtu --out o.htg", lambda t: all(b"<VTKFile" in t.path(name).read_bytes()[:200] for name in ("o.vtu", "o.htg"))),
    ("Draw it.", "proxima octree m.off --depth 5 --view iso --picture o.png", lambda t: png_size(t.path("o.png")) == (1280, 960)),
    # Touch
    ("Touch it without a device.", "proxima touch m.off --device hand:press --seconds 0.5 --free-running", lambda t: "passed through the surface 0 times" in t.out),
    ("Record that and play it again.",
     "proxima touch m.off --device hand:slide --seconds 0.5 --free-running --record s.pxt --quiet && proxima touch m.off --device replay:s.pxt --json -",
     lambda t: t.json["ticks"] == 500),
    ("Touch two things.", "proxima touch m.off --object cube --pose 1=5,0,0 --device hand:press --seconds 0.2 --free-running", lambda t: t.status == 0),
    # The thesis
    ("Print a table of the thesis.", "proxima tables --only 3.2", lambda t: "3.2" in t.out),
    ("Draw a figure of the thesis.", "proxima figures --only 3.1 --out figures", lambda t: "3.1" in t.text("figures/figures.html")),
    # When something goes wrong
    ("I mistype an option.", "proxima octree cube --dept 3", lambda t: t.status == 2 and "--depth" in t.err),
    ("I mistype a built-in.", "proxima check spher:10x10", lambda t: t.status == 1 and "sphere" in t.err),
    ("My file is not there.", "proxima closest absent.obj --point 0,0,0", lambda t: t.status == 1 and t.err.count("\n") == 1 and "absent.obj" in t.err),
    ("A line of my points is broken.", "printf '1,2,3\\n4,five,6\\n' | proxima closest cube.off --points -", lambda t: t.status == 1 and "2" in t.err),
    ("Show in a log how far it is.", "proxima index icosphere:5 --lists --progress --quiet", lambda t: t.status == 0 and "%" in t.err),
]


def run_day(program, model):
    """What failed, as lines."""
    failed = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "bin").mkdir()
        (folder / "bin" / "proxima").symlink_to(Path(program).resolve())
        made = subprocess.run([program, "repair", model, "--out", folder / "m.off", "--quiet"], capture_output=True, text=True)
        if made.returncode != 0:
            return [f"{model}: {made.stderr.strip()}"]
        mesh = Mesh(folder / "m.off")
        kept = {"prepared": prepare(folder, mesh)}
        for words, command, check in TASKS:
            task = Task(folder, mesh, kept)
            task.run(command, program)
            try:
                passed, why = bool(check(task)), ""
            except Exception as error:  # what a check cannot read is wrong
                passed, why = False, f" ({error!r:.200})"
            if not passed:
                failed.append(f"{model}: {words}\n    $ {command}\n    status {task.status}{why}\n    {task.err.strip()[:300]}\n    {task.out[:300]!r}")
    return failed


def main():
    program, models = sys.argv[1], sys.argv[2:] or ["spaceship:2000"]
    failed = []
    for model in models:
        lines = run_day(program, model)
        print(f"{model}: {len(TASKS) - len(lines)} of {len(TASKS)} tasks done")
        failed += lines
    print("\n".join(failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
