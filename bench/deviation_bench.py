"""The deviation of two meshes by `proxima deviation` and by peers, one thread each, in processor time. Run by scripts/bench deviation.

    proxima     bounds of the Hausdorff distance 1e-6 of the diagonal apart, and of means and root mean squares, 1e-5; the whole command
    CGAL        bounded_error_symmetric_Hausdorff_distance, with an error of 1e-4 of the diagonal
    VTK         vtkHausdorffDistancePointSetFilter: from vertices alone, without a bound of what is between them
    Open3D      a million random points of each surface, as Metro has it, without a bound
"""
import argparse
import functools
import json
import resource
import statistics
import subprocess
import tempfile
from pathlib import Path

import numpy as np

BUNNY = Path("/usr/share/glmark2/models/bunny.obj")
SAMPLES = 1_000_000


def processor_seconds(who):
    usage = resource.getrusage(who)
    return usage.ru_utime + usage.ru_stime


def timed(who, rounds, work):
    """The median of the processor time of this process or of those it starts, and what the last round gave."""
    taken = []
    for _ in range(rounds):
        before = processor_seconds(who)
        answer = work()
        taken.append(processor_seconds(who) - before)
    return statistics.median(taken), answer


def write_off(path, points, triangles):
    with open(path, "w") as file:
        file.write(f"OFF\n{len(points)} {len(triangles)} 0\n")
        file.writelines("{:.17g} {:.17g} {:.17g}\n".format(*point) for point in points)
        file.writelines("3 {} {} {}\n".format(*triangle) for triangle in triangles)


@functools.cache
def read_off(path):
    head, counts, body = Path(path).read_text().split("\n", 2)
    assert head == "OFF"
    vertices, triangles, _ = map(int, counts.split())
    numbers = np.fromstring(body, sep=" ")
    return numbers[:3 * vertices].reshape(-1, 3), numbers[3 * vertices:].reshape(triangles, 4)[:, 1:].astype(np.int64)


class Pairs:
    """The meshes as files in a folder."""

    def __init__(self, proxima, folder):
        self.proxima, self.folder = proxima, Path(folder)

    def model(self, name):
        path = self.folder / f"{name.replace(':', '_').replace('/', '_')}.off"
        if not path.exists():
            subprocess.run([self.proxima, "repair", name, "--no-orient", "--no-outward", "--quiet", "--out", path], check=True)
        return path

    def moved(self, name, what, move):
        points, triangles = read_off(self.model(name))
        path = self.folder / f"{what}.off"
        write_off(path, move(points, triangles), triangles)
        return path

    def usual(self):
        pairs = [(a, b, self.model(a), self.model(b)) for a, b in [("icosphere:6", "sphere:190x190"), ("torus:264x132", "torus:260x134")]]
        name, mesh = ("bunny", str(BUNNY)) if BUNNY.exists() else ("torus:264x132", "torus:264x132")
        a = self.model(mesh)
        size = np.linalg.norm(np.ptp(read_off(a)[0], axis=0))

        def noise(points, triangles):
            return points + 1e-3 * size * np.random.default_rng(5).uniform(-1, 1, points.shape)

        def offset(points, triangles):
            corners = points[triangles]
            normals = np.zeros_like(points)
            across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            for k in range(3):
                np.add.at(normals, triangles[:, k], across)
            return points + 1e-3 * size * normals / np.linalg.norm(normals, axis=1)[:, None]

        pairs.append((name, "the same with noise", a, self.moved(mesh, "noise", noise)))
        pairs.append((name, "offset copy", a, self.moved(mesh, "offset", offset)))
        return pairs


def by_proxima(proxima, a, b, rounds):
    def run(*options):
        command = [proxima, "deviation", a, b, "--threads", "1", "--json", "-", *options]
        return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)

    greatest, found = timed(resource.RUSAGE_CHILDREN, rounds, lambda: run("--no-mean"))
    both, means = timed(resource.RUSAGE_CHILDREN, rounds, run)
    lower, upper = found["hausdorff"]
    mean = means["both_ways"]["mean"]
    return [f"{lower:.6g} to {upper:.6g}", f"{greatest:.2f}", f"{mean[0]:.4g} to {mean[1]:.4g}", f"{both - greatest:.2f}"]


