"""How thick a mesh is behind each of its triangles: rays inward, and the thinnest place with the triangles round it.

    python3 examples/thickness_of_walls.py [MESH]
"""
import sys

import numpy as np

import proxima

mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else proxima.Mesh.sample("torus:100x50")
index = proxima.Index(mesh)
a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
middle = (a + b + c) / 3
normal = np.cross(b - a, c - a)
length = np.linalg.norm(normal, axis=1)
middle, inward = middle[length > 0], -normal[length > 0] / length[length > 0, None]

size = np.linalg.norm(np.subtract(*mesh.bounds))
thickness = index.cast(middle, inward, t_min=1e-9 * size).t  # a little off, so that a triangle does not hit itself
print(f"thickness: {thickness.min():.4g} at least, {np.median(thickness):.4g} in the median")
thinnest = middle[thickness.argmin()]
patch = proxima.Topology(mesh).patch(index.closest_one(thinnest), rings=2)
print(f"thinnest at {thinnest.round(3)}, with {len(patch.triangle)} triangles within two rings")
