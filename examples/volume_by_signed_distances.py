"""The volume of a closed mesh, by counting points inside: signed distances of random points in its box.

    python3 examples/volume_by_signed_distances.py [MESH]
"""
import sys

import numpy as np

import proxima

mesh = proxima.Mesh.read(sys.argv[1]) if len(sys.argv) > 1 else proxima.Mesh.sample("torus:100x50")
index = proxima.Index(mesh, signs=True)
lower, upper = mesh.bounds
points = np.random.default_rng(1).uniform(lower, upper, (200_000, 3))
inside = index.signed_distance(points) < 0
print(f"by counting:  {inside.mean() * np.prod(upper - lower):.4f}")

a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
print(f"by triangles: {np.einsum('ij,ij->', a, np.cross(b, c)) / 6:.4f}")
