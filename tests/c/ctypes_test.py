"""The C interface from a program that knows only the shared library: Python's ctypes.

    ctypes_test.py LIBRARY [SCENE]      a scene of two tetrahedra is read by the library that is opened for it
"""
import ctypes
import math
import sys

library = ctypes.CDLL(sys.argv[1])
library.proxima_error_message.restype = ctypes.c_char_p
library.proxima_mesh_triangle_count.restype = ctypes.c_size_t


def check(status):
    if status != 0:
        raise ValueError(library.proxima_error_message().decode())


mesh, index = ctypes.c_void_p(), ctypes.c_void_p()
check(library.proxima_mesh_sample(b"icosphere:5", ctypes.byref(mesh)))
check(library.proxima_index_build(mesh, 4, None, ctypes.byref(index)))
library.proxima_mesh_destroy(mesh)

count = 1000
points = (ctypes.c_double * (3 * count))()
for i in range(count):
    z, turn, radius = 2 * i / (count - 1) - 1, 2.4 * i, 0.5 + i / count
    ring = math.sqrt(1 - z * z)
    points[3 * i:3 * i + 3] = [radius * ring * math.cos(turn), radius * ring * math.sin(turn), radius * z]
distances = (ctypes.c_double * count)()
check(library.proxima_signed_distances(index, points, ctypes.c_size_t(count), None, distances))
worst = max(abs(distances[i] - (0.5 + i / count - 1)) for i in range(count))
if not 0 < worst < 1e-3:  # of the sphere that the mesh stands for
    sys.exit(f"off by {worst}")

try:
    check(library.proxima_mesh_read(b"missing.ply", ctypes.byref(mesh)))
    sys.exit("a missing file was read")
except ValueError as error:
    if "missing.ply" not in str(error):
        sys.exit(f"the message does not name the file: {error}")
for scene in sys.argv[2:]:  # of two tetrahedra
    check(library.proxima_mesh_read(scene.encode(), ctypes.byref(mesh)))
    if library.proxima_mesh_triangle_count(mesh) != 8:
        sys.exit(f"{scene}: {library.proxima_mesh_triangle_count(mesh)} triangles")
    library.proxima_mesh_destroy(mesh)
library.proxima_index_destroy(index)
print(f"{count} signed distances, off by at most {worst:.1e}")
