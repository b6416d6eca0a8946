"""What the Python module adds to the C++ library: processor time of both in one process, one thread, taking turns. Where
python3-open3d is installed, also the closest points and signed distances of its RaycastingScene on the same mesh.

    python_bench.py C++_SIDE [--mesh FILE] [--points N] [--rounds N]
"""
import argparse
import ctypes
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import proxima
from proxima.compat.open3d import RaycastingScene


def median_times(rounds, *sides):
    """Median seconds of each side and of the first side's share in the second, round by round."""
    taken = [[] for _ in sides]
    for number in range(rounds + 1):
        for side, times in zip(sides, taken):
            begin = time.process_time()
            side()
            if number:  # the first round warms the memory
                times.append(time.process_time() - begin)
    ratio = statistics.median(a / b for a, b in zip(taken[0], taken[1]))
    return [statistics.median(times) for times in taken], ratio


def cpu_of(code, runs=9):
    """Median processor milliseconds that a new interpreter takes for the code."""
    program = f"import numpy, time\nbegin = time.process_time()\n{code}\nprint(time.process_time() - begin)"
    return 1e3 * statistics.median(float(subprocess.run([sys.executable, "-c", program], check=True, capture_output=True,
                                                        text=True).stdout) for _ in range(runs))


def distance_to_triangles(points, corners):
    """How far each point is from the triangle of the same row, (N, 3, 3)."""
    least = np.full(len(points), np.inf)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    above_inside = np.linalg.norm(normal, axis=1) > 0
    for number in range(3):
        begin, end = corners[:, number], corners[:, (number + 1) % 3]
        side, from_begin = end - begin, points - begin
        length = np.maximum(np.sum(side * side, axis=1), np.finfo(float).tiny)
        share = np.clip(np.sum(from_begin * side, axis=1) / length, 0, 1)
        least = np.minimum(least, np.linalg.norm(from_begin - share[:, None] * side, axis=1))
        above_inside &= np.sum(np.cross(normal, side) * from_begin, axis=1) >= 0
    unit = normal[above_inside] / np.linalg.norm(normal[above_inside], axis=1, keepdims=True)
    least[above_inside] = np.abs(np.sum((points - corners[:, 0])[above_inside] * unit, axis=1))
    return least


def check_closest(name, mesh, points, answer, least, noise):
    """Ends the program where closest points or triangles are wrong by more than noise of the least distances. Where the nearest
    triangle is unique up to noise, no other one passes."""
    near, triangle = (np.asarray(column, dtype) for column, dtype in zip(answer, ("f8", "i8")))
    corners = np.asarray(mesh.vertices)[np.asarray(mesh.faces)[triangle]]
    for what, off in (("distances", np.abs(np.linalg.norm(points - near, axis=1) - least)),
                      ("distances to the triangles named", np.abs(distance_to_triangles(points, corners) - least)),
                      ("points", distance_to_triangles(near, corners))):
        if not off.max() <= noise:
            sys.exit(f"{name}: {what} are off by {off.max()}, more than {noise}")


def against_open3d(mesh, index, points, rounds):
    """Processor time of closest points and triangles, one thread each, floats in for both. All answers are compared."""
    try:
        import open3d
    except ImportError:
        print("closest points of Open3D: python3-open3d is not installed")
        return
    tensor = open3d.core.Tensor
    scene = open3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(tensor(np.asarray(mesh.vertices, "f4")), tensor(np.asarray(mesh.faces)))
    adapter = RaycastingScene()
    adapter.add_triangles(mesh)
    lists = index.with_lists()
    random = np.random.default_rng(2)
    near = np.asarray(mesh.vertices)[random.integers(len(mesh.vertices), size=20_000)]
    near = near + 0.01 * np.ptp(mesh.bounds, axis=0).max() * random.uniform(-1, 1, near.shape)
    name = f"Open3D {open3d.__version__}"
    size = np.ptp(mesh.bounds)
    print(f"\nclosest points and triangles of 20000 points as float32, one thread each; the ratio is that of {name} to ours")
    print(f"{'':46}{name:>14}{'ours':>12}{'ratio':>8}")
    for where, some in (("in the box", points[:20_000]), ("near the surface", near)):
        given = some.astype("f4")
        exact = given.astype("f8")

        def open3d_closest():
            return scene.compute_closest_points(tensor(given), nthreads=1)

        def adapter_closest():
            return adapter.compute_closest_points(given, nthreads=1)

        def index_closest():
            return index.closest(given, columns=("point", "triangle"), threads=1)

        def lists_closest():
            return lists.closest(given, columns=("point", "triangle"), threads=1)

        sides = (("Index(mesh)", index_closest), ("Index(mesh, lists=True)", lists_closest), ("compat.open3d", adapter_closest))
        of_index, of_lists, of_adapter, of_open3d = index_closest(), lists_closest(), adapter_closest(), open3d_closest()
        answers = {"Index(mesh)": (of_index.point, of_index.triangle), "Index(mesh, lists=True)": (of_lists.point, of_lists.triangle),
                   "compat.open3d": (of_adapter["points"], of_adapter["primitive_ids"]),
                   name: (of_open3d["points"].numpy(), of_open3d["primitive_ids"].numpy())}
        least = index.closest(given, columns=("distance",), threads=1).distance
        for who, answer in answers.items():
            in_doubles = who.startswith("Index")
            check_closest(f"{where}, {who}", mesh, exact, answer, least, (1e-9 if in_doubles else 1e-5) * size)
        for kind, mine in sides:
            (their_time, our_time), ratio = median_times(rounds, open3d_closest, mine)
            us = 1e-6 * len(given)
            print(f"{f'{where}, {kind}':46}{their_time / us:11.3f} us{our_time / us:9.3f} us{ratio:8.1f}")