def by_cgal(peer, a, b, seconds):
    if peer is None:
        return ["no CGAL", ""]
    points = np.concatenate([read_off(a)[0], read_off(b)[0]])
    error = 1e-4 * np.linalg.norm(np.ptp(points, axis=0))
    try:
        answer = subprocess.run([peer, a, b, repr(float(error))], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, timeout=seconds)
    except subprocess.TimeoutExpired:
        return [f"none in {seconds} s", ""]
    if answer.returncode != 0:
        return ["does not take these", ""]
    distance, taken = answer.stdout.split()
    return [f"{float(distance):.6g} (± {error:.2g})", f"{float(taken):.2f}"]


def by_vtk(a, b, rounds):
    try:
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
        from vtkmodules.vtkCommonCore import vtkPoints, vtkSMPTools
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
        from vtkmodules.vtkFiltersModeling import vtkHausdorffDistancePointSetFilter
    except ImportError:
        return ["no VTK", ""]
    vtkSMPTools.Initialize(1)
    both = []
    for path in (a, b):
        points, triangles = read_off(path)
        data, places, polygons = vtkPolyData(), vtkPoints(), vtkCellArray()
        places.SetDataTypeToDouble()
        places.SetData(numpy_to_vtk(points, deep=True))
        data.SetPoints(places)
        cells = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
        polygons.ImportLegacyFormat(numpy_to_vtkIdTypeArray(cells, deep=True))
        data.SetPolys(polygons)
        both.append(data)

    def measure():
        filter = vtkHausdorffDistancePointSetFilter()
        filter.SetInputData(0, both[0])
        filter.SetInputData(1, both[1])
        filter.SetTargetDistanceMethodToPointToCell()
        filter.Update()
        return filter.GetHausdorffDistance()

    taken, distance = timed(resource.RUSAGE_SELF, rounds, measure)
    return [f"{distance:.6g}", f"{taken:.2f}"]


def by_open3d(a, b, rounds):
    try:
        import open3d
    except ImportError:
        return ["no Open3D", ""]
    meshes = [read_off(path) for path in (a, b)]

    def points_of(points, triangles, random):
        corners = points[triangles]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        chosen = corners[random.choice(len(triangles), SAMPLES, p=areas / areas.sum())]
        s, t = random.random((2, SAMPLES))
        s, t = np.where(s + t > 1, 1 - s, s), np.where(s + t > 1, 1 - t, t)
        return chosen[:, 0] + s[:, None] * (chosen[:, 1] - chosen[:, 0]) + t[:, None] * (chosen[:, 2] - chosen[:, 0]), areas.sum()

    def measure():
        random = np.random.default_rng(1)
        total = weights = 0
        for this, that in (meshes, meshes[::-1]):
            scene = open3d.t.geometry.RaycastingScene(nthreads=1)
            scene.add_triangles(open3d.core.Tensor(that[0].astype(np.float32)), open3d.core.Tensor(that[1].astype(np.uint32)))
            samples, area = points_of(*this, random)
            distances = scene.compute_distance(open3d.core.Tensor(samples.astype(np.float32)), nthreads=1).numpy()
            total += area * distances.mean(dtype=float)
            weights += area
        return total / weights

    taken, mean = timed(resource.RUSAGE_SELF, rounds, measure)
    return [f"{mean:.4g}", f"{taken:.2f}"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("proxima")
    parser.add_argument("--cgal", help="the program deviation_bench")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=int, default=120, help="what CGAL may take for a pair")
    parser.add_argument("--pair", nargs=2, action="append", metavar=("A", "B"), help="two models instead of the usual pairs")
    options = parser.parse_args()
    print("| A, B | triangles | Hausdorff distance, Proxima | s | mean of both by area, Proxima | s | CGAL | s | VTK, vertices alone | s "
          "| mean, Open3D, samples | s |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        files = Pairs(options.proxima, folder)
        pairs = [(a, b, files.model(a), files.model(b)) for a, b in options.pair] if options.pair else files.usual()
        for name_a, name_b, a, b in pairs:
            counts = ", ".join(str(len(read_off(path)[1])) for path in (a, b))
            row = [f"{name_a}, {name_b}", counts, *by_proxima(options.proxima, a, b, options.rounds), *by_cgal(options.cgal, a, b, options.seconds),
                   *by_vtk(a, b, options.rounds), *by_open3d(a, b, options.rounds)]
            print("| " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