def field_against_open3d(mesh, rounds):
    """Processor time of a grid of signed distances, one thread each; no ratio where the signs of Open3D do not work."""
    try:
        import open3d
    except ImportError:
        return
    tensor = open3d.core.Tensor
    scene = open3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(tensor(np.asarray(mesh.vertices, "f4")), tensor(np.asarray(mesh.faces)))
    index = proxima.Index(mesh, signs=True)
    name = f"Open3D {open3d.__version__}"
    noise = 1e-4 * np.ptp(mesh.bounds)
    print(f"\nsigned distances on a grid, one thread each; the ratio is that of {name} to Index.distance_field")
    print(f"{'':46}{name:>14}{'ours':>12}{'ratio':>8}")
    for resolution in (64, 128):
        field = index.distance_field(resolution, threads=1)
        places = np.stack(np.meshgrid(*map(np.arange, field.distance.shape), indexing="ij"), axis=-1)
        given = tensor((field.origin + field.spacing * places).astype("f4"))
        theirs = scene.compute_signed_distance(given, nthreads=1).numpy()
        size = " x ".join(map(str, field.distance.shape))
        inside = np.count_nonzero(field.distance < -noise)
        if inside and not np.any(theirs < 0):
            print(f"{size:46}the signs of {name} do not work here: it finds no point inside, Index.distance_field {inside}")
            off = np.abs(np.abs(theirs) - np.abs(field.distance))
        else:
            (their_time, our_time), ratio = median_times(
                rounds, lambda: scene.compute_signed_distance(given, nthreads=1), lambda: index.distance_field(resolution, threads=1))
            us = 1e-6 * field.distance.size
            print(f"{size:46}{their_time / us:11.3f} us{our_time / us:9.3f} us{ratio:8.1f}")
            off = np.abs(theirs - field.distance)
        print(f"    {np.count_nonzero(off > noise)} of {off.size} distances of {name} differ by more than 1e-4 of the size"
              + (", whatever their signs" if inside and not np.any(theirs < 0) else ""))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("library")
    parser.add_argument("--mesh", default="/usr/share/glmark2/models/bunny.obj")
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()

    cpp = ctypes.CDLL(options.library)
    cpp.one_by_one.restype = ctypes.c_double
    count = ctypes.c_size_t(options.points)
    if not cpp.prepare(options.mesh.encode(), count):
        sys.exit(f"{options.mesh} cannot be used")
    mesh = proxima.Mesh.read(options.mesh)
    index = proxima.Index(mesh)
    lower, upper = mesh.bounds
    random = np.random.default_rng(1)
    points = lower + (1.2 * random.random((options.points, 3)) - 0.1) * (upper - lower)
    address = points.ctypes.data_as(ctypes.c_void_p)

    def address_of(array):
        return array.ctypes.data_as(ctypes.c_void_p)

    ids = index.closest(points, columns=("distance", "triangle"), threads=1)
    whole = index.closest(points, threads=1)
    squared, triangles = np.empty(options.points), np.empty(options.points, "i4")
    few = points[:20_000]
    numbers = few.tolist()
    rows = list(few)
    one = index.closest_one

    def from_numbers():
        for x, y, z in numbers:
            one(x, y, z)

    def from_rows():
        for row in rows:
            one(row)

    print(f"{options.mesh}, {len(mesh.faces)} triangles, {options.points} points in its box, one thread, processor time,\n"
          f"medians of {options.rounds} rounds; the ratio is that of Python to C++")
    print(f"{'':34}{'Python':>12}{'C++':>12}{'ratio':>8}")

    def show(name, per, unit, sides):
        (ours, theirs), ratio = median_times(options.rounds, *sides)
        print(f"{name:34}{ours / per:9.3f} {unit}{theirs / per:9.3f} {unit}{ratio:8.3f}")
        return (ours - theirs) / per

    us = 1e-6 * options.points
    show("distances and ids, each", us, "us", (
        lambda: index.closest(points, out=ids, threads=1),
        lambda: cpp.distances_and_ids(address, count, address_of(squared), address_of(triangles))))
    show("all columns, each", us, "us", (
        lambda: index.closest(points, out=whole, threads=1), lambda: cpp.all_columns(address, count)))
    us = 1e-6 * len(few)
    beside = (lambda: cpp.one_by_one(address, ctypes.c_size_t(len(few))),)
    more = show("closest_one(x, y, z), in a loop", us, "us", (from_numbers, *beside))
    row = show("closest_one(row), in a loop", us, "us", (from_rows, *beside))
    print(f"closest_one(x, y, z) takes {more:.2f} us more than C++, closest_one(row) {row:.2f} us")
    print(f"import after NumPy's: {cpu_of('import proxima'):.1f} ms")
    size = next(Path(proxima.__file__).parent.glob("_core*.so")).stat().st_size
    print(f"the module has {size / 1e6:.2f} MB")
    if not np.array_equal(np.sqrt(squared), ids.distance) or not np.array_equal(triangles, whole.triangle):
        sys.exit("the answers differ")
    against_open3d(mesh, index, points, options.rounds)
    field_against_open3d(mesh, options.rounds)


if __name__ == "__main__":
    main()
